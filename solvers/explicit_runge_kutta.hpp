// Explicit Runge-Kutta methods of many stages, at fixed step and controlled by their own error estimate.
//
//   k_i = f(t + c_i h, y + h sum_{j<i} a_ij k_j),   y <- y + h sum b_i k_i
//
// A formula is a type with a table of coefficients:
//   stages, order, a, b, c      constants; zeros are left out when the stages are compiled
//   error<n>(k, h, y, next, atol, rtol)   norm of the estimated error, the step is good if it is at most 1
//   error_order                 the error of a step falls with this power of h
//   DenseOutput (optional)      states within a step from a few more slopes
// Stages that only the estimate uses come last, and steps of fixed size do without them.
//
// The stages of a formula and a model are one function, which the run at fixed step, the controlled one and
// the branch share. Its sums are unrolled with the coefficients in the instructions. In each sum the newest
// slope comes last, multiplied by a factor that is ready: nobody waits for the rest.
//
// Asked times inside a step change neither steps nor counters. Without a dense output they are reached by a
// step of the same formula from the start of that step: shorter than a step which was just found good.
//
// Step control: h <- h min(6, max(1/3, 0.9 err^(-1/p))), no growth after a rejection; the first step is that
// of Hairer's `hinit`. Source: Hairer, Norsett & Wanner, Solving ODEs I (1993), II.4.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "solvers/adaptive_step.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/pairs.hpp"

namespace polhode {

/// Stages that the formula itself uses: those up to the last weight.
template <class Formula>
constexpr int formula_stages = [] {
  int s = Formula::stages;
  while (Formula::b[s - 1] == 0) --s;
  return s;
}();

/// Coefficients of the stability polynomial R(z) = 1 + sum_k (b^T A^(k-1) 1) z^k.
template <class Table>
constexpr std::array<double, formula_stages<Table> + 1> stability_polynomial_of() {
  constexpr int s = formula_stages<Table>;
  std::array<double, s + 1> R{1};
  std::array<double, s> v{};
  v.fill(1);  // A^(k-1) 1
  for (int k = 1; k <= s; ++k) {
    double sum = 0;
    for (int i = 0; i < s; ++i) sum += Table::b[i] * v[std::size_t(i)];
    R[std::size_t(k)] = sum;
    for (int i = s; i-- > 0;) {
      double next = 0;
      for (int j = 0; j < i; ++j) next += Table::a[i][j] * v[std::size_t(j)];
      v[std::size_t(i)] = next;
    }
  }
  return R;
}

/// a_sj, or b_j for s = stages.
template <class Table>
constexpr double coefficient(int s, int j) {
  return s == Table::stages ? Table::b[j] : Table::a[s][j];
}

/// sum_{j <= last} a_sj k_j of one pair of components.
template <class Table, int s, int last, class K>
[[gnu::always_inline]] inline Pair weighted(const K* k, int i) {
  if constexpr (last < 0)
    return Pair{};
  else if constexpr (coefficient<Table>(s, last) == 0)
    return weighted<Table, s, last - 1>(k, i);
  else
    return weighted<Table, s, last - 1>(k, i) + coefficient<Table>(s, last) * k[last].p[i];
}

/// y + h sum_j a_sj k_j.
template <class Table, int s, int n>
[[gnu::always_inline]] inline Pairs<n> stage_state(double h, const Pairs<n>& y, const Pairs<n>* k) {
  constexpr int newest = s - 1;
  const double factor = h * coefficient<Table>(s, newest);
  Pairs<n> x;
  unroll<Pairs<n>::count>([&](auto i) __attribute__((always_inline)) {
    if constexpr (newest == 0)
      x.p[i] = y.p[i] + factor * k[0].p[i];
    else
      x.p[i] = (y.p[i] + h * weighted<Table, s, newest - 1>(k, i)) + factor * k[newest].p[i];
  });
  return x;
}

/// The same for s and coefficients known at run time.
template <class Table, int n>
Pairs<n> stage_state(int s, double h, const Pairs<n>& y, const Pairs<n>* k) {
  Pairs<n> x = y;
  for (int j = 0; j < s; ++j) {
    const double factor = h * coefficient<Table>(s, j);
    if (factor != 0)
      for (int i = 0; i < Pairs<n>::count; ++i) x.p[i] += factor * k[j].p[i];
  }
  return x;
}

// With sanitizers each unrolled operation brings checks of its own, and a minute of compile time in all.
#if defined(__SANITIZE_ADDRESS__)
#define POLHODE_STAGES_IN_A_LOOP 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define POLHODE_STAGES_IN_A_LOOP 1
#endif
#endif
#ifdef POLHODE_STAGES_IN_A_LOOP
constexpr bool stages_in_a_loop = true;
#undef POLHODE_STAGES_IN_A_LOOP
#else
constexpr bool stages_in_a_loop = false;
#endif

/// The increment h sum b_i k_i of a step, and its slopes.
///
/// first_known   k[0] is already there
/// estimate      the stages that only the estimate needs as well
template <class Table, AnyModel M>
[[gnu::noinline]] Pairs<M::size> runge_kutta_increment(const M& m, double t, double h,
                                                       const Pairs<M::size>& start, bool first_known,
                                                       bool estimate, Pairs<M::size>* k) {
  constexpr int n = M::size, used = formula_stages<Table>;
  const Pairs<n> y = start;
  if (!first_known) k[0] = slope(m, t, y);
  if constexpr (stages_in_a_loop || requires { m.rotation.load.loads; }) {
    // A list of loads is a loop already: not worth its code at every stage.
    for (int s = 1; s < (estimate ? Table::stages : used); ++s)
      k[s] = slope(m, t + Table::c[s] * h, stage_state<Table, n>(s, h, y, k));
  } else {
    const auto stage = [&](auto s) __attribute__((always_inline)) {
      k[s] = slope(m, t + Table::c[s] * h, stage_state<Table, s, n>(h, y, k));
    };
    unroll<used - 1>([&](auto s)
                         __attribute__((always_inline)) { stage(std::integral_constant<int, s + 1>()); });
    if constexpr (used < Table::stages)
      if (estimate)
        unroll<Table::stages - used>([&](auto s) __attribute__((always_inline)) {
          stage(std::integral_constant<int, s + used>());
        });
  }
  Pairs<n> increment;
  constexpr int newest = used - 1;
  const double factor = h * Table::b[newest];
  unroll<Pairs<n>::count>([&](auto i) __attribute__((always_inline)) {
    increment.p[i] = h * weighted<Table, Table::stages, newest - 1>(k, i) + factor * k[newest].p[i];
  });
  return increment;
}

template <int n>
[[gnu::always_inline]] inline Pairs<n> sum(const Pairs<n>& a, const Pairs<n>& b) {
  Pairs<n> c;
  for (int i = 0; i < Pairs<n>::count; ++i) c.p[i] = a.p[i] + b.p[i];
  return c;
}

/// At fixed step, for the loop of solvers/fixed_step.hpp.
template <class Formula>
struct ExplicitFixed : QuaternionForm {
  static constexpr int rhs_per_step = formula_stages<Formula>;

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    return y_plus(m, t, h, y, pairs_of<M::size>(y.data()));
  }
  /// What the step adds to y, for solvers/compensated.hpp.
  template <AnyModel M>
  typename M::State increment(const M& m, double t, double h, const typename M::State& y) const {
    return y_plus(m, t, h, y, Pairs<M::size>{});
  }

 private:
  template <AnyModel M>
  static typename M::State y_plus(const M& m, double t, double h, const typename M::State& y,
                                  const Pairs<M::size>& to) {
    Pairs<M::size> k[Formula::stages];
    typename M::State next;
    copy_to<M::size>(next.data(),
                     sum<M::size>(to, runge_kutta_increment<Formula>(m, t, h, pairs_of<M::size>(y.data()),
                                                                     false, false, k)));
    return next;
  }
};

/// The step sizes that the errors of steps ask for.
class StepControl {
 public:
  explicit StepControl(int error_order) : exponent_(-1.0 / error_order) {}
  void restart() { rejected_ = false; }
  /// Factor for the next step after an error (which may be no number).
  double factor(double error) {
    const double wanted = 0.9 * std::pow(error, exponent_);
    const bool good = error <= 1;
    // Written so that no number becomes the smallest.
    const double f = wanted > 1.0 / 3 ? std::min(wanted, good && rejected_ ? 1.0 : 6.0) : 1.0 / 3;
    rejected_ = !good;
    return f;
  }

 private:
  double exponent_;
  bool rejected_ = false;
};

/// First trial step of Hairer's `hinit`: from the slopes at both ends of an explicit Euler step, the step at
/// which a formula of this order would err by 1/100 of the tolerance.
inline double trial_step(std::span<const double> y, std::span<const double> d,
                         std::span<const double> d_euler, double euler_step, int order,
                         const Setting& setting) {
  double rate = 0, bend = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double scale = setting.absolute_tolerance() + setting.rtol * std::abs(y[i]);
    rate += d[i] * d[i] / (scale * scale);
    bend += (d_euler[i] - d[i]) * (d_euler[i] - d[i]) / (scale * scale);
  }
  const auto n = static_cast<double>(y.size());
  const double steepest = std::max(std::sqrt(rate / n), std::sqrt(bend / n) / euler_step);
  const double h = std::pow(0.01 / steepest, 1.0 / order);
  return h < 100 * euler_step ? h : 100 * euler_step;
}

/// What controlled runs on pairs share: state, first trial, the loop around Self::try_step(p), which takes
/// one trial step and returns false to give up.
template <class Self, AnyModel M>
class TrialSteps : public AdaptiveSteps {
 public:
  static constexpr int n = M::size;
  void cruise(double t_stop, std::int64_t limit, Progress& p) override {
    while (p.t + p.h < t_stop && p.attempts < limit)
      if (!self().try_step(p)) break;
  }
  bool attempt(Progress& p) override {
    before_ = y_;
    h_ = p.h;
    const std::int64_t accepted = p.accepted;
    self().try_step(p);
    return p.accepted > accepted;
  }
  Sample sample(double t) const override { return sample_of(t, y_); }
  bool is_finite() const override {
    typename M::State y;
    copy_to<n>(y.data(), y_);
    return all_finite(y);
  }

 protected:
  /// order   that of the formula whose first step is sought
  TrialSteps(M model, const Setting& setting, int order)
      : model_(std::move(model)),
        atol_(setting.absolute_tolerance()),
        rtol_(setting.rtol),
        y_(pairs_of<n>(model_.initial.data())) {
    typename M::State d, d_euler, y = model_.initial;
    model_.rhs(0.0, y.data(), d.data());
    first_ = first_step(y, d, setting);
    if (first_ > 0) {
      for (std::size_t i = 0; i < y.size(); ++i) y[i] += first_ * d[i];
      model_.rhs(first_, y.data(), d_euler.data());
      first_ = trial_step(model_.initial, d, d_euler, first_, order, setting);
    }
  }
  void back_to_start(double t_end, Progress& p) {
    y_ = pairs_of<n>(model_.initial.data());
    p.rhs_evals = 2;  // of the first step
    p.h = first_ > 0 ? std::min(first_, t_end) : 1e-6 * t_end;
  }
  Sample sample_of(double t, const Pairs<n>& x) const {
    typename M::State y;
    copy_to<n>(y.data(), x);
    return observe(model_, t, y.data());
  }

  M model_;
  double atol_, rtol_, first_ = 0, h_ = 0;  // h_: of the last attempt
  Pairs<n> y_, before_{};

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

/// A controlled run.
template <class Formula, AnyModel M>
class ExplicitAdaptive final : public TrialSteps<ExplicitAdaptive<Formula, M>, M> {
  using Base = TrialSteps<ExplicitAdaptive, M>;
  friend Base;
  using Base::model_, Base::atol_, Base::rtol_, Base::h_, Base::y_, Base::before_, Base::sample_of;

 public:
  static constexpr int n = M::size;
  ExplicitAdaptive(M model, const Setting& setting) : Base(std::move(model), setting, Formula::order) {}

  void restart(double t_end, Progress& p) override {
    Base::back_to_start(t_end, p);
    control_.restart();
    first_known_ = false;
  }
  bool attempt(Progress& p) override {
    dense_ready_ = false;
    return Base::attempt(p);
  }
  bool sample_within(double t_start, double t, Sample& out) override {
    if constexpr (requires { typename Formula::template DenseOutput<n>; }) {
      if (!dense_ready_) dense_.prepare(model_, t_start, h_, before_, y_, k_);
      dense_ready_ = true;
      out = sample_of(t, dense_.at((t - t_start) / h_));
    } else {
      Pairs<n> k[Formula::stages];
      out = sample_of(t, sum<n>(before_, runge_kutta_increment<Formula>(model_, t_start, t - t_start, before_,
                                                                        false, false, k)));
    }
    return true;
  }

 private:
  struct NoDenseOutput {};
  static auto dense_output() {
    if constexpr (requires { typename Formula::template DenseOutput<n>; })
      return typename Formula::template DenseOutput<n>();
    else
      return NoDenseOutput();
  }

  /// One trial step. False: give up.
  bool try_step(Progress& p) {
    const double h = p.h, t = p.t;
    const Pairs<n> next =
        sum<n>(y_, runge_kutta_increment<Formula>(model_, t, h, y_, first_known_, true, k_));
    p.rhs_evals += Formula::stages - first_known_;
    const double error = Formula::template error<n>(k_, h, y_, next, atol_, rtol_);
    const bool good = error <= 1;
    p.h = h * control_.factor(error);
    first_known_ = !good;
    if (good) {
      y_ = next;
      p.t = t + h;
    }
    return p.tell(t, h, good);
  }
  StepControl control_{Formula::error_order};
  bool first_known_ = false, dense_ready_ = false;
  Pairs<n> k_[Formula::stages]{};
  [[no_unique_address]] decltype(dense_output()) dense_;
};

/// `prepare` of a formula with both knobs.
template <class Formula>
Prepared run_explicit(const Scene& scene, const Setting& setting) {
  if (setting.knob == Knob::steps) return run_fixed_step<ExplicitFixed<Formula>>(scene, setting);
  return with_model(scene, [&](auto model) {
    using Run = ExplicitAdaptive<Formula, decltype(model)>;
    return run_adaptive_steps(std::make_shared<Run>(std::move(model), setting), setting);
  });
}

}  // namespace polhode
