// Midpoint rules on the rotation group: the step turns by the mean of the rates at its ends.
//   w_m = (w_0 + w_1)/2
//   lie-midpoint   q_1 = q_0 exp(h w_m),  w_1 = w_0 + h I^-1((I w_m) x w_m + tau_B(q_0 exp(h w_m/2)))
//   akw-midpoint   q_1 = q_0 cay(h w_m),  L_1 = L_0 + h tau_S(q_0 cay(h w_m/2)),  cay(v) = (1, v/2)/|(1,
//   v/2)|
// Order 2, symmetric and so reversible; |q| = 1 to rounding. Of the free body both keep the energy and |L|,
// which are quadratic in w_B; the second, whose state is the momentum in space, keeps that to the last bit:
// the Cayley map is what the midpoint rule turns by. Implicit: solved to rounding by fixed-point iteration;
// where that does not contract (h |w| beyond about one) the run ends with solver_failed. Source: Simo & Wong,
// Int. J. Numer. Meth. Eng. 31 (1991); Austin, Krishnaprasad & Wang, J. Comput. Phys. 107 (1993), 105.
#include "solvers/momentum_form.hpp"

namespace polhode {
namespace {

inline Quaternion cayley(const Vec3& v) {
  const double scale = 1 / std::sqrt(1 + 0.25 * v.squaredNorm());
  return {scale, 0.5 * scale * v.x(), 0.5 * scale * v.y(), 0.5 * scale * v.z()};
}

constexpr const char* not_found = "the fixed-point iteration for the end of the step does not converge";

struct LieMidpoint : LieGroupForm {
  std::int64_t rhs_evals = 0;
  const char* failure = nullptr;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    const Turning start = turning_of(m, y);
    Vec3 w = start.w;
    if (!iterate_to_rounding(w, rhs_evals, [&](const Vec3& end) -> Vec3 {
          const Vec3 middle = 0.5 * (start.w + end);
          const Quaternion q = start.q * exp_rotation<double>(0.5 * h * middle);
          return start.w + h * slope(m, t + 0.5 * h, {q, middle});
        }))
      failure = not_found;
    return moved<4>(m, h, y, {start.q * exp_rotation<double>(0.5 * h * (start.w + w)), w});
  }
};

struct AkwMidpoint : MomentumForm {
  std::int64_t rhs_evals = 0;
  const char* failure = nullptr;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    Carried x = carried_of(m, y);
    const Vec3 start = rates_of(m, x), momentum = x.body_momentum();
    Vec3 w = start, impulse = Vec3::Zero();  // in the body axes at the start
    if (!iterate_to_rounding(w, rhs_evals, [&](const Vec3& end) -> Vec3 {
          const Vec3 middle = 0.5 * (start + end);
          if constexpr (M::Rotating::has_load) {
            const Quaternion half = cayley(0.5 * h * middle);
            impulse = h * to_space<double>(half, m.rotation.load.template torque_B<double>(
                                                     t + 0.5 * h, x.q * half, middle));
          }
          return m.rotation.inverse_moments().cwiseProduct(
              to_body<double>(cayley(h * middle), momentum + impulse));
        }))
      failure = not_found;
    if constexpr (M::Rotating::has_load) x.L += to_space<double>(x.q, impulse);
    x.q = x.q * cayley(0.5 * h * (start + w));
    return next<4>(m, h, y, x);
  }
};

constexpr Claims claims = {.attitude_order = 2,
                           .rate_order = 2,
                           .energy_order = 2,
                           .momentum_order = 2,
                           .unit_attitude = Claim::yes,
                           .momentum_magnitude = Claim::yes,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::yes,
                           .reversible = Claim::yes};
constexpr Claims momentum_claims = [] {
  Claims c = claims;
  c.space_momentum = Claim::yes;
  return c;
}();

constinit const Method rows[] = {
    {.id = "lie-midpoint",
     .family = "Lie group",
     .summary = "turn by the exponential of the mean rates, implicit midpoint for w_B",
     .source = "Simo & Wong, Int. J. Numer. Meth. Eng. 31 (1991)",
     .by_steps = true,
     .claims = claims,
     .prepare = run_fixed_step<LieMidpoint>},
    {.id = "akw-midpoint",
     .family = "Lie group",
     .summary = "energy-momentum method: Cayley turn by the mean rates, momentum carried in space",
     .source =
         "Simo & Wong, Int. J. Numer. Meth. Eng. 31 (1991); Austin, Krishnaprasad & Wang, J. Comput. Phys. "
         "107 (1993)",
     .by_steps = true,
     .claims = momentum_claims,
     .prepare = run_fixed_step<AkwMidpoint>},
};

}  // namespace
extern const MethodRows lie_midpoint;
const MethodRows lie_midpoint = rows;
}  // namespace polhode
