// One CVODE object for one model, made once and initialised anew for each run.
//
// Asked times are interpolated by CVODE's own polynomial, of the order of the step they lie in; the stop time
// is set to the end of the run, which is hit exactly. The first step is taken with the end as its target,
// because CVODE chooses its size from there. So errors and counters do not depend on how many samples are
// asked, and a run to one end time is the run that CVode(end, CV_NORMAL) would make.
#pragma once
#include <Eigen/Core>

#include "solvers/sundials_vector.hpp"
#include "solvers/sundials_watch.hpp"

namespace polhode::sundials {

/// What a row chooses of CVODE.
struct CvodeChoice {
  enum class Formula { adams, bdf } formula = Formula::adams;
  bool projected = false;             // BDF: q to unit length after each step
  bool stability_limit = false;       // BDF: watches for an order that is not stable
  bool difference_quotients = false;  // BDF: CVODE's own Jacobian, not the model's
  bool fixed_length_vectors = false;  // ours, in place of the library's
};

class Cvode {
 public:
  Cvode(std::unique_ptr<ErasedModel> model, const Setting& setting, const CvodeChoice& choice)
      : watch_(std::move(model)), setting_(setting) {
    const int size = watch_.model().size();
    y_ = serial_vector(size, context_.get(), choice.fixed_length_vectors);
    set_initial();
    const bool adams = choice.formula == CvodeChoice::Formula::adams;
    cvode_ = owned<OwnedCvode>(CVodeCreate(adams ? CV_ADAMS : CV_BDF, context_.get()));
    silence(cvode_.get());
    CVodeInit(cvode_.get(), Watch::rhs, 0, y_.get());
    CVodeSStolerances(cvode_.get(), setting.rtol, setting.absolute_tolerance());
    CVodeSetUserData(cvode_.get(), &watch_);
    if (adams) {
      fixed_point_ = owned<Owned<SUNNonlinearSolver>>(SUNNonlinSol_FixedPoint(y_.get(), 0, context_.get()));
      CVodeSetNonlinearSolver(cvode_.get(), fixed_point_.get());
    } else {  // Newton's method is CVODE's default
      matrix_ = owned<Owned<SUNMatrix>>(SUNDenseMatrix(size, size, context_.get()));
      linear_ = owned<Owned<SUNLinearSolver>>(SUNLinSol_Dense(y_.get(), matrix_.get(), context_.get()));
      CVodeSetLinearSolver(cvode_.get(), linear_.get(), matrix_.get());
      if (!choice.difference_quotients) CVodeSetJacFn(cvode_.get(), Watch::jacobian);
    }
    if (choice.stability_limit) CVodeSetStabLimDet(cvode_.get(), SUNTRUE);
    if (choice.projected) CVodeSetProjFn(cvode_.get(), project);
  }

  void integrate(const Grid& grid, Trajectory& out) {
    Record record(setting_, grid, out);
    watch_.begin(record);
    set_initial();
    record.start(watch_.model().sample(0.0, state()));
    if (grid.stretches.empty()) return;

    CVodeReInit(cvode_.get(), 0, y_.get());
    CVodeSetStopTime(cvode_.get(), grid.end());
    CVodeSetMaxNumSteps(cvode_.get(), setting_.step_limit);
    double t = 0;
    int flag =
        grid.stretches.size() > 1 ? CVode(cvode_.get(), grid.end(), y_.get(), &t, CV_ONE_STEP) : CV_SUCCESS;
    for (const auto& stretch : grid.stretches) {
      if (flag >= 0) flag = advance(stretch.t_end, t);
      if (flag < 0 || !record.keep(watch_.model().sample(stretch.t_end, state()))) break;
    }
    count(out.work);
    if (flag < 0) {
      CVodeGetCurrentTime(cvode_.get(), &t);
      watch_.explain(record, flag == CV_TOO_MUCH_WORK, setting_.step_limit,
                     flag_text("CVODE", CVodeGetReturnFlagName(flag)), t);
    }
  }

 private:
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

  /// Right-hand sides are all that were called, those of difference quotients included.
  void count(Work& work) const {
    long steps = 0, error_failures = 0, solve_failures = 0, jacobians = 0;
    CVodeGetNumSteps(cvode_.get(), &steps);
    CVodeGetNumErrTestFails(cvode_.get(), &error_failures);
    CVodeGetNumStepSolveFails(cvode_.get(), &solve_failures);
    if (linear_) CVodeGetNumJacEvals(cvode_.get(), &jacobians);
    work = {steps, error_failures + solve_failures, watch_.calls(), jacobians};
  }

  double* state() const { return NV_DATA_S(y_.get()); }
  void set_initial() { std::ranges::copy(watch_.model().initial(), state()); }

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

  Watch watch_;
  Setting setting_;
  Owned<SUNContext> context_ = make_context();  // made first, freed last
  Owned<N_Vector> y_;
  Owned<SUNMatrix> matrix_;
  Owned<SUNLinearSolver> linear_;
  Owned<SUNNonlinearSolver> fixed_point_;
  OwnedCvode cvode_;
};

/// The run of a row.
inline Prepared run_cvode(std::unique_ptr<ErasedModel> model, const Setting& setting,
                          const CvodeChoice& choice) {
  return {[cvode = std::make_shared<Cvode>(std::move(model), setting, choice)](
              const Grid& grid, Trajectory& out) { cvode->integrate(grid, out); },
          {}};
}

inline constexpr std::string_view cvode_source =
    "Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Cohen & Hindmarsh, Computers in Physics 10 (1996)";
inline constexpr std::string_view sundials_version = "SUNDIALS " SUNDIALS_VERSION;
/// Of every row that does nothing for an invariant.
inline constexpr Claims keeps_nothing = {.unit_attitude = Claim::no,
                                         .momentum_magnitude = Claim::no,
                                         .space_momentum = Claim::no,
                                         .energy_bounded = Claim::no,
                                         .reversible = Claim::no};

}  // namespace polhode::sundials
