// Jacobi's elliptic functions of one parameter, and the argument at which they have given values, in any
// number type. By Landen's transformation (models/landen.hpp): exact at quarter periods, where a library's
// functions need not be. Source: DLMF 22.20(ii).
#pragma once
#include <cmath>

#include "models/landen.hpp"

namespace polhode {

template <class S>
class JacobiFunctions {
 public:
  struct Values {
    S sn, cn, dn;
  };

  /// m    the parameter k^2, in [0, 1)
  /// m1   1 - m > 0, given apart because it may be tiny
  JacobiFunctions(const S& m, const S& m1) : m1_(m1), mean_(root(m1), m) {}

  Values at(const S& u) const {
    using std::cos;
    using std::sin;
    const S phi = mean_.amplitude(u);
    const S sn = sin(phi), cn = cos(phi);
    return {sn, cn, root(cn * cn + m1_ * sn * sn)};
  }

  /// u in [-2 K, 2 K] with sn u and cn u in the ratio given.
  S argument(const S& sn, const S& cn) const {
    const S u = mean_.circular(sn, cn < S(0) ? S(-cn) : cn) / mean_.limit();
    if (!(cn < S(0))) return u;
    return (sn < S(0) ? S(-1) : S(1)) * S(2) * quarter_period() - u;
  }

  /// K
  S quarter_period() const { return half_turn<S>() / (S(2) * mean_.limit()); }

 private:
  static S root(const S& x) {
    using std::sqrt;
    return S(sqrt(x));
  }

  S m1_;
  LandenMean<S> mean_;
};

}  // namespace polhode
