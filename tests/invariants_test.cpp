// What a method claims to keep, over a million steps: rounding may walk, but must not drift.
//
// A claim that holds for a thousand steps can hide an error of the same sign in every one of them, such as a
// momentum that goes through w = m (1/I) and back each step: 2e-16 a step, 2e-10 after a million. No solver
// is named here: the registry is the list.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "experiments/question.hpp"
#include "tests/sanitized.hpp"

namespace polhode {

void PrintTo(const Method* m, std::ostream* out);

namespace {

/// A million steps where a step is cheap; methods of higher order take in each as many stages as pay for it.
std::int64_t steps_of(const Method& m) {
  const double order = m.claims.attitude_order;
  const std::int64_t many = sanitized ? 100'000 : 1'000'000;
  return order <= 2 ? many : order <= 4 ? many / 4 : order <= 6 ? many / 10 : many / 25;
}

/// The largest change of each quantity in the first tenth of a run, and in all of it.
struct Change {
  double momentum = 0, magnitude = 0, energy = 0, unit = 0;
};
struct Long {
  std::int64_t steps = 0;
  Change early, all;
  Outcome outcome = Outcome::ok;
};

/// n steps, a multiple of the number of samples, of about a thirtieth of a radian.
constexpr int samples = 500;
Trajectory run_of(const Method& method, const std::string& scene, double h, std::int64_t n) {
  const std::int64_t stretch = n / samples;
  Grid grid;
  grid.from_start = true;
  for (int i = 1; i <= samples; ++i)
    grid.stretches.push_back({h * static_cast<double>(stretch * i), stretch, h});
  Setting setting;
  setting.knob = Knob::steps;
  return run_once(method, find_scene(scene), setting, grid);
}

Long long_run(const Method& method) {
  Long result;
  result.steps = steps_of(method);
  const Trajectory run = run_of(method, "hairer-vilmart", 0.01, result.steps);
  result.outcome = run.outcome;
  const Sample& start = run.samples.front();
  for (std::size_t i = 0; i < run.samples.size(); ++i) {
    const Sample& s = run.samples[i];
    const auto widen = [&](Change& c) {
      c.momentum = std::max(c.momentum, (s.L - start.L).norm() / start.L.norm());
      c.magnitude = std::max(c.magnitude, std::abs(s.L.norm() / start.L.norm() - 1));
      c.energy = std::max(c.energy, std::abs(s.rotational_energy / start.rotational_energy - 1));
      c.unit = std::max(c.unit, s.unit_defect);
    };
    widen(result.all);
    if (10 * i <= run.samples.size()) widen(result.early);
  }
  return result;
}

/// How far n steps may walk by rounding. A step touches each kept quantity with some thirty operations, each
/// wrong by up to half an ulp (a third of one in the mean square): sqrt(30) eps/sqrt(12) = 1.6 eps a step.
/// Four times the walk of n such steps is out of reach, a drift of a fiftieth of an ulp a step is not.
double walk(const Method& m, std::int64_t n) {
  return 4 * 1.6 * m.epsilon * std::sqrt(static_cast<double>(n));
}

class Invariants : public testing::TestWithParam<const Method*> {};

TEST_P(Invariants, WalkButDoNotDrift) {
  const Method& method = *GetParam();
  const Claims& claims = method.claims;
  const Long run = long_run(method);
  ASSERT_EQ(run.outcome, Outcome::ok);
  const double bound = walk(method, run.steps);
  if (claims.momentum_magnitude == Claim::yes) {
    EXPECT_LE(run.all.magnitude, bound);
  }
  // In space nothing but a torque changes L: who claims it has it for a state that no step
  // rounds. (Carried in the body, its direction would walk with the attitude's, to 7e-13 here.)
  if (claims.space_momentum == Claim::yes) {
    EXPECT_LE(run.all.momentum, 2e-14);
  }
  if (claims.unit_attitude == Claim::yes) {
    EXPECT_LE(run.all.unit, bound);
  }
  // A bounded oscillation is seen in full in the first tenth, a drift grows tenfold after it.
  if (claims.energy_bounded == Claim::yes) {
    EXPECT_LE(run.all.energy, 1.5 * run.early.energy + bound);
  }
}

class UnitAttitude : public testing::TestWithParam<const Method*> {};

// A sphere turns by the same angle in each step, so that whatever a step does to |q| it does every time.
TEST_P(UnitAttitude, OfASphereThatTurnsOnAndOn) {
  const Method& method = *GetParam();
  const std::int64_t n = std::max<std::int64_t>(samples, steps_of(method) / 5);
  const Trajectory run = run_of(method, "sphere", 0.01, n);
  ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
  double defect = 0;
  for (const Sample& s : run.samples) defect = std::max(defect, s.unit_defect);
  EXPECT_LE(defect, walk(method, n));
}

std::vector<const Method*> rows(bool (*claims)(const Claims&)) {
  std::vector<const Method*> list;
  for (const Method* m : own_methods())
    if (claims(m->claims) && m->by_steps) list.push_back(m);
  return list;
}
bool keeps_a_quantity(const Claims& c) {
  return c.momentum_magnitude == Claim::yes || c.space_momentum == Claim::yes ||
         c.energy_bounded == Claim::yes;
}
bool keeps_unit_length(const Claims& c) { return c.unit_attitude == Claim::yes; }
std::string name_of_test(const testing::TestParamInfo<const Method*>& info) {
  std::string name(info.param->id);
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
}
INSTANTIATE_TEST_SUITE_P(Registry, Invariants, testing::ValuesIn(rows(keeps_a_quantity)), name_of_test);
INSTANTIATE_TEST_SUITE_P(Registry, UnitAttitude, testing::ValuesIn(rows(keeps_unit_length)), name_of_test);

}  // namespace
}  // namespace polhode
