// `bench`: CPU time per step of every solver and scene, and so what leaving parts out of a scene saves.
#include <fmt/format.h>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/stopwatch.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"unknowns", ColumnType::integer, "length of the state of the scene"},
    {"solver", ColumnType::text, "solver id"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"steps", ColumnType::integer, "steps of a run"},
    {"rhs_evals", ColumnType::integer, "evaluations of the right-hand side in a run"},
    {"ns_per_step", ColumnType::number, "least CPU time of a step over the repeats, ns"},
    {"ns_per_step_median", ColumnType::number, "median, ns"},
    {"ns_per_step_mad", ColumnType::number, "median absolute deviation, ns"},
    {"steps_per_s", ColumnType::number, "from the least time"},
    {"repeats", ColumnType::integer, "repeats of the measurement"},
};

// From a scene with every part to a particle: a full scene, no translation, a spherical body, rates alone, no
// rotation.
constexpr const char* default_scenes[] = {"spinning-projectile", "tumbling-box",   "hairer-vilmart", "sphere",
                                          "euler-equations",     "thrown-particle"};

}  // namespace

int bench_verb(const Options& options) {
  Table table{"bench.csv", columns, {}};
  std::vector<std::string> scenes = options.scenes;
  if (scenes.empty()) scenes.assign(std::begin(default_scenes), std::end(default_scenes));
  std::vector<const Method*> methods;
  for (const Method* m : options.solvers.empty() ? all_methods() : select_methods(options.solvers))
    if (m->family != "truth") methods.push_back(m);
  struct Candidate {
    std::string scene;
    int unknowns;
    const Method* method;
    Trajectory run;
    Timing timing;
  };
  std::vector<Candidate> all;
  std::vector<std::function<void()>> timed;
  std::vector<std::size_t> of;
  for (const std::string& id : scenes) {
    const Scene scene = asked_scene(options, id);
    for (const Method* m : methods) {
      const Knob knob = options.chooses_steps() && m->by_steps ? Knob::steps : m->default_knob();
      Setting setting = setting_of(options, knob);
      // The arithmetic of a step does not depend on its size: a short one keeps every solver stable and
      // finite.
      const double end[] = {scene.duration};
      const Grid grid = knob != Knob::steps ? grid_of_times(end)
                        : options.h
                            ? grid_of_size(end, *options.h)
                            : grid_of_steps(end, options.steps.value_or(options.quick ? 2048 : 16384));
      Candidate c{scene.id, scene.unknowns, m, run_once(*m, scene, setting, grid), {}};
      if (c.run.outcome == Outcome::ok) {
        of.push_back(all.size());
        timed.emplace_back([run = m->prepare(scene, setting).integrate, grid, out = Trajectory{}]() mutable {
          run(grid, out);
        });
      }
      all.push_back(std::move(c));
    }
  }
  const auto measured =
      time_interleaved(timed, options.quick ? TimingPlan{3, 50e-6, 5e-3} : TimingPlan{9, 200e-6, 50e-3});
  for (std::size_t i = 0; i < of.size(); ++i) all[of[i]].timing = measured[i];
  for (const Candidate& c : all) {
    std::vector<Cell> row{text(c.scene), std::int64_t{c.unknowns}, text(c.method->id),
                          text(name_of(c.run.outcome))};
    row.resize(std::size(columns));
    if (c.run.outcome == Outcome::ok && c.run.work.steps > 0) {
      const auto steps = double(c.run.work.steps);
      row[4] = c.run.work.steps;
      row[5] = c.run.work.rhs_evals;
      row[6] = c.timing.min / steps * 1e9;
      row[7] = c.timing.median / steps * 1e9;
      row[8] = c.timing.mad / steps * 1e9;
      row[9] = steps / c.timing.min;
      row[10] = std::int64_t{c.timing.repeats};
    }
    table.add(std::move(row));
  }
  if (options.output) {
    if (*options.output == "-")
      write_stdout(csv(table));
    else
      write_file(*options.output, csv(table));
    return interrupted() ? 130 : 0;
  }
  std::string out = fmt::format("{:<30} {:<22} {:>8} {:>12} {:>12} {:>9}\n", "solver", "scene", "unknowns",
                                "ns/step", "median", "+-");
  for (const Method* m : methods) {
    for (const Candidate& c : all) {
      if (c.method != m) continue;
      out += fmt::format("{:<30} {:<22} {:>8} ", m->id, c.scene, c.unknowns);
      if (c.run.outcome == Outcome::ok && c.run.work.steps > 0) {
        const auto steps = double(c.run.work.steps);
        out += fmt::format("{:>12.1f} {:>12.1f} {:>9.1f}\n", c.timing.min / steps * 1e9,
                           c.timing.median / steps * 1e9, c.timing.mad / steps * 1e9);
      } else {
        out += fmt::format("{}{}\n", name_of(c.run.outcome), c.run.reason.empty() ? "" : ": " + c.run.reason);
      }
    }
  }
  write_stdout(out);
  return interrupted() ? 130 : 0;
}

}  // namespace polhode
