// What a scene file says, in 50 digits: the problem that the truth solves.
//
// Twice, because a truth has to prove itself: in principal axes, as the equations are solved, and as the file
// states it, in its own body axes, as they are checked (solvers/proof.hpp).
#pragma once
#include <optional>
#include <vector>

#include "models/scene.hpp"
#include "models/wide.hpp"

namespace polhode {

/// A load as the file states it: vectors in the user's body axes or in space.
struct StatedLoad {
  enum class Kind { gravity_about_pivot, drag, spring, body_torque, space_torque, gravity_gradient };
  Kind kind;
  Vec3T<Wide> vector = Vec3T<Wide>::Zero();  // acceleration (space) or torque
  Vec3T<Wide> center = Vec3T<Wide>::Zero();  // of mass, from the pivot
  Mat3T<Wide> matrix = Mat3T<Wide>::Zero();  // of the drag, N m s
  // Mass; stiffness and damping of a spring; mean motion.
  Wide number = Wide(0), damping = Wide(0);
  // Of a spring: turns the user's axes into those that the spring turns, where they are not the same.
  QuaternionT<Wide> frame{Wide(1), Wide(0), Wide(0), Wide(0)};
};

/// Which vector the file gives as the start of the rotation.
enum class StatedRates { body, space, momentum };

/// The rotation as the file states it, in the user's body axes ("_U").
struct StatedRotation {
  // kg m^2, about the centre of mass or the pivot; the inverse apart, as one moment may be tiny.
  Mat3T<Resolved> inertia_U, inverse_inertia_U;
  QuaternionT<Wide> q_SU;  // of any length
  StatedRates form = StatedRates::body;
  Vec3T<Wide> given = Vec3T<Wide>::Zero();  // w_U, w_S [rad/s] or L_S [kg m^2/s]
  std::vector<StatedLoad> loads;
  QuaternionT<Wide> principal_to_stated{Wide(1), Wide(0), Wide(0), Wide(0)};
};

struct ExactScene {
  std::optional<RotationDataT<Wide>> rotation;
  std::optional<TranslationDataT<Wide>> translation;
  std::optional<StatedRotation> stated;  // where there is a rotation
};

/// That of the file where the scene was read from one and its doubles are still those; else its doubles,
/// which then are the problem.
ExactScene exact_scene(const Scene& scene);

/// Do solvers start from other numbers than the truth, because doubles cannot hold them?
bool starts_rounded(const Scene& scene);

/// The same data in another number type, each number correctly rounded.
template <class To, class From>
RotationDataT<To> cast_rotation(const RotationDataT<From>& r) {
  RotationDataT<To> to;
  to.moments = r.moments.template cast<To>();
  to.principal_to_user = r.principal_to_user.template cast<To>();
  to.q0 = r.q0.template cast<To>();
  to.w0 = r.w0.template cast<To>();
  for (const auto& load : r.loads) to.loads.push_back(cast_load<To>(load));
  to.attitude = r.attitude;
  to.about_pivot = r.about_pivot;
  return to;
}
template <class To, class From>
TranslationDataT<To> cast_translation(const TranslationDataT<From>& t) {
  return {static_cast<To>(t.mass),  t.p0.template cast<To>(),
          t.v0.template cast<To>(), t.acceleration.template cast<To>(),
          static_cast<To>(t.drag),  t.has_force};
}

}  // namespace polhode
