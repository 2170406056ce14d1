// On which side of its separatrix is a free body, and how near?
#pragma once
#include <type_traits>

#include "models/attitude.hpp"
#include "models/double_double.hpp"

namespace polhode {

/// The type in which a sum of products of five numbers of type S is exact; wide types specialise it.
template <class S>
struct ExactProducts;

/// L^2 - 2 E I_mid = I_max (I_max - I_mid) w_max^2 - I_min (I_mid - I_min) w_min^2, which cancels near the
/// separatrix: to 1e-32 of a term for doubles, exactly for wider types.
///
/// I                    moments [kg m^2], increasing
/// w_least, w_largest   rates about the axes of the least and of the largest [rad/s]
/// returns              positive where the polhode goes round the axis of the largest moment
template <class S>
S momentum_excess(const Vec3T<S>& I, const S& w_least, const S& w_largest) {
  if constexpr (std::is_floating_point_v<S>) {
    const auto product = [](const S& outer, const S& middle, const S& rate) {
      const DoubleDouble w{static_cast<double>(rate)},
          d = DoubleDouble{static_cast<double>(outer)} + DoubleDouble{-static_cast<double>(middle)};
      return DoubleDouble{static_cast<double>(outer)} * d * (w * w);
    };
    const DoubleDouble d = product(I[2], I[1], w_largest) + product(I[0], I[1], w_least);
    return static_cast<S>(d.high) + static_cast<S>(d.low);
  } else {
    using Exact = typename ExactProducts<S>::Type;
    const Exact a(I[0]), b(I[1]), c(I[2]), u(w_least), v(w_largest);
    return static_cast<S>(Exact(c * (c - b) * v * v - a * (b - a) * u * u));
  }
}

}  // namespace polhode
