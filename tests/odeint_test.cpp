// What is particular to one or the other stepper of Boost.Odeint.
#include <cmath>

#include <gtest/gtest.h>

#include "solvers/registry.hpp"

namespace polhode {
namespace {

Scene hairer_vilmart() {
  Scene scene;
  scene.duration = 10;
  RotationData rotation;
  rotation.moments = Vec3(0.6, 0.8, 1);
  rotation.w0 = Vec3(3, 0.5, -0.9);
  scene.rotation = rotation;
  return scene;
}

Grid grid_of(int stretches, std::int64_t steps_in_each) {
  Grid grid;
  for (int i = 1; i <= stretches; ++i)
    grid.stretches.push_back({10.0 * i / stretches, steps_in_each, 10.0 / stretches / double(steps_in_each)});
  return grid;
}

Trajectory run(const char* id, const Setting& setting, const Grid& grid) {
  const Prepared prepared = find_method(id).prepare(hairer_vilmart(), setting);
  Trajectory trajectory;
  prepared.integrate(grid, trajectory);
  return trajectory;
}

double error(const Trajectory& t, const Grid& grid) {
  Grid end;
  end.stretches.push_back(grid.stretches.back());
  Trajectory truth;
  find_method("exact").prepare(hairer_vilmart(), {}).integrate(end, truth);
  return attitude_error(truth.samples.back().q, t.samples.back().q);
}

TEST(AdamsBashforthMoulton, HistorySurvivesSamplesAndNotTheRun) {
  // 16 stretches of 512 steps are the same run as one of 8192: the sizes 10/16/512 and 10/8192 are the same
  // double. A second run of what was prepared starts anew.
  for (const char* id : {"odeint-abm4", "odeint-abm8", "odeint-abm8-rk4-start"}) {
    const Trajectory whole = run(id, {}, grid_of(1, 8192)), parts = run(id, {}, grid_of(16, 512));
    EXPECT_LT(attitude_error(whole.samples.back().q, parts.samples.back().q), 1e-13) << id;
    EXPECT_EQ(whole.work.rhs_evals, parts.work.rhs_evals) << id;

    const Prepared prepared = find_method(id).prepare(hairer_vilmart(), {});
    Trajectory first, second;
    prepared.integrate(grid_of(1, 100), first);
    prepared.integrate(grid_of(1, 100), second);
    EXPECT_EQ(first.samples.back().q.coeffs(), second.samples.back().q.coeffs()) << id;
    EXPECT_EQ(first.work.rhs_evals, second.work.rhs_evals) << id;
  }
}

TEST(AdamsBashforthMoulton, TwoEvaluationsAStepOnceStarted) {
  EXPECT_EQ(run("odeint-abm4", {}, grid_of(1, 100)).work.rhs_evals, 3 * 4 + 97 * 2);
  EXPECT_EQ(run("odeint-abm8", {}, grid_of(1, 100)).work.rhs_evals, 7 * 13 + 93 * 2);
  EXPECT_EQ(run("odeint-abm8-rk4-start", {}, grid_of(1, 100)).work.rhs_evals, 7 * 4 + 93 * 2);
}

TEST(AdamsBashforthMoulton, StartsAnewWhereTheStepChanges) {
  // Twice as many steps in the second half: the slopes of the first are of no use there. Taken for those of
  // the new size they would make an error of the size of a step, 1e-2.
  Grid grid;
  grid.stretches = {{5, 500, 0.01}, {10, 1000, 0.005}};
  const Trajectory t = run("odeint-abm8", {}, grid);
  EXPECT_LT(error(t, grid), 1e-9);
  EXPECT_EQ(t.work.rhs_evals, 2 * 7 * 13 + (1500 - 14) * 2);
}

TEST(AdamsBashforthMoulton, AStartOfOrderFourSpoilsOrderEight) {
  // The seven first steps of runge_kutta4 leave an error of order 5 that no later step mends.
  const Grid grid = grid_of(1, 1024);
  EXPECT_GT(error(run("odeint-abm8-rk4-start", {}, grid), grid),
            10 * error(run("odeint-abm8", {}, grid), grid));
}

TEST(DenseOutput, IsTheSameRunWithPoorerSamples) {
  Setting setting;
  setting.knob = Knob::tolerance;
  setting.rtol = 1e-10;
  const Grid grid = grid_of(200, 1);
  Trajectory truth;
  find_method("exact").prepare(hairer_vilmart(), {}).integrate(grid, truth);
  const auto worst = [&](const Trajectory& t) {
    double largest = 0;
    for (std::size_t i = 0; i < truth.samples.size(); ++i)
      largest = std::max(largest, attitude_error(truth.samples[i].q, t.samples[i].q));
    return largest;
  };
  const Trajectory branched = run("odeint-dopri5", setting, grid),
                   dense = run("odeint-dopri5-dense", setting, grid);
  // The same steps but for the last, which one shortens; rejected ones are counted as well.
  EXPECT_NEAR(double(dense.work.steps), double(branched.work.steps), 1);
  EXPECT_EQ(dense.work.rejected_steps, branched.work.rejected_steps);
  EXPECT_NEAR(double(dense.work.rhs_evals), double(branched.work.rhs_evals), 7);
  // Three times the error, measured (1.5e-10 against 5.0e-11); twice leaves room for another compiler.
  EXPECT_GT(worst(dense), 2 * worst(branched));
  EXPECT_LT(worst(dense), 1e-9);
}

Scene with_drag(double coefficient) {
  Scene scene = hairer_vilmart();
  scene.rotation->loads.push_back(AngularDrag<double>{(coefficient * Vec3::Ones()).asDiagonal()});
  return scene;
}

TEST(Rosenbrock4, StiffDragIsCheap) {
  // Drag of 1e6/s beside a turn a second: an explicit method is bound to h < 3e-6, some 4e6 steps for 10 s.
  Setting setting;
  setting.knob = Knob::tolerance;
  setting.rtol = 1e-6;
  Trajectory t;
  find_method("odeint-rosenbrock4").prepare(with_drag(1e6), setting).integrate(grid_of(10, 1), t);
  ASSERT_EQ(t.outcome, Outcome::ok) << t.reason;
  EXPECT_LT(t.work.steps, 1000);
  EXPECT_EQ(t.work.jacobian_evals, t.work.steps + t.work.rejected_steps);
  EXPECT_LT(t.samples.back().w_B.norm(), 1e-5);  // at rest, to the absolute tolerance
}

TEST(Rosenbrock4, KnowsWhereTheEquationsDependOnTime) {
  // The torque of gravity on a satellite turns with its orbit. With a wrong df/dt the order is 1, as it is in
  // the library of Boost 1.74: so only its corrected row is held to order 4.
  Scene scene = hairer_vilmart();
  scene.rotation->loads.push_back(GravityGradient<double>{0.7, Vec3(0.6, 0.8, 1)});
  const auto end = [&](const char* id, std::int64_t steps) {
    Trajectory t;
    find_method(id).prepare(scene, {}).integrate(grid_of(1, steps), t);
    return t.samples.back().q;
  };
  const Quaternion truth = end("verner98", 1000);
  const double coarse = attitude_error(truth, end("odeint-rosenbrock4-corrected", 400)),
               fine = attitude_error(truth, end("odeint-rosenbrock4-corrected", 800));
  EXPECT_GT(std::log2(coarse / fine), 3.7);
  EXPECT_LE(fine, 1.01 * attitude_error(truth, end("odeint-rosenbrock4", 800)));
}

TEST(ImplicitEuler, SaysWhereItsIterationFailsAndNeverHangs) {
  // Steps of 0.1 s: at 3 rad/s the iteration contracts, with any drag; at 3000 rad/s it cannot.
  for (const double drag : {1.0, 1e3, 1e6})
    for (const double rate : {1.0, 1e3, 1e200}) {
      Scene scene = with_drag(drag);
      scene.rotation->w0 *= rate;
      Trajectory t;
      find_method("odeint-implicit-euler").prepare(scene, {}).integrate(grid_of(1, 100), t);
      const Outcome expected = rate == 1     ? Outcome::ok
                               : rate == 1e3 ? Outcome::solver_failed
                                             : Outcome::not_finite;
      EXPECT_EQ(t.outcome, expected) << drag << ' ' << rate << ' ' << t.reason;
      EXPECT_EQ(t.outcome == Outcome::ok, t.reason.empty());
    }
}

}  // namespace
}  // namespace polhode
