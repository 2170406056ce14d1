// From a state vector to a sample: what a run reports at an asked time.
#pragma once
#include <cmath>

#include "models/body.hpp"
#include "solvers/method.hpp"

namespace polhode {

/// The sample of a state [q][w_B][p v] at time t.
/// Out of line: it is called at asked times only, from several places of every solver.
template <AnyModel M>
[[gnu::noinline]] Sample observe(const M& m, double t, const double* y) {
  Sample s;
  s.t = t;
  if constexpr (M::has_attitude) {
    s.q = m.rotation.attitude_of(y);
    s.unit_defect = std::abs(std::sqrt(squared_norm(s.q)) - 1);
  }
  if constexpr (M::has_rotation) {
    s.w_B = m.rotation.w_of(y);
    s.L = m.angular_momentum(y);
  }
  if constexpr (M::has_translation) {
    s.p = m.position(y);
    s.v = m.velocity(y);
  }
  s.rotational_energy = m.rotational_energy(y);
  s.total_energy = s.rotational_energy + m.other_energy(t, y);
  return s;
}

}  // namespace polhode
