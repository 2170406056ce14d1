// A model's right-hand side and Jacobian as SUNDIALS calls them, under watch: calls are counted, the clock is
// looked at, numbers that are not finite are caught; and how a run that failed ended, in words.
#pragma once
#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>

#include "solvers/erased_model.hpp"
#include "solvers/record.hpp"
#include "solvers/sundials.hpp"

namespace polhode::sundials {

class Watch {
 public:
  explicit Watch(std::unique_ptr<ErasedModel> model)
      : model_(std::move(model)), size_(model_->initial().size()) {}
  Watch(const Watch&) = delete;  // the library holds its address
  Watch& operator=(const Watch&) = delete;

  const ErasedModel& model() const { return *model_; }
  /// Of a run that begins.
  void begin(Record& record) {
    record_ = &record;
    calls_ = jacobians_ = 0;
    not_finite_ = timed_out_ = false;
  }
  std::int64_t calls() const { return calls_; }  // of the right-hand side
  std::int64_t jacobians() const { return jacobians_; }
  /// What was called since then, to look at a run, does not count.
  void forget_calls_since(std::int64_t calls, std::int64_t jacobians) {
    calls_ = calls;
    jacobians_ = jacobians;
  }

  /// The end of a run that failed at t. The two arguments in the middle: was it the limit of steps, and
  /// which.
  void explain(Record& record, bool too_many_steps, std::int64_t limit, const std::string& failure,
               double t) const {
    if (timed_out_)
      record.in_time(t);
    else if (not_finite_)
      record.end(Outcome::not_finite, "a right-hand side that is not finite", t);
    else if (too_many_steps)
      record.end(Outcome::step_limit, "gave up after " + std::to_string(limit) + " steps", t);
    else
      record.end(Outcome::solver_failed, failure, t);
  }

  /// A right-hand side that is not finite is a failure from which a shorter step may recover (1); a timeout
  /// is one for good (-1).
  static int rhs(sunrealtype t, N_Vector y, N_Vector d, void* user) {
    auto& self = *static_cast<Watch*>(user);
    ++self.calls_;
    if (self.calls_ % calls_per_look == 0) self.timed_out_ = self.timed_out_ || !self.record_->in_time(t);
    // Said at every call from then on: CVODE 6.4 goes on after a single -1 inside its functional iteration.
    if (self.timed_out_) return -1;
    self.model_->rhs(t, NV_DATA_S(y), NV_DATA_S(d));
    self.not_finite_ = !all_finite(std::span<const double>(NV_DATA_S(d), self.size_));
    return self.not_finite_ ? 1 : 0;
  }

  /// The two halves of a right-hand side for a partitioned method: w' and v' alone, and q' and p' alone. A
  /// pair of them counts as one.
  static int rhs_of_rates(sunrealtype t, N_Vector y, N_Vector d, void* user) {
    const int flag = rhs(t, y, d, user);
    static_cast<Watch*>(user)->clear(NV_DATA_S(d), false);
    return flag;
  }
  static int rhs_of_places(sunrealtype t, N_Vector y, N_Vector d, void* user) {
    auto& self = *static_cast<Watch*>(user);
    self.model_->rhs(t, NV_DATA_S(y), NV_DATA_S(d));
    self.clear(NV_DATA_S(d), true);
    return 0;
  }

  /// Both libraries store columns one after another.
  static int jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector,
                      N_Vector) {
    auto& self = *static_cast<Watch*>(user);
    ++self.jacobians_;
    self.model_->jacobian(t, NV_DATA_S(y), SM_DATA_D(J));
    return 0;
  }

 private:
  static constexpr std::int64_t calls_per_look = 1024;  // at the clock

  /// Zeros in place of the derivatives of w and v, or of those of q and p.
  void clear(double* d, bool rates) const {
    const std::size_t w_at = model_->has_attitude() ? 4 : 0;
    const bool rotates = size_ != 6;
    for (std::size_t i = 0; i < size_; ++i) {
      const bool is_rate = rotates && i < w_at + 3 ? i >= w_at : (i - (rotates ? w_at + 3 : 0)) >= 3;
      if (is_rate == rates) d[i] = 0;
    }
  }

  std::unique_ptr<ErasedModel> model_;
  std::size_t size_;
  Record* record_ = nullptr;  // of the run in progress
  std::int64_t calls_ = 0, jacobians_ = 0;
  bool not_finite_ = false, timed_out_ = false;
};

/// "PACKAGE: NAME_OF_FLAG" from a name that the library has allocated.
inline std::string flag_text(const char* package, char* allocated_name) {
  const std::unique_ptr<char, void (*)(void*)> name(allocated_name, std::free);
  return std::string(package) + ": " + name.get();
}

}  // namespace polhode::sundials
