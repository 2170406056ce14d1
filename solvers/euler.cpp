// Explicit Euler on the quaternion: both derivatives from the old state.
//   q <- q + h/2 q (0, w_B),   w_B <- w_B + h I^-1((I w_B) x w_B + tau_B)
// Order 1. |q| grows by (1 + h^2|w|^2/4)^(1/2) every step, unless it is divided out; energy and momentum of a
// free body grow, because the exact rates turn on an ellipsoid and a tangent step always leaves it outwards.
// Source: the lecture notes' loop, with the attitude as a quaternion.
#include "solvers/fixed_step.hpp"

namespace polhode {
namespace {

template <bool renormalise>
struct Euler : QuaternionForm {
  static constexpr int rhs_per_step = 1;
  static constexpr std::string_view needs = "needs an attitude to renormalise";

  template <AnyModel M>
  requires(!renormalise || M::has_attitude) typename M::State
      step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State d, next;
    m.rhs(t, y.data(), d.data());
    for (std::size_t i = 0; i < y.size(); ++i) next[i] = y[i] + h * d[i];
    if constexpr (renormalise) renormalise_attitude(next);
    return next;
  }
};

constexpr double amplification[] = {1, 1};
constexpr Claims claims = {.attitude_order = 1,
                           .rate_order = 1,
                           .energy_order = 1,
                           .momentum_order = 1,
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
    {.id = "euler",
     .family = "classical",
     .summary = "explicit Euler on (q, w_B), the quaternion left as it comes",
     .source = "lecture notes on rigid body dynamics; Hairer, Norsett & Wanner, Solving ODEs I (1993), I.7",
     .by_steps = true,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Euler<false>>},
    {.id = "euler-renormalised",
     .family = "classical",
     .summary = "explicit Euler on (q, w_B) with q/|q| after each step",
     .source = "lecture notes on rigid body dynamics; Hairer, Norsett & Wanner, Solving ODEs I (1993), I.7",
     .by_steps = true,
     .claims = renormalised_claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Euler<true>>},
};

}  // namespace
extern const MethodRows euler;
const MethodRows euler = rows;
}  // namespace polhode
