// The one loop around every solver of our own hand or Odeint's that chooses its steps: limits, counters,
// samples. It asks the solver for three things: to go on until just before an asked time, to take the step
// that reaches or passes it, and for the state inside that step.
#pragma once
#include <memory>

#include "solvers/record.hpp"

namespace polhode {

/// Where a run is, and what it took.
struct Progress {
  double t = 0, h = 0;  // s; h: the next trial
  std::int64_t accepted = 0, attempts = 0, rhs_evals = 0, jacobian_evals = 0;
  int rejected_in_a_row = 0;
  bool stuck = false;  // no step size was acceptable, down to one that does not move the time

  /// To be told of each trial. False: give up.
  bool tell(double t_before, double h_tried, bool good) {
    ++attempts;
    if (good) {
      ++accepted;
      rejected_in_a_row = 0;
      return true;
    }
    // A controller may grow a step after an error that is not a number, or shrink it for ever.
    stuck = ++rejected_in_a_row == 500 || !(t_before + h_tried > t_before);
    return !stuck;
  }
};

/// A run in steps of its own choice, its stepper and model no longer seen.
class AdaptiveSteps {
 public:
  virtual ~AdaptiveSteps() = default;
  /// Back to t = 0. Sets the first trial step (at most t_end) and counts what it cost.
  virtual void restart(double t_end, Progress& p) = 0;
  /// Trial steps while p.t + p.h < t_stop, p.attempts < limit and it is not stuck.
  virtual void cruise(double t_stop, std::int64_t limit, Progress& p) = 0;
  /// One trial step, before which the state is remembered. True if it was accepted.
  virtual bool attempt(Progress& p) = 0;
  /// The state at the end of the last step.
  virtual Sample sample(double t) const = 0;
  /// The state at a time within the last step, that of `attempt`, which began at t_start; false if it cannot
  /// be had.
  virtual bool sample_within(double t_start, double t, Sample& out) = 0;
  virtual bool is_finite() const = 0;
};

/// The run that takes these steps, which stand at the start.
Prepared run_adaptive_steps(std::shared_ptr<AdaptiveSteps> steps, const Setting& setting);

/// First trial step [s]: 0.01 |y|/|y'| in the norm of the tolerances, the first guess of Hairer, Norsett &
/// Wanner, Solving ODEs I (1993), II.4. Zero where the state or its rate is zero and the quotient says
/// nothing. A poor guess costs a rejected step or two, no accuracy.
double first_step(std::span<const double> y, std::span<const double> d, const Setting& setting);

}  // namespace polhode
