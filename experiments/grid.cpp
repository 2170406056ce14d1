// Step placement. Steps are counted by integers; only the ends of stretches are rounded to a double.
#include "experiments/grid.hpp"

#include <cmath>

#include <fmt/format.h>

#include "models/errors.hpp"

namespace polhode {

std::vector<double> uniform_times(double duration, std::int64_t n) {
  std::vector<double> times;
  times.reserve(static_cast<std::size_t>(n));
  for (std::int64_t k = 1; k <= n; ++k)
    times.push_back(k == n ? duration : duration * static_cast<double>(k) / static_cast<double>(n));
  return times;
}

std::vector<std::int64_t> log_spaced(std::int64_t last, int n) {
  std::vector<std::int64_t> values;
  for (int i = 0; i <= n; ++i) {
    const auto v =
        static_cast<std::int64_t>(std::llround(std::pow(static_cast<double>(last), double(i) / n)));
    if (values.empty() || v > values.back()) values.push_back(v);
  }
  return values;
}

Grid grid_of_steps(std::span<const double> times, std::int64_t steps) {
  Grid grid;
  const double end = times.back();
  const double h = end / static_cast<double>(steps);
  double start = 0;
  for (const double t : times) {
    const double exact = static_cast<double>(steps) * ((t - start) / end);
    // Even: the stretch holds a whole number of steps of the common size, to a few ulp.
    const double whole = std::max(1.0, std::round(exact));
    const bool even = std::abs(exact - whole) <= 1e-9 * whole;
    grid.stretches.push_back({t, static_cast<std::int64_t>(whole), even ? h : (t - start) / whole});
    start = t;
  }
  return grid;
}

Grid grid_of_size(std::span<const double> times, double h) {
  Grid grid;
  double start = 0;
  for (const double t : times) {
    const double count = (t - start) / h, whole = std::round(count);
    // h and the times were each rounded once when read: their quotient is whole within a few ulp of itself,
    // and of t/h where two near times are subtracted.
    if (!(whole >= 1) || whole > 1e15 || std::abs(count - whole) > 1e-9 + 8 * 2.3e-16 * (t / h))
      throw UsageError(
          fmt::format("--h {}: the stretch from t = {} s to {} s holds {:.6g} steps; needs a whole number", h,
                      start, t, count));
    grid.stretches.push_back({t, static_cast<std::int64_t>(whole), h});
    start = t;
  }
  return grid;
}

Grid grid_of_times(std::span<const double> times) {
  Grid grid;
  for (const double t : times) grid.stretches.push_back({t, 0, 0});
  return grid;
}

AskedTimes asked_times(const Scene& scene, const Options& options) {
  if (options.times.empty()) return {true, uniform_times(scene.duration, options.samples.value_or(1))};
  AskedTimes asked{options.times.front() == 0, {}};
  double before = -1;
  for (const double t : options.times) {
    if (t < 0 || t > scene.duration)
      throw UsageError(
          fmt::format("--times: {} is outside [0, {}] s, the duration of '{}'", t, scene.duration, scene.id));
    if (t <= before) throw UsageError(fmt::format("--times must increase: {} after {}", t, before));
    before = t;
    if (t > 0) asked.times.push_back(t);
  }
  return asked;
}

}  // namespace polhode
