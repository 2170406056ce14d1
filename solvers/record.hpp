// The books of one run, kept the same way by every solver: samples, limits, and how it ended.
#pragma once
#include <chrono>
#include <string>

#include "solvers/method.hpp"

namespace polhode {

/// Fills a trajectory. Every function that can end the run returns true while it goes on, and has written
/// outcome and reason when it does not.
class Record {
 public:
  /// Empties `out` (its memory is kept) and starts the clock of the time-out.
  Record(const Setting& setting, const Grid& grid, Trajectory& out);

  /// The state at t = 0: what energies are compared with.
  void start(const Sample& sample);
  /// The state at an asked time. A sample with a number that is not finite, or of 1e12 times the energy that
  /// the body started with, ends the run.
  bool keep(const Sample& sample);
  /// To be asked now and then.
  bool in_time(double t);
  /// Ends the run; " at t = ... s" is added to the reason.
  bool end(Outcome outcome, std::string reason, double t);

 private:
  using clock = std::chrono::steady_clock;
  const Setting& setting_;
  bool from_start_, timed_;
  clock::time_point began_;
  double start_energy_ = 0;  // J
  Trajectory& out_;
};

/// Is every number of the state finite?
template <class State>
bool all_finite(const State& y) {
  double sum = 0;
  for (const double x : y) sum += x * 0;  // 0 for a finite x, NaN otherwise
  return sum == 0;
}

}  // namespace polhode
