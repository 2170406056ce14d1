// The Newton-Euler equations as lecture notes on rigid-body dynamics state them, in space components:
//
//   particle     (p, v):  sum F = m v'
//   rigid body   (p, v, R, w):  R' = [w]x R,  I = R I_B R^T,  L = I w,  sum tau = w x I w + I w'
//   both at once [m 1  0; 0  I] (a, w') = (F, tau - w x I w)
//
// Nothing is reduced or simplified here; the tests hold these forms against the reduced ones in
// models/body.hpp.
#pragma once
#include <Eigen/LU>

#include "models/attitude.hpp"

namespace polhode {

/// Inertia tensor in space components [kg m^2] of a body turned by R, which need not be orthogonal to
/// rounding.
inline Mat3 inertia_S(const Mat3& R, const Vec3& moments) { return R * moments.asDiagonal() * R.transpose(); }

/// Angular momentum in space components: L = I w [kg m^2/s].
inline Vec3 angular_momentum_S(const Mat3& I_S, const Vec3& w_S) { return I_S * w_S; }

/// Linear momentum m v [kg m/s].
inline Vec3 linear_momentum(double mass, const Vec3& v) { return mass * v; }

/// Torque about the centre of mass of a force F at r: r x F [N m].
inline Vec3 torque_of_force(const Vec3& r, const Vec3& F) { return r.cross(F); }

/// Velocity of a point of the body at r from the centre of mass: v + w x r [m/s].
inline Vec3 point_velocity(const Vec3& v, const Vec3& w_S, const Vec3& r) { return v + w_S.cross(r); }

/// w' from tau = w x I w + I w', with the true inverse of the matrix I [rad/s^2].
inline Vec3 angular_acceleration_S(const Mat3& I_S, const Vec3& w_S, const Vec3& tau_S) {
  return I_S.inverse() * (tau_S - w_S.cross(I_S * w_S));
}

struct Acceleration {
  Vec3 linear;   // a, m/s^2
  Vec3 angular;  // w', rad/s^2
};

/// Solves the 6x6 block system [m 1  0; 0  I](a, w') = (F, tau - w x I w) as it stands, by LU of the whole
/// matrix.
inline Acceleration newton_euler(double mass, const Mat3& I_S, const Vec3& w_S, const Vec3& F,
                                 const Vec3& tau_S) {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  A.topLeftCorner<3, 3>() = mass * Mat3::Identity();
  A.bottomRightCorner<3, 3>() = I_S;
  Eigen::Matrix<double, 6, 1> b;
  b << F, tau_S - w_S.cross(I_S * w_S);
  const Eigen::Matrix<double, 6, 1> x = A.partialPivLu().solve(b);
  return {x.head<3>(), x.tail<3>()};
}

}  // namespace polhode
