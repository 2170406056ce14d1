// Discrete Moser-Veselov against the closed form of the free body: orders, what is kept over a million steps,
// and the row that has no error.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "models/extended_free_rotation.hpp"
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

ExtendedFreeRotation motion_of(const Scene& scene) {
  return ExtendedFreeRotation(scene.rotation->moments, scene.rotation->q0, scene.rotation->w0);
}

/// Attitude [rad] or relative rate, whichever is further off.
double error_of(const ExtendedFreeRotation& motion, const Sample& s) {
  const auto exact = motion.at(s.t);
  return std::max(attitude_error(exact.q, s.q), (exact.w_B - s.w_B).norm() / exact.w_B.norm());
}

Scene free_body(const Vec3& moments, const Vec3& w0) {
  Scene scene = find_scene("hairer-vilmart");
  scene.rotation->moments = moments;
  scene.rotation->w0 = w0;
  return scene;
}

class MoserVeselovOrder : public testing::TestWithParam<int> {};

TEST_P(MoserVeselovOrder, OfTheFreeBody) {
  const int order = GetParam();
  const Scene scene = find_scene("hairer-vilmart");
  const auto motion = motion_of(scene);
  std::vector<double> h, error;
  for (const int steps : {100, 110, 125, 150}) {
    const Trajectory run = run_steps("dmv" + std::to_string(order), scene, 10, steps);
    ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
    h.push_back(std::log(10.0 / steps));
    error.push_back(std::log(error_of(motion, run.samples.front())));
  }
  // At h |w| = 0.3 the next term, h^2 smaller, bends the slope by a few hundredths; the smallest error, 2e-13
  // of order 10, is thirty times what rounding does.
  EXPECT_NEAR(fit_line(h, error).slope, order, 0.15);
}

INSTANTIATE_TEST_SUITE_P(All, MoserVeselovOrder, testing::Values(2, 4, 6, 8, 10));

TEST(MoserVeselov, EnergyAndMomentumOverAMillionSteps) {
  const std::int64_t steps = sanitized ? 10'000 : 1'000'000;
  const Scene scene = find_scene("hairer-vilmart");
  const Vec3 L0 = scene.rotation->moments.cwiseProduct(scene.rotation->w0);
  const double E0 = 0.5 * L0.dot(scene.rotation->w0);
  for (const char* id : {"dmv2", "dmv6", "dmv-exact"}) {
    const Trajectory run = run_steps(id, scene, 0.1 * double(steps), steps);
    ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
    const Sample& s = run.samples.front();
    // A step changes m by a third of itself, and each change is rounded to 1e-16 of itself: after a million
    // that went no particular way, 3e-17 times a thousand.
    EXPECT_LT(std::abs(s.rotational_energy / E0 - 1), 1e-13) << id;
    EXPECT_LT((s.L - L0).norm() / L0.norm(), 1e-13) << id;
    EXPECT_LT(s.unit_defect, 1e-13) << id;
  }
}

TEST(MoserVeselov, ExactHasNoErrorForAnyStepThatItTakes) {
  const Scene scene = find_scene("hairer-vilmart");
  const auto motion = motion_of(scene);
  int refused = 0;
  for (int steps = 5; steps < 3000; steps += 1 + steps / 20) {
    const Trajectory run = run_steps("dmv-exact", scene, 10, steps);
    if (run.outcome == Outcome::solver_failed) {
      EXPECT_GT(10.0 / steps, 0.48) << "refuses a step that has a solution: the body turns by 3.16 h";
      EXPECT_NE(run.reason.find("no solution"), std::string::npos);
      ++refused;
      continue;
    }
    ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
    EXPECT_LT(error_of(motion, run.samples.front()), 5e-14) << steps << " steps";
  }
  EXPECT_GT(refused, 5);
}

TEST(MoserVeselov, ExactForEveryBody) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  int solved = 0;
  for (int i = 0; i < 2000; ++i) {
    // Moments of a body that can be built: sums of two of three positive numbers; some of them equal, some
    // flat, some nearly at rest about an axis.
    Vec3 d(std::exp(normal(random)), std::exp(normal(random)), std::exp(normal(random)));
    if (i % 7 == 0) d[1] = d[0];
    if (i % 11 == 0) d[2] = 1e-12 * d[1];
    if (i % 101 == 0) d[1] = d[2] = d[0];
    Vec3 w(normal(random), normal(random), normal(random));
    if (i % 5 == 0) w[i % 3] *= std::pow(10.0, -16 * uniform(random));
    if (i % 13 == 0) w[(i + 1) % 3] *= std::pow(10.0, -16 * uniform(random));
    if (i % 29 == 0) w[1] = w[2] = 0;
    const Scene scene = free_body(Vec3(d[1] + d[2], d[2] + d[0], d[0] + d[1]), w);
    const double h = std::pow(10.0, -5 + 5 * uniform(random));
    const Trajectory run = run_steps("dmv-exact", scene, 20 * h, 20);
    if (run.outcome == Outcome::solver_failed) continue;
    ASSERT_EQ(run.outcome, Outcome::ok) << run.reason;
    ++solved;
    // Near the end of solvability (determinant 0.05) twenty steps each multiply rounding by twenty.
    EXPECT_LT(error_of(motion_of(scene), run.samples.front()), 20 * 20 * 2.2e-16 * (1 + 20 * h * w.norm()))
        << scene.rotation->moments.transpose() << " | " << w.transpose() << " | " << h;
  }
  EXPECT_GT(solved, 1600);
}

TEST(MoserVeselov, StepsWithoutSolutionAreReported) {
  // A ball turns by arcsin(h w) a step: no further than h w = 1.
  const Scene ball = free_body(Vec3(1, 1, 1), Vec3(0.6, 0, 0.8));
  EXPECT_EQ(run_steps("dmv2", ball, 9, 10).outcome, Outcome::ok);
  for (const double h : {1.01, 1.5, 3.0, 100.0}) {
    const Trajectory run = run_steps("dmv2", ball, 10 * h, 10);
    EXPECT_EQ(run.outcome, Outcome::solver_failed) << h;
    EXPECT_FALSE(run.reason.empty());
  }
  // With the right moments it turns by h w, as long as that is less than a right angle.
  EXPECT_EQ(run_steps("dmv-exact", ball, 15, 10).outcome, Outcome::ok);
  for (const double h : {1.6, 3.0, 6.3, 100.0})
    EXPECT_EQ(run_steps("dmv-exact", ball, 10 * h, 10).outcome, Outcome::solver_failed) << h;
  for (const char* id : {"dmv2", "dmv4", "dmv6", "dmv8", "dmv10", "dmv-exact"}) {
    const Trajectory run = run_steps(id, find_scene("heavy-top"), 2, 10);
    EXPECT_EQ(run.outcome, Outcome::solver_failed) << id << ": 30 radians a step";
  }
}

TEST(MoserVeselov, ExactBetweenKicksIsFreeFlowBetweenKicks) {
  // Two ways to the same free motion: Newton on the discrete equation, and theta functions.
  for (const char* id : {"attitude-spring", "gravity-gradient-satellite", "angular-drag"}) {
    const Scene scene = find_scene(id);
    const Trajectory a = run_steps("dmv-exact", scene, scene.duration, 600),
                     b = run_steps("free-flow-split", scene, scene.duration, 600);
    ASSERT_EQ(a.outcome, Outcome::ok) << id << ": " << a.reason;
    const Sample &x = a.samples.front(), &y = b.samples.front();
    // 600 steps, each with a rounding error of some 1e-15 in the closed form.
    EXPECT_LT(attitude_error(x.q, y.q), 600 * 2e-15) << id;
    EXPECT_LT((x.w_B - y.w_B).norm(), 600 * 2e-15 * y.w_B.norm()) << id;
  }
}

}  // namespace
}  // namespace polhode
