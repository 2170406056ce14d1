// The one loop of every solver of fixed step.
//
// A stepper is a struct with `step(model, t, h, state) -> state` and, by its base, the form of its state:
// `QuaternionForm` (the model's own [q][w_B][p v]) or a form of the solver's own. It has a constant
// `rhs_per_step`, or a counter `rhs_evals` that its steps add to; and `failure`, a sentence, if a step can
// fail. A member `choice` holds what the rows of a file choose at run time, such as a table of coefficients.
// The time is t_start + i h with an integer i. Nothing is allocated inside; the state is looked at only at
// the asked times and every few thousand steps, when the clock is. Only the steps themselves are compiled for
// each stepper and model.
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
concept Stepper = requires(S& s, const M& m, decltype(S::start(m)) y) {
  { s.step(m, 0.0, 0.0, y) } -> std::convertible_to<decltype(S::start(m))>;
  { S::sample(m, 0.0, y) } -> std::convertible_to<Sample>;
};

/// How far a stretch of steps came, and what it cost.
struct Advance {
  std::int64_t next = 0;  // the first step that is not finished
  Outcome outcome = Outcome::ok;
  const char* reason = nullptr;  // of a failure
  std::int64_t rhs_evals = 0;
};

/// A run in steps of fixed size, its stepper and model no longer seen.
class FixedSteps {
 public:
  virtual ~FixedSteps() = default;
  virtual void restart() = 0;
  /// Takes the steps i, i + 1, ... until - 1 of size h, step i at t_start + i h, or fewer if one fails.
  virtual Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) = 0;
  virtual Sample sample(double t) const = 0;
};

/// Type of a stepper's member `choice`; empty if it has none.
template <class S>
struct ChoiceOf {
  struct Type {};
};
template <class S>
requires requires(S s) { s.choice; }
struct ChoiceOf<S> {
  using Type = decltype(S::choice);
};

template <class S, class M>
requires Stepper<S, M>
class FixedStepsOf final : public FixedSteps {
 public:
  using Choice = typename ChoiceOf<S>::Type;
  explicit FixedStepsOf(M model, const Choice& choice = {}) : model_(std::move(model)), choice_(choice) {}
  void restart() override { y_ = S::start(model_); }
  Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) override {
    Advance done;
    S stepper;  // a library's one holds stage derivatives: scratch, best where only this function sees it
    if constexpr (requires { stepper.choice; }) stepper.choice = choice_;
    auto y = y_;
    const std::int64_t from = i;
    for (; i < until; ++i) {
      const double t = t_start + static_cast<double>(i) * h;
      if constexpr (requires { stepper.advance(model_, t, h, y); })
        stepper.advance(model_, t, h, y);  // in place: a library's stepper that would have to copy the state
      else
        y = stepper.step(model_, t, h, y);
      if constexpr (requires { stepper.failure; })
        if (stepper.failure != nullptr) {
          done.outcome = Outcome::solver_failed;
          done.reason = stepper.failure;
          break;
        }
    }
    y_ = y;
    done.next = i;
    if constexpr (requires { stepper.rhs_evals; })
      done.rhs_evals = stepper.rhs_evals;
    else
      done.rhs_evals = (i - from) * S::rhs_per_step;
    if (done.outcome == Outcome::ok && !all_finite(y)) {
      done.outcome = Outcome::not_finite;
      done.reason = "a state that is not finite";
    }
    return done;
  }
  Sample sample(double t) const override { return S::sample(model_, t, y_); }

 private:
  M model_;
  [[no_unique_address]] Choice choice_;
  decltype(S::start(std::declval<const M&>())) y_ = S::start(model_);
};

/// The run that takes these steps, which stand at the start.
Prepared run_fixed_steps(std::shared_ptr<FixedSteps> steps, const Setting& setting);

/// `prepare` of a fixed-step solver. S::needs says what a scene lacks that it cannot serve.
template <class S>
Prepared run_fixed_step(const Scene& scene, const Setting& setting,
                        const typename ChoiceOf<S>::Type& choice) {
  std::shared_ptr<FixedSteps> steps = with_model(scene, [&](auto model) -> std::shared_ptr<FixedSteps> {
    using M = decltype(model);
    if constexpr (Stepper<S, M>)
      return std::make_shared<FixedStepsOf<S, M>>(std::move(model), choice);
    else
      return nullptr;
  });
  if constexpr (requires { S::needs; })
    if (!steps) return {{}, std::string(S::needs)};
  return run_fixed_steps(std::move(steps), setting);
}
template <class S>
Prepared run_fixed_step(const Scene& scene, const Setting& setting) {
  return run_fixed_step<S>(scene, setting, {});
}

}  // namespace polhode
