// Question: which physics engine is right about a spinning body, at which step size, and at what price?
//
// Every row of every engine that is there (those left out of other studies too), in each precision, on the
// scenes whose body turns freely: there whatever is lost or gained is the engine's doing alone. Beside them
// our own solvers of the same order, found by what they claim: the first that keeps nothing, the first that
// keeps the attitude a rotation, the first that keeps the momentum too; and the first that chooses its own
// steps.
//
// Errors are the largest over 16 common times. Time is that of the step loop alone; a step costs the same
// whatever its size, so rungs of more than 10000 steps take the time of the last that was measured.
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"
#include "experiments/stopwatch.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"precision", ColumnType::text, "of its arithmetic: double or single"},
    {"mode", ColumnType::text,
     "how the engine treats the gyroscopic term, or its integrator; empty: not an engine"},
    {"steps", ColumnType::integer, "steps over the duration; accepted ones where the solver chooses them"},
    {"h_s", ColumnType::number, "step size, s; the mean where the solver chooses it"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"attitude_error_max_rad", ColumnType::number, "largest attitude error over the sample times, rad"},
    {"rate_error_max_rel", ColumnType::number, "largest |w - w_exact|/|w_exact|"},
    {"energy_error_max_rel", ColumnType::number, "largest |E - E_exact|/|E(0)| of the rotation"},
    {"momentum_error_max_rel", ColumnType::number, "largest |L - L_exact|/|L(0)|"},
    {"momentum_direction_error_max_rad", ColumnType::number, "largest angle between L and L_exact, rad"},
    {"attitude_order", ColumnType::number, "slope to the row before; of steps alone"},
    {"energy_order", ColumnType::number, "slope to the row before; of steps alone"},
    {"momentum_order", ColumnType::number, "slope to the row before; of steps alone"},
    {"ns_per_step", ColumnType::number, "CPU time of a step, least of the repeats, ns"},
    {"real_time_factor", ColumnType::number, "seconds simulated in a second of CPU time"},
    {"knob", ColumnType::text, "steps or rtol"},
    {"knob_value", ColumnType::number, "its value"},
    {"verdict", ColumnType::text, "of this solver on this scene, in words; the same in each of its rows"},
};

constexpr std::int64_t longest_timed = 10'000;  // steps
constexpr std::int64_t patience = 20'000;       // steps of a solver that chooses them

struct Rung {
  Knob knob = Knob::steps;
  double value = 0;
  Trajectory run;
  Errors errors{};
  double direction = 0;      // rad
  double energy_gain = 0;    // relative, at the end
  double ns = std::nan("");  // per step
};
struct Ladder {
  const Method* method;
  std::vector<Rung> rungs;
};

bool is_engine(const Method& m) { return m.family == "engine"; }

/// "implicit-body" of bullet-implicit-body-f32: what follows the engine's name.
std::string mode_of(const Method& m) {
  if (!is_engine(m)) return "";
  std::string_view id = m.id;
  if (id.ends_with("-f32")) id.remove_suffix(4);
  const std::size_t dash = id.find('-');
  return dash == std::string_view::npos ? "default" : std::string(id.substr(dash + 1));
}

/// Engines, and beside them solvers of our own (no library's version) with the orders that engines claim and
/// the fourth, which the best of them have in a part.
std::vector<const Method*> asked_methods(const Plan& plan) {
  if (!plan.options.solvers.empty()) return plan.methods;
  std::vector<const Method*> chosen;
  const auto first = [&chosen](const auto& fits) {
    for (const Method* m : all_methods())
      if (m->family != "truth" && m->family != "closed form" && !is_engine(*m) && m->version.empty() &&
          fits(*m)) {
        chosen.push_back(m);
        return;
      }
  };
  for (const double order : {1.0, 2.0, 4.0}) {
    const auto of_order = [order](const Method& m) { return m.by_steps && m.claims.attitude_order == order; };
    first([&](const Method& m) {
      return of_order(m) && m.claims.unit_attitude == Claim::no && m.claims.space_momentum == Claim::no;
    });
    first([&](const Method& m) {
      return of_order(m) && m.claims.unit_attitude == Claim::yes && m.claims.space_momentum == Claim::no;
    });
    first([&](const Method& m) { return of_order(m) && m.claims.space_momentum == Claim::yes; });
  }
  first([](const Method& m) { return m.by_tolerance; });
  std::vector<const Method*> methods;
  for (const Method* m : all_methods())  // in the order of the registry
    if (is_engine(*m) || std::find(chosen.begin(), chosen.end(), m) != chosen.end()) methods.push_back(m);
  return methods;
}

bool turns_freely(const Scene& s) { return s.rotation && s.rotation->attitude && s.rotation->loads.empty(); }

std::vector<Rung> empty_rungs(const Method& m, bool quick) {
  std::vector<Rung> rungs;
  const auto add = [&rungs](Knob knob, double value) {
    rungs.emplace_back();
    rungs.back().knob = knob;
    rungs.back().value = value;
  };
  if (m.default_knob() == Knob::tolerance)
    for (int k = 3; k <= (quick ? 5 : 9); k += 2) add(Knob::tolerance, std::pow(10.0, -k));
  else if (quick)
    for (const double n : {1000.0, 2000.0, 10'000.0}) add(Knob::steps, n);
  else
    for (const double n : {600.0, 1000.0, 2000.0, 5000.0, 10e3, 20e3, 50e3, 100e3}) add(Knob::steps, n);
  return rungs;
}

double angle(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// The best of a ladder and where, of the rungs that ended well.
const Rung* best_of(const Ladder& ladder, double Errors::*error) {
  const Rung* best = nullptr;
  for (const Rung& r : ladder.rungs)
    if (r.run.outcome == Outcome::ok && (!best || r.errors.*error < best->errors.*error)) best = &r;
  return best;
}

double slope(const Rung& before, const Rung& now, double Errors::*error) {
  return std::log(before.errors.*error / now.errors.*error) / std::log(now.value / before.value);
}

std::string knob_text(const Scene& scene, const Rung& r) {
  return r.knob == Knob::steps ? fmt::format("h = {:.3g} s", scene.duration / r.value)
                               : fmt::format("rtol = {:.0e}", r.value);
}

/// What the numbers say, in words.
std::string verdict_of(const Scene& scene, const Ladder& ladder, bool has_floor) {
  const Rung *first = nullptr, *last = nullptr;
  std::string failed;
  for (const Rung& r : ladder.rungs) {
    if (r.run.outcome == Outcome::ok) {
      if (!first) first = &r;
      last = &r;
    } else {
      failed = fmt::format("; {} at {}: {}", name_of(r.run.outcome), knob_text(scene, r), r.run.reason);
    }
  }
  if (!first) return failed.empty() ? "not run" : failed.substr(2);
  const Errors &coarse = first->errors, &fine = last->errors;
  std::string out;
  // Smaller steps must bring the momentum nearer, if the motion is the right one. (Not the energy, which a
  // wrong motion may keep.)
  const bool converges =
      first == last || coarse.momentum_max < 1e-6 || fine.momentum_max < 0.5 * coarse.momentum_max;
  if (!converges)
    out = fmt::format("not this motion at any step size: momentum off by {:.2g} %", 100 * fine.momentum_max);
  else
    out = fmt::format("converges to this motion: at {} momentum within {:.1e}", knob_text(scene, *last),
                      fine.momentum_max);
  const double rounding = 1e3 * ladder.method->epsilon;
  if (coarse.energy_max < rounding)
    out += ", energy kept to rounding";
  else if (coarse.energy_max < 1e-4)
    out += fmt::format(", energy within {:.1e} at {}", coarse.energy_max, knob_text(scene, *first));
  else
    out += fmt::format(", energy {}: {:.2g} % at {}", first->energy_gain > 0 ? "gained" : "lost",
                       100 * std::abs(first->energy_gain), knob_text(scene, *first));
  if (first->knob == Knob::steps && converges) {
    const char* separator = "; order ";
    for (const auto& [member, of] :
         {std::pair{&Errors::attitude_max, "attitude"}, {&Errors::energy_max, "energy"}}) {
      std::vector<double> h, errors;
      for (const Rung& r : ladder.rungs)
        if (r.run.outcome == Outcome::ok)
          h.push_back(scene.duration / r.value), errors.push_back(r.errors.*member);
      // From a third on, of a radian or of the energy, an error is no longer a power of the step.
      if (const auto order = observed_order(h, errors, rounding, 0.3))
        out += fmt::format("{}{:.1f} in {}", std::exchange(separator, ", "), order->slope, of);
    }
  }
  // Away from the floor of doubles, an attitude that smaller steps make worse is the rounding of the engine.
  const Rung* best = best_of(ladder, &Errors::attitude_max);
  if (has_floor && best != last && last->errors.attitude_max > 1.1 * best->errors.attitude_max)
    out += fmt::format("; rounding makes the attitude worse below {}: {:.1e} rad there, {:.1e} rad at {}",
                       knob_text(scene, *best), best->errors.attitude_max, last->errors.attitude_max,
                       knob_text(scene, *last));
  else
    out += fmt::format("; attitude within {:.1e} rad", best->errors.attitude_max);
  if (last->ns == last->ns) out += fmt::format("; {:.0f} ns a step", last->ns);
  return out + failed;
}

void measure(const Plan& plan, const Scene& scene, const SceneTruth& truth, std::span<const double> times,
             std::vector<Ladder>& ladders) {
  std::vector<std::pair<const Method*, Rung*>> all;
  for (Ladder& l : ladders)
    for (Rung& r : l.rungs) all.emplace_back(l.method, &r);
  const auto setting = [&plan](const Rung& r) {
    Setting s = setting_of(plan.options, r.knob);
    if (r.knob == Knob::tolerance) {
      s.rtol = r.value;
      s.step_limit = patience;
    }
    return s;
  };
  const auto grid = [](const Rung& r, std::span<const double> at) {
    return r.knob == Knob::steps ? grid_of_steps(at, static_cast<std::int64_t>(r.value)) : grid_of_times(at);
  };
  for_each_run(plan.options, all.size(), [&](std::size_t i) {
    const auto& [method, rung] = all[i];
    progress(plan.options, "engines: " + scene.id + ", " + std::string(method->id));
    rung->run = run_once(*method, scene, setting(*rung), grid(*rung, times));
    tell_failure(plan.options, scene, *method, rung->run);
    if (rung->run.outcome != Outcome::ok) return;
    rung->errors = errors_of(scene, truth, rung->run.samples, 1, method->epsilon);
    for (std::size_t k = 0; k < rung->run.samples.size(); ++k)
      rung->direction = std::max(rung->direction,
                                 angle(rung->run.samples[k].L, truth.truth.samples[k + 1].L.cast<double>()));
    const double E0 = truth.truth.samples.front().rotational_energy.convert_to<double>();
    rung->energy_gain = rung->run.samples.back().rotational_energy / E0 - 1;
  });
  if (interrupted()) return;

  progress(plan.options, "engines: " + scene.id + ", clock");
  std::vector<std::function<void()>> timed;
  std::vector<Rung*> of;
  const double end[] = {scene.duration};
  for (const auto& [method, rung] : all) {
    if (rung->run.outcome != Outcome::ok || rung->run.work.steps > longest_timed) continue;
    timed.emplace_back([run = method->prepare(scene, setting(*rung)).integrate, g = grid(*rung, end),
                        out = Trajectory{}]() mutable { run(g, out); });
    of.push_back(rung);
  }
  const auto measured = time_interleaved(timed, TimingPlan{plan.options.quick ? 3 : 5, 50e-6, 5e-3});
  for (std::size_t i = 0; i < of.size(); ++i)
    of[i]->ns = 1e9 * measured[i].min / static_cast<double>(of[i]->run.work.steps);
  for (Ladder& l : ladders)
    for (std::size_t i = 1; i < l.rungs.size(); ++i)
      if (Rung& r = l.rungs[i]; r.run.outcome == Outcome::ok && r.ns != r.ns) r.ns = l.rungs[i - 1].ns;
}

}  // namespace

std::vector<Table> engines(const Plan& plan) {
  Table table{"engines.csv", columns, {}};
  refuse_options(plan.options, "engines makes its own ladders of steps, tolerances and sample times", true,
                 true, true);
  const std::vector<const Method*> methods = asked_methods(plan);
  for (const Scene& scene : plan.scenes) {
    if (interrupted()) break;
    if (!turns_freely(scene)) continue;
    const auto times = uniform_times(scene.duration, 16);
    const auto truth = truth_for(plan, scene, times, "engines", true);
    if (interrupted()) break;
    std::vector<Ladder> ladders;
    for (const Method* m : methods)
      if (m->default_knob() != Knob::none && m->family != "truth")
        ladders.push_back({m, empty_rungs(*m, plan.options.quick)});
    if (!truth->is_known()) {
      for (const Ladder& l : ladders) {
        const Knob knob = l.rungs.front().knob;
        const Trajectory run = run_without_truth(*l.method, scene, setting_of(plan.options, knob), *truth);
        std::vector<Cell> row{text(scene.id), text(l.method->id), text(precision_of(*l.method)),
                              mode_of(*l.method)};
        row.resize(std::size(columns));
        row[6] = text(name_of(run.outcome));
        row[17] = text(name_of(knob));
        row[19] = fmt::format("{}: {}", name_of(run.outcome), run.reason);
        table.add(std::move(row));
      }
      continue;
    }
    measure(plan, scene, *truth, times, ladders);
    if (interrupted()) break;  // a scene is reported whole or not at all
    for (const Ladder& l : ladders) {
      const bool has_floor = l.method->epsilon > 1e-10;
      const Cell verdict = verdict_of(scene, l, has_floor);
      const Rung* before = nullptr;
      for (const Rung& r : l.rungs) {
        std::vector<Cell> row{text(scene.id), text(l.method->id), text(precision_of(*l.method)),
                              mode_of(*l.method)};
        row.resize(std::size(columns));
        row[6] = text(name_of(r.run.outcome));
        const bool ok = r.run.outcome == Outcome::ok;
        if (r.knob == Knob::steps) {
          row[4] = static_cast<std::int64_t>(r.value);
          row[5] = scene.duration / r.value;
        } else if (ok) {
          row[4] = r.run.work.steps;
          row[5] = scene.duration / static_cast<double>(r.run.work.steps);
        }
        if (ok) {
          row[7] = number(r.errors.attitude_max);
          row[8] = number(r.errors.rate_max);
          row[9] = number(r.errors.energy_max);
          row[10] = number(r.errors.momentum_max);
          row[11] = number(r.direction);
          if (before && r.knob == Knob::steps) {
            row[12] = number(slope(*before, r, &Errors::attitude_max));
            row[13] = number(slope(*before, r, &Errors::energy_max));
            row[14] = number(slope(*before, r, &Errors::momentum_max));
          }
          row[15] = number(r.ns);
          row[16] = number(1e9 * scene.duration / (r.ns * static_cast<double>(r.run.work.steps)));
        }
        before = ok ? &r : nullptr;
        row[17] = text(name_of(r.knob));
        row[18] = r.value;
        row[19] = verdict;
        table.add(std::move(row));
      }
    }
  }
  std::vector<Table> tables;
  tables.push_back(std::move(table));
  return tables;
}

}  // namespace polhode
