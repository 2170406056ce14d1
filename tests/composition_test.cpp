// Splittings and their compositions beyond what the claims measure.
#include <cmath>

#include <gtest/gtest.h>

#include "experiments/fit.hpp"
#include "experiments/question.hpp"
#include "models/extended_free_rotation.hpp"
#include "solvers/reference.hpp"
#include "solvers/registry.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

Trajectory run_steps(const std::string& id, const Scene& scene, double duration, std::int64_t steps) {
  Grid grid;
  grid.stretches = {{duration, steps, duration / double(steps)}};
  Setting setting;
  setting.knob = Knob::steps;
  return run_once(find_method(id), scene, setting, grid);
}

Scene free_body(const Vec3& moments, const Vec3& w0) {
  Scene scene = find_scene("hairer-vilmart");
  scene.rotation->moments = moments;
  scene.rotation->w0 = w0;
  return scene;
}

double error_of(const Scene& scene, const Sample& s) {
  const auto exact =
      ExtendedFreeRotation(scene.rotation->moments, scene.rotation->q0, scene.rotation->w0).at(s.t);
  return std::max(attitude_error(exact.q, s.q), (exact.w_B - s.w_B).norm() / exact.w_B.norm());
}

TEST(Composition, OrderTen) {
  // Errors from 1e-11 to 1e-13 on a motion slow enough for them to be asymptotic: no ladder of halvings fits
  // in.
  const Scene scene = find_scene("attitude-spring");
  const double end[] = {3.0};
  const Quaternion exact = reference_solution(scene, end).samples.front().q.cast<double>();
  for (const char* id : {"symmetric-split-ss10", "free-flow-ss10"}) {
    std::vector<double> h, error;
    for (const int steps : {15, 17, 19, 21}) {
      const Trajectory run = run_steps(id, scene, 3, steps);
      ASSERT_EQ(run.outcome, Outcome::ok);
      h.push_back(std::log(3.0 / steps));
      error.push_back(std::log(attitude_error(exact, run.samples.front().q)));
    }
    EXPECT_NEAR(fit_line(h, error).slope, 10, 0.3) << id;
  }
}

TEST(Composition, FreeFlowIsTheFreeMotion) {
  const Scene scene = find_scene("hairer-vilmart");
  for (const char* id : {"free-flow-split", "free-flow-suzuki4", "free-flow-ss10"})
    for (const int steps : {1, 2, 10, 100}) {
      // Set up anew at each step, to some 4e-15.
      EXPECT_LT(error_of(scene, run_steps(id, scene, 10, steps).samples.front()), 4e-15 * (1 + steps))
          << id << ", " << steps << " steps";
    }
}

TEST(Composition, WithNearlyTwoEqualMomentsTheTopIsTheMotion) {
  // Whichever axis is the third: the rest is zero. Short steps use the polynomials, long ones the library's
  // sines.
  const Vec3 w(1.5, -0.7, 2.0);
  for (const Vec3& moments : {Vec3(0.6, 1, 1), Vec3(1, 0.6, 1), Vec3(1, 1, 0.6), Vec3(1, 1.4, 1)}) {
    const Scene scene = free_body(moments, w);
    for (const char* id : {"symmetric-split", "symmetric-split-blanes-moan4", "symmetric-split-ss10"})
      for (const int steps : {1, 3, 10, 100}) {
        // Substeps of a composition go to and fro: some ten times the way, a few ulp a turn.
        EXPECT_LT(error_of(scene, run_steps(id, scene, 10, steps).samples.front()), 2e-15 * (50 + steps))
            << id << ", " << steps << " steps";
      }
  }
}

TEST(Composition, MomentumIsKeptThroughManySteps) {
  const std::int64_t steps = sanitized ? 10'000 : 300'000;
  const Scene scene = find_scene("hairer-vilmart");
  const Vec3 L0 = scene.rotation->moments.cwiseProduct(scene.rotation->w0);
  for (const char* id : {"symmetric-split", "no-squish", "symmetric-split-suzuki4", "free-flow-split"}) {
    const Sample s = run_steps(id, scene, 0.02 * double(steps), steps).samples.front();
    // What does not drift: the root of 16 turns a step, each rounded by 1e-16 of what it changes or carries,
    // no particular way.
    EXPECT_LT((s.L - L0).norm() / L0.norm(), 2.2e-16 * std::sqrt(16.0 * double(steps))) << id;
    EXPECT_LT(s.unit_defect, 2.2e-16 * std::sqrt(16.0 * double(steps))) << id;
  }
}

TEST(Composition, KicksWithDragAreExact) {
  // Of a ball the free motion leaves w_B alone, and drag does the rest: the rates have no error, however long
  // the step, though the attitude has. Drag in axes that are not the principal ones makes its matrix full.
  Scene scene = find_scene("angular-drag");
  scene.rotation->moments = Vec3(0.5, 0.5, 0.5);
  scene.rotation->w0 = Vec3(1.5, -0.7, 2);
  Mat3 C;
  C << 0.3, 0.05, -0.02, 0.05, 0.2, 0.04, -0.02, 0.04, 0.4;
  scene.rotation->loads = {AngularDrag<double>{C}};
  const double end[] = {2.0};
  const Vec3 exact = reference_solution(scene, end).samples.front().w_B.cast<double>();
  ASSERT_LT(exact.norm(), 0.5 * scene.rotation->w0.norm());
  for (const char* id :
       {"symmetric-split", "symmetric-split-kahan-li8", "free-flow-blanes-moan6", "dmv-exact"})
    for (const int steps : {2, 7, 100}) {
      if (id == std::string("dmv-exact") && steps < 7) continue;  // a turn of more than a right angle
      const Trajectory run = run_steps(id, scene, 2, steps);
      ASSERT_EQ(run.outcome, Outcome::ok) << id;
      // Some twenty kicks a step and turns that should not touch L, an ulp each.
      EXPECT_LT((run.samples.front().w_B - exact).norm(), 20 * steps * 2.2e-16 * exact.norm() + 1e-15) << id;
    }
}

}  // namespace
}  // namespace polhode
