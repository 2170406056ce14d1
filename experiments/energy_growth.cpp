// Trends of the energy.
#include "experiments/energy_growth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace polhode {
namespace {

// The energy is looked at after each of the first steps, then 64 times more: a growth that ends by itself (of
// a matrix that it inflates, say) may be over in a few dozen steps.
constexpr int first_looks = 64, looks = 64;

struct Halves {
  Outcome outcome = Outcome::ok;
  double first = 1, second = 0;  // largest energy in either half over that at the start
  double end = std::numeric_limits<double>::quiet_NaN();
  double steps = 0;
};

Halves halves(const Integration& run, double h, std::int64_t steps) {
  const std::int64_t stretch = (steps + looks - 1) / looks;
  Grid grid;
  grid.from_start = true;
  std::int64_t at = 0;
  const auto look_after = [&](std::int64_t n) {
    at += n;
    grid.stretches.push_back({h * static_cast<double>(at), n, h});
  };
  for (int k = 0; k < first_looks; ++k) look_after(1);
  while (at < stretch * looks) look_after(std::min(stretch, stretch * looks - at));
  Trajectory out;
  run(grid, out);
  Halves result;
  result.outcome = out.outcome;
  result.steps = static_cast<double>(at);
  if (out.samples.empty()) return result;
  const Sample& start = out.samples.front();
  const double scale = start.rotational_energy + std::abs(start.total_energy - start.rotational_energy);
  for (std::size_t k = 0; k < out.samples.size() && scale > 0; ++k) {
    const double e = 1 + (out.samples[k].total_energy - start.total_energy) / scale;
    if (!std::isfinite(e)) result.outcome = Outcome::not_finite;
    double& largest = out.samples[k].t <= 0.5 * grid.end() ? result.first : result.second;
    largest = std::max(largest, e);
    result.end = e;
  }
  return result;
}

/// Beyond this the run has left the motion, whether it grows on or not.
constexpr double lost = 100;

bool grows(const Halves& r, double resolution) {
  return r.second > r.first * (1 + 0.5 * r.steps * resolution) || r.second > lost || r.first > lost;
}

}  // namespace

EnergyGrowth energy_growth(const Integration& run, double h, std::int64_t steps) {
  Halves r = halves(run, h, steps);
  EnergyGrowth g;
  g.stable = r.outcome == Outcome::ok && !grows(r, growth_resolution);
  // A trend goes on at its rate; the crest of a slow swing does not.
  const double rate = std::log(r.second / r.first) / (0.5 * r.steps);
  for (int k = 0; k < 2 && r.outcome == Outcome::ok && !g.stable && r.second < 2 * r.first; ++k) {
    steps *= 4;
    r = halves(run, h, steps);
    g.stable = r.outcome == Outcome::ok && !grows(r, std::max(growth_resolution, 0.25 * rate));
  }
  g.outcome = r.outcome;
  g.per_step = r.outcome == Outcome::ok && r.end > 0 ? std::expm1(std::log(r.end) / r.steps)
                                                     : std::numeric_limits<double>::quiet_NaN();
  return g;
}

bool loses_or_keeps_energy(const Scene& scene) {
  if (!scene.rotation) return false;
  return std::ranges::all_of(scene.rotation->loads, [](const AnyTorque<double>& load) {
    return std::holds_alternative<AngularDrag<double>>(load) ||
           std::holds_alternative<AttitudeSpring<double>>(load) ||
           std::holds_alternative<GravityAboutPivot<double>>(load);
  });
}

}  // namespace polhode
