// A second way to the motion of a scene, for a short stretch: what a truth is checked against.
//
// Nothing is shared with what finds the truth. The state is attitude and angular momentum in space, in the
// file's own body axes, w = I^-1 R^T L with the full tensor; torques are written as in the lecture notes:
//   q' = 1/2 q (0, w_U),   L' = sum tau_S,   p' = v,   v' = g - (b/m) v
// and are integrated by extrapolation of the modified midpoint rule (Gragg, Bulirsch & Stoer) in 100 digits.
// Source: Hairer, Norsett & Wanner, Solving ODEs I (1993), II.9.
#pragma once
#include <array>

#include "models/exact_scene.hpp"
#include "solvers/reference.hpp"

namespace polhode {

using Checked = Decimal<100>;

/// A state in the file's own body axes.
struct StatedState {
  // q_SU (4), L_S (3; L_U where the scene has no attitude), p_S (3), v_S (3)
  std::array<Checked, 13> x{};

  QuaternionT<Checked> q() const { return {x[0], x[1], x[2], x[3]}; }
  Vec3T<Checked> L() const { return {x[4], x[5], x[6]}; }
  Vec3T<Checked> p() const { return {x[7], x[8], x[9]}; }
  Vec3T<Checked> v() const { return {x[10], x[11], x[12]}; }
};

class SecondMethod {
 public:
  explicit SecondMethod(const ExactScene& exact);

  /// What the file says of t = 0.
  StatedState start() const;
  /// A sample of the truth, whose attitude and rates are in principal axes.
  StatedState stated(const WideSample& sample) const;

  Vec3T<Checked> rates_U(const StatedState& s) const;
  Checked rotational_energy(const StatedState& s) const;
  /// Of the loads that have one, at time t.
  Checked potential_energy(const Checked& t, const StatedState& s) const;
  /// How fast the state turns or decays [1/s]; 0 where nothing happens.
  double pace(const StatedState& s) const;

  struct Reached {
    StatedState state;
    double attitude_error = 0, rate_error = 0, way_error = 0;  // estimates: rad, relative, relative
  };
  /// From time t over h (of either sign), by `rows` rows of extrapolation. `side` is the sign that springs
  /// hold, of q_w.
  Reached reached(const Checked& t, const StatedState& from, const Checked& h, int rows) const;
  /// The sign of q_w of a spring's axes, and where it is zero that of its change; +1 where that is zero, too.
  int side(const StatedState& s, bool backward) const;

 private:
  using Values = std::array<Checked, 13>;
  Values slope(const Checked& t, const Values& x, int side) const;
  Vec3T<Checked> torque_S(const Checked& t, const Values& x, const Mat3T<Checked>& R,
                          const Vec3T<Checked>& w_U, int side) const;

  bool rotates_ = false, oriented_ = false, moves_ = false;
  StatedRotation stated_;
  Mat3T<Checked> inertia_, inverse_;
  QuaternionT<Checked> to_stated_;
  TranslationDataT<Checked> translation_;
};

/// What the rates of a scene are measured by where it is at rest: those that its loads could bring about in a
/// radian or so [rad/s].
double natural_rate(const ExactScene& exact);

}  // namespace polhode
