// Boost.Odeint's Dormand-Prince pair 5(4): seven stages, the last of which is the first of the next step.
//
// Propagates the formula of order 5. With a tolerance, the step is controlled by the difference to the
// embedded formula of order 4, in the maximum norm of |e_i|/(atol + rtol (|y_i| + h|y_i'|)), which is the
// library's own. Keeps no invariant. No order is claimed for the attitude: on a tumbling body its error falls
// with h^6 almost down to rounding, the term of h^5 being small there.
//
// Source: Odeint, boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp; Dormand & Prince, J. Comput. Appl.
// Math. 6 (1980); stability polynomial: the order conditions and z^6/600.
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;

struct Dopri5 {
  template <class State>
  using fixed = OdeintFixedFsal<odeint::runge_kutta_dopri5<State>, 6>;

  static constexpr bool one_function = true;
  template <class State>
  static auto controlled(const Setting& setting) {
    return controlled_pair<odeint::runge_kutta_dopri5<State>>(setting);
  }
};

constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24, 1.0 / 120, 1.0 / 600};

constinit const Method rows[] = {
    {.id = "odeint-dopri5",
     .family = "Boost.Odeint",
     .summary = "runge_kutta_dopri5 on (q, w_B), error-controlled or fixed step",
     .source =
         "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Dormand & Prince, J. Comput. Appl. Math. 6 (1980)",
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
     .prepare = run_odeint<Dopri5>},
};

}  // namespace
extern const MethodRows odeint_dopri5;
const MethodRows odeint_dopri5 = rows;
}  // namespace polhode
