// Runge-Kutta-Munthe-Kaas of order 4: the classical tableau in the Lie algebra.
//   q(t + s) = q exp(u(s)),  u' = dexpinv(u, w_B),  w_B' = I^-1((I w_B) x w_B + tau_B),  u(0) = 0
// and one step of the classical Runge-Kutta method for (u, w_B). Order 4. |q| = 1 to rounding; momentum and
// energy drift, because w_B takes an ordinary Runge-Kutta step.
// Source: Munthe-Kaas, BIT 38 (1998); Iserles et al., Acta Numerica 9 (2000), section 3.2.
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

struct Rkmk4 : LieGroupForm {
  static constexpr int rhs_per_step = 4;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Turning x = turning_of(m, y);
    const Vec3 u1 = x.w, a1 = slope(m, t, x);
    const Vec3 v2 = 0.5 * h * u1;
    const Turning x2{x.q * exp_rotation<double>(v2), x.w + 0.5 * h * a1};
    const Vec3 u2 = dexpinv(v2, x2.w), a2 = slope(m, t + 0.5 * h, x2);
    const Vec3 v3 = 0.5 * h * u2;
    const Turning x3{x.q * exp_rotation<double>(v3), x.w + 0.5 * h * a2};
    const Vec3 u3 = dexpinv(v3, x3.w), a3 = slope(m, t + 0.5 * h, x3);
    const Vec3 v4 = h * u3;
    const Turning x4{x.q * exp_rotation<double>(v4), x.w + h * a3};
    const Vec3 u4 = dexpinv(v4, x4.w), a4 = slope(m, t + h, x4);
    const Vec3 v = h / 6 * ((u1 + u4) + 2 * (u2 + u3));
    return moved<4>(m, h, y, {x.q * exp_rotation<double>(v), x.w + h / 6 * ((a1 + a4) + 2 * (a2 + a3))});
  }
};

constinit const Method rows[] = {
    {.id = "rkmk4",
     .family = "Lie group",
     .summary = "classical Runge-Kutta in the Lie algebra, one exponential a step",
     .source = "Munthe-Kaas, BIT 38 (1998); Iserles et al., Acta Numerica 9 (2000), section 3.2",
     .by_steps = true,
     .claims = {.attitude_order = 4,
                .rate_order = 4,
                .energy_order = 4,
                .momentum_order = 4,
                .unit_attitude = Claim::yes,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = run_fixed_step<Rkmk4>},
};

}  // namespace
extern const MethodRows rkmk4;
const MethodRows rkmk4 = rows;
}  // namespace polhode
