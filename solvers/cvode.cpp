// SUNDIALS CVODE: linear multistep methods of variable order and step on the flat state of a model.
//
// cvode-adams: Adams-Moulton, orders 1 to 12, functional iteration; no Jacobian and no linear solver is made.
//
// cvode-bdf: BDF, orders 1 to 5, Newton with the model's own Jacobian and dense LU.
//
// cvode-bdf-projected: BDF that projects q to unit length after each step by CVodeSetProjFn and takes the
// part of the error estimate along q out of the error test. |q| is one to rounding where a step ends, thus at
// the end of the run; at an asked time inside a step the interpolant leaves the sphere by less than the
// tolerance.
//
// None keeps energy or momentum. The attitude error of a tumbling body is some 30 to 200 times the tolerance.
//
// Asked times are interpolated by CVODE's own polynomial, of the order of the step they lie in; the stop time
// is set to the end of the run, which is hit exactly. The first step is taken with the end as its target,
// because CVODE chooses its size from there. So errors and counters do not depend on how many samples are
// asked, and a run to one end time is the run that CVode(end, CV_NORMAL) would make.
//
// Source: Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Cohen & Hindmarsh, CVODE, Computers in Physics 10
// (1996); projection: Eich, SIAM J. Numer. Anal. 30 (1993).
#include <Eigen/Core>

#include "solvers/erased_model.hpp"
#include "solvers/record.hpp"
#include "solvers/sundials.hpp"

namespace polhode {
namespace {

using namespace sundials;

enum class Formula { adams, bdf, bdf_projected };

/// One CVODE object for one model, made once and initialised anew for each run.
class Cvode {
 public:
  Cvode(std::unique_ptr<ErasedModel> model, const Setting& setting, Formula formula)
      : model_(std::move(model)), setting_(setting), size_(model_->initial().size()) {
    y_ = owned<Owned<N_Vector>>(N_VNew_Serial(model_->size(), context_.get()));
    N_VEnableFusedOps_Serial(y_.get(), SUNTRUE);  // before CVODE clones it: its history sums in one pass
    set_initial();
    cvode_ = owned<OwnedCvode>(CVodeCreate(formula == Formula::adams ? CV_ADAMS : CV_BDF, context_.get()));
    silence(cvode_.get());
    CVodeInit(cvode_.get(), rhs, 0, y_.get());
    CVodeSStolerances(cvode_.get(), setting.rtol, setting.absolute_tolerance());
    CVodeSetUserData(cvode_.get(), this);
    if (formula == Formula::adams) {
      fixed_point_ = owned<Owned<SUNNonlinearSolver>>(SUNNonlinSol_FixedPoint(y_.get(), 0, context_.get()));
      CVodeSetNonlinearSolver(cvode_.get(), fixed_point_.get());
    } else {  // Newton's method is CVODE's default
      matrix_ = owned<Owned<SUNMatrix>>(SUNDenseMatrix(model_->size(), model_->size(), context_.get()));
      linear_ = owned<Owned<SUNLinearSolver>>(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()));
      CVodeSetLinearSolver(cvode_.get(), linear_.get(), matrix_.get());
      CVodeSetJacFn(cvode_.get(), jacobian);
    }
    if (formula == Formula::bdf_projected) CVodeSetProjFn(cvode_.get(), project);
  }
  Cvode(const Cvode&) = delete;  // CVODE holds its address
  Cvode& operator=(const Cvode&) = delete;

  void integrate(const Grid& grid, Trajectory& out) {
    Record record(setting_, grid, out);
    record_ = &record;
    set_initial();
    record.start(model_->sample(0.0, state()));
    if (grid.stretches.empty()) return;
    calls_ = 0;
    not_finite_ = timed_out_ = false;

    CVodeReInit(cvode_.get(), 0, y_.get());
    CVodeSetStopTime(cvode_.get(), grid.end());
    CVodeSetMaxNumSteps(cvode_.get(), setting_.step_limit);
    double t = 0;
    int flag =
        grid.stretches.size() > 1 ? CVode(cvode_.get(), grid.end(), y_.get(), &t, CV_ONE_STEP) : CV_SUCCESS;
    for (const auto& stretch : grid.stretches) {
      if (flag >= 0) flag = advance(stretch.t_end, t);
      if (flag < 0 || !record.keep(model_->sample(stretch.t_end, state()))) break;
    }
    count(out.work);
    if (flag < 0) explain(flag, record);
  }

 private:
  static constexpr std::int64_t calls_per_look = 1024;  // at the clock

  /// CVODE to t_asked; its step limit holds for one call, ours for the run.
  int advance(double t_asked, double& t) {
    long taken = 0;
    CVodeGetNumSteps(cvode_.get(), &taken);
    double reached = 0;
    CVodeGetCurrentTime(cvode_.get(), &reached);
    if (taken > 0) {
      const std::int64_t left = setting_.step_limit - taken;
      if (left <= 0 && reached < t_asked) return CV_TOO_MUCH_WORK;
      CVodeSetMaxNumSteps(cvode_.get(), std::max<std::int64_t>(left, 1));
    }
    return CVode(cvode_.get(), t_asked, y_.get(), &t, CV_NORMAL);
  }

  void count(Work& work) const {
    long steps = 0, error_failures = 0, solve_failures = 0, jacobians = 0;
    CVodeGetNumSteps(cvode_.get(), &steps);
    CVodeGetNumErrTestFails(cvode_.get(), &error_failures);
    CVodeGetNumStepSolveFails(cvode_.get(), &solve_failures);
    if (linear_) CVodeGetNumJacEvals(cvode_.get(), &jacobians);
    work = {steps, error_failures + solve_failures, calls_, jacobians};
  }

  void explain(int flag, Record& record) const {
    double t = 0;
    CVodeGetCurrentTime(cvode_.get(), &t);
    if (timed_out_) {
      record.in_time(t);
    } else if (not_finite_) {
      record.end(Outcome::not_finite, "a right-hand side that is not finite", t);
    } else if (flag == CV_TOO_MUCH_WORK) {
      record.end(Outcome::step_limit, "gave up after " + std::to_string(setting_.step_limit) + " steps", t);
    } else {
      const std::unique_ptr<char, void (*)(void*)> name(CVodeGetReturnFlagName(flag), std::free);
      record.end(Outcome::solver_failed, std::string("CVODE: ") + name.get(), t);
    }
  }

  double* state() const { return NV_DATA_S(y_.get()); }
  void set_initial() { std::ranges::copy(model_->initial(), state()); }

  /// A right-hand side that is not finite is a failure from which a shorter step may recover (1); a timeout
  /// is one for good (-1).
  static int rhs(sunrealtype t, N_Vector y, N_Vector d, void* user) {
    auto& self = *static_cast<Cvode*>(user);
    ++self.calls_;
    if (self.calls_ % calls_per_look == 0) self.timed_out_ = self.timed_out_ || !self.record_->in_time(t);
    // Said at every call from then on: CVODE 6.4 goes on after a single -1 inside its functional iteration.
    if (self.timed_out_) return -1;
    self.model_->rhs(t, NV_DATA_S(y), NV_DATA_S(d));
    self.not_finite_ = !all_finite(std::span<const double>(NV_DATA_S(d), self.size_));
    return self.not_finite_ ? 1 : 0;
  }

  /// Both libraries store columns one after another.
  static int jacobian(sunrealtype t, N_Vector y, N_Vector, SUNMatrix J, void* user, N_Vector, N_Vector,
                      N_Vector) {
    static_cast<const Cvode*>(user)->model_->jacobian(t, NV_DATA_S(y), SM_DATA_D(J));
    return 0;
  }

  /// The correction from y to the nearest state with |q| = 1, and the error estimate without its part along
  /// q.
  static int project(sunrealtype, N_Vector y, N_Vector correction, sunrealtype, N_Vector error, void*) {
    const Eigen::Map<const Eigen::Vector4d> q(NV_DATA_S(y));
    const double length = q.norm();
    if (!(length > 0)) return 1;  // a shorter step may keep clear of zero
    N_VConst(0, correction);
    Eigen::Map<Eigen::Vector4d>(NV_DATA_S(correction)) = q * (1 / length - 1);
    if (error != nullptr) {
      Eigen::Map<Eigen::Vector4d> e(NV_DATA_S(error));
      e -= q * (q.dot(e) / (length * length));
    }
    return 0;
  }

  std::unique_ptr<ErasedModel> model_;
  Setting setting_;
  std::size_t size_;
  Record* record_ = nullptr;                    // of the run in progress
  Owned<SUNContext> context_ = make_context();  // made first, freed last
  Owned<N_Vector> y_;
  Owned<SUNMatrix> matrix_;
  Owned<SUNLinearSolver> linear_;
  Owned<SUNNonlinearSolver> fixed_point_;
  OwnedCvode cvode_;
  std::int64_t calls_ = 0;
  bool not_finite_ = false, timed_out_ = false;
};

template <Formula formula>
Prepared prepare(const Scene& scene, const Setting& setting) {
  auto model = erased_model(scene);
  if (formula == Formula::bdf_projected && !model->has_attitude())
    return {{}, "needs an attitude to project"};
  return {[cvode = std::make_shared<Cvode>(std::move(model), setting, formula)](
              const Grid& grid, Trajectory& out) { cvode->integrate(grid, out); },
          {}};
}

constexpr Claims claims = {.unit_attitude = Claim::no,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no,
                           .reversible = Claim::no};
constexpr std::string_view source =
    "Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Cohen & Hindmarsh, Computers in Physics 10 (1996)";
constexpr std::string_view version = "SUNDIALS " SUNDIALS_VERSION;

constinit const Method rows[] = {
    {.id = "cvode-adams",
     .family = "SUNDIALS CVODE",
     .summary = "Adams-Moulton of variable order on (q, w_B), functional iteration",
     .source = source,
     .version = version,
     .by_tolerance = true,
     .claims = claims,
     .prepare = prepare<Formula::adams>},
    {.id = "cvode-bdf",
     .family = "SUNDIALS CVODE",
     .summary = "BDF of variable order on (q, w_B), Newton with analytic Jacobian",
     .source = source,
     .version = version,
     .by_tolerance = true,
     .claims = claims,
     .prepare = prepare<Formula::bdf>},
    {.id = "cvode-bdf-projected",
     .family = "SUNDIALS CVODE",
     .summary = "BDF with q projected to unit length after each step by CVODE's own projection",
     .source = "Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Eich, SIAM J. Numer. Anal. 30 (1993)",
     .version = version,
     .by_tolerance = true,
     .claims = claims,
     .prepare = prepare<Formula::bdf_projected>},
};

}  // namespace
extern const MethodRows cvode;
const MethodRows cvode = rows;
}  // namespace polhode
