// Boost.Odeint's classical Runge-Kutta method of order 4, at fixed step: the same formula as `rk4`, another
// code.
//   k1 = f(t, y), k2 = f(t + h/2, y + h/2 k1), k3 = f(t + h/2, y + h/2 k2), k4 = f(t + h, y + h k3),
//   y <- y + h/6 (k1 + 2 k2 + 2 k3 + k4)
//
// Order 4; keeps no invariant, not even |q|. No order is claimed for the energy of a free body: its error
// falls with h^5 while steps are long, and settles to h^4 only below h = 1/64 or so. What it is here for: an
// independent result and an honest price.
//
// Source: Odeint, boost/numeric/odeint/stepper/runge_kutta4.hpp; Kutta, Z. Math. Phys. 46 (1901).
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

struct Rk4 {
  template <class State>
  using fixed = OdeintFixed<boost::numeric::odeint::runge_kutta4<State>, 4>;
};

constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};

constinit const Method rows[] = {
    {.id = "odeint-rk4",
     .family = "Boost.Odeint",
     .summary = "runge_kutta4 on (q, w_B), fixed step",
     .source = "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Kutta, Z. Math. Phys. 46 (1901)",
     .version = boost_version,
     .by_steps = true,
     .claims = {.attitude_order = 4,
                .rate_order = 4,
                .energy_order = 4,
                .momentum_order = 4,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = amplification,
     .prepare = run_odeint<Rk4>},
};

}  // namespace
extern const MethodRows odeint_rk4;
const MethodRows odeint_rk4 = rows;
}  // namespace polhode
