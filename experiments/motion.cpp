// Question: what does it look like?
//
// The first turns of every body, exact and by one fixed-step solver of each family, at one step for all that
// is coarse enough to show what each does wrong. The page draws polhodes and tumbling bodies from it; errors
// to be relied on are those of the other questions.
#include <algorithm>
#include <set>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id; the one of family truth is exact"},
    {"knob", ColumnType::text, "steps, or none"},
    {"knob_value", ColumnType::number, "steps over the time shown"},
    {"outcome", ColumnType::text, "ok, or why the run failed; samples up to then are kept"},
    {"t_s", ColumnType::number, "time, s"},
    {"qw", ColumnType::number, "attitude, principal frame to space, scalar first, of the length that it has"},
    {"qx", ColumnType::number, ""},
    {"qy", ColumnType::number, ""},
    {"qz", ColumnType::number, ""},
    {"wx_rad_per_s", ColumnType::number, "angular velocity in the principal frame, rad/s"},
    {"wy_rad_per_s", ColumnType::number, ""},
    {"wz_rad_per_s", ColumnType::number, ""},
};

constexpr std::int64_t sample_count = 200, steps_per_sample = 2;
constexpr double turn_per_sample = 0.35;  // rad; an eye loses the direction of a turn somewhere below pi

/// The time to be shown: all of the scene, or as long as 200 samples can follow the spin.
double window_of(const Scene& scene, const Truth& truth) {
  double fastest = 0;
  for (const WideSample& s : truth.samples) fastest = std::max(fastest, s.w_B.cast<double>().norm());
  return std::min(scene.duration, fastest > 0 ? sample_count * turn_per_sample / fastest : scene.duration);
}

/// The first of each family that steps as it is told and serves the scene, or whoever was asked for.
std::vector<const Method*> shown(const Plan& plan, const Scene& scene) {
  std::vector<const Method*> out;
  std::set<std::string_view> families;
  for (const Method* m : plan.methods) {
    if (m->family == "truth" || !m->by_steps) continue;
    if (plan.options.solvers.empty() && families.count(m->family)) continue;
    if (!m->prepare(scene, setting_of(plan.options, Knob::steps)).integrate) continue;
    families.insert(m->family);
    out.push_back(m);
  }
  return out;
}

}  // namespace

std::vector<Table> motion(const Plan& plan) {
  Table table{"motion.csv", columns, {}};
  refuse_options(plan.options, "motion shows 200 moments of a few turns, two steps apart", true, true, true);
  const auto add = [&table](std::vector<Cell> row, double t, const Quaternion& q, const Vec3& w) {
    for (const double x : {t, q.w(), q.x(), q.y(), q.z(), w.x(), w.y(), w.z()}) row.push_back(number(x));
    table.add(std::move(row));
  };
  for (const Scene& scene : plan.scenes) {
    if (interrupted()) break;
    if (!scene.rotation || !scene.rotation->attitude) continue;
    const auto whole = truth_for(plan, scene, uniform_times(scene.duration, 16), "motion", false);
    if (interrupted()) break;
    const std::vector<const Method*> methods = shown(plan, scene);
    const auto times = uniform_times(window_of(scene, whole->truth), sample_count);
    const auto truth = whole->is_known() ? truth_for(plan, scene, times, "motion", false) : whole;
    if (interrupted()) break;
    if (!truth->is_known()) {
      for (const Method* m : methods) {
        std::vector<Cell> row{text(scene.id), text(m->id), text(name_of(Knob::steps)), Cell(),
                              text(name_of(Outcome::no_truth))};
        row.resize(std::size(columns));
        table.add(std::move(row));
      }
      continue;
    }
    const auto exact = std::find_if(all_methods().begin(), all_methods().end(),
                                    [](const Method* m) { return m->family == "truth"; });
    const std::vector<Cell> head{text(scene.id), text((*exact)->id), text(name_of(Knob::none)), Cell(),
                                 text(name_of(Outcome::ok))};
    for (std::size_t k = 0; k < truth->truth.samples.size(); ++k) {
      const WideSample& s = truth->truth.samples[k];
      add(head, k == 0 ? 0 : times[k - 1], s.q.cast<double>(), s.w_B.cast<double>());
    }
    std::vector<Trajectory> runs(methods.size());
    Grid grid = grid_of_steps(times, sample_count * steps_per_sample);
    grid.from_start = true;
    for_each_run(plan.options, methods.size(), [&](std::size_t i) {
      runs[i] = run_once(*methods[i], scene, setting_of(plan.options, Knob::steps), grid);
      tell_failure(plan.options, scene, *methods[i], runs[i]);
    });
    if (interrupted()) break;
    for (std::size_t i = 0; i < methods.size(); ++i)
      for (const Sample& s : runs[i].samples)
        add({text(scene.id), text(methods[i]->id), text(name_of(Knob::steps)), double(grid.steps()),
             text(name_of(runs[i].outcome))},
            s.t, s.q, s.w_B);
  }
  std::vector<Table> tables;
  tables.push_back(std::move(table));
  return tables;
}

}  // namespace polhode
