// What survives at the edge of what can be computed, and is it right?
//
// Every solver gets every case at the same accuracy: fixed steps of a fiftieth of a radian (where the case
// does not say otherwise), tolerances of 1e-9. The verdict is that of the whole motion against the exact one:
//
//   right             attitude within 1e-3 rad and rates within 1e-3 of the truth (ten times what doubles
//   resolve,
//                     where that is more)
//   bounded_but_wrong not right, but its energy stays within a hundredth of the truth
//   dissipates        not right, with less energy than that
//   gains_energy      not right, with more; a run that was stopped because its energy ran away, too
//   clamped, asleep, not_finite, solver_failed, timeout, unsupported, no_truth   as its outcome says
#include <algorithm>
#include <cmath>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/stability.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"case", ColumnType::text, "case id"},
    {"title", ColumnType::text, "what is extreme"},
    {"solver", ColumnType::text, "solver id"},
    {"knob", ColumnType::text, "steps, rtol or none"},
    {"knob_value", ColumnType::number, "its value"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"verdict", ColumnType::text,
     "right, bounded_but_wrong, dissipates, gains_energy, clamped, asleep, not_finite, solver_failed, "
     "timeout, "
     "unsupported, no_truth"},
    {"value", ColumnType::number, "the number that decided, see value_meaning"},
    {"value_meaning", ColumnType::text, "attitude_error_rad, rate_error_rel, or energy_error_rel (signed)"},
};
constexpr std::size_t key_columns = 5;

struct Case {
  const char *id, *title;
  Scene scene;
  std::int64_t steps;
  bool slow = false;  // left out of a quick look
};

/// A free body that turns by about `angle` rad.
Case free_case(const char* id, const char* title, const Vec3& moments, const Vec3& w0, double angle,
               double rad_per_step = 0.02) {
  Case c{id, title, {}, 0};
  c.scene.id = id;
  c.scene.unknowns = 7;
  // Scaled before it is squared: denormal and huge rates have no norm.
  const double largest = w0.cwiseAbs().maxCoeff();
  const double rate = largest * (w0 / largest).norm();
  c.scene.duration = angle / rate;
  RotationData r;
  r.moments = moments;
  r.w0 = w0;
  c.scene.rotation = r;
  c.steps = std::max<std::int64_t>(1, std::llround(angle / rad_per_step));
  return c;
}

std::vector<Case> all_cases() {
  const Vec3 body(0.6, 0.8, 1), spin(3, 0.5, -0.9);
  const Vec3 simbody(.0612666667, .0644666667, .0055333333);
  std::vector<Case> cases;
  const auto add = [&](Case c) { cases.push_back(std::move(c)); };
  // 1 - k^2 falls with the square of the rate beside the unstable axis; the body hesitates for longer and
  // longer.
  add(free_case("separatrix-1e-10", "next to the separatrix: 1 - k^2 = 1e-10", body, Vec3(1e-5, 3, 1e-5),
                40));
  add(free_case("separatrix-1e-22", "next to the separatrix: 1 - k^2 = 1.7e-22 (Simbody's case)", simbody,
                Vec3(10, 0, 1e-10), 90));
  add(free_case("separatrix-1e-25", "next to the separatrix: 1 - k^2 = 1e-25", simbody, Vec3(10, 0, 2.4e-12),
                90));
  add(free_case("unstable-axis", "spins exactly about the unstable axis", body, Vec3(0, 3, 0), 40));
  add(free_case("needle", "a needle: I1 + I2 exceeds I3 by 1e-12", Vec3(1e-12, 1, 1), Vec3(5, 0.3, 0.2), 20));
  add(free_case("disc", "a disc: I1 + I2 exceeds I3 by 1e-12", Vec3(0.8, 1.2, 2 - 1e-12), Vec3(1, 0.5, 3),
                20));
  add(free_case("near-sphere-1e-9", "moments equal to 1e-9", Vec3(1, 1 + 1e-9, 1 + 3e-9), spin, 20));
  add(free_case("near-sphere-1e-15", "moments equal to 1e-15", Vec3(1, 1 + 1e-15, 1 + 3e-15), spin, 20));
  add(free_case("slow", "spins at 1e-12 rad/s", body, 1e-12 * Vec3(0.9, 0.2, -0.4), 20));
  add(free_case("fast", "spins at 1e9 rad/s", body, 1e9 * Vec3(0.9, 0.2, -0.4), 20));
  add(free_case("tiny", "mass and size of 1e-30: moments of 1e-90", 1e-90 * body, spin, 20));
  add(free_case("huge", "mass and size of 1e30: moments of 1e90", 1e90 * body, spin, 20));
  add(free_case("denormal", "rates of 1e-310 rad/s", body, 1e-310 * spin, 1e-300));
  cases.back().scene.duration = 1e10;
  cases.back().steps = 1000;
  add(free_case("largest", "rates of 1e150 rad/s: energies of 1e300 J", body, 1e150 * Vec3(0.9, 0.2, -0.4),
                20));
  add(free_case("at-rest", "no angular velocity", body, spin, 30));
  cases.back().scene.rotation->w0 = Vec3::Zero();
  constexpr double pi = 3.14159265358979323846;
  add(free_case("step-quarter-pi", "h|w| just above pi/4", body, spin, 40, pi / 4 * 1.01));
  add(free_case("step-pi", "h|w| just above pi", body, spin, 40, pi * 1.01));
  add(free_case("step-two-pi", "h|w| just above 2 pi", body, spin, 80, 2 * pi * 1.01));
  add(free_case("one-step", "one step of a hundredth of a radian", body, spin, 0.01, 0.01));
  add(free_case("1e8-steps", "1e8 steps over 30 rad", body, spin, 30, 3e-7));
  cases.back().slow = true;
  add(free_case("1e6-turns", "a million turns in steps of a tenth of a radian", body, spin, 2 * pi * 1e6,
                0.1));
  cases.back().slow = true;
  Case corner =
      free_case("corner", "a spring whose torque jumps where q_w = 0", body, Vec3(0.2, 1.5, 0.3), 9);
  corner.scene.rotation->q0 = Quaternion(0.3, 0.2, 0.9, 0.1);
  corner.scene.rotation->loads = {AttitudeSpring<double>{0.5, 0.0}};
  add(std::move(corner));
  return cases;
}

struct Verdict {
  std::string_view name;
  double value = std::numeric_limits<double>::quiet_NaN();
  std::string_view meaning;
};

Verdict verdict_of(const Scene& scene, const SceneTruth& truth, const Trajectory& run, double epsilon) {
  switch (run.outcome) {
    case Outcome::ok:
      break;
    case Outcome::diverged:
      return {"gains_energy", std::numeric_limits<double>::quiet_NaN(), {}};
    case Outcome::step_limit:
      return {"timeout", std::numeric_limits<double>::quiet_NaN(), {}};
    default:
      return {name_of(run.outcome), std::numeric_limits<double>::quiet_NaN(), {}};
  }
  const Errors e = errors_of(scene, truth, run.samples, 1, epsilon);
  const double coarser = epsilon / std::numeric_limits<double>::epsilon();
  const double attitude_bound = std::max(1e-3, 10 * coarser * truth.floor().attitude);
  const double rate_bound = std::max(1e-3, 10 * coarser * truth.floor().rate);
  if (e.attitude_max <= attitude_bound && e.rate_max <= rate_bound)
    return {"right", e.attitude_max, "attitude_error_rad"};
  double gain = 0;
  for (std::size_t i = 0; i < run.samples.size(); ++i) {
    const Wide exact = truth.truth.samples[i + 1].total_energy;
    const double d =
        Wide(Wide(run.samples[i].total_energy) - exact).convert_to<double>() / energy_scale(truth, false);
    if (!(std::abs(d) <= std::abs(gain))) gain = d;
  }
  if (!std::isfinite(gain)) return {"not_finite", std::numeric_limits<double>::quiet_NaN(), {}};
  if (gain > 0.01) return {"gains_energy", gain, "energy_error_rel"};
  if (gain < -0.01) return {"dissipates", gain, "energy_error_rel"};
  if (e.attitude_max > attitude_bound) return {"bounded_but_wrong", e.attitude_max, "attitude_error_rad"};
  return {"bounded_but_wrong", e.rate_max, "rate_error_rel"};
}

}  // namespace

Table extremes(const Plan& plan) {
  Table table{"extremes.csv", columns, {}, key_columns};
  std::vector<Case> cases = all_cases();
  if (plan.options.quick) std::erase_if(cases, [](const Case& c) { return c.slow; });
  std::vector<std::shared_ptr<const SceneTruth>> truths(cases.size());
  const auto times_of = [](const Case& c) {
    return uniform_times(c.scene.duration, std::min<std::int64_t>(16, c.steps));
  };
  for_each_run(plan.options, cases.size(), [&](std::size_t i) {
    truths[i] = truth_for(plan, cases[i].scene, times_of(cases[i]), "extremes", true);
  });
  std::vector<std::vector<Cell>> rows(cases.size() * plan.methods.size());
  if (!interrupted())
    for_each_run(plan.options, rows.size(), [&](std::size_t i) {
      const Case& c = cases[i / plan.methods.size()];
      const Method& method = *plan.methods[i % plan.methods.size()];
      if (method.family == "truth") return;
      // Steps where it has them: what a step of a given size does is the question.
      const Knob knob = method.by_steps ? Knob::steps : method.default_knob();
      Setting setting = setting_of(plan.options, knob);
      setting.timeout_s = std::min(setting.timeout_s, 2.0);
      setting.rtol = 1e-9;
      const auto times = times_of(c);
      const Grid grid = knob == Knob::steps ? grid_of_steps(times, c.steps) : grid_of_times(times);
      std::vector<Cell> row = {text(c.id), text(c.title), text(method.id), text(name_of(knob)),
                               knob == Knob::steps       ? Cell(double(grid.steps()))
                               : knob == Knob::tolerance ? Cell(setting.rtol)
                                                         : Cell()};
      if (auto known = plan.earlier.find(table, row)) {
        rows[i] = std::move(*known);
        return;
      }
      progress(plan.options, std::string("extremes: ") + c.id + ", " + std::string(method.id));
      const SceneTruth& truth = *truths[i / plan.methods.size()];
      const Trajectory run = truth.is_known() ? run_once(method, c.scene, setting, grid)
                                              : run_without_truth(method, c.scene, setting, truth);
      const Verdict v = verdict_of(c.scene, truth, run, method.epsilon);
      row.resize(std::size(columns));
      row[5] = text(name_of(run.outcome));
      row[6] = text(v.name);
      row[7] = number(v.value);
      row[8] = text(v.meaning);
      if (!interrupted()) rows[i] = std::move(row);
    });
  for (auto& row : rows)
    if (!row.empty()) table.add(std::move(row));
  return table;
}

}  // namespace polhode
