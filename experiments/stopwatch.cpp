// Interleaved timing with the thread's CPU clock.
#include "experiments/stopwatch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "experiments/interrupt.hpp"
#include "solvers/thread_time.hpp"

namespace polhode {

double median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

std::vector<Timing> time_interleaved(std::span<const std::function<void()>> candidates,
                                     const TimingPlan& plan,
                                     const std::function<void(std::size_t, std::size_t)>& told) {
  // A word every sixteen measurements: seldom enough to be no disturbance.
  const std::size_t all_of_them = candidates.size() * static_cast<std::size_t>(plan.repeats + 1);
  std::size_t done = 0;
  const auto tell = [&] {
    if (told && done++ % 16 == 0) told(done - 1, all_of_them);
  };
  struct Measured {
    int batch = 1;
    double spent = 0;
    std::vector<double> times;
  };
  std::vector<Measured> all(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {  // warm up, and find the batch size
    tell();
    candidates[i]();
    const double began = thread_seconds();
    candidates[i]();
    const double one = std::max(thread_seconds() - began, 1e-9);
    all[i].batch = static_cast<int>(std::clamp(std::ceil(plan.shortest_measurement / one), 1.0, 1e5));
  }
  for (int round = 0; round < plan.repeats && !interrupted(); ++round)
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      Measured& m = all[i];
      tell();
      if (round >= 3 && m.spent > plan.budget) continue;
      const double began = thread_seconds();
      for (int k = 0; k < m.batch; ++k) candidates[i]();
      const double took = thread_seconds() - began;
      m.spent += took;
      m.times.push_back(took / m.batch);
    }
  std::vector<Timing> result;
  for (const Measured& m : all) {
    Timing t;
    t.repeats = static_cast<int>(m.times.size());
    t.median = median(m.times);
    t.min = m.times.empty() ? t.median : *std::min_element(m.times.begin(), m.times.end());
    std::vector<double> deviations;
    for (const double x : m.times) deviations.push_back(std::abs(x - t.median));
    t.mad = median(std::move(deviations));
    result.push_back(t);
  }
  return result;
}

}  // namespace polhode
