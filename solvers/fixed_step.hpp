// The one loop of every solver of fixed step.
//
// A stepper is a struct with `step(model, t, h, state) -> state` and, by its base, the form of its state:
// `QuaternionForm` (the model's own [q][w_B][p v]) or a form of the solver's own. The time is t_start + i h
// with an integer i. Nothing is allocated inside; the state is looked at only at the asked times and every
// few thousand steps, when the clock is. Only the steps themselves are compiled for each stepper and model.
#pragma once
#include <concepts>
#include <memory>

#include "models/model.hpp"
#include "solvers/observe.hpp"
#include "solvers/record.hpp"

namespace polhode {

/// State form of most steppers: the flat state of the model.
struct QuaternionForm {
  template <AnyModel M>
  static auto start(const M& m) {
    return m.initial;
  }
  template <AnyModel M>
  static Sample sample(const M& m, double t, const typename M::State& y) {
    return observe(m, t, y.data());
  }
};

/// q <- q/|q| in a flat state, the step that the `-renormalised` variants add.
template <class State>
void renormalise_attitude(State& y) {
  const double scale = 1 / std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
  for (std::size_t i = 0; i < 4; ++i) y[i] *= scale;
}

/// What the concept asks is what a solver file may leave out: no step for a model, no support of it.
template <class S, class M>
concept Stepper = requires(const S& s, const M& m, decltype(S::start(m)) y) {
  { s.step(m, 0.0, 0.0, y) } -> std::convertible_to<decltype(S::start(m))>;
  { S::sample(m, 0.0, y) } -> std::convertible_to<Sample>;
};

/// A run in steps of fixed size, its stepper and model no longer seen.
class FixedSteps {
 public:
  virtual ~FixedSteps() = default;
  virtual void restart() = 0;
  /// Takes the steps i, i + 1, ... until - 1 of size h, step i at t_start + i h. Returns the first that it
  /// did not finish, with the reason why, or `until`.
  virtual std::int64_t advance(double t_start, double h, std::int64_t i, std::int64_t until, Outcome& outcome,
                               std::string& reason) = 0;
  virtual Sample sample(double t) const = 0;
};

template <class S, class M>
requires Stepper<S, M>
class FixedStepsOf final : public FixedSteps {
 public:
  explicit FixedStepsOf(M model) : model_(std::move(model)) {}
  void restart() override { y_ = S::start(model_); }
  std::int64_t advance(double t_start, double h, std::int64_t i, std::int64_t until, Outcome& outcome,
                       [[maybe_unused]] std::string& reason) override {
    S stepper;  // a library's one holds stage derivatives: scratch, best where only this function sees it
    auto y = y_;
    for (; i < until; ++i) {
      const double t = t_start + static_cast<double>(i) * h;
      if constexpr (requires { stepper.advance(model_, t, h, y); })
        stepper.advance(model_, t, h, y);  // in place: a library's stepper that would have to copy the state
      else
        y = stepper.step(model_, t, h, y);
      if constexpr (requires { stepper.failure; })
        if (stepper.failure != nullptr) {
          outcome = Outcome::solver_failed;
          reason = stepper.failure;
          return i;
        }
    }
    y_ = y;
    if (!all_finite(y)) outcome = Outcome::not_finite;
    return i;
  }
  Sample sample(double t) const override { return S::sample(model_, t, y_); }

 private:
  M model_;
  decltype(S::start(std::declval<const M&>())) y_ = S::start(model_);
};

/// The run that takes these steps, which stand at the start. `rhs_per_step` right-hand sides each, for the
/// work counters.
Prepared run_fixed_steps(std::shared_ptr<FixedSteps> steps, const Setting& setting, int rhs_per_step);

/// `prepare` of a fixed-step solver. S::needs says what a scene lacks that it cannot serve.
template <class S>
Prepared run_fixed_step(const Scene& scene, const Setting& setting) {
  std::shared_ptr<FixedSteps> steps = with_model(scene, [](auto model) -> std::shared_ptr<FixedSteps> {
    using M = decltype(model);
    if constexpr (Stepper<S, M>)
      return std::make_shared<FixedStepsOf<S, M>>(std::move(model));
    else
      return nullptr;
  });
  if constexpr (requires { S::needs; })
    if (!steps) return {{}, std::string(S::needs)};
  return run_fixed_steps(std::move(steps), setting, S::rhs_per_step);
}

}  // namespace polhode
