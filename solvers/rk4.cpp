// The classical Runge-Kutta method on (q, w_B).
//   k1 = f(t, y), k2 = f(t + h/2, y + h/2 k1), k3 = f(t + h/2, y + h/2 k2), k4 = f(t + h, y + h k3)
//   y <- y + h/6 (k1 + 2 k2 + 2 k3 + k4)
// Order 4. |q| leaves one with order 5 unless it is divided out; nothing else is kept.
// rk4-compensated carries the rounding of the sum y + increment along: solvers/compensated.hpp. For steps so
// small that rounding is all the error there is.
// Source: Kutta (1901); Hairer, Norsett & Wanner, Solving Ordinary Differential Equations I (1993), II.1.
#include "solvers/compensated.hpp"
#include "solvers/fixed_step.hpp"
#include "solvers/runge_kutta_4.hpp"

namespace polhode {
namespace {

template <bool renormalise>
struct Rk4 : QuaternionForm {
  static constexpr int rhs_per_step = 4;
  static constexpr std::string_view needs = "needs an attitude to renormalise";

  template <AnyModel M>
  requires(!renormalise || M::has_attitude) typename M::State
      step(const M& m, double t, double h, const typename M::State& y) const {
    auto next = runge_kutta_4([&m](double s, const double* x, double* d) { m.rhs(s, x, d); }, t, h, y);
    if constexpr (renormalise) renormalise_attitude(next);
    return next;
  }
  template <AnyModel M>
  requires(!renormalise) typename M::State
      increment(const M& m, double t, double h, const typename M::State& y) const {
    return runge_kutta_4_increment([&m](double s, const double* x, double* d) { m.rhs(s, x, d); }, t, h, y);
  }
};

constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};
constexpr Claims claims = {.attitude_order = 4,
                           .rate_order = 4,
                           .energy_order = 4,
                           .momentum_order = 4,
                           .unit_attitude = Claim::no,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no,
                           .reversible = Claim::no};
constexpr Claims renormalised_claims = [] {
  Claims c = claims;
  c.unit_attitude = Claim::yes;
  return c;
}();

constinit const Method rows[] = {
    {.id = "rk4",
     .family = "classical",
     .summary = "classical Runge-Kutta on (q, w_B), the quaternion left as it comes",
     .source = "Kutta (1901); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.1",
     .by_steps = true,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Rk4<false>>},
    {.id = "rk4-renormalised",
     .family = "classical",
     .summary = "classical Runge-Kutta on (q, w_B) with q/|q| after each step",
     .source = "Kutta (1901); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.1",
     .by_steps = true,
     .claims = renormalised_claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Rk4<true>>},
    {.id = "rk4-compensated",
     .family = "classical",
     .summary = "classical Runge-Kutta on (q, w_B), the rounding of its sums carried along",
     .source = "Kutta (1901); Kahan, Comm. ACM 8 (1965)",
     .by_steps = true,
     .in_studies = false,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Compensated<Rk4<false>>>},
};

}  // namespace
extern const MethodRows rk4;
const MethodRows rk4 = rows;
}  // namespace polhode
