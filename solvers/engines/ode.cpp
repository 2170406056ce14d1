// Open Dynamics Engine: maximal coordinates, semi-implicit Euler in space components.
//   w_S <- w_S + h I_S^-1 tau_S + d,   q <- q + h/2 (0, w_S) q normalised,   v <- v + h F/m,   p <- p + h v
// The gyroscopic part d is that of implicit Euler with the momentum L = I_S w_S held, (I_S - h hat(L)) (w_S +
// d) = L, which dissipates: 2 E loses d . I_S d in every step. A body near its separatrix ends up on the
// other side of it.
//
// Order 1; momentum and energy drift; the quaternion is normalised in every step. `ode-step` solves the whole
// system of contacts and joints at once, `ode-quickstep` iterates; without any they differ by rounding alone.
//
// Defaults as shipped, which are what is used here: gyroscopic term on, no auto-disable, no damping, no limit
// on speed (ODE itself recommends one below 500 rad/s), attitude by the small-rotation formula above ("finite
// rotation mode" 0). ODE's assertions abort the program on a number that is not finite: a body that turns or
// moves faster than 1e10 ends the run as `diverged` before it gets there. Steps must be positive.
//
// Source: Open Dynamics Engine 0.16.2, manual, and ode/src/step.cpp, util.cpp (dxStepBody).
#include <algorithm>
#include <memory>
#include <mutex>

#include <ode/ode.h>

#include "solvers/engines/engine_run.hpp"

namespace polhode {
namespace {

constexpr Met too_fast = {
    Outcome::diverged,
    "a velocity beyond 1e10, soon after which ODE cannot normalise the quaternion and aborts"};

class Ode {
 public:
  enum class Choice { step, quickstep };
  // All worlds share one stand-in for threads, whose assertion aborts the program when two of them step at
  // once.
  static inline std::mutex one_thread;
  Ode(const EngineBody& b, Choice choice)
      : b_(b), choice_(choice), world_(made()), body_(dBodyCreate(world_.get())) {
    dWorldSetGravity(world_.get(), b.gravity_S.x(), b.gravity_S.y(), b.gravity_S.z());
    dMass mass;
    dMassSetParameters(&mass, b.mass, 0, 0, 0, b.moments.x(), b.moments.y(), b.moments.z(), 0, 0, 0);
    dBodySetMass(body_, &mass);
  }

  void restart() {
    const Quaternion& q = b_.q0;
    const dQuaternion attitude = {q.w(), q.x(), q.y(), q.z()};
    dBodySetQuaternion(body_, attitude);  // normalises
    const Vec3 w = to_space<double>(q, b_.w0_B), &p = b_.p0_S, &v = b_.v0_S;
    dBodySetAngularVel(body_, w.x(), w.y(), w.z());
    dBodySetPosition(body_, p.x(), p.y(), p.z());
    dBodySetLinearVel(body_, v.x(), v.y(), v.z());
    dBodySetForce(body_, 0, 0, 0);
    dBodySetTorque(body_, 0, 0, 0);
  }
  Met set_step(double h) {
    h_ = h;
    return h > 0 ? Met{} : Met{Outcome::solver_failed, "ODE takes steps forward only"};
  }
  static std::int64_t rhs_evals(std::int64_t steps) { return steps; }

  Met step(double t) {
    if (!(fastest() < fastest_for_assertions)) return too_fast;
    if (b_.torque_S) {
      const Vec3 tau = b_.torque_S(t, rotation(), vec(dBodyGetAngularVel(body_)));
      dBodyAddTorque(body_, tau.x(), tau.y(), tau.z());
    }
    if (b_.drag != 0) {
      const Vec3 force = -b_.drag * vec(dBodyGetLinearVel(body_));
      dBodyAddForce(body_, force.x(), force.y(), force.z());
    }
    const bool done =
        choice_ == Choice::step ? dWorldStep(world_.get(), h_) : dWorldQuickStep(world_.get(), h_);
    return done ? Met{} : Met{Outcome::solver_failed, "ODE had no memory for the step"};
  }

  EngineState state() const {
    const dReal* const a = dBodyGetQuaternion(body_);
    const Quaternion q(a[0], a[1], a[2], a[3]);
    return {q, rotation().transpose() * vec(dBodyGetAngularVel(body_)), vec(dBodyGetPosition(body_)),
            vec(dBodyGetLinearVel(body_)), std::abs(std::sqrt(squared_norm(q)) - 1)};
  }

 private:
  struct Destroy {
    void operator()(dxWorld* world) const {
      const std::lock_guard alone(one_thread);
      dWorldDestroy(world);  // and its bodies
    }
  };
  using World = std::unique_ptr<dxWorld, Destroy>;
  static World made() {
    const std::lock_guard alone(one_thread);
    return World(dWorldCreate());
  }

  double fastest() const {
    return std::max(vec(dBodyGetAngularVel(body_)).cwiseAbs().maxCoeff(),
                    vec(dBodyGetLinearVel(body_)).cwiseAbs().maxCoeff());
  }
  static Vec3 vec(const dReal* a) { return {a[0], a[1], a[2]}; }
  Mat3 rotation() const {
    const dReal* const a = dBodyGetRotation(body_);  // rows of four
    return Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(a).leftCols<3>();
  }

  const EngineBody& b_;
  Choice choice_;
  World world_;
  dBodyID body_;
  double h_ = 0;
};

template <Ode::Choice choice>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_engine<Ode>(scene, setting, choice);
}

constexpr Claims claims = {.attitude_order = 1,
                           .rate_order = 1,
                           .energy_order = 1,
                           .momentum_order = 1,
                           .unit_attitude = Claim::yes,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no};  // reversible: it takes no step back

constexpr const char* settings =
    "the defaults: gyroscopic term on, no auto-disable, no damping, no limit on speed, finite rotation mode "
    "0; q "
    "normalised every step";

}  // namespace
}  // namespace polhode

const std::size_t polhode_engine_stamp = polhode::engine_stamp;

const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static_assert(sizeof(dReal) == sizeof(double));
  static const auto row = [](const char* id, const char* summary, const char* source, bool in_studies,
                             decltype(Method::prepare) run) {
    return Method{.id = id,
                  .family = "engine",
                  .summary = summary,
                  .source = source,
                  .version = "ODE " dODE_VERSION,
                  .settings = settings,
                  .by_steps = true,
                  .in_studies = in_studies,
                  .claims = claims,
                  .prepare = run};
  };
  static const Method methods[] = {
      row("ode-step", "ODE, semi-implicit Euler with a linearly implicit gyroscopic term that dissipates",
          "Open Dynamics Engine, dWorldStep", true, prepare<Ode::Choice::step>),
      row("ode-quickstep", "ODE's iterative solver: without joints and contacts the same as ode-step",
          "Open Dynamics Engine, dWorldQuickStep", false, prepare<Ode::Choice::quickstep>),
  };
  static const MethodRows rows = methods;
  dInitODE2(0);
  return &rows;
}
