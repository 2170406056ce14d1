// Boost.Odeint's Cash-Karp pair 5(4): six stages.
//
// Propagates the formula of order 5. With a tolerance, the step is controlled by the difference to the
// embedded formula of order 4, in the maximum norm of |e_i|/(atol + rtol (|y_i| + h|y_i'|)), which is the
// library's own. No stage serves the next step: a rejected step is paid in full. Keeps no invariant.
//
// Source: Odeint, boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp; Cash & Karp, ACM Trans. Math.
// Softw. 16 (1990); stability polynomial: the order conditions and z^6/800.
#include <boost/numeric/odeint/stepper/runge_kutta_cash_karp54.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;

struct CashKarp54 {
  template <class State>
  using fixed = OdeintFixed<odeint::runge_kutta_cash_karp54<State>, 6>;

  static constexpr bool one_function = true;
  template <class State>
  static auto controlled(const Setting& setting) {
    return controlled_pair<odeint::runge_kutta_cash_karp54<State>>(setting);
  }
};

constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 800};

constinit const Method rows[] = {
    {.id = "odeint-cash-karp54",
     .family = "Boost.Odeint",
     .summary = "runge_kutta_cash_karp54 on (q, w_B), error-controlled or fixed step",
     .source =
         "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Cash & Karp, ACM Trans. Math. Softw. 16 (1990)",
     .version = boost_version,
     .by_steps = true,
     .by_tolerance = true,
     .claims = {.attitude_order = 5,
                .rate_order = 5,
                .energy_order = 5,
                .momentum_order = 5,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = amplification,
     .prepare = run_odeint<CashKarp54>},
};

}  // namespace
extern const MethodRows odeint_cash_karp54;
const MethodRows odeint_cash_karp54 = rows;
}  // namespace polhode
