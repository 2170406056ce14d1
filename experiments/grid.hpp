// Asked times and step placement, from options and the scene's duration.
#pragma once
#include <span>
#include <vector>

#include "experiments/options.hpp"
#include "models/scene.hpp"
#include "solvers/method.hpp"

namespace polhode {

/// T k/n for k = 1..n: the end is hit exactly.
std::vector<double> uniform_times(double duration, std::int64_t n);

/// n + 1 log-spaced integers from 1 to last, without repeats.
std::vector<std::int64_t> log_spaced(std::int64_t last, int n);

/// About `steps` equal steps over all, placed so that every time is hit exactly (at least one in each
/// stretch). Where the division is even, every step has the same size duration/steps.
Grid grid_of_steps(std::span<const double> times, std::int64_t steps);

/// Steps of size h. Throws UsageError if h does not divide every stretch between two times to rounding.
Grid grid_of_size(std::span<const double> times, double h);

/// For solvers that choose their own steps.
Grid grid_of_times(std::span<const double> times);

/// The times that the options ask for on this scene (without t = 0), and whether t = 0 is asked too. Throws
/// UsageError if they do not increase or leave the duration.
struct AskedTimes {
  bool from_start;
  std::vector<double> times;
};
AskedTimes asked_times(const Scene& scene, const Options& options);

}  // namespace polhode
