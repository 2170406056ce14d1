// What every truth does with its states: samples, and the difference of two runs as uncertainty.
#pragma once
#include "models/model.hpp"
#include "solvers/reference.hpp"

namespace polhode {

template <class M>
WideSample wide_sample(const M& m, const Wide& t, const typename M::State& y) {
  WideSample s;
  s.t = t;
  if constexpr (M::has_attitude) s.q = normalised<Wide>(m.rotation.attitude_of(y.data()));
  if constexpr (M::has_rotation) {
    s.w_B = m.rotation.w_of(y.data());
    s.L = m.angular_momentum(y.data());
  }
  if constexpr (M::has_translation) {
    s.p = m.position(y.data());
    s.v = m.velocity(y.data());
  }
  s.rotational_energy = m.rotational_energy(y.data());
  s.total_energy = m.total_energy(t, y.data());
  return s;
}

/// The stated uncertainty becomes the difference of sample i to (q, w_B), where that is larger. Rates below
/// 1e-30 of the fastest count as zero.
inline void widen_uncertainty(Truth& truth, std::size_t i, const QuaternionT<Wide>& q,
                              const Vec3T<Wide>& w_B) {
  const WideSample& s = truth.samples[i];
  truth.attitude_uncertainty =
      std::max(truth.attitude_uncertainty, attitude_error<Wide>(s.q, q).convert_to<double>());
  Wide scale = s.w_B.norm();
  for (const WideSample& other : truth.samples) scale = std::max(scale, Wide(Wide(1e-30) * other.w_B.norm()));
  if (scale > 0)
    truth.rate_uncertainty =
        std::max(truth.rate_uncertainty, Wide((s.w_B - w_B).norm() / scale).convert_to<double>());
}

}  // namespace polhode
