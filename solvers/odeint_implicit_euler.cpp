// Boost.Odeint's implicit Euler method, at fixed step.
//   y' = y + h f(t + h, y'), by Newton's method with the Jacobian at the start of the step
//
// Order 1, L-stable; energy and momentum drift. What to know of the library's code (1.74): it factorises the
// matrix of its iteration in place, and does so again in every iteration, of what the last one has left. From
// the second on it solves with another matrix than it means to. Where h J is small that contracts all the
// same, and order 1 is there; where it does not, the iteration has no limit. A pivot of zero ends the
// process.
//
// So the wrapper's right-hand side counts: after 200 evaluations in one step the run ends with solver_failed.
// And it ends so before the library meets a pivot of zero, which a copy of its matrix shows that goes through
// the same factorisations (solvers/odeint_ublas.cpp).
//
// Source: Odeint, boost/numeric/odeint/stepper/implicit_euler.hpp; Hairer & Wanner, Solving ODEs II (1996),
// IV.8.
#include "solvers/odeint.hpp"
#include "solvers/odeint_implicit.hpp"

namespace polhode {
namespace {

Prepared prepare_implicit_euler(const Scene& scene, const Setting& setting) {
  return run_fixed_steps(std::make_shared<ImplicitFixed>(scene, odeint_implicit_euler_stepper), setting);
}

constexpr double numerator[] = {1}, denominator[] = {1, -1};

constinit const Method rows[] = {
    {.id = "odeint-implicit-euler",
     .family = "Boost.Odeint",
     .summary = "implicit_euler on (q, w_B) with the model's Jacobian, fixed step",
     .source =
         "Ahnert & Mulansky, AIP Conf. Proc. 1389 (2011); Hairer & Wanner, Solving ODEs II (1996), IV.8",
     .version = boost_version,
     .by_steps = true,
     .in_studies = false,
     .claims = {.attitude_order = 1,
                .rate_order = 1,
                .energy_order = 1,
                .momentum_order = 1,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = numerator,
     .stability_denominator = denominator,
     .prepare = prepare_implicit_euler},
};

}  // namespace
extern const MethodRows odeint_implicit_euler;
const MethodRows odeint_implicit_euler = rows;
}  // namespace polhode
