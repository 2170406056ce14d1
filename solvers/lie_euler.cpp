// Lie-Euler: the angular velocity is frozen for a step, and the attitude turns by its exponential.
//   lie-euler            q <- q exp(h w_B),  w_B <- w_B + h I^-1((I w_B) x w_B + tau_B)
//   lie-euler-momentum   q <- q exp(h w_B),  I w_B <- exp(-h w_B)(I w_B + h tau_B)
// Order 1. |q| = 1 to rounding, because the exponential is a unit quaternion. The first lets momentum and
// energy drift, since w_B takes a plain Euler step; the second carries the momentum along with the turn, so
// that a free body keeps it in space, magnitude and direction, to rounding; its energy drifts.
// Source: Iserles, Munthe-Kaas, Norsett & Zanna, Lie-group methods, Acta Numerica 9 (2000), section 2.
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

template <bool of_momentum>
struct LieEuler : LieGroupForm {
  static constexpr int rhs_per_step = 1;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Turning x = turning_of(m, y);
    const Quaternion turn = exp_rotation<double>(h * x.w);
    Vec3 w;
    if constexpr (of_momentum) {
      Vec3 momentum = m.rotation.momentum_B(x.w);
      if constexpr (M::Rotating::has_load)
        momentum += h * m.rotation.load.template torque_B<double>(t, x.q, x.w);
      w = m.rotation.inverse_moments().cwiseProduct(to_body<double>(turn, momentum));
    } else {
      w = x.w + h * slope(m, t, x);
    }
    return moved<1>(m, h, y, {x.q * turn, w});
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
     .prepare = run_fixed_step<LieEuler<false>>},
    {.id = "lie-euler-momentum",
     .family = "Lie group",
     .summary = "the same, with the momentum carried along by the turn",
     .source = source,
     .by_steps = true,
     .claims = momentum_claims,
     .prepare = run_fixed_step<LieEuler<true>>},
};

}  // namespace
extern const MethodRows lie_euler;
const MethodRows lie_euler = rows;
}  // namespace polhode
