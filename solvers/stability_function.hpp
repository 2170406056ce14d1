// The stability function of a Runge-Kutta method, from its tableau.
//   R(z) = 1 + z b^T (1 - z A)^-1 (1, ..., 1)^T = P(z)/Q(z),   Q(z) = det(1 - z A)
// Source: Hairer & Wanner, Solving ODEs II (1996), IV.3.
#pragma once
#include <vector>

#include <Eigen/Core>

#include "solvers/method.hpp"

namespace polhode {

/// Coefficients of P and Q in ascending powers; Q is {1} where the method is explicit.
struct StabilityFunction {
  std::vector<double> numerator, denominator;
};

/// A, b   the tableau, s x s and s
inline StabilityFunction stability_function(const Eigen::MatrixXd& A_given, const Eigen::VectorXd& b_given) {
  using Number = long double;  // powers of A cancel
  using Matrix = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Number, Eigen::Dynamic, 1>;
  const Matrix A = A_given.cast<Number>();
  const Vector b = b_given.cast<Number>();
  const auto s = A.rows();
  // det(1 - z A) by Faddeev and LeVerrier: q_k = -tr(A M_k)/k, M_(k+1) = A M_k + q_k.
  std::vector<Number> Q = {1};
  Matrix M = Matrix::Identity(s, s);
  for (Eigen::Index k = 1; k <= s; ++k) {
    const Matrix AM = A * M;
    Q.push_back(-AM.trace() / static_cast<Number>(k));
    M = AM + Q.back() * Matrix::Identity(s, s);
  }
  // P = Q times the series 1 + sum_k (b^T A^(k-1) 1) z^k, of which no more than z^s remains.
  std::vector<Number> series = {1};
  Vector v = Vector::Ones(s);
  for (Eigen::Index k = 1; k <= s; ++k) {
    series.push_back(b.dot(v));
    v = A * v;
  }
  StabilityFunction R;
  for (std::size_t k = 0; k < series.size(); ++k) {
    Number p = 0;
    for (std::size_t i = 0; i <= k; ++i) p += Q[i] * series[k - i];
    R.numerator.push_back(static_cast<double>(p));
    R.denominator.push_back(static_cast<double>(Q[k]));
  }
  while (R.denominator.size() > 1 && R.denominator.back() == 0) R.denominator.pop_back();
  return R;
}

/// R(z) of a row that has one; T: double or std::complex<double>.
template <class T>
T amplification(const Method& m, const T& z) {
  const auto at = [&z](std::span<const double> c) {
    T sum(0);
    for (std::size_t k = c.size(); k-- > 0;) sum = sum * z + c[k];
    return sum;
  };
  return m.stability_denominator.empty() ? at(m.stability_polynomial)
                                         : at(m.stability_polynomial) / at(m.stability_denominator);
}

}  // namespace polhode
