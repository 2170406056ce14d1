// DART: minimal coordinates, semi-implicit Euler, the velocity in body components.
//   w_B <- w_B + h I^-1((I w_B) x w_B + tau_B),   R <- R exp(h w_B) with the new w,   and so for v and p
// Order 1. The attitude is stored as a rotation vector, so it is one exactly; each step takes its exponential
// and the logarithm of the result. On a free body the step is Bullet's explicit one. Momentum and energy
// drift.
//
// The body hangs on a free joint, on a ball joint where the scene has no translation, on a translational
// joint if it is a particle, in a World with its constraint solver. The defaults are used: no damping, no
// sleep, no limit on speed. DART's assertions abort the program on a number that is not finite: a body that
// turns or moves faster than 1e10 ends the run as `diverged` before it gets there. Steps must be positive.
//
// Must be compiled with the alignment of Eigen that DART was: no -march of this machine's own, or with
// EIGEN_MAX_ALIGN_BYTES=16.
//
// Source: DART 6.12, World::step, FreeJoint::integratePositions; Lee et al., DART: Dynamic Animation and
// Robotics Toolkit, JOSS 3 (2018).
#include <memory>

#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/TranslationalJoint.hpp>
#include <dart/simulation/World.hpp>

#include "solvers/engines/engine_run.hpp"

namespace polhode {
namespace {

constexpr Met too_fast = {Outcome::diverged,
                          "a velocity beyond 1e10, soon after which DART aborts the program"};

class Dart {
 public:
  struct Choice {};
  Dart(const EngineBody& b, Choice) : b_(b), world_(dart::simulation::World::create()) {
    const auto skeleton = dart::dynamics::Skeleton::create();
    joint_and_body(skeleton);
    dart::dynamics::Inertia inertia;
    inertia.setMass(b.mass);
    inertia.setMoment(b.moments.x(), b.moments.y(), b.moments.z(), 0, 0, 0);
    body_->setInertia(inertia);
    world_->setGravity(b.gravity_S);
    world_->addSkeleton(skeleton);
  }

  void restart() {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    const Mat3 R = rotation_matrix(b_.q0);
    pose.linear() = R;
    pose.translation() = b_.p0_S;
    if (!b_.rotates) {
      joint_->setPositions(b_.p0_S);
      joint_->setVelocities(b_.v0_S);
    } else if (!b_.moves) {
      joint_->setPositions(dart::dynamics::BallJoint::convertToPositions(R));
      joint_->setVelocities(b_.w0_B);
    } else {
      joint_->setPositions(dart::dynamics::FreeJoint::convertToPositions(pose));
      Eigen::Matrix<double, 6, 1> velocity;
      velocity << b_.w0_B, R.transpose() * b_.v0_S;
      joint_->setVelocities(velocity);
    }
    body_->clearExternalForces();
  }
  Met set_step(double h) {
    if (!(h > 0)) return {Outcome::solver_failed, "DART takes steps forward only"};
    world_->setTimeStep(h);
    return {};
  }
  static std::int64_t rhs_evals(std::int64_t steps) { return steps; }

  Met step(double t) {
    if (!(joint_->getVelocities().cwiseAbs().maxCoeff() < fastest_for_assertions)) return too_fast;
    if (b_.torque_S)
      body_->addExtTorque(b_.torque_S(t, body_->getWorldTransform().linear(), body_->getAngularVelocity()),
                          false);
    if (b_.drag != 0) body_->addExtForce(-b_.drag * body_->getLinearVelocity(), Vec3::Zero(), false, true);
    world_->step();
    return {};
  }

  EngineState state() const {
    const Eigen::Isometry3d& pose = body_->getWorldTransform();
    const Mat3 R = pose.linear();
    return {quaternion_of(R), R.transpose() * body_->getAngularVelocity(), pose.translation(),
            body_->getLinearVelocity(), (R.transpose() * R - Mat3::Identity()).norm()};
  }

 private:
  void joint_and_body(const dart::dynamics::SkeletonPtr& skeleton) {
    const auto make = [&](auto* joint) {
      std::tie(joint, body_) = skeleton->createJointAndBodyNodePair<std::remove_pointer_t<decltype(joint)>>();
      joint_ = joint;
    };
    if (!b_.rotates)
      make(static_cast<dart::dynamics::TranslationalJoint*>(nullptr));
    else if (!b_.moves)
      make(static_cast<dart::dynamics::BallJoint*>(nullptr));
    else
      make(static_cast<dart::dynamics::FreeJoint*>(nullptr));
  }

  const EngineBody& b_;
  dart::simulation::WorldPtr world_;
  dart::dynamics::Joint* joint_ = nullptr;
  dart::dynamics::BodyNode* body_ = nullptr;
};

Prepared prepare(const Scene& scene, const Setting& setting) { return run_engine<Dart>(scene, setting, {}); }

}  // namespace
}  // namespace polhode

const std::size_t polhode_engine_stamp = polhode::engine_stamp;

const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static const Method methods[] = {
      {.id = "dart",
       .family = "engine",
       .summary = "DART, semi-implicit Euler in joint coordinates; on a free body Bullet's explicit step",
       .source = "DART, World::step; Lee et al., JOSS 3 (2018)",
       .version = "DART " DART_VERSION,
       .settings = "the defaults: no damping, no sleep, no limit on speed",
       .by_steps = true,
       .in_studies = false,
       .claims = {.attitude_order = 1,
                  .rate_order = 1,
                  .energy_order = 1,
                  .momentum_order = 1,
                  .unit_attitude = Claim::yes,
                  .momentum_magnitude = Claim::no,
                  .space_momentum = Claim::no,
                  .energy_bounded = Claim::no},  // reversible: it takes no step back
       .prepare = prepare}};
  static const MethodRows rows = methods;
  return &rows;
}
