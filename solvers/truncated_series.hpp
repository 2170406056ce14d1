// A number that knows its first three derivatives in time: c0 + c1 s + c2 s^2 + c3 s^3, truncated.
//
// For methods that ask for derivatives of a torque: the loads are templates of their number type. Longer
// series are the business of models/jet.hpp, which records once and allocates; here each operation is a few
// products.
#pragma once
#include <array>
#include <cmath>

#include <Eigen/Core>

namespace polhode {

class TruncatedSeries {
 public:
  static constexpr int terms = 4;

  TruncatedSeries() = default;
  TruncatedSeries(double constant) : c_{constant} {}  // NOLINT(google-explicit-constructor): numbers convert

  double operator[](int k) const { return c_[static_cast<std::size_t>(k)]; }
  double& operator[](int k) { return c_[static_cast<std::size_t>(k)]; }

  friend TruncatedSeries operator+(TruncatedSeries a, const TruncatedSeries& b) { return a += b; }
  friend TruncatedSeries operator-(TruncatedSeries a, const TruncatedSeries& b) { return a -= b; }
  friend TruncatedSeries operator-(const TruncatedSeries& a) { return TruncatedSeries() -= a; }
  friend TruncatedSeries operator*(const TruncatedSeries& a, const TruncatedSeries& b) {
    TruncatedSeries r;
    for (int k = 0; k < terms; ++k)
      for (int j = 0; j <= k; ++j) r[k] += a[j] * b[k - j];
    return r;
  }
  friend TruncatedSeries operator/(const TruncatedSeries& a, const TruncatedSeries& b) {
    TruncatedSeries r;  // r b = a
    for (int k = 0; k < terms; ++k) {
      double rest = a[k];
      for (int j = 0; j < k; ++j) rest -= r[j] * b[k - j];
      r[k] = rest / b[0];
    }
    return r;
  }
  TruncatedSeries& operator+=(const TruncatedSeries& b) {
    for (int k = 0; k < terms; ++k) (*this)[k] += b[k];
    return *this;
  }
  TruncatedSeries& operator-=(const TruncatedSeries& b) {
    for (int k = 0; k < terms; ++k) (*this)[k] -= b[k];
    return *this;
  }
  TruncatedSeries& operator*=(const TruncatedSeries& b) { return *this = *this * b; }

  friend TruncatedSeries sqrt(const TruncatedSeries& a) {
    TruncatedSeries r;  // r r = a
    r[0] = std::sqrt(a[0]);
    for (int k = 1; k < terms; ++k) {
      double rest = a[k];
      for (int j = 1; j < k; ++j) rest -= r[j] * r[k - j];
      r[k] = rest / (2 * r[0]);
    }
    return r;
  }
  friend TruncatedSeries sin(const TruncatedSeries& a) { return circular(a, true); }
  friend TruncatedSeries cos(const TruncatedSeries& a) { return circular(a, false); }
  /// A step function has no derivatives but zero.
  friend TruncatedSeries sign_of(const TruncatedSeries& a) { return a[0] < 0 ? -1.0 : 1.0; }

 private:
  static TruncatedSeries circular(const TruncatedSeries& a, bool sine) {
    TruncatedSeries s(std::sin(a[0])), c(std::cos(a[0]));  // s' = a' c, c' = -a' s
    for (int k = 1; k < terms; ++k)
      for (int j = 1; j <= k; ++j) {
        s[k] += j * a[j] * c[k - j] / k;
        c[k] -= j * a[j] * s[k - j] / k;
      }
    return sine ? s : c;
  }

  std::array<double, terms> c_{};
};

}  // namespace polhode

namespace Eigen {
template <>
struct NumTraits<polhode::TruncatedSeries> : GenericNumTraits<polhode::TruncatedSeries> {
  using Real = polhode::TruncatedSeries;
  using NonInteger = polhode::TruncatedSeries;
  using Nested = polhode::TruncatedSeries;
  using Literal = polhode::TruncatedSeries;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 4,
    AddCost = 4,
    MulCost = 16
  };
};
}  // namespace Eigen
