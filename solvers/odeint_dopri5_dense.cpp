// Boost.Odeint's Dormand-Prince pair 5(4) with the library's dense output: make_dense_output's stepper.
//
// The steps are those of `odeint-dopri5` until the last, which is not shortened: it passes the end. Every
// sample, the end included, is the library's interpolation of order 4 between two steps. It costs no
// evaluation, and accuracy: the errors within steps are larger than those at their ends (how much:
// solvers/odeint.hpp). Here to show that price; where samples are to be as good as the run, `odeint-dopri5`
// is the row.
//
// Rejected trials happen inside the library; they are counted by their evaluations, six each.
//
// Source: Odeint, boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp; Dormand & Prince, J. Comput.
// Appl. Math. 6 (1980); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.6.
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
// after the stepper, whose includes it forgets
#include <boost/numeric/odeint/stepper/dense_output_runge_kutta.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;

template <AnyModel M>
class Dopri5Dense final : public AdaptiveSteps {
 public:
  using State = typename M::State;
  Dopri5Dense(M model, const Setting& setting)
      : model_(std::move(model)), stepper_(controlled_pair<odeint::runge_kutta_dopri5<State>>(setting)) {
    State d;
    model_.rhs(0.0, model_.initial.data(), d.data());
    first_ = first_step(model_.initial, d, setting);
    stepper_.initialize(model_.initial, 0, 1);
  }

  void restart(double t_end, Progress& p) override {
    p.h = first_ > 0 ? std::min(first_, t_end) : 1e-6 * t_end;
    p.rhs_evals = 2;  // of the first step's size, and its slope
    stepper_.initialize(model_.initial, 0, p.h);
    slope_known_ = false;
  }
  void cruise(double t_stop, std::int64_t limit, Progress& p) override {
    while (p.t + p.h < t_stop && p.attempts < limit)
      if (!try_step(p)) break;
  }
  bool attempt(Progress& p) override { return try_step(p); }
  Sample sample(double t) const override {
    State y;
    if (t == stepper_.current_time())
      y = stepper_.current_state();
    else
      stepper_.calc_state(t, y);
    return observe(model_, t, y.data());
  }
  bool sample_within(double, double t, Sample& out) override {
    out = sample(t);
    return true;
  }
  bool is_finite() const override { return all_finite(stepper_.current_state()); }

 private:
  /// A step with all its trials. False: given up.
  bool try_step(Progress& p) {
    const double before = stepper_.current_time();
    std::int64_t calls = 0;
    try {
      stepper_.do_step(OdeintRhs<M>{&model_, &calls});
    } catch (const odeint::odeint_error&) {  // 500 trials in vain
      p.stuck = true;
    }
    calls -= !slope_known_;
    slope_known_ = true;
    p.rhs_evals += calls;
    const double h = stepper_.current_time() - before;
    for (std::int64_t rejected = calls / 6 - !p.stuck; rejected > 0; --rejected) ++p.attempts;
    if (p.stuck) return false;
    p.t = stepper_.current_time();
    p.h = stepper_.current_time_step();
    return p.tell(before, h, true);
  }

  M model_;
  double first_ = 0;
  bool slope_known_ = false;
  odeint::dense_output_runge_kutta<odeint::controlled_runge_kutta<odeint::runge_kutta_dopri5<State>>>
      stepper_;
};

Prepared prepare_dense(const Scene& scene, const Setting& setting) {
  if (setting.knob == Knob::steps) return {{}, "has no fixed step size, only a tolerance"};
  return with_model(scene, [&](auto model) {
    return run_adaptive_steps(std::make_shared<Dopri5Dense<decltype(model)>>(std::move(model), setting),
                              setting);
  });
}

constinit const Method rows[] = {
    {.id = "odeint-dopri5-dense",
     .family = "Boost.Odeint",
     .summary = "runge_kutta_dopri5 on (q, w_B), its samples from the library's dense output of order 4",
     .source =
         "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Dormand & Prince, J. Comput. Appl. Math. 6 (1980)",
     .version = boost_version,
     .by_tolerance = true,
     .in_studies = false,
     .claims = {.unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = prepare_dense},
};

}  // namespace
extern const MethodRows odeint_dopri5_dense;
const MethodRows odeint_dopri5_dense = rows;
}  // namespace polhode
