// The adapters of SUNDIALS CVODE and Boost.Odeint, and the explicit Runge-Kutta methods of our own that run
// as they do: they solve the right equations to the accuracy that was asked, report what they did, and fail
// as values.
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "models/model.hpp"
#include "solvers/registry.hpp"
#include "tests/free_body_runs.hpp"

namespace polhode {
namespace {

/// All their rows that have a knob: read from the registry, so that a new one is tested at once.
std::vector<const Method*> adapters(Knob knob) {
  std::vector<const Method*> found;
  for (const Method* m : select_methods({"cvode-*", "odeint-*", "dop853*", "verner98", "gbs"}))
    if (m->has(knob)) found.push_back(m);
  return found;
}

Scene particle() {
  Scene scene;
  scene.duration = 2;
  TranslationData translation;
  translation.mass = 2;
  translation.v0 = Vec3(3, 0, 4);
  translation.acceleration = Vec3(0, 0, -9.81);
  translation.drag = 0.6;
  translation.has_force = true;
  scene.translation = translation;
  return scene;
}

TEST(Adapters, ReachThePublishedState) {
  // The error control keeps the local error near the tolerance; the global error is larger by the growth
  // along the run: 10 s are a few turns, and a free body parts from its neighbours linearly in time. CVODE
  // controls the error per step, so that its 400 to 1300 steps add up: three digits are allowed for both
  // together. A matrix that has left the rotations carries another inertia, R I R^T, and its body moves
  // otherwise: a defect of its six conditions adds up where that of |q| does not, for which one digit more is
  // allowed and a factor 2 (1.4e4 is the largest measured over 1e-3 ... 1e-12).
  for (const Method* m : adapters(Knob::tolerance))
    for (const double rtol : {1e-6, 1e-9, 1e-12}) {
      const Trajectory t = run(*m, hairer_vilmart(), tolerance(rtol), equal_grid(10, 1));
      ASSERT_EQ(t.outcome, Outcome::ok) << m->id << ": " << t.reason;
      const double allowed = m->id.ends_with("-matrix") ? 20'000 : 1000;
      EXPECT_LT(error_at_10(t.samples.back()), allowed * rtol) << m->id << " at " << rtol;
    }
}

TEST(Adapters, FixedStepsReachThePublishedState) {
  // 10 s in 4096 steps: h = 0.00244. The smallest order is 4 with an error of 4.0e-10 measured at h = 0.0039,
  // which 4th order brings to 6.2e-11; a factor 2 for the margin. The others are at rounding, about 2e-13.
  // (Lower orders are in the table of claims alone.)
  for (const Method* m : adapters(Knob::steps)) {
    if (m->claims.attitude_order < 4) continue;
    Setting setting;
    setting.knob = Knob::steps;
    const Trajectory t = run(*m, hairer_vilmart(), setting, equal_grid(10, 1, 4096));
    ASSERT_EQ(t.outcome, Outcome::ok) << m->id << ": " << t.reason;
    EXPECT_LT(error_at_10(t.samples.back()), 1.3e-10) << m->id;
    EXPECT_EQ(t.work.steps, 4096) << m->id;
  }
}

TEST(Adapters, OneStepOfOdeintRk4IsThePublishedOne) {
  // EXUDYN's unit test of its explicit solver: I = (5.2988, 1.1775, 4.3568), w0 = (2, 4, 6), one step of
  // 1e-3, to the 16 digits printed; 4 units in the last place of the largest.
  Scene scene = hairer_vilmart();
  scene.rotation->moments = Vec3(5.2988, 1.1775, 4.3568);
  scene.rotation->w0 = Vec3(2, 4, 6);
  Grid grid;
  grid.stretches.push_back({1e-3, 1, 1e-3});
  const Trajectory t = run(find_method("odeint-rk4"), scene, Setting{}, grid);
  const Vec3 published(1.985608117600764, 3.990428541317109, 6.007531319827856);
  EXPECT_LT((t.samples.back().w_B - published).cwiseAbs().maxCoeff(), 4 * 8.9e-16);
}

TEST(Adapters, SmallerTolerancesGiveSmallerErrors) {
  // With the error of a step kept at the tolerance, order k takes N ~ tol^(-1/(k+1)) steps, and their errors
  // add up to N tol = tol^(k/(k+1)): exponent 3/4 or more from order 3 on, which all of these use at such
  // tolerances.
  for (const Method* m : adapters(Knob::tolerance)) {
    double first = 0, last = 1;
    for (const double rtol : {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}) {
      const double error =
          error_at_10(run(*m, hairer_vilmart(), tolerance(rtol), equal_grid(10, 1)).samples.back());
      EXPECT_LT(error, last) << m->id << " at " << rtol;
      if (first == 0) first = error;
      last = error;
    }
    EXPECT_GT(std::log10(first / last) / 8, 0.75) << m->id;
  }
}

TEST(Adapters, LookingDoesNotDisturb) {
  for (const Method* m : adapters(Knob::tolerance)) {
    const Prepared prepared = m->prepare(hairer_vilmart(), tolerance(1e-8));
    Trajectory once, often, again;
    prepared.integrate(equal_grid(10, 1), once);
    prepared.integrate(equal_grid(10, 1000), often);
    prepared.integrate(equal_grid(10, 1), again);  // and a run leaves nothing behind for the next one
    ASSERT_EQ(often.samples.size(), 1001u) << m->id;
    for (const Trajectory* t : {&often, &again}) {
      EXPECT_EQ(t->work.steps, once.work.steps) << m->id;
      EXPECT_EQ(t->work.rejected_steps, once.work.rejected_steps) << m->id;
      EXPECT_EQ(t->work.rhs_evals, once.work.rhs_evals) << m->id;
      EXPECT_EQ(t->work.jacobian_evals, once.work.jacobian_evals) << m->id;
      EXPECT_EQ(t->samples.back().q.coeffs(), once.samples.back().q.coeffs()) << m->id;
      EXPECT_EQ(t->samples.back().w_B, once.samples.back().w_B) << m->id;
    }
  }
}

TEST(Adapters, SamplesInsideStepsAreAsAccurateAsTheRun) {
  // Truth: rkf78 in 1000 steps of 0.01, where its error is at rounding (4e-16 of truncation: 7.4e-9 at h =
  // 0.25, order 8). The largest error of 100 samples must not exceed three times the error at the end and the
  // tolerance together: a free body's error grows with time, and the end is among its largest.
  Setting fine;
  fine.knob = Knob::steps;
  const Trajectory truth = run(find_method("odeint-rkf78"), hairer_vilmart(), fine, equal_grid(10, 100, 10));
  for (const Method* m : adapters(Knob::tolerance)) {
    const Trajectory t = run(*m, hairer_vilmart(), tolerance(1e-8), equal_grid(10, 100));
    double largest = 0;
    for (std::size_t i = 0; i < t.samples.size(); ++i)
      largest = std::max(largest, attitude_error(truth.samples[i].q, t.samples[i].q));
    const double end = attitude_error(truth.samples.back().q, t.samples.back().q);
    EXPECT_LT(largest, 3 * (end + 1e-8)) << m->id;
  }
}

TEST(Adapters, AParticleFallsWithDrag) {
  // v' = g - (b/m) v has v = v_inf + (v0 - v_inf) exp(-k t), k = b/m = 0.3, v_inf = g/k. The error per unit
  // step is the tolerance times the size of the state, about 10, and drag damps it.
  const Scene scene = particle();
  const double k = 0.3, decay = std::exp(-k * 2);
  const Vec3 v_inf = Vec3(0, 0, -9.81) / k, v0(3, 0, 4);
  const Vec3 v = v_inf + (v0 - v_inf) * decay, p = v_inf * 2 + (v0 - v_inf) * (1 - decay) / k;
  for (const Method* m : adapters(Knob::tolerance)) {
    if (m->prepare(scene, tolerance(1e-9)).unsupported.starts_with("needs an attitude")) continue;  // below
    const Trajectory t = run(*m, scene, tolerance(1e-9), equal_grid(2, 4));
    ASSERT_EQ(t.outcome, Outcome::ok) << m->id << ": " << t.reason;
    EXPECT_LT((t.samples.back().v - v).norm(), 1e-6) << m->id;
    EXPECT_LT((t.samples.back().p - p).norm(), 1e-6) << m->id;
  }
}

TEST(Adapters, WhatDoesNotFitIsUnsupportedWithAReason) {
  Scene rates = hairer_vilmart();
  rates.rotation->attitude = false;
  for (const char* id :
       {"cvode-bdf-projected", "cvode-adams-renormalised", "cvode-adams-norm-feedback", "cvode-adams-matrix"})
    for (const Scene& scene : {particle(), rates}) {
      const Prepared bare = find_method(id).prepare(scene, tolerance(1e-6));
      EXPECT_FALSE(bare.integrate) << id;
      EXPECT_NE(bare.unsupported.find("attitude"), std::string::npos) << bare.unsupported;
    }

  const Prepared no_tolerance = find_method("odeint-rk4").prepare(hairer_vilmart(), tolerance(1e-6));
  EXPECT_FALSE(no_tolerance.integrate);
  EXPECT_NE(no_tolerance.unsupported.find("tolerance"), std::string::npos);
  EXPECT_FALSE(find_method("odeint-bulirsch-stoer").prepare(hairer_vilmart(), Setting{}).integrate);
}

TEST(Adapters, StepLimitAndTimeoutAreOutcomes) {
  for (const Method* m : adapters(Knob::tolerance)) {
    Setting limited = tolerance(1e-8);
    limited.step_limit = 5;
    for (const int samples : {1, 200}) {
      const Trajectory t = run(*m, hairer_vilmart(), limited, equal_grid(10, samples));
      EXPECT_EQ(t.outcome, Outcome::step_limit) << m->id << ": " << t.reason;
      EXPECT_EQ(t.work.steps + t.work.rejected_steps * (m->family != "SUNDIALS CVODE"), 5) << m->id;
      EXPECT_FALSE(t.reason.empty());
    }
    // Long enough that it cannot end in the time given: 1e7 s are 4e7 turns, and no machine takes them in a
    // millisecond.
    Setting hurried = tolerance(1e-8);
    hurried.timeout_s = 1e-3;
    const Trajectory t = run(*m, hairer_vilmart(), hurried, equal_grid(1e7, 1));
    EXPECT_EQ(t.outcome, Outcome::timeout) << m->id << ": " << t.reason;
    EXPECT_GT(t.work.steps, 0) << m->id;
  }
}

TEST(Adapters, WhatIsNotFiniteIsSaid) {
  // Rates of 1e200 rad/s: their products overflow in the first right-hand side.
  Scene scene = hairer_vilmart();
  scene.rotation->w0 = Vec3(1e200, 1e200, 1e200);
  for (const Method* m : adapters(Knob::tolerance)) {
    const Trajectory t = run(*m, scene, tolerance(1e-6), equal_grid(10, 10));
    EXPECT_NE(t.outcome, Outcome::ok) << m->id;
    EXPECT_FALSE(t.reason.empty()) << m->id;
  }
}

TEST(Adapters, NothingIsPrintedOnFailure) {
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  Setting limited = tolerance(1e-8);
  limited.step_limit = 5;
  for (const Method* m : adapters(Knob::tolerance)) run(*m, hairer_vilmart(), limited, equal_grid(10, 1));
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

TEST(Cvode, AdamsMakesNoJacobianAndBdfDoes) {
  const Grid grid = equal_grid(10, 1);
  EXPECT_EQ(run(find_method("cvode-adams"), hairer_vilmart(), tolerance(1e-8), grid).work.jacobian_evals, 0);
  EXPECT_GT(run(find_method("cvode-bdf"), hairer_vilmart(), tolerance(1e-8), grid).work.jacobian_evals, 0);
}

TEST(Cvode, StiffDragIsCheapForBdfAlone) {
  // Drag of 1e6/s beside a turn a second: an explicit method is bound to h < 2e-6 for stability, 5e6 steps
  // for 10 s; BDF takes its steps by accuracy alone. 10^4 is between the two with room on both sides.
  Scene scene = hairer_vilmart();
  scene.rotation->loads.push_back(AngularDrag<double>{Vec3(1e6, 1e6, 1e6).asDiagonal()});
  const Trajectory t = run(find_method("cvode-bdf"), scene, tolerance(1e-6), equal_grid(10, 10));
  ASSERT_EQ(t.outcome, Outcome::ok) << t.reason;
  EXPECT_LT(t.work.steps, 10'000);
  EXPECT_LT(t.samples.back().w_B.norm(), 1e-5);  // it has come to rest, to the absolute tolerance
}

TEST(Cvode, ProjectionKeepsTheAttitudeUnit) {
  for (const double rtol : {1e-4, 1e-6, 1e-8}) {
    const Trajectory projected =
        run(find_method("cvode-bdf-projected"), hairer_vilmart(), tolerance(rtol), equal_grid(10, 50));
    ASSERT_EQ(projected.outcome, Outcome::ok) << projected.reason;
    // At the end, which is the end of a step: the rounding of four products and a root.
    EXPECT_LT(projected.samples.back().unit_defect, 1e-15);
    // Between two steps the interpolant passes off the sphere by the error of a step, which is of the size of
    // the tolerance and does not add up; without projection the defect grows with the number of steps.
    for (const Sample& s : projected.samples) EXPECT_LT(s.unit_defect, rtol) << "t = " << s.t;
    const Trajectory bare =
        run(find_method("cvode-bdf"), hairer_vilmart(), tolerance(rtol), equal_grid(10, 50));
    EXPECT_GT(bare.samples.back().unit_defect, rtol);
  }
}

// ---- the Jacobian that BDF is given

std::vector<std::vector<AnyTorque<double>>> all_load_lists() {
  const Mat3 drag = (Mat3() << 0.3, 0.01, 0, 0.01, 0.2, 0.02, 0, 0.02, 0.5).finished();
  const std::vector<AnyTorque<double>> each = {
      GravityAboutPivot<double>{2, Vec3(0.5, -1, -9.81), Vec3(0.1, 0.2, 0.3)},
      AngularDrag<double>{drag},
      AttitudeSpring<double>{3, 0.4, normalised(Quaternion(0.9, 0.1, -0.3, 0.2))},
      ConstantTorque<double, Frame::body>{Vec3(0.1, 0.2, -0.3)},
      ConstantTorque<double, Frame::space>{Vec3(0.3, -0.1, 0.2)},
      GravityGradient<double>{0.7, Vec3(0.6, 0.8, 1)}};
  EXPECT_EQ(each.size(), std::variant_size_v<AnyTorque<double>>);
  std::vector<std::vector<AnyTorque<double>>> lists = {{}, each};
  for (const auto& load : each) lists.push_back({load});
  return lists;
}

/// Largest difference between the analytic Jacobian and central differences, relative to the largest entry.
double jacobian_error(const Scene& scene) {
  return with_model(scene, [](const auto& m) {
    using M = std::decay_t<decltype(m)>;
    constexpr int n = M::size;
    auto y = m.initial;
    if constexpr (M::has_attitude)
      for (std::size_t i = 0; i < 4; ++i) y[i] *= 1.1;  // q need not be of unit length
    const double t = 0.37;
    Eigen::Matrix<double, n, n> analytic, numeric;
    m.jacobian(t, y.data(), analytic);
    for (int j = 0; j < n; ++j) {
      const double h = 1e-5;
      auto above = y, below = y;
      above[static_cast<std::size_t>(j)] += h;
      below[static_cast<std::size_t>(j)] -= h;
      Eigen::Matrix<double, n, 1> f_above, f_below;
      m.rhs(t, above.data(), f_above.data());
      m.rhs(t, below.data(), f_below.data());
      numeric.col(j) = (f_above - f_below) / (2 * h);
    }
    return (analytic - numeric).cwiseAbs().maxCoeff() / std::max(1.0, analytic.cwiseAbs().maxCoeff());
  });
}

TEST(Jacobian, AgreesWithCentralDifferencesForEveryLoad) {
  // Central differences with h = 1e-5: truncation h^2/6 |f'''| with third derivatives of at most some 100
  // times the first (rotations are of degree two over |q|^2), 2e-9; rounding eps |f|/h = 1e-16 * 30 / 1e-5 =
  // 3e-10.
  for (const auto& loads : all_load_lists())
    for (const bool attitude : {true, false})
      for (const bool round : {true, false})
        for (const int translation : {0, 1, 2}) {
          if (!attitude && translation > 0) continue;
          Scene scene = hairer_vilmart();
          scene.rotation->q0 = Quaternion(0.5, -0.7, 0.3, 0.4);
          scene.rotation->attitude = attitude;
          if (round) scene.rotation->moments = Vec3(0.7, 0.7, 0.7);
          bool needs_attitude = false;
          for (const auto& load : loads) {
            needs_attitude =
                needs_attitude || std::visit([](const auto& l) { return l.needs_attitude; }, load);
            scene.rotation->loads.push_back(load);
          }
          if (needs_attitude && !attitude) continue;  // such a scene is refused when it is read
          if (translation > 0) scene.translation = particle().translation;
          if (translation == 1) scene.translation->has_force = false;
          EXPECT_LT(jacobian_error(scene), 3e-9)
              << loads.size() << " loads, the first of kind "
              << (loads.empty() ? -1 : static_cast<int>(loads.front().index()))
              << (attitude ? "" : ", rates alone") << (round ? ", round" : "") << ", translation "
              << translation;
        }
}

TEST(Jacobian, AgreesWithCentralDifferencesForAParticle) {
  EXPECT_LT(jacobian_error(particle()), 3e-9);
  Scene unforced = particle();
  unforced.translation->has_force = false;
  EXPECT_LT(jacobian_error(unforced), 3e-9);
}

}  // namespace
}  // namespace polhode
