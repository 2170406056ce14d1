// Sums of two doubles, where one is not enough: exact products and sums, kept as a high and a low word.
// Source: Dekker, Numer. Math. 18 (1971); Knuth, The Art of Computer Programming 2, 4.2.2.
#pragma once
#include <cmath>

namespace polhode {

/// high + low, with |low| at most half a unit in the last place of high: 32 digits.
struct DoubleDouble {
  double high = 0, low = 0;
};

inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const double s = a.high + b.high, bb = s - a.high;
  const double low = ((a.high - (s - bb)) + (b.high - bb)) + (a.low + b.low);
  const double high = s + low;
  return {high, low - (high - s)};
}
inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double p = a.high * b.high;
  const double low = std::fma(a.high, b.high, -p) + (a.high * b.low + a.low * b.high);
  const double high = p + low;
  return {high, low - (high - p)};
}

}  // namespace polhode
