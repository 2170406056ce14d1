// Bullet: the rigid body of a game engine, semi-implicit Euler in space components with the gyroscopic term
// as a flag.
//   w_S <- w_S + h I_S^-1 tau_S + d,   R <- exp(h w_S) R,   v <- v + h F/m,   p <- p + h v    (new w_S and v)
// with the gyroscopic part d of the change, f(w) = w x (I w):
//   none            d = 0: another differential equation, whose energy is kept and whose body never tumbles
//   explicit        d = -h I_S^-1 f(w_S), the torque f cut at 100 N m
//   implicit-world  d = one Newton step of I (w' - w) + h f(w') = 0 from w' = w, in space components
//   implicit-body   the same in body components, turned back by the old attitude (Bullet's default)
// Order 1 but for `none`, which converges to the wrong motion. The attitude is a matrix, rebuilt from a
// normalised quaternion every step, so it stays a rotation to rounding; momentum and energy drift.
//
// These rows step a btRigidBody alone, without world, collision shape or constraint solver, by exactly the
// arithmetic that btDiscreteDynamicsWorld::stepSimulation(h, 0, h) performs on one free body; in Bullet the
// gyroscopic part lives inside the constraint solver, so the public predictIntegratedTransform alone would
// lack it. Three more rows have a whole world around the body:
//   world           implicit-body in that world (same results to the last bit), to show what it costs
//   multibody       btMultiBody, the body as a tree in reduced coordinates: explicit, in body components
//   defaults        as shipped, world or multibody: stepSimulation(h), which takes steps of 1/60 s whatever h
//   is
//
// What a user would trip over is set in all but the defaults: no deactivation (slow bodies fall asleep after
// 2 s), no damping, one substep. What cannot be switched off ends the run as `clamped`: the rotation per step
// is cut at pi/4 without touching w, and the torque of `explicit` at 100 N m. Below |w| = 0.001 rad/s Bullet
// takes a series for sin.
//
// This file is compiled twice, against Bullet in double and in single precision (ids with the suffix -f32);
// the loads and the samples are in double in both. The two modules live in one process. Statics of Bullet's
// inline functions (btTransform::getIdentity) must not be used here: the linker makes them one per process,
// RTLD_LOCAL or not, and they differ in size between the two.
//
// Source: Bullet 3.24, btTransformUtil.h, btRigidBody.h (implicit-body is Catto's, Numerical methods, Game
// Developers Conference 2015; implicit-world Ewert's), btSequentialImpulseConstraintSolver,
// btDiscreteDynamicsWorld, btMultiBody, btMultiBodyDynamicsWorld.
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <btBulletDynamicsCommon.h>

#include "solvers/engines/engine_run.hpp"

namespace polhode {
namespace {

constexpr bool single_precision = sizeof(btScalar) == sizeof(float);
constexpr int no_gyroscopic_term = 0;
constexpr double substep_of_defaults = 1.0 / 60;  // s

btVector3 to_bullet(const Vec3& a) { return {btScalar(a.x()), btScalar(a.y()), btScalar(a.z())}; }
Vec3 from_bullet(const btVector3& a) { return {a.x(), a.y(), a.z()}; }
Mat3 from_bullet(const btMatrix3x3& a) {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.row(i) = from_bullet(a[i]);
  return m;
}
Quaternion from_bullet(const btQuaternion& q) { return Quaternion(q.w(), q.x(), q.y(), q.z()); }

/// Mass and inertia as Bullet takes them. A body without translation has mass 1: Bullet leaves the gyroscopic
/// part out of a body without mass. A particle gets no inertia, which Bullet holds still.
btRigidBody::btRigidBodyConstructionInfo construction(const EngineBody& b, btCollisionShape* shape) {
  return {btScalar(b.mass), nullptr, shape, b.rotates ? to_bullet(b.moments) : btVector3(0, 0, 0)};
}

/// The flag of the body: a sphere and a particle need no gyroscopic part.
int flag_for(const EngineBody& b, int mode) { return b.has_gyroscopic_term() ? mode : no_gyroscopic_term; }

btTransform start_pose(const EngineBody& b) {
  btTransform pose;
  pose.setIdentity();
  const Quaternion& q = b.q0;
  if (b.rotates)
    pose.setRotation(btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())));
  pose.setOrigin(to_bullet(b.p0_S));
  return pose;
}
btVector3 start_rate(const EngineBody& b) { return to_bullet(to_space<double>(b.q0, b.w0_B)); }

void put_at_start(const EngineBody& b, btRigidBody& body) {
  if (b.rotates) body.setAngularVelocity(start_rate(b));
  body.setLinearVelocity(to_bullet(b.v0_S));
  body.setCenterOfMassTransform(start_pose(b));  // brings the inertia in space components up to date, too
  body.clearForces();
}

/// Torque and drag at the start of the step, given to Bullet as any program that uses it would.
void apply_loads(const EngineBody& b, double t, btRigidBody& body) {
  if (b.torque_S)
    body.applyTorque(to_bullet(b.torque_S(t, from_bullet(body.getCenterOfMassTransform().getBasis()),
                                          from_bullet(body.getAngularVelocity()))));
  if (b.drag != 0) body.applyCentralForce(body.getLinearVelocity() * btScalar(-b.drag));
}

constexpr Met rotation_cut = {Outcome::clamped,
                              "a rotation of more than pi/4 in a step, which Bullet cuts to pi/4"};
constexpr Met torque_cut = {Outcome::clamped,
                            "a gyroscopic torque of more than 100 N m, which Bullet cuts to 100 N m"};
constexpr Met fell_asleep = {
    Outcome::asleep, "Bullet put the slow body to sleep and its velocities to zero, as it does by default"};

/// Bullet cuts the rotation of a step at pi/4, silently.
bool is_clipped(const btVector3& w, btScalar h) {
  const btScalar limit = ANGULAR_MOTION_THRESHOLD;
  return w.length2() * (h * h) > limit * limit;
}

Met standing_still(btScalar h) {
  return btFuzzyZero(h)
             ? Met{Outcome::solver_failed, "a step size below Bullet's epsilon, at which it stands still"}
             : Met{};
}

/// What Bullet stores is the matrix, so its defect is the one that counts; q by Bullet's own conversion.
EngineState state_of(const btRigidBody& body) {
  const btTransform& pose = body.getCenterOfMassTransform();
  const Mat3 R = from_bullet(pose.getBasis());
  return {from_bullet(pose.getRotation()), R.transpose() * from_bullet(body.getAngularVelocity()),
          from_bullet(pose.getOrigin()), from_bullet(body.getLinearVelocity()),
          (R.transpose() * R - Mat3::Identity()).norm()};
}

/// The body alone.
class Alone {
 public:
  using Choice = int;  // the gyroscopic mode
  static std::int64_t rhs_evals(std::int64_t steps) { return steps; }
  Alone(const EngineBody& b, int mode)
      : b_(b), flag_(flag_for(b, mode)), forced_(b.has_force()), body_(construction(b, nullptr)) {
    body_.setGravity(to_bullet(b.gravity_S));
  }
  void restart() { put_at_start(b_, body_); }
  Met set_step(double h) { return standing_still(h_ = btScalar(h)); }
  EngineState state() const { return state_of(body_); }

  Met step(double t) {
    const bool loaded = static_cast<bool>(b_.torque_S);
    const btScalar h = h_;
    if (loaded || forced_) apply_loads(b_, t, body_);
    if (forced_) {
      body_.applyGravity();
      body_.setLinearVelocity(body_.getLinearVelocity() + body_.getTotalForce() * body_.getInvMass() * h);
    }
    btTransform& pose = body_.getWorldTransform();
    if (!b_.rotates) {
      pose.setOrigin(pose.getOrigin() + body_.getLinearVelocity() * h);
    } else {
      btVector3 change(0, 0, 0);  // of the angular velocity; products in the order of the constraint solver
      if (loaded) change = body_.getTotalTorque() * body_.getInvInertiaTensorWorld() * h;
      if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) {
        change += body_.computeGyroscopicImpulseImplicit_Body(h);
      } else if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) {
        change += body_.computeGyroscopicImpulseImplicit_World(h);
      } else if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT) {
        const btVector3 torque = body_.computeGyroscopicForceExplicit(BT_LARGE_FLOAT);
        if (torque.length2() > torque_limit_ * torque_limit_) return torque_cut;
        change -= torque * body_.getInvInertiaTensorWorld() * h;
      }
      const btVector3 w = body_.getAngularVelocity() + change;
      body_.setAngularVelocity(w);
      if (is_clipped(w, h)) return rotation_cut;
      btTransformUtil::integrateTransform(pose, body_.getLinearVelocity(), w, h, pose);
      if (loaded || flag_ == BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT) body_.updateInertiaTensor();
    }
    if (loaded || forced_) body_.clearForces();
    return {};
  }

 private:
  const btScalar torque_limit_ = btContactSolverInfo().m_maxGyroscopicForce;
  const EngineBody& b_;
  int flag_;
  bool forced_;
  btScalar h_ = 0;
  btRigidBody body_;
};

/// Bullet's usual parts, which a world is made of and which outlive it.
template <class ConstraintSolver>
struct Parts {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  ConstraintSolver constraint_solver;
};

/// A world for one body: as shipped (defaults), or in one step of the size that is asked.
template <class World, class ConstraintSolver>
class Surroundings : private Parts<ConstraintSolver>, public World {
 public:
  explicit Surroundings(bool defaults)
      : World(&this->dispatcher, &this->broadphase, &this->constraint_solver, &this->configuration),
        defaults_(defaults) {}
  void restart() { World::m_localTime = 0; }

  Met set_step(double h) {
    h_ = btScalar(h);
    // To the rounding of its clock: stepSimulation(1/60) is one substep.
    if (defaults_ && h > substep_of_defaults * (1 + 4 * std::numeric_limits<btScalar>::epsilon()))
      return {Outcome::clamped, "a step of more than 1/60 s, of which Bullet by default takes 1/60 s alone"};
    return standing_still(h_);
  }
  void advance() { substeps_ += defaults_ ? World::stepSimulation(h_) : World::stepSimulation(h_, 0, h_); }
  /// Steps that Bullet has taken since the last call.
  std::int64_t substeps() { return std::exchange(substeps_, 0); }
  Met cut(const btVector3& w) const {
    return is_clipped(w, defaults_ ? btScalar(substep_of_defaults) : h_) ? rotation_cut : Met{};
  }

 private:
  bool defaults_;
  btScalar h_ = 0;
  std::int64_t substeps_ = 0;
};

/// The body in a world. The world takes only bodies with a shape; with nothing else there the shape meets
/// nothing.
class InWorld {
 public:
  using Choice = bool;  // as shipped?
  std::int64_t rhs_evals(std::int64_t) { return world_.substeps(); }
  InWorld(const EngineBody& b, bool defaults)
      : b_(b), defaults_(defaults), world_(defaults), body_(construction(b, &shape_)) {
    if (!defaults) body_.setFlags(flag_for(b, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY));
    world_.setGravity(to_bullet(b.gravity_S));
    world_.addRigidBody(&body_);
  }
  InWorld(const InWorld&) = delete;
  InWorld& operator=(const InWorld&) = delete;
  ~InWorld() { world_.removeRigidBody(&body_); }
  void restart() {
    world_.restart();
    world_.removeRigidBody(&body_);  // a run that failed leaves its last box in the broadphase
    body_.forceActivationState(defaults_ ? ACTIVE_TAG : DISABLE_DEACTIVATION);
    body_.setDeactivationTime(0);
    put_at_start(b_, body_);
    world_.addRigidBody(&body_);
  }
  Met set_step(double h) { return world_.set_step(h); }
  EngineState state() const { return state_of(body_); }

  Met step(double t) {
    apply_loads(b_, t, body_);
    world_.advance();
    if (!body_.isActive()) return fell_asleep;
    return world_.cut(body_.getAngularVelocity());
  }

 private:
  const EngineBody& b_;
  bool defaults_;
  Surroundings<btDiscreteDynamicsWorld, btSequentialImpulseConstraintSolver> world_;
  btSphereShape shape_{1};
  btRigidBody body_;
};

/// The body as a tree of one, by Featherstone's algorithm.
class Multibody {
 public:
  using Choice = bool;  // as shipped?
  std::int64_t rhs_evals(std::int64_t) { return world_.substeps(); }
  Multibody(const EngineBody& b, bool defaults)
      : b_(b),
        defaults_(defaults),
        world_(defaults),
        body_(0, btScalar(b.mass), to_bullet(b.moments), false, defaults) {
    if (defaults) {
      collider_.setCollisionShape(&shape_);
      body_.setBaseCollider(&collider_);
      world_.addCollisionObject(&collider_);
    } else {
      body_.setLinearDamping(0);
      body_.setAngularDamping(0);
      body_.setMaxCoordinateVelocity(BT_LARGE_FLOAT);
    }
    world_.setGravity(to_bullet(b.gravity_S));
    body_.finalizeMultiDof();
    world_.addMultiBody(&body_);
  }
  Multibody(const Multibody&) = delete;
  Multibody& operator=(const Multibody&) = delete;
  ~Multibody() {
    world_.removeMultiBody(&body_);
    if (defaults_) world_.removeCollisionObject(&collider_);
  }
  void restart() {
    world_.restart();
    body_.clearForcesAndTorques();
    body_.clearVelocities();
    body_.setBaseWorldTransform(start_pose(b_));
    if (b_.rotates) body_.setBaseOmega(start_rate(b_));
    body_.setBaseVel(to_bullet(b_.v0_S));
    body_.wakeUp();
    if (defaults_) {
      collider_.setWorldTransform(start_pose(b_));
      collider_.forceActivationState(ACTIVE_TAG);
    }
  }
  Met set_step(double h) { return world_.set_step(h); }
  EngineState state() const {
    const Quaternion q = from_bullet(body_.getWorldToBaseRot()).conjugate();
    return {q, to_body<double>(q, from_bullet(body_.getBaseOmega())), from_bullet(body_.getBasePos()),
            from_bullet(body_.getBaseVel()), std::abs(std::sqrt(squared_norm(q)) - 1)};
  }

  Met step(double t) {
    if (b_.torque_S)
      body_.addBaseTorque(
          to_bullet(b_.torque_S(t, from_bullet(btMatrix3x3(body_.getWorldToBaseRot().inverse())),
                                from_bullet(body_.getBaseOmega()))));
    if (b_.drag != 0) body_.addBaseForce(body_.getBaseVel() * btScalar(-b_.drag));
    world_.advance();
    if (!body_.isAwake()) return fell_asleep;
    if (defaults_ && fastest() >= body_.getMaxCoordinateVelocity())
      return {Outcome::clamped,
              "a velocity of more than 100 m/s or rad/s, which Bullet cuts to 100 by default"};
    return world_.cut(body_.getBaseOmega());
  }

 private:
  btScalar fastest() const {
    const btVector3 w = body_.getBaseOmega().absolute(), v = body_.getBaseVel().absolute();
    return btMax(w[w.maxAxis()], v[v.maxAxis()]);
  }
  const EngineBody& b_;
  bool defaults_;
  Surroundings<btMultiBodyDynamicsWorld, btMultiBodyConstraintSolver> world_;
  btSphereShape shape_{1};
  btMultiBody body_;
  btMultiBodyLinkCollider collider_{&body_, -1};
};

template <class Body, typename Body::Choice choice>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_engine<Body>(scene, setting, choice);
}

// Measured on a free body of moments (0.6, 0.8, 1) over 10 s, h = 0.1 to 0.001.
constexpr Claims first_order_claims = {.attitude_order = 1,
                                       .rate_order = 1,
                                       .energy_order = 1,
                                       .momentum_order = 1,
                                       .unit_attitude = Claim::yes,  // to the rounding of its own precision
                                       .momentum_magnitude = Claim::no,
                                       .space_momentum = Claim::no,
                                       .energy_bounded = Claim::no,
                                       .reversible = Claim::no};
// Without the term w_S never changes, and with it the components of w and L in the body: |L| and the energy
// are kept, the direction of L is not, and the error has order 0. (In single precision the rounding of 50000
// steps is a drift of 1e-4, which nobody would call kept.)
constexpr Claims none_claims = [] {
  Claims c = first_order_claims;
  c.attitude_order = c.rate_order = c.momentum_order = 0;
  c.energy_order = Claims::none;
  c.momentum_magnitude = Claim::yes;
  c.energy_bounded = c.reversible = single_precision ? Claim::unknown : Claim::yes;
  return c;
}();
// Steps of 1/60 s whatever is asked: smaller ones bring nothing, and there is no order.
constexpr Claims defaults_claims = {
    .unit_attitude = Claim::yes, .momentum_magnitude = Claim::no, .space_momentum = Claim::no};

struct Row {
  std::string id, summary, source;
  const char* settings;
  Claims claims;
  decltype(Method::prepare) run;
  bool in_studies = !single_precision;
};

constexpr const char* alone = "no world; torque, gravity and drag applied once a step";
constexpr const char* in_world =
    "stepSimulation(h, 0, h); never asleep (DISABLE_DEACTIVATION); damping 0 (default)";
constexpr const char* tree =
    "stepSimulation(h, 0, h); never asleep; linear and angular damping 0 (default 0.04); no limit on "
    "velocities "
    "(default 100)";
constexpr const char* as_shipped =
    "stepSimulation(h): one step of 1/60 s when so much time has gathered; asleep below 0.8 m/s and 1 rad/s "
    "for "
    "2 s; damping 0";
constexpr const char* tree_as_shipped =
    "stepSimulation(h): one step of 1/60 s when so much time has gathered; asleep when slow for 2 s; linear "
    "and "
    "angular damping 0.04; velocities cut at 100";

std::vector<Row> described_rows() {
  const std::string suffix = single_precision ? "-f32" : "";
  const std::string in = single_precision ? "Bullet in single precision, " : "Bullet in double precision, ";
  const std::string file = "Bullet, btRigidBody.cpp: ";
  return {
      {"bullet-none" + suffix,
       in + "no gyroscopic term: w stays constant in space, which is not the free motion", file + "no flag",
       alone, none_claims, prepare<Alone, no_gyroscopic_term>},
      {"bullet-explicit" + suffix,
       in + "semi-implicit Euler, gyroscopic torque of the old state (cut at 100 N m)",
       file + "computeGyroscopicForceExplicit", alone, first_order_claims,
       prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT>},
      {"bullet-implicit-world" + suffix,
       in + "semi-implicit Euler, gyroscopic term by one Newton step of implicit Euler in space components",
       file + "computeGyroscopicImpulseImplicit_World", alone, first_order_claims,
       prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD>},
      {"bullet-implicit-body" + suffix,
       in + "semi-implicit Euler, gyroscopic term by one Newton step of implicit Euler in body components "
            "(default)",
       file + "computeGyroscopicImpulseImplicit_Body; Catto, Numerical methods, Game Developers Conference "
              "(2015)",
       alone, first_order_claims, prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY>},
      {"bullet-world" + suffix,
       in + "bullet-implicit-body stepped by a whole btDiscreteDynamicsWorld: same results, its cost",
       "Bullet, btDiscreteDynamicsWorld::stepSimulation(h, 0, h)", in_world, first_order_claims,
       prepare<InWorld, false>, false},
      {"bullet-multibody" + suffix,
       in + "btMultiBody, reduced coordinates: semi-implicit Euler, gyroscopic torque of the old state",
       "Bullet, btMultiBody.cpp: computeAccelerationsArticulatedBodyAlgorithmMultiDof; Featherstone (1987)",
       tree, first_order_claims, prepare<Multibody, false>, false},
      {"bullet-defaults" + suffix, in + "btRigidBody in its world as shipped: substeps of 1/60 s, sleeping",
       "Bullet, btDiscreteDynamicsWorld::stepSimulation(h)", as_shipped, defaults_claims,
       prepare<InWorld, true>, false},
      {"bullet-multibody-defaults" + suffix,
       in +
           "btMultiBody in its world as shipped: substeps of 1/60 s, damping, sleeping, limits on velocities",
       "Bullet, btMultiBodyDynamicsWorld::stepSimulation(h)", tree_as_shipped, defaults_claims,
       prepare<Multibody, true>, false},
  };
}

}  // namespace
}  // namespace polhode

const std::size_t polhode_engine_stamp = polhode::engine_stamp;

const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static const std::string version =
      "Bullet " + std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
  static const std::vector<Row> described = described_rows();
  static const std::vector<Method> methods = [] {
    std::vector<Method> all;
    for (const Row& r : described)
      all.push_back({.id = r.id,
                     .family = "engine",
                     .summary = r.summary,
                     .source = r.source,
                     .version = version,
                     .settings = r.settings,
                     .by_steps = true,
                     .epsilon = std::numeric_limits<btScalar>::epsilon(),
                     .in_studies = r.in_studies,
                     .claims = r.claims,
                     .prepare = r.run});
    return all;
  }();
  static const MethodRows rows = methods;
  return &rows;
}
