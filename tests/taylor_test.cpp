// Taylor series in double precision: the same numbers on every processor, the solution within the tolerance
// on every kind of load, samples that cost nothing, and rounding that does not pile up.
#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "experiments/grid.hpp"
#include "experiments/truth.hpp"
#include "solvers/registry.hpp"
#include "solvers/taylor_kernels.hpp"
#include "tests/reference_cases.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

Trajectory run(const Scene& scene, double rtol, std::span<const double> times) {
  Setting setting;
  setting.knob = Knob::tolerance;
  setting.rtol = rtol;
  const Prepared prepared = find_method("taylor").prepare(scene, setting);
  Trajectory out;
  prepared.integrate(grid_of_times(times), out);
  return out;
}

TEST(Taylor, EveryInstructionSetGivesTheSameBits) {
  const auto kernels = taylor_kernels();
  ASSERT_FALSE(kernels.empty());
  int scenes = 0;
  for (const std::string& id : builtin_scene_ids()) {
    const Scene scene = find_scene(id);
    const auto body = taylor_body(scene);
    if (!body) continue;
    ++scenes;
    std::vector<TaylorLine> ends;
    for (const TaylorKernel* kernel : kernels) {
      TaylorLine& line = ends.emplace_back();
      const Quaternion q = scene.rotation->q0.normalized();
      const double start[] = {q.w(), q.x(), q.y(), q.z()};
      std::copy(start, start + 4, line.q);
      std::copy(scene.rotation->w0.data(), scene.rotation->w0.data() + 3, line.w);
      line.h = 0.1 / scene.rotation->w0.norm();
      kernel->step(*body, line, scene.duration);
      kernel->cruise(*body, line, scene.duration, 200);
      kernel->step(*body, line, line.t + 0.01 * line.h);
    }
    for (const TaylorLine& line : ends) {
      EXPECT_EQ(std::memcmp(line.q, ends.front().q, sizeof line.q), 0) << id;
      EXPECT_EQ(std::memcmp(line.w, ends.front().w, sizeof line.w), 0) << id;
      EXPECT_EQ(std::memcmp(line.v, ends.front().v, sizeof line.v), 0) << id;
      EXPECT_EQ(line.t, ends.front().t) << id;
      EXPECT_GT(line.steps, 1) << id;
    }
  }
  EXPECT_GE(scenes, 12);
}

/// A step leaves a term below the tolerance, and the terms behind it, which fall faster than by halves; each
/// grows by the motion's conditioning until the end. On top of that, what rounding does: the project calls
/// nothing an error of a method that is below ten times the floor.
double bound(double growth, double floor, double rtol, std::int64_t steps) {
  return 2 * rtol * static_cast<double>(steps) * growth + 10 * floor;
}

TEST(Taylor, AskedTimesCostNoStepAndNoAccuracy) {
  std::vector<const char*> scenes{"heavy-top"};
  if (!sanitized) scenes.insert(scenes.end(), {"hairer-vilmart", "spinning-projectile", "euler-equations"});
  for (const char* id : scenes) {
    const Scene scene = find_scene(id);
    const double end[] = {scene.duration};
    const auto many = uniform_times(scene.duration, 500);
    const Trajectory once = run(scene, 1e-12, end), often = run(scene, 1e-12, many);
    EXPECT_EQ(once.work.steps, often.work.steps) << id;
    EXPECT_EQ(once.samples.back().w_B, often.samples.back().w_B) << id;
    EXPECT_EQ(once.samples.back().q.coeffs(), often.samples.back().q.coeffs()) << id;
    const auto truth = truth_of(scene, many);
    const Errors e = errors_of(scene, *truth, often.samples, 1, std::numeric_limits<double>::epsilon());
    EXPECT_LT(e.rate_max, bound(truth->floor().conditioning, truth->floor().rate, 1e-12, often.work.steps))
        << id;
  }
}

TEST(Taylor, KeepsTheRestOfEverySum) {
  // 2500 steps of 0.4 time units. Rounding the state at each of them by half a unit would make w and the
  // energy walk to sqrt(2500) times that, 5e-15 and more, and the phase, which sums w up, to 2500^(3/2) times
  // 0.4 |w| of it, some 1e-11. With the rest of every sum kept, a fifth of that is already too much.
  const Scene scene = find_scene("hairer-vilmart");
  const double end[] = {1000.0};
  const Trajectory got = run(scene, 1e-18, end);
  const auto truth = truth_of(scene, end);
  const Errors e = errors_of(scene, *truth, got.samples, 1, std::numeric_limits<double>::epsilon());
  EXPECT_LT(e.attitude_max, 1e-12);
  EXPECT_LT(e.energy_max, 1e-15);
}

// Every load, by the public cases.
class TaylorOnCase : public testing::TestWithParam<std::string> {};

TEST_P(TaylorOnCase, IsRightWithinTheTolerance) {
  using namespace reference_cases;
  const Json file = read_json(GetParam());
  const std::vector<double> times = numbers(file.at("times"));
  const Scene scene = scene_of(file.at("inputs"), GetParam(), times.back());
  const auto truth = truth_of(scene, times);
  for (const double rtol : {1e-6, 1e-10, 1e-14}) {
    const Trajectory got = run(scene, rtol, times);
    ASSERT_EQ(got.outcome, Outcome::ok) << got.reason;
    ASSERT_EQ(got.samples.size(), times.size());
    const Errors e = errors_of(scene, *truth, got.samples, 1, std::numeric_limits<double>::epsilon());
    const double growth = std::isfinite(truth->floor().conditioning) ? truth->floor().conditioning : 1;
    EXPECT_LT(e.attitude_max, bound(growth, truth->floor().attitude, rtol, got.work.steps)) << rtol;
    EXPECT_LT(e.rate_max, bound(growth, truth->floor().rate, rtol, got.work.steps)) << rtol;
  }
}

INSTANTIATE_TEST_SUITE_P(Public, TaylorOnCase, testing::ValuesIn(reference_cases::case_names()),
                         [](const testing::TestParamInfo<std::string>& info_of_case) {
                           std::string name = info_of_case.param;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace polhode
