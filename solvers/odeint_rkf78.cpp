// Boost.Odeint's Fehlberg pair 7(8): thirteen stages.
//
// The library propagates the formula of order 8 and controls the step by the difference to order 7,
//   e = 41/840 h (k1 + k11 - k12 - k13),
// which vanishes when f depends on t alone: the pair is blind to quadrature. The norm of the error is the
// library's own, the maximum of |e_i|/(atol + rtol (|y_i| + h|y_i'|)). Keeps no invariant. Order 8 is claimed
// where doubles can show it, for the attitude; the other errors reach rounding before they settle to a power.
//
// Source: Odeint, boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp; Fehlberg, NASA TR R-287 (1968).
// The stability polynomial was computed from the library's tableau in exact fractions.
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;

struct Rkf78 {
  template <class State>
  using fixed = OdeintFixed<odeint::runge_kutta_fehlberg78<State>, 13>;

  static constexpr bool one_function = false;
  template <class State>
  static auto controlled(const Setting& setting) {
    return controlled_pair<odeint::runge_kutta_fehlberg78<State>>(setting);
  }
};

constexpr double amplification[] = {1,
                                    1,
                                    1.0 / 2,
                                    1.0 / 6,
                                    1.0 / 24,
                                    1.0 / 120,
                                    1.0 / 720,
                                    1.0 / 5040,
                                    1.0 / 40320,
                                    491.0 / 209018880,
                                    1333.0 / 5643509760,
                                    -13.0 / 501645312,
                                    -65.0 / 4514807808};

constinit const Method rows[] = {
    {.id = "odeint-rkf78",
     .family = "Boost.Odeint",
     .summary = "runge_kutta_fehlberg78 on (q, w_B), error-controlled or fixed step",
     .source = "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Fehlberg, NASA TR R-287 (1968)",
     .version = boost_version,
     .by_steps = true,
     .by_tolerance = true,
     // No claim for the energy: its error meets rounding before three steps of the asymptotic range are to be
     // seen.
     .claims = {.attitude_order = 8,
                .rate_order = 8,
                .momentum_order = 8,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = amplification,
     .prepare = run_odeint<Rkf78>},
};

}  // namespace
extern const MethodRows odeint_rkf78;
const MethodRows odeint_rkf78 = rows;
}  // namespace polhode
