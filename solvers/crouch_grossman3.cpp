// Crouch-Grossman of order 3: a Runge-Kutta step in which every term is an exponential of its own.
//   stages from the right:  x2 = q exp(a21 k1),  x3 = q exp(a31 k1) exp(a32 k2)
//   q <- q exp(b1 k1) exp(b2 k2) exp(b3 k3),  k_i = h w_B of the stage; w_B adds up with the same weights
// Order 3. |q| = 1 to rounding; momentum and energy drift. Source: Crouch & Grossman, J. Nonlinear Sci. 3
// (1993); coefficients: Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), IV.8.1.
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

constexpr double a21 = 3.0 / 4, a31 = 119.0 / 216, a32 = 17.0 / 108;
constexpr double b1 = 13.0 / 51, b2 = -2.0 / 3, b3 = 24.0 / 17;
constexpr double c3 = a31 + a32;

struct CrouchGrossman3 : LieGroupForm {
  static constexpr int rhs_per_step = 3;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Turning x = turning_of(m, y);
    const Vec3 k1 = h * x.w, s1 = h * slope(m, t, x);
    const Turning x2{x.q * exp_rotation<double>(a21 * k1), x.w + a21 * s1};
    const Vec3 k2 = h * x2.w, s2 = h * slope(m, t + a21 * h, x2);
    const Turning x3{x.q * exp_rotation<double>(a31 * k1) * exp_rotation<double>(a32 * k2),
                     x.w + a31 * s1 + a32 * s2};
    const Vec3 k3 = h * x3.w, s3 = h * slope(m, t + c3 * h, x3);
    const Quaternion turn =
        exp_rotation<double>(b1 * k1) * exp_rotation<double>(b2 * k2) * exp_rotation<double>(b3 * k3);
    return moved<4>(m, h, y, {x.q * turn, x.w + (b1 * s1 + b2 * s2 + b3 * s3)});
  }
};

constinit const Method rows[] = {
    {.id = "crouch-grossman3",
     .family = "Lie group",
     .summary = "three stages, each term of a sum an exponential of its own",
     .source = "Crouch & Grossman, J. Nonlinear Sci. 3 (1993); Hairer, Lubich & Wanner, Geometric Numerical "
               "Integration (2006), IV.8.1",
     .by_steps = true,
     .claims = {.attitude_order = 3,
                .rate_order = 3,
                .energy_order = 3,
                .momentum_order = 3,
                .unit_attitude = Claim::yes,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = run_fixed_step<CrouchGrossman3>},
};

}  // namespace
extern const MethodRows crouch_grossman3;
const MethodRows crouch_grossman3 = rows;
}  // namespace polhode
