// Scenes whose motion can be written down: the closed form of each, in any number type.
//
//   free body                      theta functions (models/free_rotation.hpp)
//   drag proportional to inertia   c_i = kappa I_i: L_B is that of the free body at the time
//                                  s = (1 - exp(-kappa t))/kappa, times exp(-kappa t)
//   about one principal axis       with drag and a torque along it: I w' = tau - c w
//   attitude spring, planar        the half-angle is a pendulum: phi'' = -(k/I) sin phi
//   gravity gradient, planar       twice the angle from the local vertical is one, with 3 n^2 (I2 - I1)/I3
//   centre of mass                 weight and linear drag: v' = g - gamma v
#pragma once
#include <memory>
#include <string>

#include "models/scene.hpp"

namespace polhode {

/// The exact state at one time. Parts that the scene lacks keep their defaults.
template <class S>
struct ExactState {
  QuaternionT<S> q{S(1), S(0), S(0), S(0)};  // principal -> space, unit
  Vec3T<S> w_B{S(0), S(0), S(0)};            // rad/s, principal components
  Vec3T<S> p{S(0), S(0), S(0)}, v{S(0), S(0), S(0)};
};

/// The motion of a scene.
template <class S>
class ClosedForm {
 public:
  virtual ~ClosedForm() = default;
  /// Computes its constants once more from the scene: what a run from the start costs.
  virtual void set_up() = 0;
  /// t may be negative, except with drag so strong that the past overflows.
  virtual ExactState<S> at(const S& t) const = 0;
};

/// What the closed form of a scene is, in words; empty if it has none that we know.
std::string closed_form_kind(const Scene& scene);

/// The closed form in S; null if there is none. In double of the doubles that solvers start from, in a wide
/// type of what the file says (models/exact_scene.hpp).
template <class S>
std::unique_ptr<ClosedForm<S>> closed_form(const Scene& scene);
template <>
std::unique_ptr<ClosedForm<double>> closed_form(const Scene& scene);

/// In doubles from constants of extended precision, where that is worth something: the triaxial free body.
std::unique_ptr<ClosedForm<double>> closed_form_extended(const Scene& scene);

}  // namespace polhode
