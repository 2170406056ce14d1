// What does it cost to run a library's solver through this program rather than by hand?
//
// For each solver below the program holds a bare twin: the equations of the free rigid body written out, the
// library called as its manual shows, nothing else. Both make the same run (the Hairer-Vilmart body for 10 s,
// asked for its end alone), set up before the clock starts. They are timed in turn, in one process, by the
// thread's CPU clock; a ratio counts only if both took the same number of steps to the same state.
//
//   polhode_overhead [LIMIT]   prints a table; exit 1 if a ratio of minima exceeds LIMIT (default 1.05)
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/modified_midpoint.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <btBulletDynamicsCommon.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "solvers/registry.hpp"
#include "solvers/thread_time.hpp"

namespace {

namespace odeint = boost::numeric::odeint;
using State = std::array<double, 7>;  // q (w, x, y, z), w_B

constexpr double t_end = 10;
constexpr double I1 = 0.6, I2 = 0.8, I3 = 1;
constexpr State start = {1, 0, 0, 0, 1.8 / I1, 0.4 / I2, -0.9 / I3};

// ---- bare: from here to the next rule nothing of this program is used

// Constants of the equations, known at run time as in any program that reads its body from somewhere. (Baked
// into the code they would make the bare Odeint runs up to a tenth faster, at the price of a program for one
// body.)
struct Body {
  double g1, g2, g3;  // (I2 - I3)/I1 and cyclic
};
Body read_body(const volatile double* moments) {
  const double a = moments[0], b = moments[1], c = moments[2];
  return {(b - c) / a, (c - a) / b, (a - b) / c};
}
const volatile double given_moments[] = {I1, I2, I3};

[[gnu::always_inline]] inline void equations(const Body& body, const double* y, double* d) {
  const double g1 = body.g1, g2 = body.g2, g3 = body.g3;
  const double hx = 0.5 * y[4], hy = 0.5 * y[5], hz = 0.5 * y[6];
  d[0] = -(y[1] * hx + y[2] * hy + y[3] * hz);
  d[1] = y[0] * hx + y[2] * hz - y[3] * hy;
  d[2] = y[0] * hy + y[3] * hx - y[1] * hz;
  d[3] = y[0] * hz + y[1] * hy - y[2] * hx;
  d[4] = g1 * (y[5] * y[6]);
  d[5] = g2 * (y[6] * y[4]);
  d[6] = g3 * (y[4] * y[5]);
}

struct BareResult {
  State y;
  long steps;  // accepted
};

struct OdeintBody {
  Body body = read_body(given_moments);
  void operator()(const State& y, State& d, double) const { equations(body, y.data(), d.data()); }
};

template <class Stepper>
std::function<BareResult()> bare_fixed(int steps) {
  return [steps, odeint_body = OdeintBody()] {
    Stepper stepper;
    State y = start;
    const double h = t_end / steps;
    for (int i = 0; i < steps; ++i) stepper.do_step(odeint_body, y, i * h, h);
    return BareResult{y, steps};
  };
}

template <class Controlled>
std::function<BareResult()> bare_controlled(std::shared_ptr<Controlled> stepper, double tolerance) {
  const OdeintBody odeint_body;
  State d;
  odeint_body(start, d, 0);
  double size = 0, rate = 0;
  for (std::size_t i = 0; i < d.size(); ++i) {
    const double scale = tolerance + tolerance * std::abs(start[i]);
    size = std::max(size, std::abs(start[i]) / scale);
    rate = std::max(rate, std::abs(d[i]) / scale);
  }
  const double first_step = 0.01 * size / rate;
  return [stepper, first_step, odeint_body] {
    State y = start;
    double t = 0, h = first_step;
    long steps = 0;
    if constexpr (requires { stepper->reset(); }) stepper->reset();
    while (t < t_end) {
      if (t + h > t_end) h = t_end - t;
      if (stepper->try_step(odeint_body, y, t, h) == odeint::success) ++steps;
    }
    return BareResult{y, steps};
  };
}

template <class Pair>
std::function<BareResult()> bare_pair(double tolerance) {
  using Controlled = odeint::controlled_runge_kutta<Pair>;
  static const Pair blank;
  return bare_controlled(
      std::make_shared<Controlled>(typename Controlled::error_checker_type(tolerance, tolerance),
                                   typename Controlled::step_adjuster_type(), blank),
      tolerance);
}

int cvode_body(sunrealtype, N_Vector y, N_Vector d, void* user) {
  equations(*static_cast<const Body*>(user), NV_DATA_S(y), NV_DATA_S(d));
  return 0;
}

int cvode_jacobian(sunrealtype, N_Vector v, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector, N_Vector) {
  const auto [g1, g2, g3] = *static_cast<const Body*>(user);
  const double* y = NV_DATA_S(v);
  const double rows[7][7] = {{0, -y[4] / 2, -y[5] / 2, -y[6] / 2, -y[1] / 2, -y[2] / 2, -y[3] / 2},
                             {y[4] / 2, 0, y[6] / 2, -y[5] / 2, y[0] / 2, -y[3] / 2, y[2] / 2},
                             {y[5] / 2, -y[6] / 2, 0, y[4] / 2, y[3] / 2, y[0] / 2, -y[1] / 2},
                             {y[6] / 2, y[5] / 2, -y[4] / 2, 0, -y[2] / 2, y[1] / 2, y[0] / 2},
                             {0, 0, 0, 0, 0, g1 * y[6], g1 * y[5]},
                             {0, 0, 0, 0, g2 * y[6], 0, g2 * y[4]},
                             {0, 0, 0, 0, g3 * y[5], g3 * y[4], 0}};
  for (int i = 0; i < 7; ++i)
    for (int j = 0; j < 7; ++j) SM_ELEMENT_D(J, i, j) = rows[i][j];
  return 0;
}

// Its objects live as long as the process: one run after another uses them, and the program ends with the
// last.
std::function<BareResult()> bare_cvode(int formula, double tolerance) {
  SUNContext context = nullptr;
#if SUNDIALS_VERSION_MAJOR < 7
  SUNContext_Create(nullptr, &context);
#else
  SUNContext_Create(SUN_COMM_NULL, &context);
#endif
  N_Vector y = N_VNew_Serial(7, context);
  N_VEnableFusedOps_Serial(y, SUNTRUE);
  std::copy(start.begin(), start.end(), NV_DATA_S(y));
  void* cvode = CVodeCreate(formula, context);
  CVodeInit(cvode, cvode_body, 0, y);
  CVodeSStolerances(cvode, tolerance, tolerance);
  CVodeSetUserData(cvode, new Body(read_body(given_moments)));
  CVodeSetMaxNumSteps(cvode, 100'000'000);
  if (formula == CV_ADAMS) {
    CVodeSetNonlinearSolver(cvode, SUNNonlinSol_FixedPoint(y, 0, context));
  } else {
    SUNMatrix J = SUNDenseMatrix(7, 7, context);
    CVodeSetLinearSolver(cvode, SUNLinSol_Dense(y, J, context), J);
    CVodeSetJacFn(cvode, cvode_jacobian);
  }
  return [y, cvode] {
    std::copy(start.begin(), start.end(), NV_DATA_S(y));
    CVodeReInit(cvode, 0, y);
    CVodeSetStopTime(cvode, t_end);
    double t = 0;
    CVode(cvode, t_end, y, &t, CV_NORMAL);
    BareResult result{};
    CVodeGetNumSteps(cvode, &result.steps);
    std::copy(NV_DATA_S(y), NV_DATA_S(y) + 7, result.y.begin());
    return result;
  };
}

// Bullet in double precision, the only one that this program links: its functions would stand in for those of
// the single build, whose module must not be run here.
struct BulletBody {
  btRigidBody body;
  explicit BulletBody(btCollisionShape* shape) : body(properties(shape)) {}
  static btRigidBody::btRigidBodyConstructionInfo properties(btCollisionShape* shape) {
    const double a = given_moments[0], b = given_moments[1], c = given_moments[2];
    return {1, nullptr, shape, btVector3(a, b, c)};
  }
  void restart() {
    btTransform pose;
    pose.setIdentity();
    body.setAngularVelocity(btVector3(start[4], start[5], start[6]));
    body.setLinearVelocity(btVector3(0, 0, 0));
    body.setCenterOfMassTransform(pose);
    body.clearForces();
  }
  BareResult result(long steps) const {
    const btQuaternion q = body.getCenterOfMassTransform().getRotation();
    const btVector3 w = body.getAngularVelocity() * body.getCenterOfMassTransform().getBasis();
    return {{q.w(), q.x(), q.y(), q.z(), w.x(), w.y(), w.z()}, steps};
  }
};

std::function<BareResult()> bare_bullet_body(int steps) {
  return [steps, bullet = std::make_shared<BulletBody>(nullptr)] {
    bullet->restart();
    btRigidBody& body = bullet->body;
    btTransform& pose = body.getWorldTransform();
    const double h = t_end / steps;
    for (int i = 0; i < steps; ++i) {
      body.setAngularVelocity(body.getAngularVelocity() + body.computeGyroscopicImpulseImplicit_Body(h));
      btTransformUtil::integrateTransform(pose, body.getLinearVelocity(), body.getAngularVelocity(), h, pose);
    }
    return bullet->result(steps);
  };
}

struct BulletWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver constraint_solver;
  btDiscreteDynamicsWorld world{&dispatcher, &broadphase, &constraint_solver, &configuration};
  btSphereShape shape{1};
  BulletBody bullet{&shape};
  BulletWorld() {
    world.setGravity(btVector3(0, 0, 0));
    bullet.body.forceActivationState(DISABLE_DEACTIVATION);
    world.addRigidBody(&bullet.body);
  }
  ~BulletWorld() { world.removeRigidBody(&bullet.body); }
};

std::function<BareResult()> bare_bullet_world(int steps) {
  return [steps, bullet = std::make_shared<BulletWorld>()] {
    bullet->bullet.restart();
    const double h = t_end / steps;
    for (int i = 0; i < steps; ++i) bullet->world.stepSimulation(h, 0, h);
    return bullet->bullet.result(steps);
  };
}

// ---- end of bare

polhode::Scene body_scene() {
  polhode::Scene scene;
  scene.duration = t_end;
  polhode::RotationData rotation;
  rotation.moments = {I1, I2, I3};
  rotation.w0 = {start[4], start[5], start[6]};
  scene.rotation = rotation;
  return scene;
}

struct Pair {
  std::string solver, setting;
  std::function<BareResult()> bare;
  polhode::Setting ours;
  std::int64_t steps = 0;  // fixed ones
};

std::vector<Pair> pairs() {
  using polhode::Knob;
  std::vector<Pair> all;
  const auto by_tolerance = [&](const char* id, double tolerance, std::function<BareResult()> bare) {
    char text[16];
    std::snprintf(text, sizeof text, "%.0e", tolerance);
    all.push_back(
        {id, std::string("rtol ") + text, std::move(bare), {.knob = Knob::tolerance, .rtol = tolerance}, 1});
  };
  const auto by_steps = [&](const char* id, int steps, std::function<BareResult()> bare) {
    all.push_back({id, std::to_string(steps) + " steps", std::move(bare), {.knob = Knob::steps}, steps});
  };
  for (const int steps : {200, 2000}) {
    by_steps("odeint-rk4", steps, bare_fixed<odeint::runge_kutta4<State>>(steps));
    by_steps("odeint-modified-midpoint", steps, bare_fixed<odeint::modified_midpoint<State>>(steps));
    by_steps("odeint-abm4", steps, bare_fixed<odeint::adams_bashforth_moulton<4, State>>(steps));
    by_steps("odeint-abm8-rk4-start", steps, bare_fixed<odeint::adams_bashforth_moulton<8, State>>(steps));
    by_steps("odeint-cash-karp54", steps, bare_fixed<odeint::runge_kutta_cash_karp54<State>>(steps));
    by_steps("odeint-dopri5", steps, bare_fixed<odeint::runge_kutta_dopri5<State>>(steps));
    by_steps("odeint-rkf78", steps, bare_fixed<odeint::runge_kutta_fehlberg78<State>>(steps));
    by_steps("bullet-implicit-body", steps, bare_bullet_body(steps));
    by_steps("bullet-world", steps, bare_bullet_world(steps));
  }
  for (const double tolerance : {1e-6, 1e-10}) {
    by_tolerance("odeint-cash-karp54", tolerance,
                 bare_pair<odeint::runge_kutta_cash_karp54<State>>(tolerance));
    by_tolerance("odeint-dopri5", tolerance, bare_pair<odeint::runge_kutta_dopri5<State>>(tolerance));
    by_tolerance("odeint-rkf78", tolerance, bare_pair<odeint::runge_kutta_fehlberg78<State>>(tolerance));
    by_tolerance(
        "odeint-bulirsch-stoer", tolerance,
        bare_controlled(std::make_shared<odeint::bulirsch_stoer<State>>(tolerance, tolerance), tolerance));
    by_tolerance("cvode-adams", tolerance, bare_cvode(CV_ADAMS, tolerance));
    by_tolerance("cvode-bdf", tolerance, bare_cvode(CV_BDF, tolerance));
  }
  return all;
}

/// Seconds a run, over so many runs.
template <class Run>
double time_of(const Run& run, long repeats) {
  const double began = polhode::thread_seconds();
  for (long i = 0; i < repeats; ++i) run();
  return (polhode::thread_seconds() - began) / static_cast<double>(repeats);
}

double median(std::vector<double> v) {
  std::nth_element(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2), v.end());
  return v[v.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const double limit = argc > 1 ? std::strtod(argv[1], nullptr) : 1.05;
  if (!(limit > 0)) {
    std::fprintf(stderr, "usage: polhode_overhead [LIMIT], got '%s'\n", argv[1]);
    return 2;
  }
  constexpr int rounds = 61;
  constexpr double batch_s = 1e-3;
  const polhode::Scene scene = body_scene();
  bool good = true;
  std::printf("%-22s %-11s %7s | %12s %12s | %12s %12s | %6s %6s\n", "solver", "setting", "steps",
              "bare min ns", "median", "polhode min", "median", "ratio", "median");
  for (const Pair& pair : pairs()) {
    const auto prepared = polhode::find_method(pair.solver).prepare(scene, pair.ours);
    polhode::Grid grid;
    grid.stretches.push_back({t_end, pair.steps, t_end / static_cast<double>(pair.steps)});
    polhode::Trajectory trajectory;
    State sink{};  // read below: the runs cannot be optimised away
    const auto bare = [&] { sink = pair.bare().y; };
    const auto ours = [&] { prepared.integrate(grid, trajectory); };

    const BareResult expected = pair.bare();
    ours();
    double distance = 1;
    if (trajectory.outcome == polhode::Outcome::ok) {
      const polhode::Sample& end = trajectory.samples.back();
      distance = std::max(
          polhode::attitude_error(
              polhode::Quaternion(expected.y[0], expected.y[1], expected.y[2], expected.y[3]), end.q),
          (polhode::Vec3(expected.y[4], expected.y[5], expected.y[6]) - end.w_B).norm());
    }
    // The two compile to the same arithmetic; 1e-11 leaves room for a compiler that orders a sum otherwise.
    const bool same = trajectory.work.steps == expected.steps && distance < 1e-11;

    const long repeats = std::max(1L, static_cast<long>(batch_s / std::max(time_of(bare, 3), 1e-9)));
    std::vector<double> bare_times, our_times;
    for (int round = 0; round < rounds; ++round) {
      const bool bare_first = round % 2 == 0;
      if (bare_first) bare_times.push_back(time_of(bare, repeats));
      our_times.push_back(time_of(ours, repeats));
      if (!bare_first) bare_times.push_back(time_of(bare, repeats));
    }
    const double bare_min = *std::min_element(bare_times.begin(), bare_times.end());
    const double our_min = *std::min_element(our_times.begin(), our_times.end());
    const double ratio = our_min / bare_min;
    std::printf("%-22s %-11s %7ld | %12.0f %12.0f | %12.0f %12.0f | %6.3f %6.3f%s%s\n", pair.solver.c_str(),
                pair.setting.c_str(), expected.steps, 1e9 * bare_min, 1e9 * median(bare_times), 1e9 * our_min,
                1e9 * median(our_times), ratio, median(our_times) / median(bare_times),
                ratio > limit ? "  above the limit" : "",
                same && sink == expected.y ? "" : "  NOT THE SAME RUN");
    good = good && same && sink == expected.y && ratio <= limit;
  }
  return good ? 0 : 1;
}
