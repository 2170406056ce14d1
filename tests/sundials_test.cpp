// SUNDIALS beyond what every solver's claims say: the tables are what their names promise, the defect of
// ERKStep is there where it is claimed, vectors of our own change nothing, looking changes nothing, and what
// fails is said.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/free_body_runs.hpp"

namespace polhode {
namespace {

Scene with_drag(double coefficient) {
  Scene scene = hairer_vilmart();
  scene.rotation->loads.push_back(
      AngularDrag<double>{Vec3(coefficient, coefficient, coefficient).asDiagonal()});
  return scene;
}

bool is_erkstep(const Method& m) { return m.id.starts_with("arkode-erkstep-"); }
/// Rows of ARKODE that stand for the others: those of the studies, a second implicit one, and all of ERKStep.
std::vector<const Method*> representative() {
  std::vector<const Method*> found;
  for (const Method* m : select_methods({"arkode-*"}))
    if (m->in_studies || is_erkstep(*m) || m->id == "arkode-trbdf2-3-3-2") found.push_back(m);
  EXPECT_GE(found.size(), 8u);
  return found;
}

bool is_explicit(const Method& m) { return m.summary.starts_with("explicit"); }

// ---- the tables

TEST(Arkode, StabilityPolynomialsAreExponentialsUpToTheOrder) {
  // A method of order p has R(z) = exp(z) + O(z^(p+1)): the coefficients up to z^p are 1/k!. They are sums of
  // products of at most 13 rounded coefficients, some of them as large as 12.
  int seen = 0;
  for (const Method* m : select_methods({"arkode-*"})) {
    if (m->stability_polynomial.empty() || m->stability_denominator.size() > 1) continue;
    ++seen;
    // NAME-STAGES-EMBEDDED-ORDER, but for the one without a pair: NAME-STAGES-ORDER.
    std::string id(m->id);
    if (id.ends_with("-fixed-vector")) id.resize(id.size() - 13);
    const int order = id.back() - '0';
    double factorial = 1;
    for (int k = 0; k <= order; ++k) {
      EXPECT_NEAR(m->stability_polynomial[static_cast<std::size_t>(k)], 1 / factorial, 1e-14)
          << id << ", z^" << k;
      factorial *= k + 1;
    }
  }
  EXPECT_GE(seen, 15 + 2 + 1);  // SUNDIALS 6.4 ships 15; ERKStep's sound ones and vectors of fixed length
}

TEST(Arkode, StabilityPolynomialsAreThoseOfTheSamePairsElsewhere) {
  for (const auto& [ours, theirs] : {std::pair("arkode-dormand-prince-7-4-5", "odeint-dopri5"),
                                     std::pair("arkode-fehlberg-13-7-8", "odeint-rkf78")}) {
    const auto R = find_method(ours).stability_polynomial, other = find_method(theirs).stability_polynomial;
    for (std::size_t k = 0; k < std::max(R.size(), other.size()); ++k)
      EXPECT_NEAR(k < R.size() ? R[k] : 0, k < other.size() ? other[k] : 0, 1e-15) << ours << ", z^" << k;
  }
}

/// Order between n and 2n fixed steps of the free body.
double order_at(const char* id, int n) {
  const Method& m = find_method(id);
  return std::log2(error_at_10(run(m, hairer_vilmart(), {}, equal_grid(10, 1, n)).samples.back()) /
                   error_at_10(run(m, hairer_vilmart(), {}, equal_grid(10, 1, 2 * n)).samples.back()));
}

/// Does the installed ERKStep take any last stage at the end of a step for its result? Mended in 6.7.0.
bool erkstep_is_wrong() {
  int major = 0, minor = 0;
  EXPECT_EQ(
      std::sscanf(std::string(find_method("cvode-adams").version).c_str(), "SUNDIALS %d.%d", &major, &minor),
      2);
  return major < 6 || (major == 6 && minor < 7);
}

TEST(Arkode, ErkstepLosesTheOrderOfSomeTablesWhereItIsWrong) {
  // A wrong first slope, off by the error of a stage of order r, h^(r+1), enters with weight b_1 h in each
  // step. Both tables at step sizes where ARKStep is well above rounding (3.5e-9 and 1.4e-4 at 128 steps).
  EXPECT_NEAR(order_at("arkode-sayfy-aburub-6-3-4", 256), 4, 0.15);
  EXPECT_NEAR(order_at("arkode-erkstep-sayfy-aburub-6-3-4", 256), erkstep_is_wrong() ? 2 : 4, 0.15);
  EXPECT_NEAR(order_at("arkode-verner-8-5-6", 128), 6, 0.15);
  if (erkstep_is_wrong())
    EXPECT_NEAR(order_at("arkode-erkstep-verner-8-5-6", 1024), 3, 0.15);
  else
    EXPECT_NEAR(order_at("arkode-erkstep-verner-8-5-6", 128), 6, 0.15);
  // Where the last node is not 1 (Cash-Karp), or the last stage is the result (Dormand-Prince), ERKStep and
  // ARKStep take the same steps; 128 of them, so that rounding is 1e-6 of the error.
  for (const char* table : {"cash-karp-6-4-5", "dormand-prince-7-4-5"}) {
    const Grid grid = equal_grid(10, 1, 128);
    const Trajectory ark =
        run(find_method(std::string("arkode-") + table), hairer_vilmart(), Setting{}, grid);
    const Trajectory erk =
        run(find_method(std::string("arkode-erkstep-") + table), hairer_vilmart(), Setting{}, grid);
    const double error = error_at_10(ark.samples.back());
    EXPECT_GT(error, 1e-9) << table;
    EXPECT_NEAR(error_at_10(erk.samples.back()), error, 1e-12) << table;
  }
}

TEST(Arkode, ErkstepSavesAStageOfDormandAndPrince) {
  const Trajectory t = run(find_method("arkode-erkstep-dormand-prince-7-4-5"), hairer_vilmart(), Setting{},
                           equal_grid(10, 1, 1000));
  // Six a step, the first slope being the last of the step before, and one or two at the ends.
  EXPECT_GE(t.work.rhs_evals, 6000);
  EXPECT_LE(t.work.rhs_evals, 6002);
}

TEST(Arkode, FixedStepsAreCountedAndEndWhereTheyShould) {
  // 0.1 is no binary fraction: 30 000 sums of 10/30000 miss 10 by some 1e-12, which must cost no step.
  for (const char* id : {"arkode-dormand-prince-7-4-5", "arkode-erkstep-dormand-prince-7-4-5"}) {
    const Trajectory t = run(find_method(id), hairer_vilmart(), Setting{}, equal_grid(10, 1, 30'000));
    EXPECT_EQ(t.work.steps, 30'000) << id;
    // Rounding of 30 000 steps of some 14 operations each, 1.1e-16 and in no preferred direction, grown by
    // the motion (28): 28 * 1.1e-16 * sqrt(4.2e5) = 2e-12.
    EXPECT_LT(error_at_10(t.samples.back()), 2e-12) << id;
  }
}

TEST(Arkode, SamplesBetweenFixedStepsChangeNothing) {
  for (const Method* m : representative()) {
    const Trajectory once = run(*m, hairer_vilmart(), Setting{}, equal_grid(10, 1, 320));
    const Trajectory often = run(*m, hairer_vilmart(), Setting{}, equal_grid(10, 16, 20));
    EXPECT_EQ(once.work.steps, often.work.steps) << m->id;
    // A stretch begins with an exact time and a fresh first slope; ERKStep's wrong one is then right, once a
    // stretch, which is a change of 16 of 320 steps.
    if (m->claims.attitude_order > 3) {
      EXPECT_LT(attitude_error(once.samples.back().q, often.samples.back().q), 1e-12) << m->id;
    }
  }
}

TEST(Arkode, ATableWithoutAPairHasNoTolerance) {
  const Method& m = find_method("arkode-knoth-wolke-3-3");
  EXPECT_FALSE(m.by_tolerance);
  const Prepared prepared = m.prepare(hairer_vilmart(), tolerance(1e-6));
  EXPECT_FALSE(prepared.integrate);
  EXPECT_NE(prepared.unsupported.find("tolerance"), std::string::npos);
}

// ---- by tolerance

TEST(Arkode, LookingDoesNotDisturb) {
  for (const Method* m : representative()) {
    const Prepared prepared = m->prepare(hairer_vilmart(), tolerance(1e-7));
    Trajectory once, often, again;
    prepared.integrate(equal_grid(10, 1), once);
    prepared.integrate(equal_grid(10, 1000), often);
    prepared.integrate(equal_grid(10, 1), again);  // and a run leaves nothing behind for the next one
    ASSERT_EQ(often.samples.size(), 1001u) << m->id << often.reason;
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

TEST(Arkode, SamplesInsideStepsAreAsAccurateAsTheRun) {
  // Truth: rkf78 in 1000 steps of 0.01, where its error is at rounding. The interpolants of the library would
  // be off by 4e-7 for Fehlberg's pair at 1e-10. A free body's error grows with time, and the end is among
  // its largest: three times that and the tolerance together are allowed.
  const Trajectory truth =
      run(find_method("odeint-rkf78"), hairer_vilmart(), Setting{}, equal_grid(10, 100, 10));
  for (const char* id : {"arkode-fehlberg-13-7-8", "arkode-dormand-prince-7-4-5", "arkode-zonneveld-5-3-4",
                         "arkode-sdirk-5-3-4", "arkode-erkstep-dormand-prince-7-4-5"}) {
    const Trajectory t = run(find_method(id), hairer_vilmart(), tolerance(1e-10), equal_grid(10, 100));
    ASSERT_EQ(t.samples.size(), 101u) << id << t.reason;
    double largest = 0;
    for (std::size_t i = 0; i < t.samples.size(); ++i)
      largest = std::max(largest, attitude_error(truth.samples[i].q, t.samples[i].q));
    const double end = attitude_error(truth.samples.back().q, t.samples.back().q);
    EXPECT_LT(largest, 3 * (end + 1e-10)) << id;
  }
}

TEST(Arkode, SmallerTolerancesGiveSmallerErrors) {
  // With the error of a step kept at the tolerance, a pair of orders q(p) takes N ~ tol^(-1/(p+1)) steps with
  // an error of h^(q+1) each: the sum falls with tol^(q/(p+1)), at least tol^(1/2) (TRBDF2, 2(3)).
  for (const Method* m : representative()) {
    if (is_erkstep(*m)) continue;  // ERKStep may have lost its order
    double first = 0, last = 1;
    for (const double rtol : {1e-3, 1e-5, 1e-7, 1e-9}) {
      const double error =
          error_at_10(run(*m, hairer_vilmart(), tolerance(rtol), equal_grid(10, 1)).samples.back());
      EXPECT_LT(error, last) << m->id << " at " << rtol;
      if (first == 0) first = error;
      last = error;
    }
    EXPECT_GT(std::log10(first / last) / 6, 0.5) << m->id;
  }
}

TEST(Arkode, StiffDragIsCheapForImplicitTablesAlone) {
  // Drag of 1e6/s beside a turn a second. An explicit table is bound by stability to h < 6e-6 at best, 1.6e6
  // steps for 10 s; the implicit ones take their steps by accuracy alone, once the drag has done its work.
  const Scene scene = with_drag(1e6);
  Setting setting = tolerance(1e-6);
  setting.step_limit = 10'000;
  int implicit = 0;
  for (const Method* m : representative()) {
    if (is_erkstep(*m)) continue;  // ERKStep may fail otherwise
    const Trajectory t = run(*m, scene, setting, equal_grid(10, 10));
    if (is_explicit(*m)) {
      EXPECT_EQ(t.outcome, Outcome::step_limit) << m->id << t.reason;
      continue;
    }
    ++implicit;
    ASSERT_EQ(t.outcome, Outcome::ok) << m->id << t.reason;
    EXPECT_LT(t.work.steps, 1000) << m->id;
    EXPECT_GT(t.work.jacobian_evals, 0) << m->id;
    EXPECT_LT(t.samples.back().w_B.norm(), 1e-5) << m->id;  // at rest, to the absolute tolerance
  }
  EXPECT_GE(implicit, 2);
}

TEST(Arkode, FixedStepsAcrossStiffDragAreStableForImplicitTablesAlone) {
  for (const Method* m : representative()) {
    const Trajectory t = run(*m, with_drag(1e6), Setting{}, equal_grid(10, 10, 10));
    if (is_explicit(*m)) {
      EXPECT_NE(t.outcome, Outcome::ok) << m->id;
    } else {
      ASSERT_EQ(t.outcome, Outcome::ok) << m->id << t.reason;
      EXPECT_LT(t.samples.back().w_B.norm(), 1e-5) << m->id;
    }
  }
}

// ---- what ends a run

TEST(Arkode, StepLimitAndTimeoutAreOutcomes) {
  for (const Method* m : representative()) {
    Setting limited = tolerance(1e-8);
    limited.step_limit = 5;
    for (const int samples : {1, 200}) {
      const Trajectory t = run(*m, hairer_vilmart(), limited, equal_grid(10, samples));
      EXPECT_EQ(t.outcome, Outcome::step_limit) << m->id << ": " << t.reason;
      EXPECT_EQ(t.work.steps, 5) << m->id;
      EXPECT_FALSE(t.reason.empty());
    }
    // 1e7 s are 4e7 turns: no machine takes them in a millisecond, by either knob.
    for (const Knob knob : {Knob::steps, Knob::tolerance}) {
      Setting hurried = tolerance(1e-8);
      hurried.knob = knob;
      hurried.timeout_s = 1e-3;
      const Trajectory t = run(*m, hairer_vilmart(), hurried, equal_grid(1e7, 1, 1'000'000'000));
      EXPECT_EQ(t.outcome, Outcome::timeout) << m->id << ": " << t.reason;
      EXPECT_GT(t.work.steps, 0) << m->id;
    }
  }
}

TEST(Arkode, WhatIsNotFiniteIsSaidAndNothingIsPrinted) {
  // Rates of 1e200 rad/s: their products overflow in the first right-hand side.
  Scene scene = hairer_vilmart();
  scene.rotation->w0 = Vec3(1e200, 1e200, 1e200);
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const Method* m : representative())
    for (const Knob knob : {Knob::steps, Knob::tolerance}) {
      Setting setting = tolerance(1e-6);
      setting.knob = knob;
      const Prepared prepared = m->prepare(scene, setting);
      Trajectory t;
      prepared.integrate(equal_grid(10, 10), t);
      EXPECT_EQ(t.outcome, Outcome::not_finite) << m->id;
      EXPECT_NE(t.reason.find("not finite"), std::string::npos) << m->id;
      prepared.integrate(equal_grid(10, 10), t);  // and a failure leaves nothing behind
      EXPECT_EQ(t.outcome, Outcome::not_finite) << m->id;
    }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

// ---- vectors of fixed length

TEST(FixedLengthVectors, GiveTheSameRunToTheLastBit) {
  // All lengths there are: 7 (a free top), 3 (its rates), 6 (a particle), 13 (both).
  Scene rates = hairer_vilmart(), both = hairer_vilmart(), particle;
  rates.rotation->attitude = false;
  TranslationData thrown;
  thrown.v0 = Vec3(3, 0, 4);
  thrown.acceleration = Vec3(0, 0, -9.81);
  thrown.drag = 0.3;
  thrown.has_force = true;
  both.translation = particle.translation = thrown;
  particle.duration = 10;
  int compared = 0;
  for (const Method* ours : select_methods({"*-fixed-vector"})) {
    const Method& theirs = find_method(std::string(ours->id.substr(0, ours->id.size() - 13)));
    for (const Scene& scene : {hairer_vilmart(), rates, particle, both, with_drag(100)})
      for (const double rtol : {1e-4, 1e-9}) {
        const Grid grid = equal_grid(10, 7);
        const Trajectory a = run(*ours, scene, tolerance(rtol), grid);
        const Trajectory b = run(theirs, scene, tolerance(rtol), grid);
        ASSERT_EQ(a.outcome, Outcome::ok) << ours->id << a.reason;
        ASSERT_EQ(a.samples.size(), b.samples.size());
#ifdef __x86_64__  // elsewhere the library may have been built with fused multiply-adds
        EXPECT_EQ(a.work.steps, b.work.steps) << ours->id;
        EXPECT_EQ(a.work.rhs_evals, b.work.rhs_evals) << ours->id;
        EXPECT_EQ(a.work.jacobian_evals, b.work.jacobian_evals) << ours->id;
        for (std::size_t i = 0; i < a.samples.size(); ++i) {
          EXPECT_EQ(a.samples[i].q.coeffs(), b.samples[i].q.coeffs()) << ours->id;
          EXPECT_EQ(a.samples[i].w_B, b.samples[i].w_B) << ours->id;
          EXPECT_EQ(a.samples[i].v, b.samples[i].v) << ours->id;
        }
#else
        EXPECT_LT((a.samples.back().w_B - b.samples.back().w_B).norm(), 1000 * rtol) << ours->id;
#endif
        ++compared;
      }
  }
  EXPECT_EQ(compared, 4 * 10);
}

// ---- variants of CVODE

TEST(CvodeVariants, RenormalisingTheSamplesTouchesNothingElse) {
  const Grid grid = equal_grid(10, 20);
  const Trajectory a = run(find_method("cvode-adams-renormalised"), hairer_vilmart(), tolerance(1e-6), grid);
  const Trajectory b = run(find_method("cvode-adams"), hairer_vilmart(), tolerance(1e-6), grid);
  ASSERT_EQ(a.samples.size(), b.samples.size());
  EXPECT_EQ(a.work.steps, b.work.steps);
  EXPECT_EQ(a.work.rhs_evals, b.work.rhs_evals);
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    EXPECT_LT(a.samples[i].unit_defect, 4e-16);
    if (i > 0) {
      EXPECT_GT(b.samples[i].unit_defect, 1e-8);
    }
    EXPECT_EQ(a.samples[i].w_B, b.samples[i].w_B);
    EXPECT_LT(attitude_error(a.samples[i].q, b.samples[i].q), 1e-15);  // the same rotation
  }
}

TEST(CvodeVariants, FeedbackHoldsTheLengthOfTheAttitude) {
  // Without it the defect is the sum of all steps', ten times as large after ten times as long; with it, that
  // of the last 1/(2k) = 0.16 s, whatever the duration. A factor 3 is between 1 and 10.
  const Grid grid = equal_grid(500, 500);
  for (const double rtol : {1e-5, 1e-8}) {
    const auto worst = [&](const char* id, double from, double to) {
      double defect = 0;
      for (const Sample& s : run(find_method(id), hairer_vilmart(), tolerance(rtol), grid).samples)
        if (s.t > from && s.t <= to) defect = std::max(defect, s.unit_defect);
      return defect;
    };
    EXPECT_LT(worst("cvode-adams-norm-feedback", 50, 500), 3 * worst("cvode-adams-norm-feedback", 0, 50));
    EXPECT_GT(worst("cvode-adams", 50, 500), 3 * worst("cvode-adams", 0, 50));
  }
}

TEST(CvodeVariants, DifferenceQuotientsAreCounted) {
  // Seven right-hand sides for each Jacobian of seven columns, and at least one for each step.
  const Trajectory t =
      run(find_method("cvode-bdf-differences"), hairer_vilmart(), tolerance(1e-8), equal_grid(10, 1));
  EXPECT_GT(t.work.jacobian_evals, 0);
  EXPECT_GE(t.work.rhs_evals, t.work.steps + 7 * t.work.jacobian_evals);
}

TEST(CvodeVariants, StabilityLimitDetectionKeepsMoreOfAnOscillation) {
  // A stiff spring without damping swings for ever, its eigenvalues on the imaginary axis, next to which BDF
  // of orders 3 to 5 is not stable and of every order damps: energy is lost. Where CVODE sees it and lowers
  // the order, the steps are more and smaller, and less is lost (10 % and 4 % measured).
  Scene scene = hairer_vilmart();
  scene.rotation->w0 *= 0.01;
  scene.rotation->loads.push_back(AttitudeSpring<double>{400, 0, Quaternion(1, 0, 0, 0)});
  const Grid grid = equal_grid(10, 1);
  const Trajectory plain = run(find_method("cvode-bdf"), scene, tolerance(1e-6), grid);
  const Trajectory watched = run(find_method("cvode-bdf-stability-limit"), scene, tolerance(1e-6), grid);
  ASSERT_EQ(watched.outcome, Outcome::ok) << watched.reason;
  const auto lost = [](const Trajectory& t) {
    return 1 - t.samples.back().total_energy / t.samples.front().total_energy;
  };
  EXPECT_GT(watched.work.steps, plain.work.steps);
  EXPECT_GT(lost(watched), 0);
  EXPECT_LT(lost(watched), 0.7 * lost(plain));
}

}  // namespace
}  // namespace polhode
