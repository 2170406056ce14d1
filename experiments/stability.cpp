// Question: how large a step does each solver survive, and what does a right answer cost, where a scene is
// stiff?
//
// The dial of a scene is set to each of its values. The step grows from a thousandth of the fastest time
// until the energy does (experiments/energy_growth.hpp), then is bisected: the largest stable step is the
// first limit met, from every one of three starts. Beside it the limit of linear theory, from the method's
// own stability function. "Did not blow up" is not "is right": the largest steps that reach an error of 1e-3
// and 1e-6 over the duration follow, with their right-hand sides, and the order at which the error falls
// while the step is still long beside the fastest time (a method may lose orders there).
//
// Asked alone, without scenes, the question is wider: the gyroscopic map, the extreme cases and what
// tolerances do belong to it (stability_map.csv, extremes.csv, tolerance.csv).
#include "experiments/stability.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "experiments/energy_growth.hpp"
#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/linear_theory.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"parameter", ColumnType::text, "the dial: the place of a number in the scene file"},
    {"parameter_value", ColumnType::number, "its value, in the unit of the scene file"},
    {"h_s", ColumnType::number, "the smallest step tried that failed, s; empty: none did"},
    {"outcome", ColumnType::text, "how the run at h_s ended (ok: it ended, but had gained energy)"},
    {"largest_stable_h_s", ColumnType::number,
     "largest step that is stable from every start, s; empty: the smallest tried failed"},
    {"theory_h_s", ColumnType::number,
     "limit of linear theory, s; empty: there is none, or no stability function"},
    {"energy_growth_per_step", ColumnType::number, "(E_end/E_start)^(1/steps) - 1 at h_s"},
    {"fastest_per_s", ColumnType::number, "modulus of the fastest eigenvalue, 1/s"},
    {"largest_tried_h_s", ColumnType::number, "largest step tried, s"},
    {"fast_mode_left", ColumnType::number,
     "what one step of 1e6 fastest times leaves of the fastest decay: 0 if L-stable, 1 if A-stable alone"},
    {"largest_accurate_h_1e3_s", ColumnType::number,
     "largest step with errors (rad, relative rates) below 1e-3, s"},
    {"largest_accurate_h_1e6_s", ColumnType::number, "largest step with errors below 1e-6, s"},
    {"rhs_evals_1e3", ColumnType::integer, "right-hand sides of the whole run at the step of 1e-3"},
    {"rhs_evals_1e6", ColumnType::integer, "right-hand sides of the whole run at the step of 1e-6"},
    {"order_while_stiff", ColumnType::number,
     "order of the error while h times the fastest rate is above 10"},
    {"claimed_order", ColumnType::number, "order that the solver claims where nothing is stiff"},
    {"largest_stable_near_rest_h_s", ColumnType::number,
     "largest step that is stable next to rest, s: what theory speaks of; empty: none, or the scene has no "
     "rest"},
};
constexpr std::size_t key_columns = 4;
/// Turns of the fastest oscillation beyond which a truth in 50 digits takes minutes [rad].
constexpr double longest_truth = 5000;

/// Where runs start: next to rest, where theory holds, in scenes of drags and springs, else turned far; as
/// given; turned.
std::vector<Scene> starts_of(const Scene& scene, const Linearised& linear) {
  const Vec3 skew = Vec3(1, 2, 3).normalized();
  // Next to rest all but a hundredth is in the fastest mode. That hundredth wakes the others: the limit of an
  // axis with less damping may come first, and a matrix that turns about one axis never leaves it.
  const Vec3 mostly_fast = (linear.fast_axis + 0.01 * skew).normalized();
  Scene far = scene, near = scene;
  if (linear.at_rest) near.rotation->w0 = 1e-3 * scene.rotation->w0.norm() * mostly_fast;
  if (!scene.rotation->attitude) return {near, scene};
  const auto turned = [](const Quaternion& q, double angle, const Vec3& axis) {
    return q * Quaternion(Eigen::AngleAxisd(angle, axis));
  };
  const Quaternion q = normalised(scene.rotation->q0);
  near.rotation->q0 = linear.at_rest ? turned(rest_attitude(scene), 1e-3, mostly_fast) : turned(q, 2.0, skew);
  far.rotation->q0 = turned(q, 0.5, skew);
  return {near, scene, far};
}

struct Limit {
  double stable = 0, failed = 0, tried = 0;  // s; 0: none
  EnergyGrowth at_failure;
};

/// factor     between two steps of the scan; precision: of the bisection after it
Limit largest_stable_step(const std::vector<Integration>& runs, double fastest, double low, double high,
                          double factor, double precision) {
  const auto try_step = [&](double h) {
    // Three periods of the fastest motion where the steps allow it: over less, damping has not had its share.
    const auto steps = static_cast<std::int64_t>(std::clamp(20 / (h * fastest), 1024.0, 4096.0));
    EnergyGrowth worst;
    for (const Integration& run : runs) {
      worst = energy_growth(run, h, steps);
      if (!worst.stable) break;
    }
    return worst;
  };
  Limit limit;
  for (double h = low; limit.failed == 0 && !interrupted();) {
    const EnergyGrowth g = try_step(h);
    limit.tried = h;
    if (!g.stable) {
      limit.failed = h;
      limit.at_failure = g;
    } else {
      limit.stable = h;
      if (h >= high) break;
      h = std::min(high, h * (h < 0.1 / fastest ? std::sqrt(10) : h < 100 / fastest ? factor : 10));
    }
  }
  while (limit.stable > 0 && limit.failed > limit.stable * precision && !interrupted()) {
    const double middle = std::sqrt(limit.stable * limit.failed);
    const EnergyGrowth g = try_step(middle);
    if (g.stable) {
      limit.stable = middle;
    } else {
      limit.failed = middle;
      limit.at_failure = g;
    }
  }
  return limit;
}

/// What is left of the fastest decay after one long step, where linear theory would have R(-1e6).
double fast_mode_left(const Method& method, const Scene& scene, const Linearised& linear,
                      const Setting& setting) {
  Scene start = scene;
  constexpr double small = 1e-6;  // of the fastest rate and more than rounding
  start.rotation->w0 = small * *linear.fast_rates;
  if (scene.rotation->attitude) {
    const Vec3 turn = small * linear.fast_turn;
    start.rotation->q0 = rest_attitude(scene) * Quaternion(1, turn.x(), turn.y(), turn.z());
  }
  Grid grid;
  grid.stretches.push_back({1e6 / linear.fastest, 1, 1e6 / linear.fastest});
  const Trajectory run = run_once(method, start, setting, grid);
  return run.outcome == Outcome::ok && !run.samples.empty() ? run.samples.back().w_B.norm() / small
                                                            : std::numeric_limits<double>::quiet_NaN();
}

struct Accurate {
  double h = 0;
  std::int64_t rhs_evals = 0;
};
struct Accuracy {
  Accurate at_1e3, at_1e6;
  double order_while_stiff = std::numeric_limits<double>::quiet_NaN();
};

/// A ladder of doubled steps up to `most`, refined where it crosses a bound.
Accuracy accuracy(const Plan& plan, const Method& method, const Scene& scene, const SceneTruth& truth,
                  std::span<const double> times, double fastest, double stable_h, std::int64_t most) {
  Setting setting = setting_of(plan.options, Knob::steps);
  setting.timeout_s = std::min(setting.timeout_s, plan.options.quick ? 0.5 : 5.0);
  const auto error = [&](std::int64_t steps, std::int64_t& rhs_evals) {
    const Trajectory run = run_once(method, scene, setting, grid_of_steps(times, steps));
    rhs_evals = run.work.rhs_evals;
    if (run.outcome != Outcome::ok) return std::numeric_limits<double>::infinity();
    const Errors e = errors_of(scene, truth, run.samples, 1, method.epsilon);
    return scene.rotation->attitude ? std::max(e.attitude_max, e.rate_max) : e.rate_max;
  };
  Accuracy result;
  std::vector<double> h, e;
  const auto reach = [&](Accurate& a, double bound, std::int64_t coarse, std::int64_t fine,
                         std::int64_t work) {
    // To a tenth in the number of steps; `coarse` misses the bound, `fine` meets it.
    while (fine > coarse + std::max<std::int64_t>(1, coarse / 10)) {
      const std::int64_t middle = (coarse + fine) / 2;
      std::int64_t rhs_evals = 0;
      if (error(middle, rhs_evals) <= bound) {
        fine = middle;
        work = rhs_evals;
      } else {
        coarse = middle;
      }
    }
    a = {scene.duration / static_cast<double>(fine), work};
  };
  // A step that is not stable is not accurate either.
  std::int64_t steps = 8;
  while (stable_h > 0 && scene.duration / static_cast<double>(steps) > 2 * stable_h) steps *= 2;
  for (std::int64_t before = 0; steps <= most && !interrupted(); before = steps, steps *= 2) {
    std::int64_t rhs_evals = 0;
    const double now = error(steps, rhs_evals);
    h.push_back(scene.duration / static_cast<double>(steps));
    e.push_back(now);
    if (now <= 1e-3 && result.at_1e3.h == 0) reach(result.at_1e3, 1e-3, before, steps, rhs_evals);
    if (now <= 1e-6) {
      reach(result.at_1e6, 1e-6, before, steps, rhs_evals);
      break;
    }
  }
  while (!h.empty() && h.back() * fastest < 10) {
    h.pop_back();
    e.pop_back();
  }
  const double floor = 100 * std::max(truth.floor().attitude, truth.floor().rate);
  if (const auto line = observed_order(h, e, floor, 0.1)) result.order_while_stiff = line->slope;
  return result;
}

}  // namespace

Table dial_table(const Plan& plan) {
  Table table{"stability.csv", columns, {}, key_columns};
  const bool quick = plan.options.quick;
  const std::int64_t most = quick ? 1024 : 65536;
  const auto times_of = [](const Scene& s) { return uniform_times(s.duration, 8); };
  for (const Scene& scene : plan.scenes) {
    if (!scene.dial || interrupted()) continue;
    if (!scene.rotation || !loses_or_keeps_energy(scene))
      throw UsageError(
          "stability: scene '" + scene.id +
          "' has a load that does work on the body (or nothing that rotates), so that growing energy "
          "says nothing of the step; drags, springs and weight about a pivot can be asked");
    std::vector<double> values = scene.dial->values;
    if (quick && values.size() > 2) values = {values.front(), values.back()};
    struct Case {
      Scene scene;
      Linearised linear;
      std::shared_ptr<const SceneTruth> truth;
      double value;
    };
    std::vector<Case> cases(values.size());
    for_each_run(plan.options, values.size(), [&](std::size_t i) {
      cases[i] = {scene.with_dial(values[i]), {}, nullptr, values[i]};
      cases[i].linear = linearised(cases[i].scene);
      double swings = 0;  // rad
      for (const auto& lambda : cases[i].linear.eigenvalues)
        swings = std::max(swings, std::abs(lambda.imag()) * cases[i].scene.duration);
      if (swings > longest_truth) {
        tell_note(plan.options, fmt::format("{} with {} swings through {:.2g} rad: no truth follows that, so "
                                            "stable steps are asked for and accurate ones are not",
                                            scene.id, cases[i].scene.variant, swings));
        return;
      }
      // Without it the stable steps can be asked all the same.
      const auto truth = truth_for(plan, cases[i].scene, times_of(cases[i].scene), "stability", true);
      if (truth->is_known()) cases[i].truth = truth;
    });
    if (interrupted()) break;
    std::vector<const Method*> methods;
    for (const Method* m : plan.methods)
      if (m->by_steps) methods.push_back(m);
    std::vector<std::vector<Cell>> rows(cases.size() * methods.size());
    for_each_run(plan.options, rows.size(), [&](std::size_t i) {
      const Method& method = *methods[i / cases.size()];
      const Case& c = cases[i % cases.size()];
      std::vector<Cell> row = {text(scene.id), text(method.id), text(scene.dial->place), c.value};
      if (auto known = plan.earlier.find(table, row)) {
        rows[i] = std::move(*known);
        return;
      }
      progress(plan.options, "stability: " + scene.id + ", " + std::string(method.id));
      row.resize(std::size(columns));
      Setting setting = setting_of(plan.options, Knob::steps);
      setting.timeout_s = std::min(setting.timeout_s, 5.0);  // a run of some thousand steps
      auto starts = starts_of(c.scene, c.linear);
      if (quick && starts.size() > 2) starts.pop_back();
      std::vector<Integration> runs;
      for (const Scene& start : starts)
        if (Prepared run = method.prepare(start, setting); run.integrate)
          runs.push_back(guarded(std::move(run.integrate)));
      const double fastest = c.linear.fastest, slow = scene.rotation->w0.norm();
      if (runs.empty() || !(fastest > 0)) {
        row[5] = text(name_of(Outcome::unsupported));
        rows[i] = std::move(row);
        return;
      }
      const double low = 1e-2 / fastest,
                   high = std::max(1e3 / fastest, slow > 0 ? std::min(0.5 / slow, 1e8 / fastest) : 0);
      const double factor = quick ? 2 : 1.5, precision = quick ? 1.005 : 1.0005;
      const auto search = [&](const std::vector<Integration>& from, double up_to) {
        return largest_stable_step(from, fastest, low, up_to, factor, precision);
      };
      // Next to rest first: what fails there fails everywhere.
      Limit limit;
      if (c.linear.at_rest) {
        limit = search({runs.front()}, high);
        if (limit.stable > 0) row[18] = limit.stable;
      }
      if (const Limit all = search(runs, limit.stable > 0 ? limit.stable : high);
          !c.linear.at_rest || all.failed > 0)
        limit = all;
      const bool failed = limit.failed > 0;
      row[5] = text(name_of(failed ? limit.at_failure.outcome : Outcome::ok));
      if (failed) {
        row[4] = limit.failed;
        row[8] = number(limit.at_failure.per_step);
      }
      if (limit.stable > 0) row[6] = limit.stable;
      // Linear theory speaks of motions next to rest, or of one so fast that the rest stands still beside it.
      if (!method.stability_polynomial.empty() && c.linear.at_rest && fastest > 10 * slow)
        if (const auto h = theoretical_limit(method, c.linear, low, high)) row[7] = *h;
      row[9] = fastest;
      row[10] = limit.tried;
      if (c.linear.fast_rates && !failed)
        row[11] = number(fast_mode_left(method, c.scene, c.linear, setting));
      if (c.truth && limit.stable > 0) {
        const Accuracy a = accuracy(plan, method, c.scene, *c.truth, times_of(c.scene), fastest,
                                    failed ? limit.stable : 0, most);
        if (a.at_1e3.h > 0) {
          row[12] = a.at_1e3.h;
          row[14] = a.at_1e3.rhs_evals;
        }
        if (a.at_1e6.h > 0) {
          row[13] = a.at_1e6.h;
          row[15] = a.at_1e6.rhs_evals;
        }
        row[16] = number(a.order_while_stiff);
      }
      if (method.claims.attitude_order > 0) row[17] = method.claims.attitude_order;
      if (!interrupted()) rows[i] = std::move(row);
    });
    for (auto& row : rows)
      if (!row.empty()) table.add(std::move(row));
  }
  return table;
}

std::vector<Table> stability(const Plan& plan) {
  refuse_options(plan.options, "stability searches the step size itself", true, true, true);
  std::vector<Table> tables;
  tables.push_back(dial_table(plan));
  if (plan.options.scenes.empty()) {
    tables.push_back(gyroscopic_map(plan));
    tables.push_back(extremes(plan));
    for (Table& t : tolerances(plan)) tables.push_back(std::move(t));
  }
  return tables;
}

}  // namespace polhode
