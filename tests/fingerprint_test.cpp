// One-step methods against exact results of 1, 2 and 10 of their steps: a wrong sign, a stage at the wrong
// time or a frame mixed up shows in the first digits, where an order of convergence would still come out
// right.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "solvers/registry.hpp"
#include "tests/reference_cases.hpp"

namespace polhode {
namespace {

using namespace reference_cases;

struct Pair {
  const char *ours, *theirs;
};

class Fingerprint : public testing::TestWithParam<Pair> {};

// Exact results have 30 digits; ten steps of a few hundred operations on numbers of order one, each rounded
// to 1.1e-16 of itself in no preferred direction, come to some 3e-15.
constexpr double tolerance = 1e-14;

void expect_close(const Vec3& got, const Vec3& want, const std::string& what) {
  EXPECT_LT((got - want).lpNorm<Eigen::Infinity>(), tolerance * want.lpNorm<Eigen::Infinity>()) << what;
}

TEST_P(Fingerprint, OneTwoAndTenSteps) {
  const Json set = read_json("fingerprints_P");
  int compared = 0;
  for (const Json& problem : set.at("problems")) {
    const Json& inputs = problem.at("inputs");
    const double h = number(inputs.at("h"));
    const Scene scene = scene_of(inputs, problem.at("id"), 10 * h);
    const Prepared prepared = find_method(GetParam().ours).prepare(scene, {});
    ASSERT_TRUE(prepared.integrate) << prepared.unsupported;
    for (const auto& [count, want] : problem.at("results").at(GetParam().theirs).at("steps").items()) {
      const std::string what = problem.at("id").get<std::string>() + ", " + count + " steps";
      const std::int64_t steps = std::stoll(count);
      Grid grid;
      grid.stretches.push_back({static_cast<double>(steps) * h, steps, h});
      Trajectory run;
      prepared.integrate(grid, run);
      ASSERT_EQ(run.outcome, Outcome::ok) << what << run.reason;
      ASSERT_EQ(run.samples.size(), 1u);
      EXPECT_EQ(run.work.steps, steps);
      const Sample& s = run.samples.front();
      expect_close(s.w_B, vector(want.at("omega_body")), what + ", w_B");
      expect_close(s.L, vector(want.at("L_world")), what + ", L");
      const double energy = number(want.at("E_rot"));
      EXPECT_NEAR(s.rotational_energy, energy, tolerance * energy) << what;
      if (want.contains("q")) {
        const Quaternion q = quaternion(want.at("q"));
        EXPECT_LT((s.q.coeffs() - q.coeffs()).lpNorm<Eigen::Infinity>(),
                  tolerance * q.coeffs().lpNorm<Eigen::Infinity>())
            << what;
        EXPECT_NEAR(s.unit_defect, std::abs(q.norm() - 1), tolerance) << what;
        expect_close(to_space<double>(s.q, s.w_B), vector(want.at("omega_world")), what + ", w_S");
      } else {
        // Of a matrix a sample keeps the nearest rotation, and how far it is from one.
        const Mat3 R = matrix(want.at("R"));
        EXPECT_LT(attitude_error(quaternion_of(nearest_rotation(R)), s.q), tolerance) << what;
        EXPECT_NEAR(s.unit_defect, (R.transpose() * R - Mat3::Identity()).norm(), tolerance) << what;
      }
      ++compared;
    }
  }
  EXPECT_EQ(compared, 6);
}

// Bullet's own step is compared in bullet_test.cpp.
INSTANTIATE_TEST_SUITE_P(
    All, Fingerprint,
    testing::Values(Pair{"euler-matrix", "explicit_euler_seed_a"},
                    Pair{"euler-matrix-turned-inverse", "explicit_euler_seed_b"},
                    Pair{"euler-matrix-orthonormalised", "explicit_euler_seed_c_gram_schmidt"},
                    Pair{"euler-space-renormalised", "explicit_euler_quat_world"},
                    Pair{"rk4-space-renormalised", "rk4_q_wworld_normalised"}, Pair{"rk4", "rk4_q_wbody_raw"},
                    Pair{"rk4-renormalised", "rk4_q_wbody_normalised"},
                    Pair{"rk4-matrix", "rk4_R_wworld_raw"},
                    Pair{"semi-implicit-euler", "lie_euler_semi_implicit"},
                    Pair{"lie-euler", "lie_euler_explicit"}, Pair{"lie-euler-momentum", "lie_euler_momentum"},
                    Pair{"implicit-midpoint", "implicit_midpoint_q_wbody"},
                    Pair{"lie-midpoint", "lie_midpoint_exp"}, Pair{"akw-midpoint", "akw_midpoint_cay"},
                    Pair{"no-squish", "strang_32123"}, Pair{"splitting-12321", "strang_12321"},
                    Pair{"splitting-13231", "strang_13231"}, Pair{"splitting-21312", "strang_21312"},
                    Pair{"splitting-23132", "strang_23132"}, Pair{"splitting-31213", "strang_31213"},
                    // RATTLE takes the steps of the discrete Moser-Veselov equation.
                    Pair{"rattle", "dmv2"}, Pair{"dmv2", "dmv2"}, Pair{"dmv4", "dmv4"}),
    [](const testing::TestParamInfo<Pair>& row) {
      std::string name(row.param.ours);
      std::replace(name.begin(), name.end(), '-', '_');
      return name;
    });

}  // namespace
}  // namespace polhode
