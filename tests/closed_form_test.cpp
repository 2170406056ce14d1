// Two truths beside each other: the closed form of a scene and its Taylor series, neither of which knows the
// other; and the closed form in doubles as a solver.
#include "models/closed_form.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "experiments/truth.hpp"
#include "models/lagrange_top.hpp"
#include "solvers/registry.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using WideVec = Vec3T<Wide>;

Scene turning(const Vec3& moments, const Quaternion& q0, const Vec3& w0,
              std::vector<AnyTorque<double>> loads) {
  static int count = 0;
  Scene s;
  s.id = "case-" + std::to_string(count++);
  s.duration = 5;
  s.rotation.emplace();
  s.rotation->moments = moments;
  s.rotation->q0 = q0;
  s.rotation->w0 = w0;
  s.rotation->loads = std::move(loads);
  return s;
}

Scene particle(double drag, const Vec3& acceleration) {
  static int count = 0;
  Scene s;
  s.id = "particle-" + std::to_string(count++);  // truths are kept by id
  s.duration = 5;
  s.translation.emplace();
  s.translation->mass = 2;
  s.translation->p0 = Vec3(1, -2, 3);
  s.translation->v0 = Vec3(4, 0.5, -1);
  s.translation->acceleration = acceleration;
  s.translation->drag = drag;
  s.translation->has_force = drag > 0 || !acceleration.isZero();
  return s;
}

struct Case {
  const char* name;
  Scene scene;
};

std::vector<Case> scenes_with_torque() {
  const Vec3 moments(1, 1.5, 2);
  const auto drag = [](double a, double b, double c) {
    return AngularDrag<double>{Vec3(a, b, c).asDiagonal()};
  };
  using BodyTorque = ConstantTorque<double, Frame::body>;
  const auto flat = [](double w, double z) { return Quaternion(w, 0, 0, z); };
  return {
      {"proportional drag", turning(moments, {0.5, 0.1, -0.7, 0.2}, {2, 1, -3}, {drag(0.25, 0.375, 0.5)})},
      {"sphere with drag", turning({2, 2, 2}, {1, 0, 0, 0}, {2, 1, -3}, {drag(0.5, 0.5, 0.5)})},
      {"drag about an axis", turning(moments, {0.5, 0.1, -0.7, 0.2}, {0, -3, 0}, {drag(0.3, 0.7, 0.1)})},
      {"torque about an axis", turning(moments, {0.5, 0.1, -0.7, 0.2}, {0, 0, 0}, {BodyTorque{{0, 0, 1.5}}})},
      {"torque and drag",
       turning(moments, {1, 0, 0, 0}, {4, 0, 0}, {BodyTorque{{-1.5, 0, 0}}, drag(0.3, 0.7, 0.1)})},
      {"torque and next to no drag",
       turning(moments, {1, 0, 0, 0}, {4, 0, 0}, {BodyTorque{{-1.5, 0, 0}}, drag(1e-9, 0, 0)})},
      {"spring", turning(moments, {0.8, 0, 0.6, 0}, {0, 0.25, 0}, {AttitudeSpring<double>{3, 0}})},
      {"spring, the other sign of q",
       turning(moments, {-0.8, 0, 0, 0.6}, {0, 0, 1.25}, {AttitudeSpring<double>{3, 0}})},
      {"spring from rest", turning(moments, {0.6, 0.8, 0, 0}, {0, 0, 0}, {AttitudeSpring<double>{3, 0}})},
      {"libration",
       turning(moments, flat(0.96, 0.28), {0, 0, 0.5}, {GravityGradient<double>{0.75, moments}})},
      {"libration across",
       turning({1.5, 1, 2}, flat(0.6, 0.8), {0, 0, 1}, {GravityGradient<double>{0.75, {1.5, 1, 2}}})},
      {"rotation over the vertical",
       turning(moments, flat(0.96, -0.28), {0, 0, 4}, {GravityGradient<double>{0.75, moments}})},
      {"backwards over the vertical",
       turning({1.5, 1, 2}, flat(0.28, -0.96), {0, 0, -3}, {GravityGradient<double>{0.75, {1.5, 1, 2}}})},
      {"particle", particle(0, Vec3::Zero())},
      {"particle, weight", particle(0, {0, 0, -9.81})},
      {"particle, weight and drag", particle(0.7, {0.1, 0, -9.81})},
      {"particle, next to no drag", particle(1e-12, {0.1, 0, -9.81})},
  };
}

std::vector<Case> built_in_scenes() {
  std::vector<Case> cases;
  for (const std::string& id : builtin_scene_ids())
    if (Scene s = find_scene(id); !closed_form_kind(s).empty()) cases.push_back({"built-in", std::move(s)});
  return cases;
}

double length(const WideVec& v) { return v.norm().convert_to<double>(); }

/// Both truths state how certain they are. 1e-36: what the series adds over some hundred steps beyond that.
void expect_equal_truths(const Case& c) {
  const auto times = uniform_times(c.scene.duration, 7);
  const Truth closed = reference_solution(c.scene, times), series = series_solution(c.scene, times);
  EXPECT_TRUE(closed.kind.starts_with("closed form")) << c.name;
  const double certain =
      10 * (closed.attitude_uncertainty + series.attitude_uncertainty + series.rate_uncertainty) + 1e-36;
  EXPECT_LT(certain, 1e-28) << c.name << ' ' << c.scene.id;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const WideSample &a = closed.samples[i], &b = series.samples[i];
    if (c.scene.rotation && c.scene.rotation->attitude) {
      EXPECT_LT(attitude_error<Wide>(a.q, b.q).convert_to<double>(), certain) << c.name << ' ' << c.scene.id;
    }
    if (c.scene.rotation) {
      const double fastest = std::max(1e-3, c.scene.rotation->w0.norm());
      EXPECT_LT(length(a.w_B - b.w_B), certain * fastest) << c.name << ' ' << c.scene.id;
      EXPECT_LT(length(a.L - b.L), certain * fastest * c.scene.rotation->moments.maxCoeff()) << c.name;
    }
    EXPECT_LT(length(a.p - b.p), certain * (1 + length(b.p))) << c.name;
    EXPECT_LT(length(a.v - b.v), certain * (1 + length(b.v))) << c.name;
  }
}

TEST(ClosedForm, AgreesWithTheSeriesOnEveryBuiltInSceneThatHasOne) {
  const auto cases = built_in_scenes();
  EXPECT_GE(cases.size(), 9u);
  for (const Case& c : cases) expect_equal_truths(c);
}

TEST(ClosedForm, AgreesWithTheSeriesUnderTorque) {
  for (const Case& c : scenes_with_torque()) expect_equal_truths(c);
}

TEST(StiffTruth, ImplicitAndExplicitAgreeWhereBothCanGo) {
  const Vec3 moments(1, 1.5, 2);
  for (const double c : {1.0, 300.0}) {
    for (const auto& load : std::vector<AnyTorque<double>>{
             AngularDrag<double>{Vec3(c, 0.3, 0.1).asDiagonal()}, AttitudeSpring<double>{3 * c, c}}) {
      Scene s = turning(moments, {0.9, 0.1, -0.3, 0.2}, {1, 2, -3}, {load});
      s.duration = 2;
      const auto times = uniform_times(s.duration, 7);
      const Truth implicit = implicit_solution(s, times), series = series_solution(s, times);
      const double certain = 10 * (implicit.attitude_uncertainty + implicit.rate_uncertainty) + 1e-36;
      EXPECT_LT(certain, 1e-27)
          << c;  // 28 digits are asked of the truth; the uncertainty is that of the coarse run
      for (std::size_t i = 0; i < times.size(); ++i) {
        const WideSample &a = implicit.samples[i], &b = series.samples[i];
        EXPECT_LT(attitude_error<Wide>(a.q, b.q).convert_to<double>(), 1e-32) << c;
        EXPECT_LT(length(a.w_B - b.w_B), 1e-32 * length(b.w_B) + 1e-60) << c;
      }
    }
  }
}

TEST(StiffTruth, FollowsRatesUpToTheHundredMillion) {
  // Drag and torque about one axis have a closed form: w -> torque/drag within 1e-8 s, and stays.
  for (const double c : sanitized ? std::vector{1e8} : std::vector{1e4, 1e6, 1e8}) {
    Scene s = turning({1, 1.5, 2}, {0.5, 0.1, -0.7, 0.2}, {2, 0, 0},
                      {AngularDrag<double>{Vec3(c, 0.3, 0.1).asDiagonal()},
                       ConstantTorque<double, Frame::body>{Vec3(3 * c, 0, 0)}});
    const std::vector<double> times{0.1 / c, 1 / c, 10 / c, 1, 5};
    EXPECT_TRUE(is_stiff(s, times));
    const Truth implicit = implicit_solution(s, times), closed = reference_solution(s, times);
    EXPECT_LT(implicit.cost_s, 30);
    for (std::size_t i = 0; i < times.size(); ++i) {
      const WideSample &a = implicit.samples[i], &b = closed.samples[i];
      EXPECT_LT(attitude_error<Wide>(a.q, b.q).convert_to<double>(), 1e-29) << c << ' ' << times[i];
      EXPECT_LT(length(a.w_B - b.w_B), 1e-29) << c << ' ' << times[i];
    }
    // With the other rates there is none, and the truth is the implicit one.
    s.rotation->w0 = Vec3(2, 1, -1);
    s.id += "-tumbling";
    const auto truth = truth_of(s, times);
    EXPECT_TRUE(truth->truth.kind.starts_with("Radau IIA")) << truth->truth.kind;
    EXPECT_LT(truth->truth.attitude_uncertainty, 1e-27);
    EXPECT_TRUE(truth->floor().conditioning > 0.5 && truth->floor().conditioning < 100)
        << truth->floor().conditioning;
  }
}

TEST(ClosedForm, InDoublesIsASolverOfItsScenes) {
  // Rounding of set-up and result, some dozen operations each, grown by the conditioning (of rates relative
  // to themselves: from rest there is none, and the torque takes their place).
  std::vector<Case> cases = scenes_with_torque();
  for (Case& c : built_in_scenes()) cases.push_back(std::move(c));
  for (const Case& c : cases) {
    const auto times = uniform_times(c.scene.duration, 7);
    const auto truth = truth_of(c.scene, times);
    const double bound = 16 * 2.2e-16 * std::max(10.0, truth->floor().conditioning);
    for (const char* id : {"exact", "exact-extended"}) {
      const Trajectory run = run_once(find_method(id), c.scene, {.knob = Knob::none}, grid_of_times(times));
      ASSERT_EQ(run.outcome, Outcome::ok) << c.name << ": " << run.reason;
      const Errors e = errors_of(c.scene, *truth, run.samples, 1, find_method(id).epsilon);
      // What a scene lacks is not a number.
      EXPECT_FALSE(e.attitude_max >= bound)
          << id << ", " << c.name << ' ' << c.scene.id << ": " << e.attitude_max;
      EXPECT_FALSE(e.rate_max >= bound) << id << ", " << c.name << ' ' << c.scene.id << ": " << e.rate_max;
      EXPECT_FALSE(e.position_max >= 1e-12) << id << ", " << c.name << ' ' << c.scene.id;
      EXPECT_EQ(run.work.steps, 7);
    }
  }
}

TEST(ClosedForm, IsNotClaimedWhereThereIsNone) {
  const Vec3 moments(1, 1.5, 2);
  const auto none = [](const Scene& s) {
    EXPECT_EQ(closed_form_kind(s), "");
    EXPECT_EQ(closed_form<double>(s), nullptr);
    const auto run = find_method("exact").prepare(s, {});
    EXPECT_FALSE(run.integrate);
    EXPECT_FALSE(run.unsupported.empty());
    EXPECT_TRUE(reference_solution(s, std::vector<double>{0.1}).kind.starts_with("Taylor"));
  };
  // Drag that is not proportional to inertia, by one unit in the last place.
  none(turning(moments, {1, 0, 0, 0}, {1, 2, 3},
               {AngularDrag<double>{Vec3(0.25, 0.375, std::nextafter(0.5, 1)).asDiagonal()}}));
  // A spring with damping, out of plane, turned beyond half a turn.
  none(turning(moments, {0.8, 0.6, 0, 0}, {1, 0, 0}, {AttitudeSpring<double>{3, 0.1}}));
  none(turning(moments, {0.8, 0.6, 0, 0}, {0, 1, 0}, {AttitudeSpring<double>{3, 0}}));
  none(turning(moments, {0.8, 0.6, 0, 0}, {9, 0, 0}, {AttitudeSpring<double>{3, 0}}));
  none(turning(moments, {1, 0.1, 0, 0}, {0, 0, 1}, {GravityGradient<double>{0.75, moments}}));
  none(find_scene("heavy-top"));
}

TEST(LagrangeTop, NutatesByEllipticFunctions) {
  Scene scene = find_scene("lagrange-top");
  const RotationData& r = *scene.rotation;
  const auto& load = std::get<GravityAboutPivot<double>>(r.loads.front());
  int axis = 0;
  load.center_B.cwiseAbs().maxCoeff(&axis);
  for (const bool other : {false, true}) {
    if (other) {  // a lively one: from rest on its side but for a slow spin
      scene.id += "-lively";
      scene.rotation->w0 = Vec3::Constant(0.25);
      scene.rotation->w0[axis] = 12;
      scene.rotation->q0 = Quaternion(0.8, 0.36, 0.48, 0.1);
      scene.duration = 2;
    }
    const auto nutation = LagrangeNutation<Wide>::of(scene);
    ASSERT_TRUE(nutation);
    const auto times = uniform_times(scene.duration, 11);
    const Truth truth = series_solution(scene, times);
    const WideVec up = -load.acceleration_S.cast<Wide>() / load.acceleration_S.cast<Wide>().norm();
    WideVec n(Wide(0), Wide(0), Wide(0));
    n[axis] = load.center_B[axis] < 0 ? -1 : 1;
    Wide least(1), most(-1);
    for (const WideSample& s : truth.samples) {
      const Wide u = up.dot(to_space<Wide>(s.q, n));
      EXPECT_LT(abs(Wide(u - nutation->cosine(s.t))).convert_to<double>(),
                10 * truth.attitude_uncertainty + 1e-33);
      least = std::min(least, u);
      most = std::max(most, u);
    }
    EXPECT_GT(most - least, 1e-3);  // or nothing was shown
    EXPECT_LT(
        abs(Wide(nutation->cosine(nutation->period()) - nutation->cosine(Wide(0)))).convert_to<double>(),
        1e-40);
  }
  EXPECT_FALSE(LagrangeNutation<Wide>::of(turning(
      {1, 1.5, 2}, {1, 0, 0, 0}, {1, 2, 3}, {GravityAboutPivot<double>{1, {0, 0, -9.81}, {0, 0, 0.5}}})));
  EXPECT_FALSE(LagrangeNutation<Wide>::of(find_scene("hairer-vilmart")));
}

}  // namespace
}  // namespace polhode
