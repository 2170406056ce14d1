// RATTLE where its textbook form divides by zero, and implicit steps that are too large.
#include <cmath>

#include <gtest/gtest.h>

#include "experiments/question.hpp"

namespace polhode {
namespace {

Trajectory run_of(const char* method, const Scene& scene, double h, std::int64_t n) {
  Grid grid;
  grid.from_start = true;
  grid.stretches = {{h * static_cast<double>(n), n, h}};
  Setting setting;
  setting.knob = Knob::steps;
  return run_once(find_method(method), scene, setting, grid);
}

// A flat body has no extent along one axis: I3 = I1 + I2, and the mass matrix of the nine coordinates is
// singular.
TEST(Rattle, FlatBody) {
  Scene plate = find_scene("hairer-vilmart");
  plate.rotation->moments = Vec3(0.4, 0.6, 1.0);
  const Trajectory coarse = run_of("rattle", plate, 0.02, 250), fine = run_of("rattle", plate, 0.01, 500);
  const Trajectory truth = run_of("gauss6", plate, 0.01, 500);
  ASSERT_EQ(coarse.outcome, Outcome::ok) << coarse.reason;
  ASSERT_EQ(fine.outcome, Outcome::ok) << fine.reason;
  const Sample &start = fine.samples.front(), &end = fine.samples.back();
  EXPECT_LT((end.L - start.L).norm(), 1e-15 * start.L.norm());
  // Newton's method leaves an ulp of the turn in each of 500 steps, and the energy feels the gyroscopic part.
  EXPECT_NEAR(end.rotational_energy, start.rotational_energy, 1e-13 * start.rotational_energy);
  const double far = attitude_error(coarse.samples.back().q, truth.samples.back().q);
  const double near = attitude_error(end.q, truth.samples.back().q);
  EXPECT_NEAR(std::log2(far / near), 2, 0.15);
}

TEST(ImplicitTurns, TooLargeAStepIsAFailureInWords) {
  const Scene scene = find_scene("hairer-vilmart");  // 3.2 rad/s
  for (const char* method : {"rattle", "krysl-liemid", "krysl-liemid-implicit"}) {
    const Trajectory run = run_of(method, scene, 5.0, 3);
    EXPECT_EQ(run.outcome, Outcome::solver_failed) << method;
    EXPECT_FALSE(run.reason.empty()) << method;
    EXPECT_EQ(run.samples.size(), 1U) << method;
  }
}

}  // namespace
}  // namespace polhode
