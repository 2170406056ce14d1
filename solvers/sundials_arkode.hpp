// SUNDIALS ARKODE with one of the library's own Butcher tables, on the flat state of a model.
//
// A table is carried by ARKStep (explicit or diagonally implicit ones) or by ERKStep (explicit ones alone).
// One object is made for a prepared run and initialised anew for each run; its vectors have the fused
// operations switched on. An implicit stage is solved by Newton's method with the model's own Jacobian and
// dense LU.
//
// Fixed steps: the object is set back to the start of each stretch between two asked times, where the time is
// exact, and takes the stretch's steps one by one; inside a stretch the library sums the time up. (To let it
// run to a stop time costs 3 % less, but where the sum of the steps misses the stop time by its rounding, the
// library takes one more step of 1e-12 s.) Implicit stages are solved to 1e-13, so that the formula's error
// is all there is.
//
// By tolerance: the library's default control (PID). Asked times inside a step are reached by a branch: a
// second object goes from the start of that step to the asked time, and the run goes on as if nobody had
// looked; its right-hand sides do not count. The library's own interpolants, Hermite and Lagrange, have
// degree 5 at most, which does for the pairs of order 4 and spoils the others: on a tumbling body (100
// samples in 10 s, rtol 1e-10) the largest error of Fehlberg's 8(7) is 3.2e-11 where steps end, 4.0e-7 by
// Hermite and 4.3e-6 by Lagrange between them; for Verner's 6(5) it is 2.7e-11, 7.3e-8 and 3.3e-9. Lagrange
// of degree 1 is set, because it costs nothing and Hermite costs right-hand sides.
#pragma once
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>

#include "solvers/sundials_vector.hpp"
#include "solvers/sundials_watch.hpp"

#if SUNDIALS_VERSION_MAJOR > 6 || (SUNDIALS_VERSION_MAJOR == 6 && SUNDIALS_VERSION_MINOR >= 6)
#include <arkode/arkode_sprkstep.h>
#define POLHODE_SPRKSTEP
#endif

namespace polhode::sundials {

/// The calls of one of ARKODE's time steppers. From 7.1 on all share one set of names, before each has its
/// own.
struct Carrier {
  int (*evolve)(void*, sunrealtype, N_Vector, sunrealtype*, int);
  int (*reset)(void*, sunrealtype, N_Vector);
  int (*tolerances)(void*, sunrealtype, sunrealtype);
  int (*set_user_data)(void*, void*);
  int (*set_fixed_step)(void*, sunrealtype);
  int (*set_first_step)(void*, sunrealtype);
  int (*set_stop_time)(void*, sunrealtype);
  int (*set_step_limit)(void*, long);
  int (*set_interpolant)(void*, int);
  int (*set_interpolant_degree)(void*, int);
  int (*steps)(void*, long*);
  int (*error_failures)(void*, long*);
  int (*time)(void*, sunrealtype*);
  char* (*flag_name)(long);
  void (*free)(void**);
};

// ARKODE's names for one carrier: as functions of a prefix, all of them spelt alike.
#define POLHODE_CARRIER(prefix)                                                                       \
  Carrier {                                                                                           \
    prefix##Evolve, prefix##Reset, prefix##SStolerances, prefix##SetUserData, prefix##SetFixedStep,   \
        prefix##SetInitStep, prefix##SetStopTime, prefix##SetMaxNumSteps, prefix##SetInterpolantType, \
        prefix##SetInterpolantDegree, prefix##GetNumSteps, prefix##GetNumErrTestFails,                \
        prefix##GetCurrentTime, prefix##GetReturnFlagName, prefix##Free                               \
  }
#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
#define POLHODE_ARKODE(name) ARKode##name
inline constexpr Carrier arkstep_calls = POLHODE_CARRIER(ARKode), erkstep_calls = arkstep_calls;
#else
#define POLHODE_ARKODE(name) ARKStep##name
inline constexpr Carrier arkstep_calls = POLHODE_CARRIER(ARKStep), erkstep_calls = POLHODE_CARRIER(ERKStep);
#endif
#undef POLHODE_CARRIER
#ifdef POLHODE_SPRKSTEP
#if SUNDIALS_VERSION_MAJOR > 7 || (SUNDIALS_VERSION_MAJOR == 7 && SUNDIALS_VERSION_MINOR >= 1)
inline constexpr Carrier sprkstep_calls = arkstep_calls;
#else  // without tolerances
inline constexpr Carrier sprkstep_calls{SPRKStepEvolve,
                                        SPRKStepReset,
                                        [](void*, sunrealtype, sunrealtype) { return 0; },
                                        SPRKStepSetUserData,
                                        SPRKStepSetFixedStep,
                                        [](void*, sunrealtype) { return 0; },
                                        SPRKStepSetStopTime,
                                        SPRKStepSetMaxNumSteps,
                                        SPRKStepSetInterpolantType,
                                        SPRKStepSetInterpolantDegree,
                                        SPRKStepGetNumSteps,
                                        [](void*, long* failures) { return static_cast<int>(*failures = 0); },
                                        SPRKStepGetCurrentTime,
                                        SPRKStepGetReturnFlagName,
                                        SPRKStepFree};
#endif
#endif

enum class CarriedBy { arkstep_explicit, arkstep_implicit, erkstep, sprkstep };
inline const Carrier& calls_of(CarriedBy by) {
#ifdef POLHODE_SPRKSTEP
  if (by == CarriedBy::sprkstep) return sprkstep_calls;
#endif
  return by == CarriedBy::erkstep ? erkstep_calls : arkstep_calls;
}

/// What a run does beside its table.
enum class Way {
  plain,
  fixed_length_vectors,  // solvers/sundials_vector.hpp
  relaxed                // each step is scaled so that it keeps the energy; SUNDIALS 6.6 and later
};

/// The energy of a scene in which it is kept, as relaxation asks for it.
struct KeptEnergy {
  Vec3 moments = Vec3::Ones();  // kg m^2
  double mass = 1;              // kg

  /// The gradient of the total energy E(y), which follows from E' = 0 along y' = d: the torque is I w' + w x
  /// I w, and dE/dq = -2 q (0, torque) / |q|^2, since q' = q (0, w) / 2.
  void gradient(const ErasedModel& model, const double* y, const double* d, double* g) const {
    const bool rotates = model.size() != 6;
    const int w_at = model.has_attitude() ? 4 : 0, p_at = rotates ? w_at + 3 : 0;
    using In = Eigen::Map<const Vec3>;
    using Out = Eigen::Map<Vec3>;
    if (rotates) {
      const In w(y + w_at), w_dot(d + w_at);
      const Vec3 m = moments.cwiseProduct(w);
      Out(g + w_at) = m;
      if (w_at > 0) {
        const Vec3 torque = moments.cwiseProduct(w_dot) + w.cross(m);
        const Quaternion q(y[0], y[1], y[2], y[3]);
        const Quaternion v = q * Quaternion(0, torque.x(), torque.y(), torque.z());
        const double scale = -2 / q.squaredNorm();
        g[0] = scale * v.w(), g[1] = scale * v.x(), g[2] = scale * v.y(), g[3] = scale * v.z();
      }
    }
    if (model.size() >= p_at + 6) {
      Out(g + p_at) = -mass * In(d + p_at + 3);
      Out(g + p_at + 3) = mass * In(y + p_at + 3);
    }
  }
};

struct ArkodeDeleter {
  void (*free)(void**) = nullptr;
  void operator()(void* arkode) const { free(&arkode); }
};

/// A watch that also tells the energy and its gradient.
class EnergyWatch : public Watch {
 public:
  EnergyWatch(std::unique_ptr<ErasedModel> model, const KeptEnergy& kept)
      : Watch(std::move(model)), kept_(kept) {}

  static int energy(N_Vector y, sunrealtype* e, void* user) {
    *e = self(user).model().sample(0, NV_DATA_S(y)).total_energy;
    return 0;
  }
  static int gradient(N_Vector y, N_Vector g, void* user) {
    auto& w = self(user);
    w.derivative_.resize(static_cast<std::size_t>(w.model().size()));
    w.model().rhs(0, NV_DATA_S(y), w.derivative_.data());
    w.kept_.gradient(w.model(), NV_DATA_S(y), w.derivative_.data(), NV_DATA_S(g));
    return 0;
  }

 private:
  static EnergyWatch& self(void* user) { return static_cast<EnergyWatch&>(*static_cast<Watch*>(user)); }
  KeptEnergy kept_;
  std::vector<double> derivative_;
};

/// One ARKODE object and the state that it hands out.
class ArkodeLine {
 public:
  /// table   the library's number of it, an ARKODE_ERKTableID, ARKODE_DIRKTableID or ARKODE_SPRKMethodID
  ArkodeLine(SUNContext context, EnergyWatch& watch, const Setting& setting, CarriedBy by, int table, Way way)
      : by_(by), calls_(calls_of(by)) {
    const int size = watch.model().size();
    y_ = serial_vector(size, context, way == Way::fixed_length_vectors);
    std::ranges::copy(watch.model().initial(), state());
    arkode_ = {create(context), ArkodeDeleter{calls_.free}};
    if (!arkode_) throw std::bad_alloc();
    silence();
    calls_.set_user_data(arkode_.get(), static_cast<Watch*>(&watch));
#ifdef POLHODE_SPRKSTEP
    if (way == Way::relaxed)
      POLHODE_ARKODE(SetRelaxFn)(arkode_.get(), EnergyWatch::energy, EnergyWatch::gradient);
    if (by == CarriedBy::sprkstep) {
      const ARKodeSPRKTable method = ARKodeSPRKTable_Load(static_cast<ARKODE_SPRKMethodID>(table));
      SPRKStepSetMethod(arkode_.get(), method);  // copies it
      ARKodeSPRKTable_Free(method);
      // 7.1 clears their vector at each start, whether it is there or not.
      SPRKStepSetUseCompensatedSums(arkode_.get(), 1);
    } else
#endif
        if (by == CarriedBy::erkstep)
      ERKStepSetTableNum(arkode_.get(), static_cast<ARKODE_ERKTableID>(table));
    else if (by == CarriedBy::arkstep_explicit)
      ARKStepSetTableNum(arkode_.get(), ARKODE_DIRK_NONE, static_cast<ARKODE_ERKTableID>(table));
    else
      ARKStepSetTableNum(arkode_.get(), static_cast<ARKODE_DIRKTableID>(table), ARKODE_ERK_NONE);
    calls_.set_interpolant(arkode_.get(), ARK_INTERP_LAGRANGE);
    calls_.set_interpolant_degree(arkode_.get(), 1);
    const bool fixed = setting.knob == Knob::steps;
    calls_.tolerances(arkode_.get(), fixed ? 1e-13 : setting.rtol,
                      fixed ? 1e-13 : setting.absolute_tolerance());
    if (by == CarriedBy::arkstep_implicit) {
      matrix_ = owned<Owned<SUNMatrix>>(SUNDenseMatrix(size, size, context));
      linear_ = owned<Owned<SUNLinearSolver>>(SUNLinSol_Dense(y_.get(), matrix_.get(), context));
      POLHODE_ARKODE(SetLinearSolver)(arkode_.get(), linear_.get(), matrix_.get());
      POLHODE_ARKODE(SetJacFn)(arkode_.get(), Watch::jacobian);
      if (fixed) {
        POLHODE_ARKODE(SetMaxNonlinIters)(arkode_.get(), 50);
        // Not given up where the corrections grow at first: steps may be twice as large before they fail.
        POLHODE_ARKODE(SetNonlinRDiv)(arkode_.get(), 1e6);
      }
    }
  }
  ArkodeLine(const ArkodeLine&) = delete;
  ArkodeLine& operator=(const ArkodeLine&) = delete;

  double* state() const { return NV_DATA_S(y_.get()); }
  /// Begins a run at t from what is in state(); counters at zero.
  void begin(double t) {
#ifdef POLHODE_SPRKSTEP
    if (by_ == CarriedBy::sprkstep)
      SPRKStepReInit(arkode_.get(), Watch::rhs_of_rates, Watch::rhs_of_places, t, y_.get());
    else
#endif
        if (by_ == CarriedBy::erkstep)
      ERKStepReInit(arkode_.get(), Watch::rhs, t, y_.get());
    else
      ARKStepReInit(arkode_.get(), explicit_rhs(), implicit_rhs(), t, y_.get());
  }
  /// Goes on at t from what is in state().
  void go_on_from(double t) { calls_.reset(arkode_.get(), t, y_.get()); }
  void fix_step(double h) { calls_.set_fixed_step(arkode_.get(), h); }
  void first_step(double h) { calls_.set_first_step(arkode_.get(), h); }
  void stop_at(double t) { calls_.set_stop_time(arkode_.get(), t); }
  void limit_steps(std::int64_t n) { calls_.set_step_limit(arkode_.get(), n); }

  /// One step towards t_end, or all of them; t becomes the time reached. Negative: a failure.
  int step(double t_end, double& t) {
    return calls_.evolve(arkode_.get(), t_end, y_.get(), &t, ARK_ONE_STEP);
  }
  int run(double t_end, double& t) { return calls_.evolve(arkode_.get(), t_end, y_.get(), &t, ARK_NORMAL); }

  double time() const {
    double t = 0;
    calls_.time(arkode_.get(), &t);
    return t;
  }
  std::int64_t steps() const {
    long n = 0;
    calls_.steps(arkode_.get(), &n);
    return n;
  }
  std::int64_t rejected_steps() const {
    long errors = 0, solves = 0;
    calls_.error_failures(arkode_.get(), &errors);
    if (by_ == CarriedBy::arkstep_implicit) POLHODE_ARKODE(GetNumStepSolveFails)(arkode_.get(), &solves);
    return errors + solves;
  }
  std::string text(int flag) const { return flag_text("ARKODE", calls_.flag_name(flag)); }

 private:
  void* create(SUNContext context) const {
#ifdef POLHODE_SPRKSTEP
    if (by_ == CarriedBy::sprkstep)
      return SPRKStepCreate(Watch::rhs_of_rates, Watch::rhs_of_places, 0, y_.get(), context);
#endif
    if (by_ == CarriedBy::erkstep) return ERKStepCreate(Watch::rhs, 0, y_.get(), context);
    return ARKStepCreate(explicit_rhs(), implicit_rhs(), 0, y_.get(), context);
  }
  ARKRhsFn explicit_rhs() const { return by_ == CarriedBy::arkstep_implicit ? nullptr : Watch::rhs; }
  ARKRhsFn implicit_rhs() const { return by_ == CarriedBy::arkstep_implicit ? Watch::rhs : nullptr; }
  /// Prints nothing; from version 7 on the context does not.
  void silence() {
#if SUNDIALS_VERSION_MAJOR < 7
    const auto nothing = [](int, const char*, const char*, char*, void*) {};
#ifdef POLHODE_SPRKSTEP
    if (by_ == CarriedBy::sprkstep)
      SPRKStepSetErrHandlerFn(arkode_.get(), nothing, nullptr);
    else
#endif
        if (by_ == CarriedBy::erkstep)
      ERKStepSetErrHandlerFn(arkode_.get(), nothing, nullptr);
    else
      ARKStepSetErrHandlerFn(arkode_.get(), nothing, nullptr);
#endif
  }

  CarriedBy by_;
  Carrier calls_;
  Owned<N_Vector> y_;
  Owned<SUNMatrix> matrix_;
  Owned<SUNLinearSolver> linear_;
  std::unique_ptr<void, ArkodeDeleter> arkode_;
};

/// ARKODE on one model, made once and initialised anew for each run.
class Arkode {
 public:
  Arkode(std::unique_ptr<ErasedModel> model, const Setting& setting, CarriedBy by, int table, Way way,
         const KeptEnergy& kept)
      : watch_(std::move(model), kept),
        setting_(setting),
        relaxed_(way == Way::relaxed),
        run_(context_.get(), watch_, setting, by, table, way),
        branch_(setting.knob == Knob::steps
                    ? nullptr
                    : std::make_unique<ArkodeLine>(context_.get(), watch_, setting, by, table,
                                                   relaxed_ ? Way::plain : way)),
        before_(watch_.model().initial().begin(), watch_.model().initial().end()) {
    if (branch_) branch_->limit_steps(1000);
  }

  void integrate(const Grid& grid, Trajectory& out) {
    Record record(setting_, grid, out);
    watch_.begin(record);
    std::ranges::copy(watch_.model().initial(), run_.state());
    record.start(sample(0));
    if (grid.stretches.empty()) return;
    run_.begin(0);
    if (setting_.knob == Knob::steps)
      fixed(grid, record, out);
    else
      by_tolerance(grid, record, out);
    out.work.rhs_evals = watch_.calls();
    out.work.jacobian_evals = watch_.jacobians();
  }

 private:
  Sample sample(double t) const { return watch_.model().sample(t, run_.state()); }

  void fixed(const Grid& grid, Record& record, Trajectory& out) {
    run_.limit_steps(-1);  // none: the grid says how many
    double t_start = 0;
    for (const auto& stretch : grid.stretches) {
      if (&stretch != &grid.stretches.front()) run_.go_on_from(t_start);
      run_.fix_step(stretch.h);
      int flag = 0;
      double t = t_start;
      for (std::int64_t i = 0; i < stretch.steps && flag >= 0; ++i) {
        flag = run_.step(stretch.t_end, t);
        out.work.steps += flag >= 0;
      }
      if (flag < 0) return watch_.explain(record, false, 0, run_.text(flag), run_.time());
      if (!record.keep(sample(stretch.t_end))) return;
      t_start = stretch.t_end;
    }
  }

  void by_tolerance(const Grid& grid, Record& record, Trajectory& out) {
    // A relaxed step ends where the energy says, at no asked time: the run goes past the end, and the branch,
    // which is not relaxed, to the time itself.
    if (!relaxed_) run_.stop_at(grid.end());
    const int flag =
        relaxed_ || grid.stretches.size() > 1 ? step_by_step(grid, record) : at_once(grid, record);
    out.work.steps = run_.steps();
    out.work.rejected_steps = run_.rejected_steps();
    if (flag < 0)
      watch_.explain(record, flag == ARK_TOO_MUCH_WORK, setting_.step_limit, run_.text(flag), run_.time());
  }

  int at_once(const Grid& grid, Record& record) {
    run_.limit_steps(setting_.step_limit);
    double t = 0;
    const int flag = run_.run(grid.end(), t);
    if (flag >= 0) record.keep(sample(grid.end()));
    return flag;
  }

  int step_by_step(const Grid& grid, Record& record) {
    const double end = grid.end();
    double t = 0;
    std::int64_t steps = 0;
    for (auto asked = grid.stretches.begin(); asked != grid.stretches.end();) {
      if (steps++ == setting_.step_limit) return ARK_TOO_MUCH_WORK;
      const double t_before = t;
      std::copy_n(run_.state(), before_.size(), before_.begin());
      const int flag = run_.step(end, t);
      if (flag < 0) return flag;
      for (; asked != grid.stretches.end() && asked->t_end <= t; ++asked) {
        const bool here = asked->t_end == t;
        if (!here && !look(t_before, asked->t_end)) {
          record.end(Outcome::solver_failed, "no acceptable step to the asked time", asked->t_end);
          return 0;
        }
        if (!record.keep(here ? sample(t) : watch_.model().sample(asked->t_end, branch_->state()))) return 0;
      }
    }
    return 0;
  }

  /// The branch, from the start of the last step to t.
  bool look(double t_start, double t) {
    const std::int64_t calls = watch_.calls(), jacobians = watch_.jacobians();
    std::ranges::copy(before_, branch_->state());
    branch_->begin(t_start);
    branch_->first_step(t - t_start);
    branch_->stop_at(t);
    double reached = 0;
    const bool there = branch_->run(t, reached) >= 0;
    watch_.forget_calls_since(calls, jacobians);
    return there;
  }

  EnergyWatch watch_;
  Setting setting_;
  bool relaxed_;
  Owned<SUNContext> context_ = make_context();
  ArkodeLine run_;
  std::unique_ptr<ArkodeLine> branch_;
  std::vector<double> before_;  // the state before the last step
};

}  // namespace polhode::sundials
