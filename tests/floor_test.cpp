// The rounding floor: what it may not do (fall, saturate, look away), and whether solvers agree with it.
#include "solvers/floor.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "solvers/registry.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

std::vector<double> divided(double duration, int parts) {
  std::vector<double> times;
  for (int i = 0; i <= parts; ++i) times.push_back(duration * i / parts);
  return times;
}

Floor floor_until(const Scene& scene, double duration) {
  return floor_of(scene, divided(duration, 16), Truth{}, Allowance{});
}

Scene body(const Vec3& moments, const Vec3& w0) {
  Scene scene;
  scene.rotation.emplace();
  scene.rotation->moments = moments;
  scene.rotation->w0 = w0;
  return scene;
}

// No body has these moments; the equations do not mind.
const Vec3 flat(3, 5, 9);

/// 1e-20 of the way from the middle axis to the separatrix.
Scene flipping() { return body(flat, Vec3(1e-10 / 3, 6.0 / 5, 0)); }

Scene spun_up(double across) {
  Scene scene = body(flat, Vec3(across, 1, 0));
  scene.rotation->loads.push_back(ConstantTorque<double, Frame::body>{Vec3(0, 2, 0)});
  return scene;
}

struct Best {
  double attitude = 1e300, rate = 1e300;
};

/// The least of the largest errors that a few good solvers make on the way, each at several settings.
Best best_errors(const Scene& scene, double duration) {
  struct Run {
    const char* method;
    double setting;
  };
  constexpr Run runs[] = {{"taylor", 1e-15},   {"taylor", 1e-16},   {"dop853", 1e-14}, {"dop853", 1e-15},
                          {"verner98", 1e-14}, {"verner98", 1e-15}, {"rk4", 3200},     {"rk4", 32000}};
  constexpr int parts = 16;
  const std::vector<double> times = divided(duration, parts);
  const Truth truth = reference_solution(scene, times);
  Best best;
  for (const Run& run : runs) {
    const Method& method = find_method(run.method);
    Setting setting;
    setting.knob = method.default_knob();
    setting.rtol = run.setting;
    Grid grid;
    grid.from_start = true;
    for (int i = 0; i < parts; ++i) {
      Grid::Stretch s{times[std::size_t(i + 1)]};
      if (setting.knob == Knob::steps) {
        s.steps = static_cast<std::int64_t>(run.setting) / parts;
        s.h = duration / parts / static_cast<double>(s.steps);
      }
      grid.stretches.push_back(s);
    }
    const Prepared prepared = method.prepare(scene, setting);
    if (!prepared.integrate) continue;
    Trajectory got;
    prepared.integrate(grid, got);
    if (got.outcome != Outcome::ok) continue;
    Best of_run{0, 0};
    Wide fastest(0);
    for (std::size_t i = 0; i < got.samples.size(); ++i) {
      const WideSample& s = truth.samples[i];
      fastest = std::max(fastest, Wide(s.w_B.norm()));
      const Wide scale = std::max(Wide(s.w_B.norm()), Wide(fastest / 1000));
      const Vec3T<Wide> gap = got.samples[i].w_B.cast<Wide>() - s.w_B;
      of_run.rate = std::max(of_run.rate, Wide(gap.norm() / scale).convert_to<double>());
      if (scene.rotation->attitude)
        of_run.attitude = std::max(
            of_run.attitude, attitude_error<Wide>(s.q, got.samples[i].q.cast<Wide>()).convert_to<double>());
    }
    best.attitude = std::min(best.attitude, of_run.attitude);
    best.rate = std::min(best.rate, of_run.rate);
  }
  return best;
}

TEST(Floor, NeverFallsWhereTheDurationGrows) {
  std::vector<Scene> scenes{flipping(), spun_up(1e-15)};
  for (Scene& s : scenes) s.duration = 20;
  for (const std::string& id : builtin_scene_ids()) scenes.push_back(find_scene(id));
  for (const Scene& scene : scenes) {
    if (!scene.rotation) continue;
    Floor before;
    for (double part = 0.01; part < 4; part *= sanitized ? 2.5 : 1.25) {
      const Floor f = floor_until(scene, part * scene.duration);
      EXPECT_GE(f.attitude, before.attitude) << scene.id << " at " << part;
      EXPECT_GE(f.rate, before.rate) << scene.id << " at " << part;
      before = f;
    }
  }
}

TEST(Floor, DoesNotDependOnTheAskedTimes) {
  const Scene scene = find_scene("t-handle");
  const Floor few = floor_of(scene, divided(20, 1), Truth{}, Allowance{});
  const Floor many = floor_of(scene, divided(20, 500), Truth{}, Allowance{});
  EXPECT_EQ(few.attitude, many.attitude);
  EXPECT_EQ(few.rate, many.rate);
  EXPECT_GT(many.attitude_growth, few.attitude_growth);  // that is of these times
}

TEST(Floor, IsHalfATurnOnceRoundingDecidesAFlip) {
  // The first flip comes after ln(2 * 1.2/3.3e-11)/0.65 = 38 s. What is rounded there, 1e-16, is ten thousand
  // times the distance to the separatrix, and has grown to one 1.5 flips later at the latest.
  EXPECT_LT(floor_until(flipping(), 30).attitude, 1e-9);
  for (const double duration : {117.0, 250.0, 1000.0}) {
    EXPECT_DOUBLE_EQ(floor_until(flipping(), duration).attitude, std::numbers::pi) << duration;
    EXPECT_DOUBLE_EQ(floor_until(flipping(), duration).rate, 2) << duration;
  }
}

TEST(Floor, GrowthHasNoBound) {
  // About the middle axis a disturbance grows by exp(0.54 times the angle); 100 s make 1e4 radians.
  const Floor unstable = floor_until(spun_up(0), 50);
  EXPECT_GT(unstable.conditioning, 1e100);
  EXPECT_LT(unstable.conditioning, 1e150);
  EXPECT_EQ(floor_until(spun_up(0), 1000).conditioning, 1e300);
  EXPECT_EQ(floor_until(body(flat, Vec3(0, 1, 0)), 1e6).conditioning, 1e300);
  // A component that is zero stays so and hides what it could do; one of 1e-15 turns the body over.
  EXPECT_LT(floor_until(spun_up(0), 50).attitude, 1e-12);
  EXPECT_DOUBLE_EQ(floor_until(spun_up(1e-15), 50).attitude, std::numbers::pi);
  EXPECT_DOUBLE_EQ(floor_until(spun_up(1e-15), 50).rate, 2);
}

TEST(Floor, RoundsEachComponentByItself) {
  // 1e-15 across the middle axis, rounded relative to |w|, would be lost at once. It is not: solvers keep
  // their digits over the first flip (53 s) until what was rounded there has grown.
  const Scene scene = body(flat, Vec3(1e-15, 1.2, 0));
  for (const double duration : {40.0, 60.0, 80.0}) {
    const Best best = best_errors(scene, duration);
    EXPECT_LT(best.attitude, 1e-9) << duration;
    EXPECT_LT(floor_until(scene, duration).attitude, 1e-8) << duration;
  }
}

// The floor is the root of a mean square over roundings at all marks and in all components. The best of eight
// runs is luckier than that, and high order takes fewer steps than there are marks: the floor may lie tens of
// times above it (measured: 0.2 to 52 times; 52 where one rounding, at the flip, decides alone). Where each
// of many steps rounds, errors add up as a walk, the root of their number: a few times above the floor.
TEST(Floor, IsWhatSolversReach) {
  struct Case {
    Scene scene;
    double duration;
  };
  std::vector<Case> cases;
  for (const char* id : {"hairer-vilmart", "t-handle", "tumbling-box", "particle-cloud", "symmetric-top",
                         "thin-rod", "sphere", "euler-equations", "angular-drag", "body-torque",
                         "space-torque", "gravity-gradient-satellite", "lagrange-top", "attitude-spring"}) {
    const Scene scene = find_scene(id);
    cases.push_back({scene, scene.duration});
  }
  cases.push_back({find_scene("tumbling-box"), 100});
  cases.push_back({find_scene("hairer-vilmart"), 100});
  cases.push_back({flipping(), 90});
  cases.push_back({body(flat, Vec3(1e-15, 1.2, 0)), 100});
  cases.push_back({spun_up(1e-15), 25});
  if (sanitized) cases.resize(2);
  for (const auto& [scene, duration] : cases) {
    const Floor floor = floor_until(scene, duration);
    const Best best = best_errors(scene, duration);
    // What a double resolves is no matter of growth.
    const double least = std::numeric_limits<double>::epsilon();
    if (scene.rotation->attitude) {
      EXPECT_GT(best.attitude + least, floor.attitude / 100) << scene.id;
      EXPECT_LT(best.attitude, 10 * floor.attitude) << scene.id;
    }
    EXPECT_GT(best.rate + least, floor.rate / 100) << scene.id;
    EXPECT_LT(best.rate, 10 * floor.rate) << scene.id;
  }
}

TEST(Floor, FollowsAFreeBodyForMillionsOfRadians) {
  // What is disturbed is late by ever more, in proportion to the time: nothing but that may be left of a
  // million products.
  for (const char* id : {"hairer-vilmart", "tumbling-box", "symmetric-top", "sphere", "thin-rod"}) {
    const Scene scene = find_scene(id);
    const Floor near = floor_until(scene, 1e4), far = floor_until(scene, 1e6);
    EXPECT_NEAR(far.attitude / near.attitude, 100, 25) << id;
    EXPECT_TRUE(far.attitude_growth > 50 * near.attitude_growth) << id << ' ' << far.attitude_growth;
    EXPECT_TRUE(far.attitude_growth < 200 * near.attitude_growth) << id << ' ' << far.attitude_growth;
  }
  // Its rates return after 6e4 radians only. It turns as a sphere does.
  const Scene round = body(Vec3(1, 1.0001, 1.0002), Vec3(0.5, 0.6, 0.7));
  Floor before;
  for (const double duration : {1e3, 4e3, 5e3, 2e4, 1e5, 1e6}) {
    const Floor f = floor_until(round, duration);
    EXPECT_NEAR(f.attitude_growth / (duration * round.rotation->w0.norm()), 1, 0.6) << duration;
    EXPECT_GT(f.attitude, before.attitude) << duration;
    before = f;
  }
}

TEST(Floor, StepsOverFastDecays) {
  Scene scene = find_scene("angular-drag");
  std::get<AngularDrag<double>>(scene.rotation->loads.front()).coefficients_B(0, 0) = 3e4;  // 1e5/s
  const Floor f = floor_until(scene, 10);
  EXPECT_TRUE(f.attitude_growth > 10 && f.attitude_growth < 100) << f.attitude_growth;
  EXPECT_TRUE(f.attitude > 1e-15 && f.attitude < 1e-13) << f.attitude;
}

TEST(Floor, SaysWhatIsNotKnown) {
  // Three thousand seconds of a top at 150 rad/s.
  const Scene top = find_scene("heavy-top");
  const Floor f = floor_until(top, 3000);
  EXPECT_TRUE(std::isnan(f.conditioning) && std::isnan(f.attitude_growth) && std::isnan(f.rate_growth));
  EXPECT_GE(f.attitude, floor_until(top, 2).attitude);  // as far as it was followed
}

TEST(Floor, IncludesWhatTheStartHasLost) {
  // The truth of a file whose numbers are no doubles; here they are 1e-9 away.
  const Scene doubles = find_scene("hairer-vilmart");
  Scene file = doubles;
  file.rotation->w0.x() *= 1 + 1e-9;
  const std::vector<double> times = divided(10, 16);
  const Floor same = floor_of(doubles, times, reference_solution(doubles, times), Allowance{});
  EXPECT_EQ(same.attitude, floor_until(doubles, 10).attitude);
  const Floor other = floor_of(doubles, times, reference_solution(file, times), Allowance{});
  EXPECT_GT(other.attitude, 3 * 10 * 0.5e-9);  // 3 rad/s for 10 s
  EXPECT_LT(other.attitude, 3 * 10 * 2e-9);
  EXPECT_TRUE(other.rate > 1e-10 && other.rate < 1e-8) << other.rate;
  EXPECT_EQ(other.conditioning, same.conditioning);
}

TEST(Floor, StopsWhenAsked) {
  int marks = 0;
  const Allowance allowance(1e9, [&marks] { return ++marks > 10; });
  EXPECT_THROW(floor_of(find_scene("heavy-top"), divided(2, 4), Truth{}, allowance), Stopped);
  EXPECT_EQ(marks, 11);
}

}  // namespace
}  // namespace polhode
