// `bench`: CPU time per step of solvers on scenes, error beside speed, and so what leaving parts out of a
// scene saves. Google Benchmark measures: repetitions of all candidates in random order, by the CPU time of
// the thread.
#include <iostream>
#include <map>
#include <set>
#include <sstream>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "experiments/columns.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/measured_run.hpp"
#include "experiments/result_folder.hpp"

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
    {"real_time_factor", ColumnType::number,
     "seconds of motion in a second of CPU time, from the least time"},
    {"attitude_error_max_rad", ColumnType::number, "largest attitude error over 16 sample times, rad"},
    {"rate_error_max_rel", ColumnType::number, "largest |w - w_exact|/|w_exact|"},
    {"position_error_max_m", ColumnType::number, "largest position error, m"},
};

// From a scene with every part to a particle: a full scene, no translation, a spherical body, rates alone, no
// rotation.
constexpr const char* default_scenes[] = {"spinning-projectile", "tumbling-box",   "hairer-vilmart", "sphere",
                                          "euler-equations",     "thrown-particle"};

struct Case {
  const Scene* scene;
  MeasuredRun run;
  Work work;                    // of the run that is timed: sample times may cost steps
  std::vector<double> seconds;  // of a run, one a repetition

  std::string name() const { return scene->id + '/' + std::string(run.method->id); }
  Timing timing() const {
    Timing t;
    t.repeats = static_cast<int>(seconds.size());
    t.median = median(seconds);
    t.min = seconds.empty() ? t.median : *std::ranges::min_element(seconds);
    std::vector<double> deviations;
    for (const double s : seconds) deviations.push_back(std::abs(s - t.median));
    t.mad = median(std::move(deviations));
    return t;
  }
};

/// Hands the repetitions to their cases, and each report to the library's own JSON.
class Collector : public benchmark::BenchmarkReporter {
 public:
  Collector(std::vector<Case>& cases, const Options& options, std::size_t runs)
      : options_(options), expected_(runs) {
    for (Case& c : cases) of_[c.name()] = &c;
    json_.SetOutputStream(&text_);
    json_.SetErrorStream(&std::cerr);
  }
  bool ReportContext(const Context& context) override { return json_.ReportContext(context); }
  void ReportRuns(const std::vector<Run>& runs) override {
    std::vector<Run> finite = runs;  // JSON has no NaN, which the variation of a zero is
    for (Run& r : finite)
      std::erase_if(r.counters, [](const auto& c) { return !std::isfinite(c.second.value); });
    json_.ReportRuns(finite);
    for (const Run& r : runs) {
      if (r.run_type != Run::RT_Iteration) continue;
      const auto c = of_.find(r.run_name.function_name);
      if (c != of_.end() && r.iterations > 0)
        c->second->seconds.push_back(r.cpu_accumulated_time / static_cast<double>(r.iterations));
      progress(options_, fmt::format("bench: {} of {}", ++seen_, expected_));
    }
  }
  void Finalize() override { json_.Finalize(); }
  std::string json() const { return text_.str(); }

 private:
  const Options& options_;
  std::size_t expected_, seen_ = 0;
  std::map<std::string, Case*> of_;
  std::ostringstream text_;
  benchmark::JSONReporter json_;
};

void measure(benchmark::State& state, const Options& options, const Case& c) {
  const Trajectory& run = c.run.run;
  if (run.outcome != Outcome::ok || interrupted()) {
    state.SkipWithError((std::string(name_of(run.outcome)) + ": " + run.reason).c_str());
    return;
  }
  const auto once = timed_run(options, *c.scene, c.run);
  for (auto _ : state) once();
  const double steps = static_cast<double>(c.work.steps);
  using benchmark::Counter;
  if (steps > 0) {
    state.counters["ns_per_step"] =
        Counter(steps * 1e-9, Counter::kIsIterationInvariantRate | Counter::kInvert);
    state.counters["steps_per_s"] = Counter(steps, Counter::kIsIterationInvariantRate);
    state.counters["steps"] = steps;
  }
  state.counters["rhs_evals"] = static_cast<double>(c.work.rhs_evals);
  state.counters["real_time_factor"] = Counter(c.scene->duration, Counter::kIsIterationInvariantRate);
  const auto error = [&state](const char* name, double x) {
    if (std::isfinite(x)) state.counters[name] = x;
  };
  error("attitude_error_max_rad", c.run.errors.attitude_max);
  error("rate_error_max_rel", c.run.errors.rate_max);
  error("position_error_max_m", c.run.errors.position_max);
  state.SetLabel(c.run.knob == Knob::none ? "nothing to set"
                                          : fmt::format("{} {}", name_of(c.run.knob), shortest(c.run.value)));
}

/// Those asked for; else the first of each family, which is enough to compare machines and versions.
std::vector<const Method*> methods_of(const Options& options) {
  std::vector<const Method*> methods;
  std::set<std::string_view> families;
  for (const Method* m : options.solvers.empty() ? all_methods() : select_methods(options.solvers))
    if (m->family != "truth" &&
        (!options.solvers.empty() || (m->in_studies && families.insert(m->family).second)))
      methods.push_back(m);
  return methods;
}

MeasuredRun run_of(const Options& options, const Scene& scene, const Method& m) {
  MeasuredRun run{&m, options.chooses_steps() && m.by_steps ? Knob::steps : m.default_knob()};
  // The arithmetic of a step does not depend on its size: a short one keeps every solver stable and finite.
  const double end[] = {scene.duration};
  if (run.knob == Knob::steps)
    run.value = static_cast<double>(options.h ? grid_of_size(end, *options.h).steps()
                                              : options.steps.value_or(options.quick ? 2048 : 16384));
  else if (run.knob == Knob::tolerance)
    run.value = options.rtol.value_or(1e-6);
  return run;
}

std::string in_words(const std::vector<Scene>& scenes, const std::vector<Case>& all) {
  std::string out;
  for (const Scene& scene : scenes) {
    out += fmt::format("{}{}, {} unknowns\n", out.empty() ? "" : "\n", scene.id, scene.unknowns);
    std::vector<std::vector<std::string>> lines{
        {"  solver", "setting", "ns/step", "+-", "steps/s", "x real time", "error"}};
    std::string unsupported;
    for (const Case& c : all) {
      if (c.scene != &scene) continue;
      const std::string id(c.run.method->id);
      if (c.run.run.outcome != Outcome::ok) {
        unsupported += fmt::format("  {}: {}: {}\n", id, name_of(c.run.run.outcome), c.run.run.reason);
        continue;
      }
      const Timing t = c.timing();
      const Errors& e = c.run.errors;
      const auto steps = static_cast<double>(c.work.steps);
      const auto of_step = [steps](double s) {
        return steps > 0 ? fmt::format("{:.1f}", s / steps * 1e9) : "-";
      };
      lines.push_back(
          {"  " + id,
           c.run.knob == Knob::none ? "-" : fmt::format("{} {}", name_of(c.run.knob), shortest(c.run.value)),
           of_step(t.min), of_step(t.mad), steps > 0 ? fmt::format("{:.3g}", steps / t.min) : "-",
           fmt::format("{:.3g}", scene.duration / t.min),
           std::isfinite(e.attitude_max) ? fmt::format("{:.1e} rad", e.attitude_max)
           : std::isfinite(e.rate_max)   ? fmt::format("{:.1e} of w", e.rate_max)
                                         : fmt::format("{:.1e} m", e.position_max)});
    }
    out += in_columns(lines) + unsupported;
  }
  return out;
}

Table table_of(const std::vector<Case>& all) {
  Table table{"bench.csv", columns, {}, 3};
  for (const Case& c : all) {
    std::vector<Cell> row{text(c.scene->id), std::int64_t{c.scene->unknowns}, text(c.run.method->id),
                          text(name_of(c.run.run.outcome))};
    row.resize(std::size(columns));
    if (c.run.run.outcome == Outcome::ok && !c.seconds.empty()) {
      const Timing t = c.timing();
      const auto steps = static_cast<double>(c.work.steps);
      row[4] = c.work.steps;
      row[5] = c.work.rhs_evals;
      if (steps > 0) {
        row[6] = t.min / steps * 1e9;
        row[7] = t.median / steps * 1e9;
        row[8] = t.mad / steps * 1e9;
        row[9] = steps / t.min;
      }
      row[10] = std::int64_t{t.repeats};
      row[11] = c.scene->duration / t.min;
      row[12] = number(c.run.errors.attitude_max);
      row[13] = number(c.run.errors.rate_max);
      row[14] = number(c.run.errors.position_max);
    }
    table.add(std::move(row));
  }
  return table;
}

}  // namespace

int bench_verb(const Options& options) {
  std::vector<std::string> ids = options.scenes;
  if (ids.empty()) ids.assign(std::begin(default_scenes), std::end(default_scenes));
  std::vector<Scene> scenes;
  for (const std::string& id : ids) scenes.push_back(asked_scene(options, id));
  std::vector<Case> all;
  for (const Scene& scene : scenes)
    for (const Method* m : methods_of(options)) all.push_back({&scene, run_of(options, scene, *m), {}, {}});
  for_each_run(options, all.size(), [&](std::size_t i) {
    Case& c = all[i];
    const auto times = uniform_times(c.scene->duration, 16);
    find_errors(options, *c.scene, *truth_for({{}, {}, options}, *c.scene, times, "bench", true), times,
                c.run);
    progress(options, "bench: errors, " + c.name());
    c.run.run.samples.clear();
    const double end[] = {c.scene->duration};
    if (c.run.run.outcome == Outcome::ok)
      c.work = run_once(*c.run.method, *c.scene, setting_of(options, c.run), grid_of(c.run, end)).work;
  });

  if (interrupted()) throw Stopped();  // nothing is measured yet

  // The library takes its settings from a command line of its own.
  std::vector<std::string> words{"polhode", "--benchmark_enable_random_interleaving=true",
                                 fmt::format("--benchmark_min_time={}", options.quick ? 0.002 : 0.01)};
  std::vector<char*> arguments;
  for (std::string& w : words) arguments.push_back(w.data());
  int count = static_cast<int>(arguments.size());
  benchmark::Initialize(&count, arguments.data());
  const int repetitions = options.quick ? 3 : 7;
  for (const Case& c : all)
    benchmark::RegisterBenchmark(c.name().c_str(), [&options, &c](benchmark::State& s) {
      measure(s, options, c);
    })->Repetitions(repetitions);
  Collector collector(all, options, all.size() * static_cast<std::size_t>(repetitions));
  benchmark::RunSpecifiedBenchmarks(&collector);
  benchmark::Shutdown();
  progress(options, "");

  const std::string text = options.json     ? collector.json()
                           : options.output ? csv(table_of(all))
                                            : in_words(scenes, all);
  if (options.output && *options.output != "-")
    write_file(*options.output, text);
  else
    write_stdout(text);
  return interrupted() ? 130 : 0;
}

}  // namespace polhode
