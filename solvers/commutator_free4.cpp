// The commutator-free method of order 4: exponentials of sums of stages, no commutators, no dexpinv.
//   x2 = q exp(k1/2), x3 = q exp(k2/2), x4 = x2 exp(k3 - k1/2)
//   q <- q exp((3 k1 + 2 k2 + 2 k3 - k4)/12) exp((-k1 + 2 k2 + 2 k3 + 3 k4)/12)
// with k_i = h w_B of the stage; w_B adds up with the same weights, those of the classical Runge-Kutta
// method. Order 4. |q| = 1 to rounding; momentum and energy drift. (Composition is from the right here, so
// the exponential that is applied first stands on the left.) Source: Celledoni, Marthinsen & Owren, Future
// Generation Computer Systems 19 (2003), 341.
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

struct CommutatorFree4 : LieGroupForm {
  static constexpr int rhs_per_step = 4;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const Turning x = turning_of(m, y);
    const Vec3 k1 = h * x.w, a1 = h * slope(m, t, x);
    const Turning x2{x.q * exp_rotation<double>(0.5 * k1), x.w + 0.5 * a1};
    const Vec3 k2 = h * x2.w, a2 = h * slope(m, t + 0.5 * h, x2);
    const Turning x3{x.q * exp_rotation<double>(0.5 * k2), x.w + 0.5 * a2};
    const Vec3 k3 = h * x3.w, a3 = h * slope(m, t + 0.5 * h, x3);
    const Turning x4{x2.q * exp_rotation<double>(k3 - 0.5 * k1), x.w + a3};
    const Vec3 k4 = h * x4.w, a4 = h * slope(m, t + h, x4);
    const Vec3 middle = 2 * (k2 + k3);
    const Quaternion first = exp_rotation<double>((3 * k1 + middle - k4) / 12),
                     second = exp_rotation<double>((3 * k4 + middle - k1) / 12);
    return moved<4>(m, h, y, {x.q * first * second, x.w + ((a1 + a4) + 2 * (a2 + a3)) / 6});
  }
};

constinit const Method rows[] = {
    {.id = "commutator-free4",
     .family = "Lie group",
     .summary = "four stages, five exponentials of sums of stages, no commutators",
     .source = "Celledoni, Marthinsen & Owren, Future Generation Computer Systems 19 (2003), 341",
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
     .prepare = run_fixed_step<CommutatorFree4>},
};

}  // namespace
extern const MethodRows commutator_free4;
const MethodRows commutator_free4 = rows;
}  // namespace polhode
