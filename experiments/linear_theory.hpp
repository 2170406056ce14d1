// What linear theory says of a step size: the eigenvalues of a scene's Jacobian, and the region in which a
// method's stability function stays within one.
#pragma once
#include <complex>
#include <optional>
#include <vector>

#include "solvers/method.hpp"

namespace polhode {

/// The motion about which a scene is linearised, with the eigenvalues of its Jacobian there.
struct Linearised {
  bool at_rest;  // about the rest that drags and springs lead to; else about the initial state
  std::vector<std::complex<double>> eigenvalues;  // 1/s
  double fastest = 0;                             // largest modulus among them
  // About rest, where the fastest eigenvalue is real: the rates of its mode, of length 1, in the principal
  // frame, and the turn from rest that belongs to it, as the vector part of a quaternion.
  std::optional<Vec3> fast_rates;
  Vec3 fast_turn = Vec3::Zero();
};
Linearised linearised(const Scene& scene);

/// The attitude (principal to space) in which a scene of drags and springs is at rest.
Quaternion rest_attitude(const Scene& scene);

/// The first h in [low, high] beyond which |R(h lambda)|^2 exceeds one by more than growth_resolution for an
/// eigenvalue that is not ten times slower than the fastest: slow motions do not limit the step. Nothing if
/// it does not happen; low if it has happened there. Needs a method that has a stability function.
std::optional<double> theoretical_limit(const Method& method, const Linearised& scene, double low,
                                        double high);

}  // namespace polhode
