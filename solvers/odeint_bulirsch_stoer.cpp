// Boost.Odeint's Bulirsch-Stoer method: the modified midpoint rule with 2, 4, 6, ... substeps, extrapolated
// to substeps of no length; order and step size are both chosen by the error control. Few, long steps.
//
// The library's `bulirsch_stoer` is used, not its `bulirsch_stoer_dense_out`: that one spends evaluations on
// an interpolant in every step and rejects steps whose interpolant (not whose end) is poor. Asked times are
// reached as solvers/odeint.hpp says. Keeps no invariant.
//
// Source: Odeint, boost/numeric/odeint/stepper/bulirsch_stoer.hpp; Hairer, Norsett & Wanner, Solving ODEs I
// (1993), II.9; Bulirsch & Stoer, Numer. Math. 8 (1966).
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

struct BulirschStoer {
  static constexpr bool one_function = true;
  template <class State>
  static auto controlled(const Setting& setting) {
    return boost::numeric::odeint::bulirsch_stoer<State>(setting.absolute_tolerance(), setting.rtol);
  }
};

constinit const Method rows[] = {
    {.id = "odeint-bulirsch-stoer",
     .family = "Boost.Odeint",
     .summary = "bulirsch_stoer on (q, w_B), order and step size controlled",
     .source = "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Bulirsch & Stoer, Numer. Math. 8 (1966)",
     .version = boost_version,
     .by_tolerance = true,
     .claims = {.unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = run_odeint<BulirschStoer>},
};

}  // namespace
extern const MethodRows odeint_bulirsch_stoer;
const MethodRows odeint_bulirsch_stoer = rows;
}  // namespace polhode
