// Every claim of every registered solver, measured. No solver is named here: the registry is the list.
#include <algorithm>
#include <cmath>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "models/closed_form.hpp"
#include "solvers/engines/engines.hpp"
#include "tests/sanitized.hpp"

namespace polhode {

void PrintTo(const Method* m, std::ostream* out) { *out << m->id; }
std::vector<Table> convergence(const Plan& plan);

namespace {

class Claims : public testing::TestWithParam<const Method*> {
 protected:
  const Method& method() const { return *GetParam(); }
  const polhode::Claims& claims() const { return GetParam()->claims; }
};

std::string name_of_test(const testing::TestParamInfo<const Method*>& info) {
  std::string name(info.param->id);
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
}

const Scene& free_body() {
  static const Scene scene = find_scene("hairer-vilmart");
  return scene;
}

/// A run over [0, duration] in steps of about h (or at rtol 1e-6), sampled at n equal times.
Trajectory free_run(const Method& method, double duration, double h, int n) {
  const auto times = uniform_times(duration, n);
  Setting setting;
  setting.knob = method.default_knob();
  setting.rtol = 1e-6;
  const Grid grid = setting.knob == Knob::steps
                        ? grid_of_steps(times, static_cast<std::int64_t>(std::llround(duration / h)))
                        : grid_of_times(times);
  Grid with_start = grid;
  with_start.from_start = true;
  return run_once(method, free_body(), setting, with_start);
}

/// A step that is coarse for the order: its truncation error is far above rounding, and the run still finite.
/// An order that doubles cannot show, and that is not claimed therefore, is seen in the stability polynomial:
/// it begins as the exponential.
double coarse_step(const Method& m) {
  double order = std::max({m.claims.attitude_order, m.claims.energy_order, 0.0}), factorial = 1;
  for (std::size_t i = 1; i < m.stability_polynomial.size() && m.stability_denominator.size() <= 1; ++i) {
    factorial *= double(i);
    if (std::abs(m.stability_polynomial[i] * factorial - 1) > 1e-9) break;
    order = std::max(order, double(i));
  }
  return order >= 6 ? 0.4 : order >= 3 ? 0.1 : 0.01;
}

TEST_P(Claims, OrdersAreMeasured) {
  const int claimed = (claims().attitude_order >= 0) + (claims().rate_order >= 0) +
                      (claims().energy_order >= 0) + (claims().momentum_order >= 0);
  EXPECT_TRUE(method().by_steps || claimed == 0) << "an order is claimed that no knob can measure";
  if (claimed == 0) return;
  if (sanitized && !method().in_studies) return;  // the code of another row, with another table
  Plan plan;
  plan.scenes = {read_scene(std::string(POLHODE_TESTS) + "/scenes/claims.toml")};
  plan.methods = {GetParam()};
  plan.options.quiet = true;
  // From order 3 on the fine end of the ladder is at rounding, or tells nothing new: 2^13 steps are enough.
  plan.options.quick = claims().attitude_order >= 3;
  const Table orders = convergence(plan)[1];
  int measured = 0;
  for (const auto& row : orders.rows) {
    if (!std::holds_alternative<double>(row[3])) continue;
    const std::string quantity = std::get<std::string>(row[2]);
    ASSERT_TRUE(std::holds_alternative<double>(row[4])) << quantity << ": no order could be fitted";
    // The band that the project promises: below it a method of the next order would be told apart easily.
    EXPECT_NEAR(std::get<double>(row[4]), std::get<double>(row[3]), 0.15) << quantity;
    ++measured;
  }
  EXPECT_EQ(measured, claimed);
}

/// Of attitude and rates, on a scene whose load depends on time: an explicit dependence is its own path
/// through a method's coefficients, which a scene without it never takes.
TEST_P(Claims, OrdersWhereALoadDependsOnTime) {
  const polhode::Claims timed = claims().with_time(true);
  if (timed.attitude_order < 0 || sanitized) return;
  Plan plan;
  plan.scenes = {read_scene(std::string(POLHODE_TESTS) + "/scenes/claims-timed.toml")};
  plan.methods = {GetParam()};
  plan.options.quiet = true;
  plan.options.quick = true;
  const Table orders = convergence(plan)[1];
  for (const auto& row : orders.rows) {
    const std::string quantity = std::get<std::string>(row[2]);
    if (quantity != "attitude" && quantity != "rate") continue;
    const double claimed = quantity == "attitude" ? timed.attitude_order : timed.rate_order;
    // High orders may have no three points between coarse steps and the floor here; they have them above.
    if (claimed < 0 || (claimed > 4 && !std::holds_alternative<double>(row[4]))) continue;
    ASSERT_TRUE(std::holds_alternative<double>(row[4])) << quantity << ": no order could be fitted";
    // At least: a leading term may vanish here that does not elsewhere. Of a high order three points are
    // left, a few times the step from the floor, where the next term still bends the slope by h^2 or so of
    // itself.
    EXPECT_GT(std::get<double>(row[4]), claimed - (claimed > 4 ? 0.5 : 0.15)) << quantity;
    if (timed.timed_order <= claimed) {
      EXPECT_LT(std::get<double>(row[4]), claimed + 0.5) << quantity;
    }
  }
}

TEST_P(Claims, AttitudeOfUnitLength) {
  if (claims().unit_attitude == Claim::unknown) return;
  const Trajectory run = free_run(method(), 10, coarse_step(method()), 16);
  double defect = 0;
  for (const Sample& s : run.samples) defect = std::max(defect, s.unit_defect);
  if (claims().unit_attitude == Claim::yes) {
    ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
    // A unit quaternion that is multiplied 1000 times: each product rounds by an ulp or two.
    EXPECT_LT(defect, 1000 * 4 * method().epsilon);
  } else {
    EXPECT_GT(defect, 1e-10);
  }
}

TEST_P(Claims, MomentumOfTheFreeBody) {
  if (claims().momentum_magnitude == Claim::unknown && claims().space_momentum == Claim::unknown) return;
  const Trajectory run = free_run(method(), 10, coarse_step(method()), 16);
  double magnitude = 0, vector = 0;
  const Vec3 L0 = run.samples.front().L;
  for (const Sample& s : run.samples) {
    magnitude = std::max(magnitude, std::abs(s.L.norm() / L0.norm() - 1));
    vector = std::max(vector, (s.L - L0).norm() / L0.norm());
  }
  // A thousand steps, each rounding by a few ulp; what is not kept must be told from that.
  const double kept = 1000 * 4 * method().epsilon, lost = 10 * kept;
  const auto check = [&](Claim claim, double change) {
    if (claim == Claim::yes) {
      EXPECT_LT(change, kept);
    } else if (claim == Claim::no) {
      EXPECT_GT(change, lost);
    }
  };
  check(claims().momentum_magnitude, magnitude);
  check(claims().space_momentum, vector);
}

TEST_P(Claims, EnergyOverALongTime) {
  if (claims().energy_bounded == Claim::unknown || method().family == "truth") return;
  const auto worst = [&](double duration) {
    // No more samples than steps, and a whole number of steps between two: one step size in all three runs.
    const double h = coarse_step(method());
    const int samples = std::min(150, static_cast<int>(std::llround(duration / h)));
    const Trajectory run = free_run(method(), duration, h, samples);
    double error = run.outcome == Outcome::ok ? 0 : std::numeric_limits<double>::infinity();
    const double E0 = run.samples.front().rotational_energy;
    for (const Sample& s : run.samples) error = std::max(error, std::abs(s.rotational_energy / E0 - 1));
    return error;
  };
  // Ten times longer, twice: a secular error grows in proportion sooner or later (an early transient may hide
  // it, a body that has lost all it can lose may end it), a bounded one does neither time. Rounding grows
  // with the root of the steps and is no part of the claim.
  const double first = worst(6), second = worst(60), third = worst(600);
  if (claims().energy_bounded == Claim::yes) {
    EXPECT_LT(second, 2 * first + 5000 * 4 * method().epsilon);
    EXPECT_LT(third, 2 * second + 50000 * 4 * method().epsilon);
  } else {
    EXPECT_TRUE(second > 3 * first || third > 3 * second) << first << ' ' << second << ' ' << third;
  }
}

TEST_P(Claims, ThereAndBack) {
  if (claims().reversible == Claim::unknown || !method().by_steps) return;
  const double h = coarse_step(method());
  const auto n = static_cast<std::int64_t>(std::llround(5 / h));
  Grid grid;
  grid.from_start = true;
  grid.stretches = {{5.0, n, h}, {0.0, n, -h}};
  Setting setting;
  setting.knob = Knob::steps;
  const Trajectory run = run_once(method(), free_body(), setting, grid);
  ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
  const Sample &start = run.samples.front(), &end = run.samples.back();
  const double missed =
      std::max(attitude_error(start.q, end.q), (start.w_B - end.w_B).norm() / start.w_B.norm());
  const double rounded = 100 * double(2 * n) * method().epsilon;  // amplified by the motion (conditioning 28)
  if (claims().reversible == Claim::yes) {
    EXPECT_LT(missed, rounded);
  } else {
    EXPECT_GT(missed, 2 * rounded);
  }
}

/// Every solver. But each test is a process of its own under ctest, and to open all engines takes longer than
/// most tests do: one that is asked for by its whole name opens them only if that is an engine's.
std::vector<const Method*> claimed_methods() {
  const std::string option = "--gtest_filter=";
  std::ifstream command_line("/proc/self/cmdline");
  for (std::string argument; std::getline(command_line, argument, '\0');) {
    if (!argument.starts_with(option) || argument.find_first_of("*?:") != std::string::npos) continue;
    std::string id = argument.substr(argument.rfind('/') + 1);
    std::replace(id.begin(), id.end(), '_', '-');
    bool engine = false;
    for (std::size_t i = 0; i < engine_count(); ++i) engine = engine || may_serve(i, id);
    return engine ? all_methods() : own_methods();
  }
  return all_methods();
}

INSTANTIATE_TEST_SUITE_P(Registry, Claims, testing::ValuesIn(claimed_methods()), name_of_test);

TEST(Registry, EverySolverHasItsIdentity) {
  std::vector<std::string_view> ids;
  for (const Method* m : all_methods()) {
    EXPECT_FALSE(m->id.empty() || m->family.empty() || m->summary.empty() || m->source.empty()) << m->id;
    EXPECT_THAT(ids, testing::Not(testing::Contains(m->id)));
    ids.push_back(m->id);
  }
  EXPECT_GE(ids.size(), 20U);
}

TEST(Registry, EverySolverServesEveryBuiltInSceneOrSaysWhyNot) {
  for (const std::string& id : builtin_scene_ids()) {
    const Scene scene = find_scene(id);
    for (const Method* m : all_methods()) {
      if (m->family == "truth") continue;
      Setting setting;
      setting.knob = m->default_knob();
      const double end[] = {scene.duration * 1e-3};
      const Grid grid = setting.knob == Knob::steps ? grid_of_steps(end, 64) : grid_of_times(end);
      const Trajectory run = run_once(*m, scene, setting, grid);
      if (run.outcome == Outcome::unsupported) {
        EXPECT_FALSE(run.reason.empty()) << m->id << " on " << id;
        // What may be refused: a particle or bare rates by solvers that are about an attitude, and a motion
        // that nobody has written down by the closed forms.
        EXPECT_TRUE(m->family == "closed form" ? closed_form_kind(scene).empty()
                                               : !scene.rotation || !scene.rotation->attitude)
            << m->id << " on " << id << ": " << run.reason;
      } else if (run.outcome == Outcome::clamped) {
        EXPECT_EQ(m->family, "engine") << m->id << " on " << id;  // an engine's own limit, reported
        EXPECT_FALSE(run.reason.empty());
      } else {
        EXPECT_EQ(run.outcome, Outcome::ok) << m->id << " on " << id << ": " << run.reason;
        EXPECT_EQ(run.samples.size(), 1U);
      }
    }
  }
}

}  // namespace
}  // namespace polhode
