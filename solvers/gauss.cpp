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
#include "solvers/iteration.hpp"
#include "solvers/stability_function.hpp"

namespace polhode {
namespace {

constexpr int most_stages = 3;
struct Tableau {
  int stages;
  double a[most_stages][most_stages], b[most_stages], c[most_stages];
};
constexpr double r4 = 0.28867513459481288225;  // sqrt(3)/6
constexpr double r6 = 3.8729833462074168852;   // sqrt(15)
constexpr Tableau tableaux[] = {
    {1, {{0.5}}, {1}, {0.5}},
    {2, {{0.25, 0.25 - r4}, {0.25 + r4, 0.25}}, {0.5, 0.5}, {0.5 - r4, 0.5 + r4}},
    {3,
     {{5.0 / 36, 2.0 / 9 - r6 / 15, 5.0 / 36 - r6 / 30},
      {5.0 / 36 + r6 / 24, 2.0 / 9, 5.0 / 36 - r6 / 24},
      {5.0 / 36 + r6 / 30, 2.0 / 9 + r6 / 15, 5.0 / 36}},
     {5.0 / 18, 4.0 / 9, 5.0 / 18},
     {0.5 - r6 / 10, 0.5, 0.5 + r6 / 10}},
};

/// The equations of a step's stages, for Newton's method, which is compiled once for all models.
class StageEquations {
 public:
  virtual ~StageEquations() = default;
  /// f(t + c_i h, y + h sum a_ij k_j) of all stages, one after the other, as k is.
  virtual void slopes(const double* k, double* f) const = 0;
  virtual void jacobian(double* J) const = 0;  // of the right-hand side at the start of the step
};

/// Simplified Newton iteration on k = f(k) from the slope at the start of the step. Where it fails k is not
/// of use. Unknowns are divided by the scales of their part of the state, so that no pivot depends on units.
/// Returns the calls of `slopes`, negative if it failed.
int newton(const StageEquations& equations, const Tableau& T, int n, double h, double* k_at,
           const double* scales, double rounding) {
  const int stages = T.stages;
  Eigen::MatrixXd J(n, n), matrix = Eigen::MatrixXd::Identity(n * stages, n * stages);
  equations.jacobian(J.data());
  const Eigen::VectorXd scale = Eigen::Map<const Eigen::VectorXd>(scales, n).replicate(stages, 1) / h;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) J(i, j) *= scales[j] / scales[i];
  for (int i = 0; i < stages; ++i)
    for (int j = 0; j < stages; ++j) matrix.block(i * n, j * n, n, n) -= h * T.a[i][j] * J;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(matrix);
  Eigen::Map<Eigen::VectorXd> k(k_at, n * stages);
  Eigen::VectorXd f(n * stages);
  double before = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= 100; ++i) {
    equations.slopes(k.data(), f.data());
    const Eigen::VectorXd correction = lu.solve((f - k).cwiseQuotient(scale));
    const double change = correction.cwiseAbs().maxCoeff();
    if (!std::isfinite(change)) return -i;
    k += correction.cwiseProduct(scale);
    if (change <= rounding || (i > 4 && change < 64 * rounding && change >= before)) return i;
    before = change;
  }
  return -100;
}

template <int stages>
struct Gauss : QuaternionForm {
  static constexpr const Tableau& T = tableaux[stages - 1];
  std::int64_t rhs_evals = 0;
  const char* failure = nullptr;

  template <AnyModel M>
  using Stages = std::array<typename M::State, stages>;

  template <AnyModel M>
  struct Equations final : StageEquations {
    const M& m;
    double t, h;
    const typename M::State& y;
    Equations(const M& model, double time, double step, const typename M::State& start)
        : m(model), t(time), h(step), y(start) {}
    void slopes(const double* k, double* f) const override { slopes_at(m, t, h, y, k, f); }
    void jacobian(double* J) const override {
      m.jacobian(t, y.data(), Eigen::Map<Eigen::Matrix<double, M::size, M::size>>(J));
    }
  };

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    constexpr std::size_t n = M::size;
    Stages<M> k, f;
    constexpr double rounding = 2.2e-16;  // relative changes of the state below an ulp are none

    m.rhs(t, y.data(), f[0].data());
    const typename M::State scale = scales_of<M>(y, f[0], h);
    k.fill(f[0]);
    const typename M::State slope = f[0];
    ++rhs_evals;
    // To a tenth of an ulp: what an iteration leaves has the same sign step after step, and would add up.
    Settling settling(rounding, 0.1 * rounding);
    bool done = false;
    for (int i = 0; i < 60 && !done && !settling.slower_than(0.7); ++i) {
      slopes_at(m, t, h, y, k[0].data(), f[0].data());
      rhs_evals += stages;
      double change = 0;
      for (std::size_t s = 0; s < stages; ++s)
        for (std::size_t j = 0; j < n; ++j) {
          // Not std::max: a difference that is no number has to be seen.
          const double d = std::abs(h * (f[s][j] - k[s][j])) / scale[j];
          if (!(d <= change)) change = d;
        }
      k = f;
      done = settling.at_rest(change);
    }
    if (!done) {
      k.fill(slope);
      const int calls = newton(Equations<M>(m, t, h, y), T, M::size, h, k[0].data(), scale.data(), rounding);
      rhs_evals += stages * std::abs(calls);
      if (calls < 0) failure = "the stage equations have no solution that could be found";
    }
    typename M::State next = y;
    for (std::size_t s = 0; s < stages; ++s)
      for (std::size_t j = 0; j < n; ++j) next[j] += h * T.b[s] * k[s][j];
    return next;
  }

 private:
  /// Of each part of the state (attitude, rates, position, velocity) its largest number, or what a step
  /// adds to it if that is more; one where nothing moves.
  template <AnyModel M>
  static typename M::State scales_of(const typename M::State& y, const typename M::State& slope, double h) {
    typename M::State scale;
    const auto part = [&](int begin, int end) {
      double largest = 0;
      for (int j = begin; j < end; ++j)
        largest = std::max({largest, std::abs(y[std::size_t(j)]), std::abs(h * slope[std::size_t(j)])});
      if (!(largest > 1e-280))
        largest = largest > 0 ? 1e-280 : 1;  // numbers with fewer digits have no ulp to reach
      for (int j = begin; j < end; ++j) scale[std::size_t(j)] = largest;
    };
    constexpr int rotation = M::rotation_size;
    if constexpr (M::has_attitude) part(0, 4);
    if constexpr (M::has_rotation) part(rotation - 3, rotation);
    if constexpr (M::has_translation) {
      part(rotation, rotation + 3);
      part(rotation + 3, rotation + 6);
    }
    return scale;
  }
  template <AnyModel M>
  static void slopes_at(const M& m, double t, double h, const typename M::State& y, const double* k,
                        double* f) {
    constexpr std::size_t n = M::size;
    for (std::size_t i = 0; i < stages; ++i) {
      typename M::State x = y, d;
      for (std::size_t s = 0; s < stages; ++s)
        for (std::size_t j = 0; j < n; ++j) x[j] += h * T.a[i][s] * k[s * n + j];
      m.rhs(t + T.c[i] * h, x.data(), d.data());
      std::copy(d.begin(), d.end(), f + i * n);
    }
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

StabilityFunction stability_of(const Tableau& T) {
  Eigen::MatrixXd A(T.stages, T.stages);
  Eigen::VectorXd b(T.stages);
  for (int i = 0; i < T.stages; ++i) {
    b[i] = T.b[i];
    for (int j = 0; j < T.stages; ++j) A(i, j) = T.a[i][j];
  }
  return stability_function(A, b);
}
const StabilityFunction stability[] = {stability_of(tableaux[0]), stability_of(tableaux[1]),
                                       stability_of(tableaux[2])};

const Method rows[] = {
    {.id = "implicit-midpoint",
     .family = "Gauss collocation",
     .summary = "implicit midpoint rule on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<2>,
     .stability_polynomial = stability[0].numerator,
     .stability_denominator = stability[0].denominator,
     .prepare = run_fixed_step<Gauss<1>>},
    {.id = "gauss4",
     .family = "Gauss collocation",
     .summary = "two stages on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<4>,
     .stability_polynomial = stability[1].numerator,
     .stability_denominator = stability[1].denominator,
     .prepare = run_fixed_step<Gauss<2>>},
    {.id = "gauss6",
     .family = "Gauss collocation",
     .summary = "three stages on (q, w_B), solved to rounding",
     .source = source,
     .by_steps = true,
     .claims = claims_of<6>,
     .stability_polynomial = stability[2].numerator,
     .stability_denominator = stability[2].denominator,
     .prepare = run_fixed_step<Gauss<3>>},
};

}  // namespace
extern const MethodRows gauss;
const MethodRows gauss = rows;
}  // namespace polhode
