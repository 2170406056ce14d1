// Gragg, Bulirsch and Stoer's extrapolation: the explicit midpoint rule with 2, 4, 6, ... substeps, its
// results extrapolated to substeps of no length.
//   T_j1: z_1 = y + h f(y), z_{i+1} = z_{i-1} + 2 h f(z_i), T_j1 = z_n, h = H/n, n = 2j
//   T_{j,k+1} = T_jk + (T_jk - T_{j-1,k})/((n_j/n_{j-k})^2 - 1)
//
// The error of T_j1 is a series in h^2, so that T_jj is of order 2j. With a tolerance, |T_jj - T_{j,j-1}| in
// the root mean square over atol + rtol |y_i| is the error, and the row k at which it should come below one
// and the step H are chosen for the least work per unit of time, as in ODEX. At fixed step four rows,
// order 8.
//
// Gragg's smoothing (z_{n-1} + 2 z_n + z_{n+1})/4 is left out: it costs an evaluation a row, and what it is
// for, damping an oscillation of the midpoint rule, has no time to grow within one H. Measured on the free
// body of Hairer & Vilmart it makes runs 12 to 23 % dearer at the same error.
//
// Asked times within a step are reached by a shorter step of as many rows. Keeps no invariant. Source:
// Hairer, Norsett & Wanner, Solving ODEs I (1993), II.9; Gragg, SIAM J. Numer. Anal. 2 (1965); Bulirsch &
// Stoer, Numer. Math. 8 (1966).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "solvers/explicit_runge_kutta.hpp"

namespace polhode {
namespace {

constexpr int most_rows = 10, fixed_rows = 4;
constexpr int substeps(int row) { return 2 * (row + 1); }  // rows count from 0
/// 1/((n_j/n_{j-k})^2 - 1)
constexpr double weight(int j, int k) {
  const double ratio = double(substeps(j)) / double(substeps(j - k));
  return 1 / (ratio * ratio - 1);
}
/// Evaluations of the rows up to this one.
constexpr int evaluations(int row) {
  int n = 1;
  for (int j = 0; j <= row; ++j) n += substeps(j) - 1;
  return n;
}

/// T_j1.
template <AnyModel M>
[[gnu::noinline]] Pairs<M::size> midpoint_rule(const M& m, double t, double H, const Pairs<M::size>& start,
                                               const Pairs<M::size>& slope_at_start, int n) {
  constexpr int count = Pairs<M::size>::count;
  const double h = H / n;
  Pairs<M::size> before = start, z = start;
  unroll<count>([&](auto i) __attribute__((always_inline)) { z.p[i] += h * slope_at_start.p[i]; });
  for (int step = 1; step < n; ++step) {
    const Pairs<M::size> f = slope(m, t + step * h, z);
    unroll<count>([&](auto i) __attribute__((always_inline)) {
      const Pair next = before.p[i] + (2 * h) * f.p[i];
      before.p[i] = z.p[i];
      z.p[i] = next;
    });
  }
  const Pairs<M::size> result = z;  // not z itself, which would live in the memory of the caller
  return result;
}

/// The last row of the table, T_j1, T_j2, ... T_jj.
template <int n>
class Extrapolation {
 public:
  /// Takes T_j1 and makes the row j of the row j - 1.
  void add(int j, const Pairs<n>& rule) {
    Pairs<n> left = rule;
    for (int k = 0; k < j; ++k) {
      const double w = weights_[std::size_t(j)][std::size_t(k)];
      Pairs<n> right;
      for (int i = 0; i < Pairs<n>::count; ++i) right.p[i] = left.p[i] + w * (left.p[i] - row_[k].p[i]);
      row_[k] = left;
      left = right;
    }
    row_[j] = left;
  }
  const Pairs<n>& result(int j) const { return row_[j]; }
  double error(int j, const Pairs<n>& weights) const {
    Pair sum{};
    for (int i = 0; i < Pairs<n>::count; ++i) {
      const Pair e = (row_[j].p[i] - row_[j - 1].p[i]) * weights.p[i];
      sum += e * e;
    }
    return std::sqrt((sum[0] + sum[1]) / n);
  }

 private:
  static constexpr auto weights_ = [] {
    std::array<std::array<double, most_rows>, most_rows> w{};
    for (int j = 0; j < most_rows; ++j)
      for (int k = 1; k <= j; ++k) w[std::size_t(j)][std::size_t(k - 1)] = weight(j, k);
    return w;
  }();
  Pairs<n> row_[most_rows];
};

template <AnyModel M>
Pairs<M::size> extrapolated_step(const M& m, double t, double H, const Pairs<M::size>& y, int rows) {
  const Pairs<M::size> f = slope(m, t, y);
  Extrapolation<M::size> table;
  for (int j = 0; j < rows; ++j) table.add(j, midpoint_rule(m, t, H, y, f, substeps(j)));
  return table.result(rows - 1);
}

struct GbsFixed : QuaternionForm {
  static constexpr int rhs_per_step = evaluations(fixed_rows - 1);

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State next;
    copy_to<M::size>(next.data(), extrapolated_step(m, t, h, pairs_of<M::size>(y.data()), fixed_rows));
    return next;
  }
};

/// Rows and step sizes: what ODEX does, for any model.
class OrderControl {
 public:
  /// A row more for every 1.7 digits.
  static int first_target(double rtol) {
    return std::clamp(static_cast<int>(std::lround(-0.6 * std::log10(rtol))), 2, most_rows - 2);
  }
  void restart(double rtol) {
    target_ = first_target(rtol);
    rejected_ = false;
  }
  int target() const { return target_; }

  /// To be told the error of row j.
  void tell(int j, double H, double error) {
    const double power = 1.0 / (2 * j + 1);
    const double wanted = 0.94 * std::pow(0.65 / error, power);
    const double factor = wanted > 0.1 ? std::min(wanted, 4.0) : 0.1;  // no number: the smallest
    step_[j] = H * factor;
    work_[j] = evaluations(j) / step_[j];
  }
  /// Row `last` did not converge; may a row up to target + 1 still?
  bool hopeful(int last, double error) const {
    double reach = 1;
    for (int j = last + 1; j <= target_ + 1; ++j) {
      const double ratio = double(substeps(j)) / substeps(0);
      reach *= ratio * ratio;
    }
    return error <= reach;
  }
  /// Step size after one that was accepted at row j.
  double accept(int j, double H) {
    int next = j;
    double h = step_[j];
    if (j > 1 && j - 1 >= first_told() && work_[j - 1] < 0.8 * work_[j]) {
      next = j - 1;
      h = step_[next];
    } else if (j <= target_ && j + 1 < most_rows && (j - 1 < first_told() || work_[j] < 0.9 * work_[j - 1])) {
      next = j + 1;
      h = step_[j] * evaluations(j + 1) / evaluations(j);
    }
    if (rejected_) {
      next = std::min(next, j);
      h = std::min(step_[next], H);
    }
    target_ = std::clamp(next, 2, most_rows - 2);
    rejected_ = false;
    return h;
  }
  /// Step size after one that was given up at row `last`.
  double reject(int last) {
    int best = std::min(last, target_);
    if (best - 1 >= first_told() && work_[best - 1] < 0.8 * work_[best]) --best;
    target_ = std::clamp(best, 2, most_rows - 2);
    rejected_ = true;
    return step_[best];
  }
  int first_told() const { return std::max(1, target_ - 2); }

 private:
  int target_ = 2;
  bool rejected_ = false;
  double step_[most_rows], work_[most_rows];
};

template <AnyModel M>
class GbsAdaptive final : public TrialSteps<GbsAdaptive<M>, M> {
  using Base = TrialSteps<GbsAdaptive, M>;
  friend Base;
  using Base::model_, Base::atol_, Base::rtol_, Base::y_, Base::before_, Base::sample_of;

 public:
  static constexpr int n = M::size;
  GbsAdaptive(M model, const Setting& setting)
      : Base(std::move(model), setting, 2 * OrderControl::first_target(setting.rtol)) {}

  void restart(double t_end, Progress& p) override {
    Base::back_to_start(t_end, p);
    control_.restart(rtol_);
    slope_known_ = false;
  }
  bool sample_within(double t_start, double t, Sample& out) override {
    out = sample_of(t, extrapolated_step(model_, t_start, t - t_start, before_, rows_));
    return true;
  }

 private:
  /// One trial step. False: give up.
  bool try_step(Progress& p) {
    const double H = p.h, t = p.t;
    if (!slope_known_) slope_ = slope(model_, t, y_);
    p.rhs_evals += !slope_known_;
    slope_known_ = true;
    Pairs<n> weights;
    const int first_told = control_.first_told();
    bool good = false;
    int j = 0;
    for (;; ++j) {
      table_.add(j, midpoint_rule(model_, t, H, y_, slope_, substeps(j)));
      p.rhs_evals += substeps(j) - 1;
      if (j == 0) weights = error_weights<n>(y_, table_.result(0), atol_, rtol_);
      if (j < first_told) continue;
      const double error = table_.error(j, weights);
      control_.tell(j, H, error);
      const int target = control_.target();
      good = error <= 1 && j >= target - 1;
      if (good || j > target || (j >= target - 1 && !control_.hopeful(j, error))) break;
    }
    if (good) {
      y_ = table_.result(j);
      rows_ = j + 1;
      slope_known_ = false;
      p.t = t + H;
      p.h = control_.accept(j, H);
    } else {
      p.h = control_.reject(j);
    }
    return p.tell(t, H, good);
  }
  OrderControl control_;
  bool slope_known_ = false;
  int rows_ = 1;
  Pairs<n> slope_{};
  Extrapolation<n> table_;
};

Prepared prepare_gbs(const Scene& scene, const Setting& setting) {
  if (setting.knob == Knob::steps) return run_fixed_step<GbsFixed>(scene, setting);
  return with_model(scene, [&](auto model) {
    return run_adaptive_steps(std::make_shared<GbsAdaptive<decltype(model)>>(std::move(model), setting),
                              setting);
  });
}

/// R(z) of the four rows: the same recursions on polynomials.
constexpr auto amplification = [] {
  constexpr std::size_t size = substeps(fixed_rows - 1) + 1;
  using Polynomial = std::array<double, size>;
  std::array<Polynomial, fixed_rows> row{};
  for (int j = 0; j < fixed_rows; ++j) {
    const double h = 1.0 / substeps(j);
    Polynomial before{1}, z{1, h};
    for (int step = 1; step < substeps(j); ++step) {
      Polynomial next = before;
      for (std::size_t i = 1; i < size; ++i) next[i] += 2 * h * z[i - 1];
      before = z;
      z = next;
    }
    for (int k = 0; k < j; ++k) {
      Polynomial right = z;
      for (std::size_t i = 0; i < size; ++i) right[i] += weight(j, k + 1) * (z[i] - row[std::size_t(k)][i]);
      row[std::size_t(k)] = z;
      z = right;
    }
    row[std::size_t(j)] = z;
  }
  return row[fixed_rows - 1];
}();

constinit const Method rows[] = {
    {.id = "gbs",
     .family = "explicit Runge-Kutta",
     .summary = "Gragg-Bulirsch-Stoer extrapolation on (q, w_B), order and step controlled, or order 8 at "
                "fixed step",
     .source =
         "Hairer, Norsett & Wanner, Solving ODEs I (1993), II.9; Bulirsch & Stoer, Numer. Math. 8 (1966)",
     .by_steps = true,
     .by_tolerance = true,
     // No order is claimed where doubles do not show it: at fixed step errors fall with h^8.3 until they meet
     // rounding.
     .claims = {.unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = amplification,
     .prepare = prepare_gbs},
};

}  // namespace
extern const MethodRows gbs;
const MethodRows gbs = rows;
}  // namespace polhode
