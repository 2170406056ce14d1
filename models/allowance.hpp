// How long a computation may take, and whether somebody has asked it to stop.
//
// Long loops call spend() once a step. Both endings are exceptions, because they leave through every level of
// a computation; whoever asked turns them into a value: a truth with its refusal, a row `no_truth`.
#pragma once
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>

#include <time.h>

namespace polhode {

/// The allowance is spent: the reason, in words.
struct Refused : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// Somebody asked to stop (Ctrl-C, SIGTERM).
struct Stopped : std::runtime_error {
  Stopped() : std::runtime_error("interrupted") {}
};

/// CPU time of this thread and a question whether to stop. Cheap to copy; belongs to one thread.
class Allowance {
 public:
  /// No limit.
  Allowance() = default;
  /// seconds   CPU time of the calling thread, from now on
  /// stop      asked at each step; true ends the computation. May be empty.
  Allowance(double seconds, std::function<bool()> stop)
      : seconds_(seconds), end_(now() + seconds), stop_(std::move(stop)) {}

  /// Throws Refused where the time is over, Stopped where somebody asked to stop. A hundred nanoseconds.
  void spend() const {
    if (stop_ && stop_()) throw Stopped();
    if (end_ < std::numeric_limits<double>::infinity() && now() > end_)
      throw Refused("it takes more than " + text() + " s of computing");
  }
  /// The seconds that were allowed.
  double seconds() const { return seconds_; }

 private:
  static double now() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  std::string text() const {
    std::string s = std::to_string(seconds_);
    while (s.ends_with('0')) s.pop_back();
    if (s.ends_with('.')) s.pop_back();
    return s;
  }

  double seconds_ = std::numeric_limits<double>::infinity(), end_ = seconds_;
  std::function<bool()> stop_;
};

}  // namespace polhode
