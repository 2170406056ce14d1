// Lie-Euler: the angular velocity is frozen for a step, and the attitude turns by its exponential.
//   lie-euler            q <- q exp(h w_B),  w_B <- w_B + h I^-1((I w_B) x w_B + tau_B)
//   lie-euler-momentum   q <- q exp(h w_B),  L_S <- L_S + h tau_S,  I w_B = R^T L_S
// Order 1. |q| = 1 to rounding, because the exponential is a unit quaternion. The first lets momentum and
// energy drift, since w_B takes a plain Euler step; the second has the momentum in space for its state, so
// that a free body keeps it, magnitude and direction, to the last bit; its energy drifts.
// Source: Iserles, Munthe-Kaas, Norsett & Zanna, Lie-group methods, Acta Numerica 9 (2000), section 2.
#include "solvers/momentum_form.hpp"

namespace polhode {
namespace {

struct LieEuler : LieGroupForm {
  static constexpr int rhs_per_step = 1;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Turning x = turning_of(m, y);
    return moved<1>(m, h, y, {x.q * exp_rotation<double>(h * x.w), x.w + h * slope(m, t, x)});
  }
};

struct LieEulerMomentum : MomentumForm {
  static constexpr int rhs_per_step = 1;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Carried x = carried_of(m, y);
    const Vec3 w = rates_of(m, x);
    Vec3 L = x.L;
    if constexpr (M::Rotating::has_load)
      L += h * to_space<double>(x.q, m.rotation.load.template torque_B<double>(t, x.q, w));
    return next<1>(m, h, y, {x.q * exp_rotation<double>(h * w), L});
  }
};

constexpr Claims claims = {.attitude_order = 1,
                           .rate_order = 1,
                           .energy_order = 1,
                           .momentum_order = 1,
                           .unit_attitude = Claim::yes,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no,
                           .reversible = Claim::no};
constexpr Claims momentum_claims = [] {
  Claims c = claims;
  c.momentum_magnitude = c.space_momentum = Claim::yes;
  return c;
}();
constexpr std::string_view source =
    "Iserles, Munthe-Kaas, Norsett & Zanna, Acta Numerica 9 (2000), section 2";

constinit const Method rows[] = {
    {.id = "lie-euler",
     .family = "Lie group",
     .summary = "q turned by the exponential of the old w_B, explicit Euler for w_B",
     .source = source,
     .by_steps = true,
     .claims = claims,
     .prepare = run_fixed_step<LieEuler>},
    {.id = "lie-euler-momentum",
     .family = "Lie group",
     .summary = "the same, with the momentum carried along by the turn",
     .source = source,
     .by_steps = true,
     .claims = momentum_claims,
     .prepare = run_fixed_step<LieEulerMomentum>},
};

}  // namespace
extern const MethodRows lie_euler;
const MethodRows lie_euler = rows;
}  // namespace polhode
