// Timing: the thread's own CPU clock, warm, many repeats, minimum, median and spread beside each other.
#pragma once
#include <functional>
#include <span>
#include <vector>

namespace polhode {

struct Timing {
  double min = 0, median = 0, mad = 0;  // s per run; mad: median absolute deviation from the median
  int repeats = 0;                      // measurements, each of as many runs as fill `shortest_measurement`
};

/// How long to measure.
struct TimingPlan {
  int repeats = 7;
  double shortest_measurement = 100e-6;  // s: shorter runs are timed in batches of several
  double budget = 30e-3;                 // s per candidate, beyond the first three repeats
};

/// Times the candidates interleaved in rounds, so that a disturbance of the machine falls on all of them.
///
/// told  is called now and then with how many measurements are done, of how many
std::vector<Timing> time_interleaved(std::span<const std::function<void()>> candidates,
                                     const TimingPlan& plan,
                                     const std::function<void(std::size_t, std::size_t)>& told = {});

/// Median of values; NaN if there are none. Sorts its copy.
double median(std::vector<double> values);

}  // namespace polhode
