// Does the energy of a run grow? What stability questions ask of every step size.
#pragma once
#include "solvers/method.hpp"

namespace polhode {

struct EnergyGrowth {
  bool stable = false;  // the run ended, and its energy has no trend upwards
  Outcome outcome = Outcome::ok;
  double per_step;  // (E_end/E_start)^(1/steps) - 1; NaN where a run has no end
};

/// What is called growth: a relative gain per step below it is not, here and in linear theory. A thousand
/// steps show it plainly, above their rounding.
constexpr double growth_resolution = 1e-7;

/// Runs `steps` steps of size h (rounded up to a multiple of 64), and eight times as many where that leaves
/// open whether the energy grows or swings: a method that keeps it on average may swing far and is stable.
///
/// The energy is the total one, relative to the start, on the scale of kinetic and potential energy there.
/// The loads must not do work: dissipative or conservative ones only.
EnergyGrowth energy_growth(const Integration& run, double h, std::int64_t steps);

/// Does no load of the scene do work on the body?
bool loses_or_keeps_energy(const Scene& scene);

}  // namespace polhode
