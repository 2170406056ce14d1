// Boost.Odeint's Adams-Bashforth-Moulton methods of k steps, k = 4 and 8, at fixed step.
//   predict y* = y_n + h sum_{j<k} beta_j f_{n-j}
//   correct y_{n+1} = y_n + h (gamma_0 f(t + h, y*) + gamma_1 f_n + gamma_2 f_{n-1} + ...)
// Two evaluations a step, whatever the order. The slopes of the last steps are the stepper's memory: it lives
// as long as the run, and starts anew if the step size changes.
//
// The first k - 1 steps are the library's runge_kutta4, whatever k. Their local errors, of order 5 each, are
// carried along and never mended. For k = 4 that is enough. For k = 8 it is not: `odeint-abm8` starts with
// the library's Fehlberg formula of order 8 in their place, and `odeint-abm8-rk4-start` is what the library
// does if nobody tells it otherwise.
//
// Orders are claimed where the steps that doubles leave show them: the energy's for k = 4 and 8 (the attitude
// errors fall with h^4.6 and h^8.5 there), the attitude's of order 5 for the poor start.
//
// Keeps no invariant. Not symmetric in time, unstable for long steps: no stability polynomial, since the next
// state is no multiple of the last one alone.
//
// Source: Odeint, boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp; Hairer, Norsett & Wanner, Solving
// ODEs I (1993), III.1.
#include <boost/numeric/odeint/stepper/adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;

/// Right-hand side, and by which formula to start.
template <AnyModel M>
struct AbmRhs {
  const M& model;
  bool fehlberg_start;
  [[gnu::always_inline]] void operator()(const typename M::State& y, typename M::State& d, double t) const {
    derivative(model, t, y, d);
  }
};

/// The library's start, or its Fehlberg formula in the same place; the right-hand side of that one is called,
/// not inlined thirteen times for the sake of seven steps.
template <class State>
class Start {
 public:
  template <class Rhs>
  void do_step_dxdt_impl(const Rhs& rhs, const State& in, const State& d, double t, State& out, double h) {
    if (rhs.fehlberg_start)
      fehlberg_step({&rhs, [](const void* f, const State& y, State& slope,
                              double at) { (*static_cast<const Rhs*>(f))(y, slope, at); }},
                    in, d, t, out, h);
    else
      rk4_.do_step_dxdt_impl(rhs, in, d, t, out, h);
  }

 private:
  struct CalledRhs {
    const void* rhs;
    void (*call)(const void*, const State&, State&, double);
    void operator()(const State& y, State& d, double t) const { call(rhs, y, d, t); }
  };
  [[gnu::noinline]] void fehlberg_step(const CalledRhs& rhs, const State& in, const State& d, double t,
                                       State& out, double h) {
    fehlberg78_.do_step_dxdt_impl(rhs, in, d, t, out, h);
  }
  odeint::runge_kutta4<State> rk4_;
  odeint::runge_kutta_fehlberg78<State> fehlberg78_;
};

/// The library's stepper is neither copied nor moved: a part of it refers to another.
template <std::size_t k, AnyModel M>
class AbmSteps final : public FixedSteps {
 public:
  AbmSteps(M model, bool fehlberg_start) : model_(std::move(model)), fehlberg_start_(fehlberg_start) {}
  void restart() override {
    y_ = model_.initial;
    stepper_.reset();
    started_ = 0;
    h_ = 0;
  }
  Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) override {
    // Sizes of stretches that are meant to be equal differ by rounding.
    if (!(std::abs(h - h_) <= 1e-9 * std::abs(h))) {
      stepper_.reset();
      started_ = 0;
      h_ = h;
    }
    const std::int64_t steps = until - i,
                       starting = std::min(steps, static_cast<std::int64_t>(k) - 1 - started_);
    started_ += starting;
    const AbmRhs<M> rhs{model_, fehlberg_start_};
    go(rhs, t_start, h, i, until);
    Advance done;
    done.next = until;
    done.rhs_evals = starting * (fehlberg_start_ ? 13 : 4) + (steps - starting) * 2;
    if (!all_finite(y_)) {
      done.outcome = Outcome::not_finite;
      done.reason = "a state that is not finite";
    }
    return done;
  }
  Sample sample(double t) const override { return observe(model_, t, y_.data()); }

 private:
  using State = typename M::State;
  // Flattened: with eight steps the compiler left to itself makes functions of the library's sums.
  [[gnu::noinline, gnu::flatten]] void go(const AbmRhs<M>& rhs, double t_start, double h, std::int64_t i,
                                          std::int64_t until) {
    auto y = y_;
    for (; i < until; ++i) stepper_.do_step(rhs, y, t_start + static_cast<double>(i) * h, h);
    y_ = y;
  }

  M model_;
  bool fehlberg_start_;
  State y_ = model_.initial;
  odeint::adams_bashforth_moulton<k, State, double, State, double, odeint::array_algebra,
                                  typename odeint::operations_dispatcher<State>::operations_type,
                                  odeint::initially_resizer, Start<State>>
      stepper_;
  std::int64_t started_ = 0;
  double h_ = 0;
};

template <std::size_t k, bool fehlberg_start>
Prepared prepare_abm(const Scene& scene, const Setting& setting) {
  const auto make = [](auto model) -> std::shared_ptr<FixedSteps> {
    return std::make_shared<AbmSteps<k, decltype(model)>>(std::move(model), fehlberg_start);
  };
  return run_fixed_steps(with_model(scene, make), setting);
}

constexpr Claims claims_with(double attitude_order, double energy_order) {
  return {.attitude_order = attitude_order,
          .energy_order = energy_order,
          .unit_attitude = Claim::no,
          .momentum_magnitude = Claim::no,
          .space_momentum = Claim::no,
          .energy_bounded = Claim::no,
          .reversible = Claim::no};
}
constexpr std::string_view source =
    "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Hairer, Norsett & Wanner, Solving ODEs I (1993), III.1";

constinit const Method rows[] = {
    {.id = "odeint-abm4",
     .family = "Boost.Odeint",
     .summary = "adams_bashforth_moulton of four steps on (q, w_B), fixed step",
     .source = source,
     .version = boost_version,
     .by_steps = true,
     .in_studies = false,
     .claims = claims_with(Claims::none, 4),
     .prepare = prepare_abm<4, false>},
    {.id = "odeint-abm8",
     .family = "Boost.Odeint",
     .summary = "adams_bashforth_moulton of eight steps on (q, w_B), started by runge_kutta_fehlberg78",
     .source = source,
     .version = boost_version,
     .by_steps = true,
     .in_studies = false,
     .claims = claims_with(Claims::none, 8),
     .prepare = prepare_abm<8, true>},
    {.id = "odeint-abm8-rk4-start",
     .family = "Boost.Odeint",
     .summary = "adams_bashforth_moulton of eight steps as the library starts it, by runge_kutta4",
     .source = source,
     .version = boost_version,
     .by_steps = true,
     .in_studies = false,
     .claims = claims_with(5, Claims::none),
     .prepare = prepare_abm<8, false>},
};

}  // namespace
extern const MethodRows odeint_abm;
const MethodRows odeint_abm = rows;
}  // namespace polhode
