// MuJoCo: minimal coordinates, a quaternion and the angular velocity in the body frame. The mass matrix M,
// the bias c (here the gyroscopic torque) and the applied forces give the acceleration; then
//   euler     v <- v + h M^-1 (f - c),  q <- q exp(h w)     with the new w: semi-implicit Euler
//   implicit  the same with M - h d(f - c)/dv in place of M: one Newton step of implicit Euler for w
//   rk4       the classical stages for v and w; but q moves by one exponential of the mean of the stages' w,
//   and
//             within the stages by one of the stage's own, which leaves out the commutators
// Orders: 1, 1, and for rk4 2 in attitude and momentum. Only what does not depend on the attitude, the rates
// and energy of a free body, has order 4. On a free body euler is Bullet's explicit and implicit its
// implicit-body. The quaternion is normalised in every step; momentum and energy drift.
//
// Loads are written to xfrc_applied from MuJoCo's control callback, so rk4 has them anew in each stage. The
// body hangs on a free joint, on a ball joint where the scene has no translation, on three slides if it is a
// particle. Contacts and constraints are off; MuJoCo's defaults have no damping, no sleep and no limit on
// speed. What it does behind the user's back: a number that is not finite or beyond 1e10 makes it reset the
// state to the model's own start and go on; here the run ends as `diverged`.
//
// Source: MuJoCo 2.2.2, documentation, "Computation: Numerical integration"; Todorov, Erez & Tassa, MuJoCo: A
// physics engine for model-based control, IROS (2012).
#include <algorithm>
#include <memory>
#include <mutex>
#include <string>

#include <mujoco/mujoco.h>

#include "solvers/engines/engine_run.hpp"

namespace polhode {
namespace {

constexpr Met was_reset = {Outcome::diverged,
                           "a number that is not finite or beyond 1e10, at which MuJoCo resets the state"};

/// A body of unit mass and inertia on the joints that it needs; its own are put in afterwards, as numbers.
mjModel* load_model(const char* joints) {
  const std::string xml =
      std::string(
          "<mujoco><compiler inertiafromgeom=\"false\"/><option><flag contact=\"disable\" "
          "constraint=\"disable\"/></option><worldbody><body>") +
      joints + "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/></body></worldbody></mujoco>";
  static std::mutex guard;  // its reader keeps the last model that it read
  const std::lock_guard lock(guard);
  const auto files = std::make_unique<mjVFS>();
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "body.xml", static_cast<int>(xml.size()));
  std::copy(xml.begin(), xml.end(), static_cast<char*>(files->filedata[0]));
  char error[200] = "";
  mjModel* const model = mj_loadXML("body.xml", files.get(), error, sizeof error);
  mj_deleteVFS(files.get());
  return model;
}

class Mujoco {
 public:
  using Choice = mjtIntegrator;
  Mujoco(const EngineBody& b, Choice integrator)
      : b_(b),
        model_(load_model(!b.rotates ? "<joint type=\"slide\" axis=\"1 0 0\"/><joint type=\"slide\" "
                                       "axis=\"0 1 0\"/><joint type=\"slide\" axis=\"0 0 1\"/>"
                          : b.moves  ? "<freejoint/>"
                                     : "<joint type=\"ball\"/>")),
        data_(mj_makeData(model_.get())),
        loaded_(b.torque_S || b.drag != 0) {
    model_->body_mass[body] = b.mass;
    for (int i = 0; i < 3; ++i) {
      model_->body_inertia[3 * body + i] = b.moments[i];
      model_->opt.gravity[i] = b.gravity_S[i];
    }
    model_->opt.integrator = integrator;
    mj_setConst(model_.get(), data_.get());
  }

  void restart() {
    mj_resetData(model_.get(), data_.get());
    if (b_.moves) {
      Eigen::Map<Vec3>(data_->qpos) = b_.p0_S;
      Eigen::Map<Vec3>(data_->qvel) = b_.v0_S;
    }
    if (b_.rotates) {
      mjtNum* const q = data_->qpos + attitude_at();
      q[0] = b_.q0.w();
      for (int i = 0; i < 3; ++i) q[1 + i] = b_.q0.vec()[i];
      Eigen::Map<Vec3>(data_->qvel + attitude_at()) = b_.w0_B;
    }
  }
  Met set_step(double h) {
    model_->opt.timestep = h;
    return {};
  }
  std::int64_t rhs_evals(std::int64_t steps) const {
    return model_->opt.integrator == mjINT_RK4 ? 4 * steps : steps;
  }

  Met step(double t) {
    data_->time = t;  // its own is a running sum
    stepping = loaded_ ? this : nullptr;
    mj_step(model_.get(), data_.get());
    stepping = nullptr;  // MuJoCo also steps on its own, when it reads a model
    const mjWarningStat* const w = data_->warning;
    return w[mjWARN_BADQPOS].number + w[mjWARN_BADQVEL].number + w[mjWARN_BADQACC].number > 0 ? was_reset
                                                                                              : Met{};
  }

  EngineState state() const {
    EngineState s;
    if (b_.rotates) {
      const mjtNum* const q = data_->qpos + attitude_at();
      s.q = Quaternion(q[0], q[1], q[2], q[3]);
      s.w_B = rates();
      s.unit_defect = std::abs(std::sqrt(squared_norm(s.q)) - 1);
    }
    if (b_.moves) {
      s.p_S = Eigen::Map<const Vec3>(data_->qpos);
      s.v_S = Eigen::Map<const Vec3>(data_->qvel);
    }
    return s;
  }

  /// MuJoCo's control callback: the loads at the state of a stage.
  static void apply_loads(const mjModel*, mjData* d) {
    if (stepping == nullptr || stepping->data_.get() != d) return;
    const EngineBody& b = stepping->b_;
    mjtNum* const wrench = d->xfrc_applied + 6 * body;
    if (b.drag != 0) Eigen::Map<Vec3>{wrench} = -b.drag * Eigen::Map<const Vec3>(d->qvel);
    if (b.torque_S) {
      const Mat3 R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(d->xmat + 9 * body);
      Eigen::Map<Vec3>{wrench + 3} = b.torque_S(d->time, R, R * stepping->rates());
    }
  }

 private:
  static constexpr int body = 1;  // 0 is the world
  static thread_local const Mujoco* stepping;

  int attitude_at() const { return b_.moves ? 3 : 0; }  // in qpos and in qvel
  Vec3 rates() const { return Eigen::Map<const Vec3>(data_->qvel + attitude_at()); }

  struct Free {
    void operator()(mjModel* m) const { mj_deleteModel(m); }
    void operator()(mjData* d) const { mj_deleteData(d); }
  };
  const EngineBody& b_;
  std::unique_ptr<mjModel, Free> model_;
  std::unique_ptr<mjData, Free> data_;
  bool loaded_;
};
thread_local const Mujoco* Mujoco::stepping = nullptr;

template <mjtIntegrator integrator>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_engine<Mujoco>(scene, setting, integrator);
}

constexpr Claims first_order_claims = {.attitude_order = 1,
                                       .rate_order = 1,
                                       .energy_order = 1,
                                       .momentum_order = 1,
                                       .unit_attitude = Claim::yes,
                                       .momentum_magnitude = Claim::no,
                                       .space_momentum = Claim::no,
                                       .energy_bounded = Claim::no,
                                       .reversible = Claim::no};
// With a load that depends on the attitude, what it does to the rates is of order 2, too. Of a free body |L|
// is as good as the rates, which at steps that suit order 2 err by rounding: it cannot be told from kept, nor
// the way back.
constexpr Claims rk4_claims = [] {
  Claims c = first_order_claims;
  c.attitude_order = c.rate_order = c.energy_order = c.momentum_order = 2;
  c.momentum_magnitude = c.reversible = Claim::unknown;
  return c;
}();

constexpr const char* settings =
    "contact and constraint off; loads through xfrc_applied; otherwise the defaults, which have no damping, "
    "sleep "
    "or limit on speed; q normalised every step";
constexpr const char* source =
    "MuJoCo documentation, Computation: Numerical integration; Todorov, Erez & Tassa, IROS (2012)";

}  // namespace
}  // namespace polhode

const std::size_t polhode_engine_stamp = polhode::engine_stamp;

const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static const std::string version = std::string("MuJoCo ") + mj_versionString();
  static const auto row = [](const char* id, const char* summary, bool in_studies, const Claims& claims,
                             decltype(Method::prepare) run) {
    return Method{.id = id,
                  .family = "engine",
                  .summary = summary,
                  .source = source,
                  .version = version,
                  .settings = settings,
                  .by_steps = true,
                  .in_studies = in_studies,
                  .claims = claims,
                  .prepare = run};
  };
  static const Method methods[] = {
      row("mujoco-euler", "MuJoCo's default, semi-implicit Euler; on a free body Bullet's explicit step",
          false, first_order_claims, prepare<mjINT_EULER>),
      row("mujoco-implicit", "MuJoCo, implicit in the velocities; on a free body Bullet's implicit-body",
          false, first_order_claims, prepare<mjINT_IMPLICIT>),
      row("mujoco-rk4",
          "MuJoCo's Runge-Kutta, one exponential a step for q: order 2 in attitude and momentum, 4 in the "
          "energy "
          "of a free body",
          true, rk4_claims, prepare<mjINT_RK4>),
  };
  static const MethodRows rows = methods;
  mju_user_warning = [](const char*) {};  // it would write a file into the current folder
  mjcb_control = Mujoco::apply_loads;
  return &rows;
}
