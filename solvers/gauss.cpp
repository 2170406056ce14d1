// Gauss collocation on (q, w_B): the implicit midpoint rule and its kin of orders 4 and 6.
//   k_i = f(t + c_i h, y + h sum a_ij k_j),  y <- y + h sum b_i k_i
// Order 2s. Symmetric, hence reversible, and A-stable. Every quadratic invariant is kept to the accuracy of
// the stage equations: |q|, and of the free body |L| and the energy, all of them quadratic in (q, w_B); the
// direction of L in space is not (q m q* is cubic).
//
// The stage equations are solved to rounding: by fixed-point iteration where that contracts fast, else by
// Newton's method with the model's own Jacobian at the start of the step. Where neither converges the run
// ends with solver_failed. Source: Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), II.1.3,
// IV.2, VIII.6.
#include <Eigen/LU>

#include "solvers/fixed_step.hpp"

namespace polhode {
namespace {

template <int stages>
struct Tableau;
template <>
struct Tableau<1> {
  static constexpr double a[1][1] = {{0.5}}, b[1] = {1}, c[1] = {0.5};
};
template <>
struct Tableau<2> {
  static constexpr double r = 0.28867513459481288225;  // sqrt(3)/6
  static constexpr double a[2][2] = {{0.25, 0.25 - r}, {0.25 + r, 0.25}};
  static constexpr double b[2] = {0.5, 0.5}, c[2] = {0.5 - r, 0.5 + r};
};
template <>
struct Tableau<3> {
  static constexpr double r = 3.8729833462074168852;  // sqrt(15)
  static constexpr double a[3][3] = {{5.0 / 36, 2.0 / 9 - r / 15, 5.0 / 36 - r / 30},
                                     {5.0 / 36 + r / 24, 2.0 / 9, 5.0 / 36 - r / 24},
                                     {5.0 / 36 + r / 30, 2.0 / 9 + r / 15, 5.0 / 36}};
  static constexpr double b[3] = {5.0 / 18, 4.0 / 9, 5.0 / 18}, c[3] = {0.5 - r / 10, 0.5, 0.5 + r / 10};
};

template <int stages>
struct Gauss : QuaternionForm {
  static constexpr int rhs_per_step = 0;  // as many as the iteration takes
  using T = Tableau<stages>;

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    constexpr int n = M::size;
    using Column = Eigen::Matrix<double, n, 1>;
    using Stages = Eigen::Matrix<double, n, stages>;
    const Eigen::Map<const Column> start(y.data());
    Stages k;
    const auto slopes_at = [&](const Stages& from) {
      Stages f;
      for (int i = 0; i < stages; ++i) {
        Column x = start;
        for (int j = 0; j < stages; ++j) x += h * T::a[i][j] * from.col(j);
        m.rhs(t + T::c[i] * h, x.data(), f.col(i).data());
      }
      return f;
    };
    m.rhs(t, y.data(), k.col(0).data());
    for (int i = 1; i < stages; ++i) k.col(i) = k.col(0);

    // Changes of the state below an ulp of it are none.
    const double rounding = 2.2e-16 * (start.cwiseAbs().maxCoeff() + 1e-300);
    const auto change_of = [&](const Stages& a, const Stages& b) {
      return std::abs(h) * (a - b).cwiseAbs().maxCoeff();
    };
    bool done = false;
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 60 && !done; ++i) {
      const Stages next = slopes_at(k);
      const double change = change_of(next, k);
      k = next;
      done = change <= rounding || (i > 3 && change < 8 * rounding && change >= before);
      if (!done && i > 2 && !(change < 0.7 * before)) break;
      before = change;
    }
    if (!done) done = newton(m, t, h, y, k, slopes_at, change_of, rounding);
    if (!done) failure = "the stage equations have no solution that could be found";
    typename M::State next = y;
    for (int i = 0; i < stages; ++i)
      for (int j = 0; j < n; ++j) next[static_cast<std::size_t>(j)] += h * T::b[i] * k(j, i);
    return next;
  }

  mutable const char* failure = nullptr;

 private:
  template <AnyModel M, class Stages, class SlopesAt, class ChangeOf>
  static bool newton(const M& m, double t, double h, const typename M::State& y, Stages& k,
                     const SlopesAt& slopes_at, const ChangeOf& change_of, double rounding) {
    constexpr int n = M::size;
    Eigen::Matrix<double, n, n> J;
    m.jacobian(t, y.data(), J);
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(n * stages, n * stages);
    for (int i = 0; i < stages; ++i)
      for (int j = 0; j < stages; ++j) matrix.block(i * n, j * n, n, n) -= h * T::a[i][j] * J;
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(matrix);
    for (int i = 0; i < stages; ++i) m.rhs(t, y.data(), k.col(i).data());
    double before = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 100; ++i) {
      const Stages f = slopes_at(k);
      const Eigen::VectorXd right = (f - k).reshaped();
      const Stages next = k + lu.solve(right).reshaped(n, stages);
      const double change = change_of(next, k);
      if (!std::isfinite(change)) return false;
      k = next;
      if (change <= rounding || (i > 3 && change < 64 * rounding && change >= before)) return true;
      before = change;
    }
    return false;
  }
};

template <int order>
constexpr Claims claims_of = {.attitude_order = order,
                              .rate_order = order,
                              .energy_order = order,
                              .momentum_order = order,
                              .unit_attitude = Claim::yes,
                              .momentum_magnitude = Claim::yes,
                              .space_momentum = Claim::no,
                              .energy_bounded = Claim::yes,
                              .reversible = Claim::yes};
constexpr std::string_view source =
    "Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), II.1.3, IV.2, VIII.6";

constinit const Method rows[] = {
    {.id = "implicit-midpoint",
     .family = "Gauss collocation",
     .summary = "implicit midpoint rule on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<2>,
     .prepare = run_fixed_step<Gauss<1>>},
    {.id = "gauss4",
     .family = "Gauss collocation",
     .summary = "two stages on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<4>,
     .prepare = run_fixed_step<Gauss<2>>},
    {.id = "gauss6",
     .family = "Gauss collocation",
     .summary = "three stages on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<6>,
     .prepare = run_fixed_step<Gauss<3>>},
};

}  // namespace
extern const MethodRows gauss;
const MethodRows gauss = rows;
}  // namespace polhode
