// How rounding grows. Brouwer (Astron. J. 46 (1937), 149): where steps are so short that truncation is below
// rounding, and each step's rounding is independent of the others', what is kept (energy) walks at random,
// t^1/2, and a phase, whose speed hangs on the energy, is the sum of such a walk, t^3/2.
//
// One walk is no law: the root mean square over 32 starts is what grows so. Of 32 squares it is known to 1/8
// (each has relative variance 2), of neighbouring times to the same number; the slope over 2 decades thus to
// 0.06 and less.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "experiments/fit.hpp"
#include "experiments/question.hpp"
#include "models/errors.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

struct Growth {
  double energy = 0, attitude = 0;          // exponents of t
  double energy_end = 0, attitude_end = 0;  // root mean squares at the end
};

/// The free body of `hairer-vilmart` from `starts` attitudes of its momentum near the first, 100 steps a
/// second up to t = 10 * 2^9.
Growth growth_of(const char* solver, int starts) {
  Grid grid;
  double before = 0;
  for (int k = 0; k < 10; ++k) {
    const double t = 10 * std::ldexp(1.0, k);
    grid.stretches.push_back({t, std::llround((t - before) * 50), 0.02});
    before = t;
  }
  std::mt19937_64 random(1937);
  std::uniform_real_distribution<double> part(-0.2, 0.2);
  std::vector<double> energy(grid.stretches.size()), attitude(energy);
  Setting setting;
  setting.knob = Knob::steps;
  for (int i = 0; i < starts; ++i) {
    Scene scene = find_scene("hairer-vilmart");
    scene.rotation->w0 += Vec3(part(random), part(random), part(random));
    const Trajectory run = run_once(find_method(solver), scene, setting, grid),
                     truth = run_once(find_method("exact-extended"), scene, {}, grid);
    EXPECT_EQ(run.outcome, Outcome::ok);
    for (std::size_t k = 0; k < energy.size(); ++k) {
      const double e0 =
          0.5 * scene.rotation->w0.dot(scene.rotation->moments.cwiseProduct(scene.rotation->w0));
      energy[k] += std::pow(run.samples[k].rotational_energy / e0 - 1, 2) / starts;
      attitude[k] += std::pow(attitude_error(truth.samples[k].q, run.samples[k].q), 2) / starts;
    }
  }
  std::vector<double> t;
  for (const auto& stretch : grid.stretches) t.push_back(std::log(stretch.t_end));
  for (auto* squares : {&energy, &attitude})
    for (double& x : *squares) x = 0.5 * std::log(x);
  return {fit_line(t, energy).slope, fit_line(t, attitude).slope, std::exp(energy.back()),
          std::exp(attitude.back())};
}

TEST(Rounding, EnergyWalksAndAttitudeSumsTheWalk) {
  std::vector<const char*> solvers{"verner98"};
  if (!sanitized) solvers.insert(solvers.end(), {"dop853", "symmetric-split-kahan-li8"});
  for (const char* solver : solvers) {
    const Growth g = growth_of(solver, sanitized ? 8 : 32);
    EXPECT_NEAR(g.energy, 0.5, 0.12) << solver;
    EXPECT_NEAR(g.attitude, 1.5, 0.12) << solver;
  }
}

}  // namespace
}  // namespace polhode
