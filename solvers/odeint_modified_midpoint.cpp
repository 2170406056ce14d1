// Boost.Odeint's modified midpoint rule: Gragg's method with its smoothing, in the library's two substeps.
//   h = H/2, z1 = y + h f(y), z2 = y + 2h f(z1), y <- (z1 + z2 + h f(z2))/2
//
// Order 2, with three evaluations; keeps no invariant, but nearly: |R(iy)|^2 = 1 + y^6/64, so that lengths
// change and a way back misses by h^5 alone. Whether a test sees that depends on its step: not claimed.
//
// The library means it as a part of its bulirsch_stoer, where many such results are extrapolated.
//
// Source: Odeint, boost/numeric/odeint/stepper/modified_midpoint.hpp; Gragg, SIAM J. Numer. Anal. 2 (1965).
#include <boost/numeric/odeint/stepper/modified_midpoint.hpp>

#include "solvers/odeint.hpp"

namespace polhode {
namespace {

struct ModifiedMidpoint {
  template <class State>
  using fixed = OdeintFixed<boost::numeric::odeint::modified_midpoint<State>, 3>;
};

constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 8};

constinit const Method rows[] = {
    {.id = "odeint-modified-midpoint",
     .family = "Boost.Odeint",
     .summary = "modified_midpoint of two substeps on (q, w_B), fixed step",
     .source = "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Gragg, SIAM J. Numer. Anal. 2 (1965)",
     .version = boost_version,
     .by_steps = true,
     .in_studies = false,
     .claims = {.attitude_order = 2,
                .rate_order = 2,
                .energy_order = 2,
                .momentum_order = 2,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::unknown,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::unknown},
     .stability_polynomial = amplification,
     .prepare = run_odeint<ModifiedMidpoint>},
};

}  // namespace
extern const MethodRows odeint_modified_midpoint;
const MethodRows odeint_modified_midpoint = rows;
}  // namespace polhode
