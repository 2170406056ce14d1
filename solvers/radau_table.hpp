// Radau IIA collocation with any number of stages: nodes, matrix, interpolation, computed in any number type.
//
// The nodes are the zeros of P_s - P_{s-1} on (0, 1] (Legendre, shifted); a_ij is the integral of the
// Lagrange polynomial of node j up to c_i, taken exactly by a Gauss rule. Order 2s - 1, L-stable. Source:
// Hairer & Wanner, Solving ODEs II (1996), IV.5.
#pragma once
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "models/landen.hpp"

namespace polhode {

template <class S>
struct RadauTable {
  int stages;
  std::vector<S> c;        // nodes, increasing; the last is 1
  std::vector<S> nodes;    // 0 and c: where the collocation polynomial is known
  std::vector<S> weights;  // barycentric, of `nodes`
  std::vector<S> lower;    // barycentric, of c alone
  Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic> a;
  double top = 1, next = 1;  // leading coefficients of the shifted Legendre polynomials of degrees s, s - 1

  explicit RadauTable(int s) : stages(s) {
    // The zeros of P_s - P_{s-1}, between those of P_s; by Newton's method with deflation, from the right.
    for (int i = 0; i < s; ++i) {
      S x = i == 0 ? S(1) : cosine(S(S(2 * i) / S(2 * s - 1)));
      for (int n = 0; n < 100 && i > 0; ++n) {
        S slope;
        const S value = difference(s, x, slope);
        S others(0);
        for (const S& found : c) others += S(1) / (x - (S(2) * found - S(1)));
        const S step = value / (slope - value * others);
        x -= step;
        using std::abs;
        if (abs(step) < std::numeric_limits<S>::epsilon()) break;
      }
      c.insert(c.begin(), S((x + S(1)) / S(2)));
    }
    nodes.push_back(S(0));
    nodes.insert(nodes.end(), c.begin(), c.end());
    weights = barycentric(nodes);
    lower = barycentric(c);
    std::vector<S> gauss_x, gauss_w;
    gauss((s + 1) / 2, gauss_x, gauss_w);
    a.resize(s, s);
    for (int i = 0; i < s; ++i)
      for (int j = 0; j < s; ++j) {
        S sum(0);
        for (std::size_t k = 0; k < gauss_x.size(); ++k) {
          S product(1);
          const S x = c[std::size_t(i)] * gauss_x[k];
          for (int l = 0; l < s; ++l)
            if (l != j) product *= (x - c[std::size_t(l)]) / (c[std::size_t(j)] - c[std::size_t(l)]);
          sum += gauss_w[k] * product;
        }
        a(i, j) = c[std::size_t(i)] * sum;
      }
    for (int k = 1; k <= s; ++k) {
      next = top;
      top *= (4.0 * k - 2) / k;
    }
  }

 private:
  static S cosine(const S& half_turns) {
    using std::cos;
    return cos(S(half_turns * half_turn<S>()));
  }
  /// P_s - P_{s-1} at x in [-1, 1], and its slope.
  static S difference(int s, const S& x, S& slope) {
    S before(1), p = x, before_slope(0), p_slope(1);
    for (int k = 2; k <= s; ++k) {
      const S next_p = (S(2 * k - 1) * x * p - S(k - 1) * before) / S(k);
      const S next_slope = (S(2 * k - 1) * (p + x * p_slope) - S(k - 1) * before_slope) / S(k);
      before = p;
      p = next_p;
      before_slope = p_slope;
      p_slope = next_slope;
    }
    slope = p_slope - before_slope;
    return p - before;
  }
  /// Gauss-Legendre rule with n points on [0, 1].
  static void gauss(int n, std::vector<S>& x, std::vector<S>& w) {
    for (int i = 0; i < n; ++i) {
      S z = cosine(S(S(4 * i + 3) / S(4 * n + 2))), slope;
      for (int k = 0; k < 100; ++k) {
        S before(1), p = z;
        for (int l = 2; l <= n; ++l) {
          const S next_p = (S(2 * l - 1) * z * p - S(l - 1) * before) / S(l);
          before = p;
          p = next_p;
        }
        slope = n == 1 ? S(1) : S(S(n) * (before - z * p) / (S(1) - z * z));
        const S step = p / slope;
        z -= step;
        using std::abs;
        if (abs(step) < std::numeric_limits<S>::epsilon()) break;
      }
      x.push_back((z + S(1)) / S(2));
      w.push_back(S(1) / ((S(1) - z * z) * slope * slope));
    }
  }
  static std::vector<S> barycentric(const std::vector<S>& x) {
    std::vector<S> w;
    for (std::size_t i = 0; i < x.size(); ++i) {
      S product(1);
      for (std::size_t j = 0; j < x.size(); ++j)
        if (j != i) product *= x[i] - x[j];
      w.push_back(S(1) / product);
    }
    return w;
  }
};

}  // namespace polhode
