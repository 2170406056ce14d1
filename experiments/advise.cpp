// `advise`: which solver, at which setting, reaches an error for the least CPU time; or has the least error
// within a time, or at a given step. Measured here, or read from the work_precision.csv of a result folder.
//
// The rule is that of every ranking here: for each solver, among its runs that ended well with an error
// within the bound, the one with the least time_min_s; ranked by it; a difference within the sum of two
// spreads is a tie.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "experiments/columns.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/search.hpp"
#include "models/errors.hpp"
#include "reports/csv.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"rank", ColumnType::integer, "1: the best"},
    {"tied", ColumnType::boolean, "1: not slower than the first beyond the spread of both"},
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"knob", ColumnType::text, "steps, rtol (absolute tolerance equal to it), or none"},
    {"knob_value", ColumnType::number, "its value; empty: nothing to set"},
    {"norm", ColumnType::text, "which error"},
    {"error", ColumnType::number, "largest over the sample times"},
    {"steps", ColumnType::integer, "accepted steps"},
    {"rhs_evals", ColumnType::integer, "evaluations of the right-hand side"},
    {"time_min_s", ColumnType::number, "CPU time of a run, least of the repeats, s"},
    {"time_median_s", ColumnType::number, "median, s"},
    {"time_mad_s", ColumnType::number, "median absolute deviation, s"},
    {"why", ColumnType::text, "in a sentence"},
    {"command", ColumnType::text, "runs it again"},
};
constexpr std::size_t shown = 10;

struct Advice {
  std::string scene, solver, command;
  const Method* method = nullptr;  // null: of a folder made with solvers that are not here
  Knob knob = Knob::none;
  double value = 0, error = 0;
  std::int64_t steps = 0, rhs_evals = 0;
  Timing timing{};
};

bool tied(const Advice& a, const Advice& first) {
  return a.timing.min - first.timing.min <= a.timing.mad + first.timing.mad;
}

std::string setting_text(const Advice& a) {
  return a.knob == Knob::none ? "nothing to set" : fmt::format("{} {}", name_of(a.knob), shortest(a.value));
}

/// One sentence from claims and counts.
std::string why(const Advice& a, const Advice& first, bool by_time) {
  const double work = static_cast<double>(a.rhs_evals > 0 ? a.rhs_evals : a.steps);
  const double work_of_first = static_cast<double>(first.rhs_evals > 0 ? first.rhs_evals : first.steps);
  const char* unit = a.rhs_evals > 0 ? "right-hand sides" : "steps";
  std::string s;
  if (a.knob == Knob::none) {
    s = "closed form, no steps: the same time for any error";
  } else {
    if (a.method && a.method->claims.attitude_order > 0)
      s = fmt::format("order {}, ", shortest(a.method->claims.attitude_order));
    if (a.knob == Knob::tolerance) s += "chooses its steps, ";
    s +=
        fmt::format("{} {} at {}", static_cast<std::int64_t>(work), unit, duration_text(a.timing.min / work));
  }
  if (a.method) {
    const Claims& c = a.method->claims;
    std::string keeps;
    const auto add = [&keeps](Claim claim, const char* what) {
      if (claim == Claim::yes) keeps += (keeps.empty() ? "" : " and ") + std::string(what);
    };
    add(c.space_momentum, "momentum");
    if (c.space_momentum != Claim::yes) add(c.momentum_magnitude, "|L|");
    add(c.energy_bounded, "energy");
    if (!keeps.empty()) s += fmt::format("; no drift of {} of a free body", keeps);
  }
  if (&a == &first) return s;
  if (by_time && tied(a, first)) return s + "; as fast as the first within the spread";
  const double slower = a.timing.min / first.timing.min;
  s += fmt::format("; {:.3g} x the time of the first", slower);
  const bool comparable = (a.rhs_evals > 0) == (first.rhs_evals > 0) && work > 0 && work_of_first > 0 &&
                          a.knob != Knob::none && first.knob != Knob::none;
  if (comparable)
    s += fmt::format(": {:.3g} x the {}, {:.3g} x the time of each", work / work_of_first, unit,
                     slower / (work / work_of_first));
  return s;
}

struct Asked {
  Goal goal;
  std::vector<double> times;
  std::string command_tail;  // of `simulate`: what makes the same samples
  std::string aim;           // in words
};

Asked asked_of(const Options& options, const Scene& scene, const Norm& norm) {
  Asked a;
  const std::string unit = norm.unit.empty() ? "" : " " + std::string(norm.unit);
  a.goal.error = options.error;
  if (!options.error) a.goal.budget_s = options.budget_s;  // beside an error: a limit of what is told
  std::int64_t samples = 16;
  double end = scene.duration;
  if (options.error)
    a.aim = fmt::format("{} error of at most {}{}", norm.name, shortest(*options.error), unit);
  if (options.budget_s && options.error)
    a.aim += fmt::format(" within {} of CPU time", duration_text(*options.budget_s));
  else if (options.budget_s)
    a.aim = fmt::format("least {} error within {} of CPU time", norm.name, duration_text(*options.budget_s));
  if (options.engine_step) {
    const double h = *options.engine_step;
    const double steps = std::floor(scene.duration / h * (1 + 1e-12));
    if (!(steps >= 1) || steps > 1e9)
      throw UsageError(
          fmt::format("--engine-step: {} s goes {:.3g} times into the {} s of '{}'; needs 1 to 1e9",
                      shortest(h), scene.duration / h, scene.duration, scene.id));
    a.goal.steps = static_cast<std::int64_t>(steps);
    // As many samples, up to 16, as divide the steps evenly.
    while (*a.goal.steps % samples != 0) --samples;
    end = std::abs(steps * h - scene.duration) < 1e-9 * scene.duration ? scene.duration : steps * h;
    a.aim = fmt::format("{} at {} steps of {} s",
                        a.aim.empty() ? fmt::format("least {} error", norm.name) : a.aim, *a.goal.steps,
                        shortest(h));
  }
  a.times = uniform_times(end, samples);
  a.command_tail = fmt::format(" --samples {}", samples);
  if (options.atol) a.command_tail += " --atol " + shortest(*options.atol);
  if (options.duration || end != scene.duration) a.command_tail += " --duration " + shortest(end);
  return a;
}

void print(const Options& options, const std::vector<Advice>& ranked, const std::string& scene,
           const Norm& norm, const std::string& aim, bool by_time, const std::string& notes) {
  Table table{"advice.csv", columns, {}, 4};
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    const Advice& a = ranked[i];
    table.add({std::int64_t(i + 1), std::int64_t{by_time && tied(a, ranked.front())}, a.scene, a.solver,
               text(name_of(a.knob)), a.knob == Knob::none ? Cell() : Cell(a.value), text(norm.name), a.error,
               a.steps, a.rhs_evals, a.timing.min, number(a.timing.median), number(a.timing.mad),
               why(a, ranked.front(), by_time), a.command});
  }
  if (options.json) {
    write_stdout(json(table));
    return;
  }
  std::string out = fmt::format("{}: {}\n\n", scene, aim);
  if (ranked.empty()) {
    write_stdout(out + "No solver gets there.\n" + notes);
    return;
  }
  std::vector<std::vector<std::string>> lines{{"", "solver", "setting", "error", "time", "+-", "rhs"}};
  for (std::size_t i = 0; i < std::min(ranked.size(), shown); ++i) {
    const Advice& a = ranked[i];
    lines.push_back({fmt::format("{}{}", i + 1, by_time && i > 0 && tied(a, ranked.front()) ? "=" : " "),
                     a.solver, setting_text(a),
                     fmt::format("{:.2g}{}{}", a.error, norm.unit.empty() ? "" : " ", norm.unit),
                     duration_text(a.timing.min), duration_text(a.timing.mad), std::to_string(a.rhs_evals)});
  }
  out += in_columns(lines) + '\n';
  for (std::size_t i = 0; i < std::min(ranked.size(), shown); ++i)
    out += fmt::format("{:>2} {}: {}.\n", i + 1, ranked[i].solver, why(ranked[i], ranked.front(), by_time));
  out += '\n';
  if (ranked.size() > shown)
    out += fmt::format("{} more get there (--json lists them)\n", ranked.size() - shown);
  out += notes;
  const auto ties =
      std::count_if(ranked.begin(), ranked.end(), [&](const Advice& a) { return tied(a, ranked.front()); });
  if (by_time && ties > 1)
    out += fmt::format("The first {} are as fast as each other within the spread (=).\n", ties);
  if (!ranked.front().command.empty()) out += fmt::format("To run it: {}\n", ranked.front().command);
  write_stdout(out);
}

int advise_on_scene(const Options& options) {
  const Scene whole = asked_scene(options, options.scenes.front());
  const Norm& norm = norm_of(whole, options.norm);
  const Asked asked = asked_of(options, whole, norm);
  Scene scene = whole;
  scene.duration = asked.times.back();
  progress(options, "advise: " + scene.id + ", truth");
  const auto truth = needed_truth_of(scene, asked.times, options);
  std::vector<const Method*> methods;
  for (const Method* m : options.solvers.empty() ? all_methods() : select_methods(options.solvers))
    if (m->in_studies || !options.solvers.empty()) methods.push_back(m);
  const std::vector<Found> found = search(options, scene, *truth, asked.times, methods, norm, asked.goal);
  progress(options, "");
  if (interrupted()) throw Stopped();

  std::vector<Advice> ranked;
  std::vector<std::string> slow, missed, failed, unsupported;
  for (const Found& f : found) {
    const MeasuredRun& m = f.best;
    const std::string id(m.method->id);
    switch (f.status) {
      case Found::Status::found:
        if (m.timing.repeats == 0) {
          slow.push_back(id);
          break;
        }
        ranked.push_back(
            {scene.id, id,
             fmt::format(
                 "polhode simulate {} --solver {}{}{}", options.scenes.front(), id,
                 m.knob == Knob::none ? "" : fmt::format(" --{} {}", name_of(m.knob), shortest(m.value)),
                 asked.command_tail),
             m.method, m.knob, m.value, f.error, f.work.steps, f.work.rhs_evals, m.timing});
        break;
      case Found::Status::too_slow:
        slow.push_back(id);
        break;
      case Found::Status::out_of_reach:
        missed.push_back(id);
        break;
      case Found::Status::failed:
        failed.push_back(id);
        break;
      case Found::Status::unsupported:
        unsupported.push_back(id);
        break;
    }
  }
  std::string notes;
  const auto note = [&](const std::vector<std::string>& ids, const char* what) {
    if (ids.empty()) return;
    notes += fmt::format("{} {}{}\n", ids.size(), what, options.verbose ? ": " + name_list(ids) : "");
  };
  if (options.error && options.budget_s) {
    std::vector<std::string> over;
    std::erase_if(ranked, [&](const Advice& a) {
      const bool is_over = a.timing.min > *options.budget_s;
      if (is_over) over.push_back(a.solver);
      return is_over;
    });
    note(over, "get there in more than that time");
  }
  note(slow, asked.goal.budget_s ? "are too slow for that time" : "are far slower");
  note(missed, "do not get there");
  note(failed, "fail on this scene");
  note(unsupported, "do not serve this scene");
  if (!notes.empty() && !options.verbose) notes += "(-v names them)\n";
  const double floor = norm.name == "attitude" ? truth->floor().attitude
                       : norm.name == "rate"   ? truth->floor().rate
                                               : 0;
  if (options.error && *options.error < floor)
    notes += fmt::format(
        "Note: {} lies below what double precision resolves on this scene, {:.1e}: who gets there "
        "is luck, but for closed forms.\n",
        shortest(*options.error), floor);
  print(options, ranked, scene.id, norm, asked.aim, asked.goal.error.has_value(), notes);
  return ranked.empty() ? 1 : 0;
}

int advise_on_folder(const Options& options) {
  const std::filesystem::path folder = options.scenes.front();
  const auto file = folder / "work_precision.csv";
  if (!std::filesystem::exists(file))
    throw InputError("'" + folder.string() +
                     "' holds no work_precision.csv; needs a result folder of study or "
                     "work-precision");
  if (options.engine_step)
    throw UsageError("--engine-step: a folder has only the steps that it was made with");
  report::CsvTable table;
  try {
    table = report::read_csv(file);
  } catch (const std::runtime_error& e) {
    throw InputError(e.what());
  }
  std::vector<std::string> scenes;
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (scenes.empty() || scenes.back() != table.text(i, "scene")) scenes.push_back(table.text(i, "scene"));
  if (options.scenes.size() == 1 && scenes.size() != 1)
    throw UsageError(fmt::format("'{}' has the scenes {}; say which: polhode advise FOLDER SCENE",
                                 folder.string(), name_list(scenes)));
  const std::string scene = options.scenes.size() > 1 ? options.scenes[1] : scenes.front();
  if (std::ranges::find(scenes, scene) == scenes.end())
    throw UsageError(
        fmt::format("'{}' has no scene '{}'; it has {}", folder.string(), scene, name_list(scenes)));
  const Norm* norm = nullptr;
  for (const Norm& n : all_norms()) {
    if (!options.norm.empty() && options.norm != n.name) continue;
    bool any = false;
    for (std::size_t i = 0; i < table.rows() && !any; ++i)
      any = table.text(i, "scene") == scene && std::isfinite(table.number(i, n.column));
    if (any && !norm) norm = &n;
  }
  if (!norm) throw InputError(file.string() + ": no row of '" + scene + "' has such an error");

  std::vector<Advice> all;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.text(i, "scene") != scene || table.text(i, "outcome") != "ok") continue;
    Advice a;
    a.scene = scene;
    a.solver = table.text(i, "solver");
    a.error = table.number(i, norm->column);
    a.timing = {table.number(i, "time_min_s"), table.number(i, "time_median_s"),
                table.number(i, "time_mad_s"), 1};
    if (!(a.timing.min > 0) || !std::isfinite(a.error)) continue;
    if (options.error && a.error > *options.error) continue;
    if (options.budget_s && a.timing.min > *options.budget_s) continue;
    for (const Knob k : {Knob::steps, Knob::tolerance, Knob::none})
      if (table.text(i, "knob") == name_of(k)) a.knob = k;
    if (a.knob != Knob::none) a.value = table.number(i, "knob_value");
    const auto count = [&](const char* column) {
      const double x = table.number(i, column);
      return x > 0 && x < 1e18 ? static_cast<std::int64_t>(x) : 0;
    };
    a.steps = count("steps");
    a.rhs_evals = count("rhs_evals");
    for (const Method* m : all_methods())
      if (m->id == a.solver) a.method = m;
    all.push_back(std::move(a));
  }
  const auto better = [&](const Advice& a, const Advice& b) {
    return options.error ? a.timing.min < b.timing.min
                         : std::pair(a.error, a.timing.min) < std::pair(b.error, b.timing.min);
  };
  std::ranges::stable_sort(all, better);
  std::vector<Advice> ranked;  // the best run of each solver
  for (Advice& a : all)
    if (std::ranges::none_of(ranked, [&a](const Advice& b) { return a.solver == b.solver; }))
      ranked.push_back(std::move(a));
  std::string aim = options.error
                        ? fmt::format("{} error of at most {}", norm->name, shortest(*options.error))
                        : fmt::format("least {} error", norm->name);
  if (options.budget_s) aim += " within " + duration_text(*options.budget_s);
  aim += ", as measured in " + folder.string();
  print(options, ranked, scene, *norm, aim, options.error.has_value(), "");
  return ranked.empty() ? 1 : 0;
}

}  // namespace

int advise_verb(const Options& options) {
  if (options.scenes.empty() || options.scenes.size() > 2)
    throw UsageError("advise needs one scene, or a result folder and which of its scenes");
  if (!options.error && !options.budget_s && !options.engine_step)
    throw UsageError("advise needs --error E (the error to reach), --budget TIME or --engine-step H");
  if (std::filesystem::is_directory(options.scenes.front())) return advise_on_folder(options);
  if (options.scenes.size() > 1)
    throw UsageError("advise takes one scene at a time; '" + options.scenes.front() +
                     "' is no result folder");
  return advise_on_scene(options);
}

}  // namespace polhode
