// Boost.Odeint's Rosenbrock method of order 4 with an estimate of order 3, for stiff equations: six linear
// systems with one matrix a step, no iteration.
//   (1/(gamma h) - J) g_i = f(t + c_i h, y + sum a_ij g_j) + sum c_ij g_j/h + d_i h f_t
//   y <- y + sum m_i g_i
//
// Order 4, L-stable, where the equations do not know the time. Where they do (a gravity gradient), the
// library (Boost 1.74 to 1.83) has order 1: its d4 is 0.0362 and should be -0.0362, as it is in RODAS.
// Measured on dy/dt = sin t - y^2: errors fall with h^1.1, with the other sign with h^4.
// `odeint-rosenbrock4-corrected` is the library with that number, given through its own template parameter.
//
// The matrix is the model's own Jacobian. With a tolerance the library's controller keeps the root mean
// square of e_i/(atol + rtol max(|y_i| before, after the step)) below one, with the predictive control of
// RODAS. Asked times are reached by a branch, as solvers/odeint.hpp says. Keeps no invariant. The price is
// the library's: ublas allocates in every step, which takes microseconds. For mild equations every explicit
// method is cheaper.
//
// Source: Odeint, boost/numeric/odeint/stepper/rosenbrock4.hpp; the coefficients are those of RODAS, Hairer &
// Wanner, Solving ODEs II (1996), IV.7, IV.10.
#include <algorithm>
#include <utility>

#include "solvers/adaptive_step.hpp"
#include "solvers/odeint.hpp"
#include "solvers/odeint_implicit.hpp"

namespace polhode {
namespace {

class RosenbrockAdaptive final : public AdaptiveSteps {
 public:
  RosenbrockAdaptive(const Scene& scene, const Setting& setting, bool corrected)
      : equations_(scene),
        y_(equations_.start()),
        before_(y_),
        aside_(y_),
        run_(odeint_rosenbrock4_stepper(equations_, corrected, setting.absolute_tolerance(), setting.rtol)),
        branch_(
            odeint_rosenbrock4_stepper(equations_, corrected, setting.absolute_tolerance(), setting.rtol)) {
    std::vector<double> d(y_.size());
    equations_.rhs(0, y_.data(), d.data());
    first_ = first_step(y_, d, setting);
  }
  void restart(double t_end, Progress& p) override {
    run_->restart();
    y_ = equations_.start();
    p.rhs_evals = 1;  // of the first step
    p.h = first_ > 0 ? std::min(first_, t_end) : 1e-6 * t_end;
  }
  void cruise(double t_stop, std::int64_t limit, Progress& p) override {
    while (p.t + p.h < t_stop && p.attempts < limit)
      if (!try_step(*run_, y_, p)) break;
  }
  bool attempt(Progress& p) override {
    before_ = y_;
    const std::int64_t accepted = p.accepted;
    try_step(*run_, y_, p);
    return p.accepted > accepted;
  }
  Sample sample(double t) const override { return equations_.sample(t, y_); }
  bool sample_within(double t_start, double t, Sample& out) override {
    branch_->restart();
    aside_ = before_;
    Progress uncounted{.t = t_start, .h = t - t_start};
    while (uncounted.attempts < 1000 && !uncounted.stuck) {
      const bool last = uncounted.t + uncounted.h >= t;
      if (last) uncounted.h = t - uncounted.t;
      const std::int64_t accepted = uncounted.accepted;
      try_step(*branch_, aside_, uncounted);
      if (!last || uncounted.accepted == accepted) continue;
      out = equations_.sample(t, aside_);
      return true;
    }
    return false;
  }
  bool is_finite() const override { return all_finite(y_); }

 private:
  /// One trial step. False: give up.
  bool try_step(ImplicitStepper& stepper, std::vector<double>& y, Progress& p) {
    const double before = p.t, trial = p.h;
    const std::int64_t rhs = equations_.rhs_evals, jacobians = equations_.jacobian_evals;
    const bool good = stepper.try_step(y.data(), p.t, p.h);
    p.rhs_evals += equations_.rhs_evals - rhs;
    p.jacobian_evals += equations_.jacobian_evals - jacobians;
    return p.tell(before, trial, good);
  }

  SceneEquations equations_;
  std::vector<double> y_, before_, aside_;
  std::unique_ptr<ImplicitStepper> run_, branch_;
  double first_ = 0;
};

template <bool corrected>
Prepared prepare_rosenbrock(const Scene& scene, const Setting& setting) {
  if (setting.knob == Knob::steps)
    return run_fixed_steps(std::make_shared<ImplicitFixed>(scene,
                                                           [](ImplicitEquations& equations) {
                                                             return odeint_rosenbrock4_stepper(
                                                                 equations, corrected, 1, 1);
                                                           }),
                           setting);
  return run_adaptive_steps(std::make_shared<RosenbrockAdaptive>(scene, setting, corrected), setting);
}

constexpr std::string_view source =
    "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Hairer & Wanner, Solving ODEs II (1996), IV.7";
constexpr Claims corrected_claims = {.attitude_order = 4,
                                     .rate_order = 4,
                                     .energy_order = 4,
                                     .momentum_order = 4,
                                     .unit_attitude = Claim::no,
                                     .momentum_magnitude = Claim::no,
                                     .space_momentum = Claim::no,
                                     .energy_bounded = Claim::no,
                                     .reversible = Claim::no};

constexpr Claims claims_as_shipped() {
  Claims c = corrected_claims;
  c.timed_order = 1;
  return c;
}

constinit const Method rows[] = {
    {.id = "odeint-rosenbrock4",
     .family = "Boost.Odeint",
     .summary = "rosenbrock4 on (q, w_B) with the model's Jacobian, error-controlled or fixed step; order 4, "
                "but 1 where a load depends on time (the library's d4)",
     .source = source,
     .version = boost_version,
     .by_steps = true,
     .by_tolerance = true,
     .in_studies = false,
     .claims = claims_as_shipped(),
     .prepare = prepare_rosenbrock<false>},
    {.id = "odeint-rosenbrock4-corrected",
     .family = "Boost.Odeint",
     .summary = "the same with the right sign of d4: order 4 also where the equations depend on time",
     .source = source,
     .version = boost_version,
     .by_steps = true,
     .by_tolerance = true,
     .in_studies = false,
     .claims = corrected_claims,
     .prepare = prepare_rosenbrock<true>},
};

}  // namespace
extern const MethodRows odeint_rosenbrock4;
const MethodRows odeint_rosenbrock4 = rows;
}  // namespace polhode
