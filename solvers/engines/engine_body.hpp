// What an engine is told of a scene, and what it is asked for: one rigid body as plain numbers.
//
// An engine reads its body at run time anyway, so nothing here is a type of the scene's own. C++17: one
// engine's headers are not C++20.
#pragma once
#include <functional>

#include "models/attitude.hpp"

namespace polhode {

/// The body at the start, in principal axes ("_B") and space ("_S").
struct EngineBody {
  bool rotates = false, moves = false;  // a particle does not rotate, a body at a pivot does not move
  double mass = 1;                      // kg; of a body that does not move: any will do
  Vec3 moments = Vec3::Ones();          // kg m^2, about the pivot if it is held at one
  Vec3 gravity_S = Vec3::Zero();        // m/s^2
  double drag = 0;                      // kg/s
  Quaternion q0{1, 0, 0, 0};            // of unit length
  Vec3 w0_B = Vec3::Zero(), p0_S = Vec3::Zero(), v0_S = Vec3::Zero();
  // Sum of the torques [N m, space] at (t, R_SB, w_S); empty if there is none.
  std::function<Vec3(double t, const Mat3& R, const Vec3& w_S)> torque_S;

  /// Is there an (I w) x w?
  bool has_gyroscopic_term() const {
    return rotates && !(moments.x() == moments.y() && moments.y() == moments.z());
  }
  bool has_force() const { return drag != 0 || gravity_S != Vec3::Zero(); }
};

/// Where the engine has it. Parts that the body lacks are not looked at.
struct EngineState {
  Quaternion q{1, 0, 0, 0};
  Vec3 w_B = Vec3::Zero(), p_S = Vec3::Zero(), v_S = Vec3::Zero();
  double unit_defect = 0;  // of what the engine itself stores: abs(|q| - 1) or |R^T R - 1|_F
};

}  // namespace polhode
