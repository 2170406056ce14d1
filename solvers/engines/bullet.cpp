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
// The rows step a btRigidBody alone, without world, collision shape or constraint solver, by exactly the
// arithmetic that btDiscreteDynamicsWorld::stepSimulation(h, 0, h) performs on one free body; in Bullet the
// gyroscopic part lives inside the constraint solver, so the public predictIntegratedTransform alone would
// lack it. `bullet-world` is that world itself (same results to the last bit), to show what it costs.
//
// What a user would trip over is set here: no deactivation (slow bodies fall asleep after 2 s), no damping,
// one substep. What cannot be switched off ends the run as `clamped`: the rotation per step is cut at pi/4
// without touching w, and the torque of `explicit` at 100 N m. Below |w| = 0.001 rad/s Bullet takes a series
// for sin.
//
// This file is compiled twice, against Bullet in double and in single precision (ids with the suffix -f32);
// the model, its loads and the samples are in double in both. The two modules live in one process. Statics of
// Bullet's inline functions (btTransform::getIdentity) must not be used here: the linker makes them one per
// process, RTLD_LOCAL or not, and they differ in size between the two.
//
// Source: Bullet 3.24, btTransformUtil.h, btRigidBody.h (implicit-body is Catto's, Numerical methods, Game
// Developers Conference 2015; implicit-world Ewert's), btSequentialImpulseConstraintSolver,
// btDiscreteDynamicsWorld.
#include <memory>
#include <string>
#include <vector>

#include <btBulletDynamicsCommon.h>

#include "solvers/engines/engines.hpp"
#include "solvers/fixed_step.hpp"

namespace polhode {
namespace {

constexpr bool single_precision = sizeof(btScalar) == sizeof(float);
constexpr int no_gyroscopic_term = 0;

btVector3 to_bullet(const Vec3& a) { return {btScalar(a.x()), btScalar(a.y()), btScalar(a.z())}; }
Vec3 from_bullet(const btVector3& a) { return {a.x(), a.y(), a.z()}; }
Mat3 from_bullet(const btMatrix3x3& a) {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.row(i) = from_bullet(a[i]);
  return m;
}

/// A scene that Bullet can hold: it has no body of rates alone.
template <class M>
concept Served = AnyModel<M> &&(M::has_attitude || !M::has_rotation);

/// Mass and inertia as Bullet takes them. A body held at a pivot, or with no translation, gets mass 1: Bullet
/// leaves the gyroscopic part out of a body without mass. A particle gets no inertia, which Bullet holds
/// still.
template <Served M>
btRigidBody::btRigidBodyConstructionInfo construction(const M& m, btCollisionShape* shape) {
  double mass = 1;
  if constexpr (M::has_translation) mass = m.translation.mass;
  btVector3 moments(0, 0, 0);
  if constexpr (M::has_rotation) moments = to_bullet(m.rotation.moments());
  return {btScalar(mass), nullptr, shape, moments};
}

/// The gravity of the scene [m/s^2], which Bullet adds as the force m g.
template <Served M>
btVector3 gravity(const M& m) {
  if constexpr (requires { m.translation.force.acceleration_S; })
    return to_bullet(m.translation.force.acceleration_S);
  else
    return btVector3(0, 0, 0);
}

/// The flag of the body: a sphere and a particle need no gyroscopic part.
template <Served M>
int flag_for(const M& m, int mode) {
  if constexpr (M::has_rotation)
    if (m.rotation.has_gyroscopic_term()) return mode;
  return no_gyroscopic_term;
}

template <Served M>
void put_at_start(const M& m, btRigidBody& body) {
  btTransform pose;
  pose.setIdentity();
  const double* y = m.initial.data();
  if constexpr (M::has_rotation) {
    const Quaternion q = m.rotation.attitude_of(y);
    pose.setRotation(btQuaternion(btScalar(q.x()), btScalar(q.y()), btScalar(q.z()), btScalar(q.w())));
    body.setAngularVelocity(to_bullet(to_space<double>(q, m.rotation.w_of(y))));
  }
  if constexpr (M::has_translation) {
    pose.setOrigin(to_bullet(m.position(y)));
    body.setLinearVelocity(to_bullet(m.velocity(y)));
  }
  body.setCenterOfMassTransform(pose);  // brings the inertia in space components up to date, too
  body.clearForces();
}

/// Torque and drag at the start of the step, given to Bullet as any program that uses it would.
template <Served M>
void apply_loads(const M& m, double t, btRigidBody& body) {
  if constexpr (M::Rotating::has_load)
    body.applyTorque(to_bullet(m.rotation.load.torque_S(
        t, from_bullet(body.getCenterOfMassTransform().getBasis()), from_bullet(body.getAngularVelocity()))));
  if constexpr (requires { m.translation.force.drag_per_mass; })
    if (m.translation.force.drag_per_mass != 0)
      body.applyCentralForce(body.getLinearVelocity() *
                             btScalar(-m.translation.force.drag_per_mass * m.translation.mass));
}

/// Bullet's own limits that a step may have met.
enum class Limit { none, rotation, torque };

/// Bullet cuts the rotation of a step at pi/4, silently.
bool is_clipped(const btVector3& w, btScalar h) {
  const btScalar limit = ANGULAR_MOTION_THRESHOLD;
  return w.length2() * (h * h) > limit * limit;
}

/// The body alone.
template <Served M>
class Alone {
 public:
  Alone(const M& m, int mode) : m_(m), flag_(flag_for(m, mode)), body_(construction(m, nullptr)) {
    body_.setGravity(gravity(m));
  }
  void restart() { put_at_start(m_, body_); }
  const btRigidBody& body() const { return body_; }

  Limit step(double t, btScalar h) {
    constexpr bool loaded = M::Rotating::has_load, forced = requires { m_.translation.force.acceleration_S; };
    if constexpr (loaded || forced) apply_loads(m_, t, body_);
    if constexpr (forced) {
      body_.applyGravity();
      body_.setLinearVelocity(body_.getLinearVelocity() + body_.getTotalForce() * body_.getInvMass() * h);
    }
    btTransform& pose = body_.getWorldTransform();
    if constexpr (!M::has_rotation) {
      pose.setOrigin(pose.getOrigin() + body_.getLinearVelocity() * h);
    } else {
      btVector3 change(0, 0, 0);  // of the angular velocity; products in the order of the constraint solver
      if constexpr (loaded) change = body_.getTotalTorque() * body_.getInvInertiaTensorWorld() * h;
      if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY) {
        change += body_.computeGyroscopicImpulseImplicit_Body(h);
      } else if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD) {
        change += body_.computeGyroscopicImpulseImplicit_World(h);
      } else if (flag_ == BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT) {
        const btVector3 torque = body_.computeGyroscopicForceExplicit(BT_LARGE_FLOAT);
        if (torque.length2() > torque_limit_ * torque_limit_) return Limit::torque;
        change -= torque * body_.getInvInertiaTensorWorld() * h;
      }
      const btVector3 w = body_.getAngularVelocity() + change;
      body_.setAngularVelocity(w);
      if (is_clipped(w, h)) return Limit::rotation;
      btTransformUtil::integrateTransform(pose, body_.getLinearVelocity(), w, h, pose);
      if (loaded || flag_ == BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT) body_.updateInertiaTensor();
    }
    if constexpr (loaded || forced) body_.clearForces();
    return Limit::none;
  }

 private:
  const btScalar torque_limit_ = btContactSolverInfo().m_maxGyroscopicForce;
  const M& m_;
  int flag_;
  btRigidBody body_;
};

/// The body in a world of Bullet's usual parts. The world takes only bodies with a shape; with nothing else
/// there the shape meets nothing.
template <Served M>
class InWorld {
 public:
  InWorld(const M& m, int mode) : m_(m), body_(construction(m, &shape_)) {
    body_.setFlags(flag_for(m, mode));
    world_.setGravity(gravity(m));
    world_.addRigidBody(&body_);
  }
  InWorld(const InWorld&) = delete;
  InWorld& operator=(const InWorld&) = delete;
  ~InWorld() { world_.removeRigidBody(&body_); }
  void restart() {
    world_.removeRigidBody(&body_);  // a run that failed leaves its last box in the broadphase
    body_.forceActivationState(DISABLE_DEACTIVATION);
    put_at_start(m_, body_);
    world_.addRigidBody(&body_);
  }
  const btRigidBody& body() const { return body_; }

  Limit step(double t, btScalar h) {
    apply_loads(m_, t, body_);
    world_.stepSimulation(h, 0, h);
    return is_clipped(body_.getAngularVelocity(), h) ? Limit::rotation : Limit::none;
  }

 private:
  const M& m_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver constraint_solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &constraint_solver_, &configuration_};
  btSphereShape shape_{1};
  btRigidBody body_;
};

/// The flat state of the model from Bullet's: q from the matrix by Bullet's own conversion, w_B = R^T w_S.
template <Served M>
typename M::State state_of(const btRigidBody& body) {
  typename M::State y{};
  const btTransform& pose = body.getCenterOfMassTransform();
  if constexpr (M::has_rotation) {
    const btQuaternion q = pose.getRotation();
    const Vec3 w_B = from_bullet(pose.getBasis()).transpose() * from_bullet(body.getAngularVelocity());
    y[0] = q.w();
    y[1] = q.x();
    y[2] = q.y();
    y[3] = q.z();
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(4 + i)] = w_B[i];
  }
  if constexpr (M::has_translation)
    for (int i = 0; i < 3; ++i) {
      y[static_cast<std::size_t>(M::rotation_size + i)] = pose.getOrigin()[i];
      y[static_cast<std::size_t>(M::rotation_size + 3 + i)] = body.getLinearVelocity()[i];
    }
  return y;
}

template <Served M>
Sample sample_of(const M& m, double t, const btRigidBody& body) {
  Sample s = observe(m, t, state_of<M>(body).data());
  if constexpr (M::has_rotation) {  // the state is the matrix, so its defect is the one that counts
    const Mat3 R = from_bullet(body.getCenterOfMassTransform().getBasis());
    s.unit_defect = (R.transpose() * R - Mat3::Identity()).norm();
  }
  return s;
}

const char* reason_of(Limit limit) {
  return limit == Limit::rotation ? "a rotation of more than pi/4 in a step, which Bullet cuts to pi/4"
                                  : "a gyroscopic torque of more than 100 N m, which Bullet cuts to 100 N m";
}

/// Steps of fixed size with one more way to end: a limit of Bullet's, looked for in every step.
template <class Body, Served M>
class BulletSteps final : public FixedSteps {
 public:
  BulletSteps(M model, int mode) : model_(std::move(model)), bullet_(model_, mode) { bullet_.restart(); }
  void restart() override { bullet_.restart(); }
  Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) override {
    const btScalar bullet_h = btScalar(h);
    if (btFuzzyZero(bullet_h))
      return {i, Outcome::solver_failed, "a step size below Bullet's epsilon, at which it stands still", 0};
    const std::int64_t from = i;
    Limit met = Limit::none;
    for (; i < until && met == Limit::none; ++i)
      met = bullet_.step(t_start + static_cast<double>(i) * h, bullet_h);
    Advance done{i, Outcome::ok, nullptr, i - from};
    if (met != Limit::none) {
      done.outcome = Outcome::clamped;
      done.reason = reason_of(met);
    } else if (!all_finite(state_of<M>(bullet_.body()))) {
      done.outcome = Outcome::not_finite;
      done.reason = "a state that is not finite";
    }
    return done;
  }
  Sample sample(double t) const override { return sample_of(model_, t, bullet_.body()); }

 private:
  M model_;
  Body bullet_;
};

/// Set up once, run often.
template <template <class> class Body>
Prepared prepare_mode(const Scene& scene, const Setting& setting, int mode) {
  std::shared_ptr<FixedSteps> steps = with_model(scene, [&](auto model) -> std::shared_ptr<FixedSteps> {
    using M = decltype(model);
    if constexpr (Served<M>)
      return std::make_shared<BulletSteps<Body<M>, M>>(std::move(model), mode);
    else
      return nullptr;
  });
  if (!steps) return {{}, "Bullet always integrates the attitude, and the scene asks for the rates alone"};
  return run_fixed_steps(std::move(steps), setting);
}

template <template <class> class Body, int mode>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return prepare_mode<Body>(scene, setting, mode);
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

struct Row {
  std::string id, summary, source;
  Claims claims;
  decltype(Method::prepare) run;
};

std::vector<Row> described_rows() {
  const std::string suffix = single_precision ? "-f32" : "";
  const std::string in = single_precision ? "Bullet in single precision, " : "Bullet in double precision, ";
  const std::string file = "Bullet, btRigidBody.cpp: ";
  return {
      {"bullet-none" + suffix,
       in + "no gyroscopic term: w stays constant in space, which is not the free motion", file + "no flag",
       none_claims, prepare<Alone, no_gyroscopic_term>},
      {"bullet-explicit" + suffix,
       in + "semi-implicit Euler, gyroscopic torque of the old state (cut at 100 N m)",
       file + "computeGyroscopicForceExplicit", first_order_claims,
       prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT>},
      {"bullet-implicit-world" + suffix,
       in + "semi-implicit Euler, gyroscopic term by one Newton step of implicit Euler in space components",
       file + "computeGyroscopicImpulseImplicit_World", first_order_claims,
       prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD>},
      {"bullet-implicit-body" + suffix,
       in + "semi-implicit Euler, gyroscopic term by one Newton step of implicit Euler in body components "
            "(default)",
       file + "computeGyroscopicImpulseImplicit_Body; Catto, Numerical methods, Game Developers Conference "
              "(2015)",
       first_order_claims, prepare<Alone, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY>},
      {"bullet-world" + suffix,
       in + "bullet-implicit-body stepped by a whole btDiscreteDynamicsWorld: same results, its cost",
       "Bullet, btDiscreteDynamicsWorld::stepSimulation(h, 0, h)", first_order_claims,
       prepare<InWorld, BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY>},
  };
}

}  // namespace
}  // namespace polhode

extern "C" {
extern const std::size_t polhode_engine_stamp;
const std::size_t polhode_engine_stamp = polhode::engine_stamp;
}

extern "C" const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static const std::string version =
      std::to_string(btGetVersion() / 100) + "." + std::to_string(btGetVersion() % 100);
  static const std::vector<Row> described = described_rows();
  static const std::vector<Method> methods = [] {
    std::vector<Method> all;
    for (const Row& r : described)
      all.push_back({.id = r.id,
                     .family = "engine",
                     .summary = r.summary,
                     .source = r.source,
                     .version = version,
                     .by_steps = true,
                     .epsilon = std::numeric_limits<btScalar>::epsilon(),
                     .in_studies = !r.id.ends_with("-f32") && !r.id.starts_with("bullet-world"),
                     .claims = r.claims,
                     .prepare = r.run});
    return all;
  }();
  static const MethodRows rows = methods;
  return &rows;
}
