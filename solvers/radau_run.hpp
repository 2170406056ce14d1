// Integration by Radau IIA of many stages in a wide type, for scenes with fast decays: the step follows the
// solution, not the decay.
//
// The stage equations are solved by Newton's method whose matrix, I - h A x J with the Jacobian at every
// stage, is factored in double precision: each iteration gains a dozen digits, fewer as the matrix grows
// stale. The step is chosen by how the collocation polynomial's Legendre coefficients fall off: its last one
// times the ratio of the last two bounds what the polynomial misses, everywhere in the step, stiff components
// included. Asked times are read off the polynomial. Source: Hairer & Wanner, Solving ODEs II (1996), IV.8.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include "solvers/erased_model.hpp"
#include "solvers/radau_table.hpp"

namespace polhode {

/// In number type S. The equations are asked through a function: beside arithmetic in software its call is
/// nothing, and one instance serves all models.
template <class S>
class RadauRun {
 public:
  using State = std::vector<S>;
  using Stages = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
  /// A step that was taken: the states at its nodes are y and y + a column of z.
  struct Step {
    S t, h;
    State y;
    Stages z;
  };

  /// doubles   the same equations in double precision, for the Jacobian
  template <class M>
  RadauRun(const M& m, const ErasedModel& doubles, int stages)
      : rhs_([m](const S& t, const S* y, S* d) { m.rhs(t, y, d); }),
        n_(M::size),
        doubles_(doubles),
        table_(stages),
        s_(stages) {
    if constexpr (M::has_attitude) parts_.push_back({0, 4});
    if constexpr (M::has_rotation) parts_.push_back({M::Rotating::w_at, M::Rotating::size});
    if constexpr (M::has_translation) {
      parts_.push_back({M::rotation_size, M::rotation_size + 3});
      parts_.push_back({M::rotation_size + 3, M::rotation_size + 6});
    }
  }

  /// Goes from (t, y) through the asked times (increasing, >= t), calling visit(time, state) at each. Returns
  /// the steps, or -1 if it took more than `step_limit` or found no step size; t and y are where it stands.
  template <class Time>
  std::int64_t run(S& t, std::span<S> y, std::span<const Time> times, double tolerance,
                   std::int64_t step_limit, const std::function<void(const S&, std::span<const S>)>& visit,
                   const std::function<void(const Step&)>& took = {},
                   const std::function<void()>& begin = {}) {
    std::size_t next = 0;
    for (; next < times.size() && S(times[next]) <= t; ++next) visit(t, y);
    if (next == times.size()) return 0;
    const auto end = static_cast<double>(times.back());
    const double start = static_cast<double>(t);
    S h(std::min(end - start, 1e-2 / std::max(largest_rate(start, y), 1 / (end - start))));
    std::int64_t steps = 0, tries = 0;
    while (next < times.size()) {
      if (steps == step_limit || ++tries > 2 * step_limit || !(t + h > t)) return -1;
      if (h > S(times.back()) - t) h = S(times.back()) - t;
      if (begin) begin();
      const double error = solve(t, y, h) ? truncation(y) : -1;
      if (error < 0) {
        h /= S(4);
        continue;
      }
      const double factor = error > 0 ? 0.9 * std::pow(tolerance / error, 1.0 / (s_ + 2)) : 4;
      if (error > tolerance) {
        h *= S(std::clamp(factor, 0.1, 0.9));
        continue;
      }
      for (; next < times.size() && S(times[next]) <= t + h; ++next)
        visit(S(times[next]), inside(y, z_, S((S(times[next]) - t) / h)));
      if (took) took({t, h, State(y.begin(), y.end()), z_});
      for (int i = 0; i < n_; ++i) y[std::size_t(i)] += z_(i, s_ - 1);
      t += h;
      h *= S(std::clamp(factor, 0.2, 4.0));
      ++steps;
    }
    return steps;
  }

  /// The collocation polynomial at a fraction of a step.
  State inside(std::span<const S> y, const Stages& z, const S& fraction) const {
    State x(y.begin(), y.end());
    S sum(0);
    std::vector<S> parts;
    for (std::size_t k = 0; k < table_.nodes.size(); ++k) {
      const S gap = fraction - table_.nodes[k];
      if (gap == S(0)) {
        for (int i = 0; i < n_ && k > 0; ++i) x[std::size_t(i)] += z(i, static_cast<int>(k) - 1);
        return x;
      }
      parts.push_back(table_.weights[k] / gap);
      sum += parts.back();
    }
    for (int i = 0; i < n_; ++i)
      for (int j = 0; j < s_; ++j) x[std::size_t(i)] += parts[std::size_t(j) + 1] / sum * z(i, j);
    return x;
  }

 private:
  using Scales = std::vector<double>;

  Eigen::MatrixXd jacobian(double t, std::span<const S> y) const {
    Eigen::MatrixXd J(n_, n_);
    Eigen::VectorXd narrowed(n_);
    for (int i = 0; i < n_; ++i) narrowed[i] = static_cast<double>(y[std::size_t(i)]);
    doubles_.jacobian(t, narrowed.data(), J.data());
    return J;
  }
  double largest_rate(double t, std::span<const S> y) const {
    return jacobian(t, y).cwiseAbs().rowwise().sum().maxCoeff();
  }

  State stage(std::span<const S> y, int j) const {
    State x(y.size());
    for (int i = 0; i < n_; ++i) x[std::size_t(i)] = y[std::size_t(i)] + z_(i, j);
    return x;
  }

  /// What differences are measured by: the length of each part of the state. One that has died out, to 1e-40
  /// of what it was, is zero.
  Scales scales(std::span<const S> y) {
    Scales scale(y.size());
    for (const auto& [from, to] : parts_) {
      S largest(0);
      for (int i = from; i < to; ++i) {
        using std::abs;
        largest = std::max(largest, S(abs(y[std::size_t(i)])));
        for (int j = 0; j < s_; ++j) largest = std::max(largest, S(abs(S(y[std::size_t(i)] + z_(i, j)))));
      }
      for (int i = from; i < to; ++i)
        scale[std::size_t(i)] = largest > S(0) ? static_cast<double>(largest) : 1;
    }
    return scale;
  }

  /// The stages of the step from (t, y) as differences z from y. False: Newton's method does not converge.
  bool solve(const S& t, std::span<const S> y, const S& h) {
    z_ = Stages::Zero(n_, s_);
    Stages f(n_, s_);
    Eigen::PartialPivLU<Eigen::MatrixXd> lu;
    const double h_double = static_cast<double>(h);
    double before = std::numeric_limits<double>::infinity(), ratio = 1;
    for (int iteration = 0; iteration < 30; ++iteration) {
      for (int j = 0; j < s_; ++j)
        rhs_(S(t + table_.c[std::size_t(j)] * h), stage(y, j).data(), f.col(j).data());
      const Stages residual = z_ - h * f.lazyProduct(table_.a.transpose());
      if (iteration < 3 || ratio > 1e-3) {
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n_ * s_, n_ * s_);
        for (int j = 0; j < s_; ++j) {
          const Eigen::MatrixXd J =
              jacobian(static_cast<double>(S(t + table_.c[std::size_t(j)] * h)), stage(y, j));
          for (int i = 0; i < s_; ++i)
            matrix.block(i * n_, j * n_, n_, n_) -= h_double * static_cast<double>(table_.a(i, j)) * J;
        }
        lu.compute(matrix);
      }
      // Scaled to the range of doubles: late residuals lie far below it otherwise.
      S largest(0);
      for (int j = 0; j < s_; ++j)
        for (int i = 0; i < n_; ++i) {
          using std::abs;
          largest = std::max(largest, S(abs(residual(i, j))));
        }
      if (!(largest > S(0))) return true;
      Eigen::VectorXd right(n_ * s_);
      for (int j = 0; j < s_; ++j)
        for (int i = 0; i < n_; ++i) right[j * n_ + i] = static_cast<double>(S(residual(i, j) / largest));
      const Eigen::VectorXd change = lu.solve(right);
      if (!change.allFinite()) return false;
      double size = 0;
      const auto scale = scales(y);
      for (int j = 0; j < s_; ++j)
        for (int i = 0; i < n_; ++i) {
          const S step = largest * S(change[j * n_ + i]);
          z_(i, j) -= step;
          size = std::max(size, std::abs(static_cast<double>(step)) / scale[std::size_t(i)]);
        }
      ratio = size / before;
      if (size < 64 * epsilon() || (ratio > 0.1 && size < 1e4 * epsilon())) return true;
      if (iteration > 2 && ratio > 0.5) return false;
      before = size;
    }
    return false;
  }
  static double epsilon() { return static_cast<double>(std::numeric_limits<S>::epsilon()); }

  /// What the polynomial of the step misses, relative to the state.
  double truncation(std::span<const S> y) {
    const auto scale = scales(y);
    double worst = 0;
    for (int i = 0; i < n_; ++i) {
      S top(0), next = table_.lower[0] * z_(i, 0);
      for (int j = 0; j < s_; ++j) top += table_.weights[std::size_t(j) + 1] * z_(i, j);
      for (int j = 1; j < s_; ++j) next += table_.lower[std::size_t(j)] * z_(i, j);
      const double last = std::abs(static_cast<double>(top)) / table_.top / scale[std::size_t(i)];
      const double last_but_one = std::abs(static_cast<double>(next)) / table_.next / scale[std::size_t(i)];
      const double fall = last_but_one > 0 ? std::min(last / last_but_one, 1.0) : 1;
      worst = std::max(worst, last * fall);
    }
    return worst;
  }

  std::function<void(const S&, const S*, S*)> rhs_;
  int n_;
  std::vector<std::pair<int, int>> parts_;  // from, to: measured together
  const ErasedModel& doubles_;
  RadauTable<S> table_;
  int s_;
  Stages z_;
};

}  // namespace polhode
