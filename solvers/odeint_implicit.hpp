// Runs of Boost.Odeint's implicit steppers: solvers/odeint_ublas.hpp around a scene.
//
// A step of theirs allocates and factorises; beside that nobody sees that the model's type is erased.
#pragma once
#include <cmath>
#include <vector>

#include "solvers/erased_model.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/odeint_ublas.hpp"

namespace polhode {

/// A scene's equations, with counters.
class SceneEquations final : public ImplicitEquations {
 public:
  explicit SceneEquations(const Scene& scene) : model_(erased_model(scene)) {
    const std::size_t n = SceneEquations::size();
    by_columns_.resize(n * n);
    earlier_.resize(n);
    // Of all loads only the gravity gradient knows the time.
    if (scene.rotation)
      for (const auto& load : scene.rotation->loads)
        timed_ = timed_ || std::holds_alternative<GravityGradient<double>>(load);
  }

  std::size_t size() const override { return model_->initial().size(); }
  void rhs(double t, const double* y, double* d) override {
    ++rhs_evals;
    model_->rhs(t, y, d);
  }
  void jacobian(double t, const double* y, double* J) override {
    ++jacobian_evals;
    const std::size_t n = size();
    model_->jacobian(t, y, by_columns_.data());
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) J[i * n + j] = by_columns_[j * n + i];
  }
  /// By central differences. What they miss, 1e-11 of f, enters a step times h^2.
  void time_derivative(double t, const double* y, double* d) override {
    std::fill(d, d + size(), 0.0);
    if (!timed_) return;
    const double h = 6e-6 * std::max(1.0, std::abs(t)), above = t + h, below = t - h;
    rhs(above, y, d);
    rhs(below, y, earlier_.data());
    for (std::size_t i = 0; i < size(); ++i) d[i] = (d[i] - earlier_[i]) / (above - below);
  }
  std::vector<double> start() const { return {model_->initial().begin(), model_->initial().end()}; }
  Sample sample(double t, const std::vector<double>& y) const { return model_->sample(t, y.data()); }

  std::int64_t rhs_evals = 0, jacobian_evals = 0;

 private:
  std::unique_ptr<ErasedModel> model_;
  std::vector<double> by_columns_, earlier_;
  bool timed_ = false;
};

/// At fixed step.
class ImplicitFixed final : public FixedSteps {
 public:
  template <class Make>
  ImplicitFixed(const Scene& scene, const Make& make)
      : equations_(scene), y_(equations_.start()), stepper_(make(equations_)) {}
  void restart() override { y_ = equations_.start(); }
  Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) override {
    Advance done;
    const std::int64_t rhs_before = equations_.rhs_evals;
    for (; i < until; ++i) {
      done.reason = stepper_->step(y_.data(), t_start + static_cast<double>(i) * h, h);
      if (done.reason == nullptr) continue;
      done.outcome = Outcome::solver_failed;
      break;
    }
    done.next = i;
    done.rhs_evals = equations_.rhs_evals - rhs_before;
    if (done.outcome == Outcome::ok && !all_finite(y_)) {
      done.outcome = Outcome::not_finite;
      done.reason = "a state that is not finite";
    }
    return done;
  }
  Sample sample(double t) const override { return equations_.sample(t, y_); }

 private:
  SceneEquations equations_;
  std::vector<double> y_;
  std::unique_ptr<ImplicitStepper> stepper_;
};

}  // namespace polhode
