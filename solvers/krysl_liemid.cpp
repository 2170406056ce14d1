// Midpoint rules on the rotation group whose middle rates come from the momentum carried to the middle.
//
//   krysl-liemid-implicit   LIEMID[I]:  I w_m = exp(-h w_m/2) m_0 + h/2 tau_B(q_m),  q_m = q_0 exp(h w_m/2)
//                           q_1 = q_0 exp(h w_m),  L_1 = L_0 + h tau_S(q_m)
//   krysl-liemid            LIEMID[EA]:  kick(h/2) M(h/2) M(h/2) kick(h/2), M the first for the free body
//
// with m = R^T L the momentum in the body. The impulse of the torque, which the midpoint rule would deliver
// in the middle, is delivered at the start of the first half of the step and at the end of the second:
// explicit in the torque, one torque a step. Turns remain implicit: a vector equation for w_m, solved by
// fixed-point iteration to rounding; where that does not contract (h |w| beyond one to four, by the body) the
// run ends with solver_failed. A torque that depends on the rates makes the last kick implicit as well.
//
// Order 2, symmetric and so reversible. The momentum of a free body is kept in space, because nothing but a
// torque changes it; the energy oscillates, bounded. |q| = 1 to rounding. Not to be confused with
// lie-midpoint, whose middle rates are the mean of those at the ends. Source: Krysl, Int. J. Numer. Meth.
// Eng. 63 (2005), 2171; Krysl & Endres, Int. J. Numer. Meth. Eng. 62 (2005), 2154.
#include "solvers/momentum_form.hpp"

namespace polhode {
namespace {

/// The middle rates of a step without torque; `impulse` is what a torque adds there, in body axes.
template <class Impulse>
bool find_middle(Vec3& w, double h, const Vec3& inverse, const Vec3& m0, std::int64_t& calls,
                 const Impulse& impulse) {
  return iterate_to_rounding(w, calls, [&](const Vec3& guess) -> Vec3 {
    const Quaternion half = exp_rotation<double>(0.5 * h * guess);
    return inverse.cwiseProduct(to_body<double>(half, m0) + impulse(half, guess));
  });
}
constexpr const char* turn_failure = "the fixed-point iteration for the middle of the step does not converge";

struct ImplicitMiddle : MomentumForm {
  std::int64_t rhs_evals = 0;
  const char* failure = nullptr;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    Carried x = carried_of(m, y);
    const Vec3& inverse = m.rotation.inverse_moments();
    const Vec3 m0 = x.body_momentum();
    Vec3 w = inverse.cwiseProduct(m0), torque = Vec3::Zero();
    const bool found =
        find_middle(w, h, inverse, m0, rhs_evals, [&](const Quaternion& half, const Vec3& guess) -> Vec3 {
          if constexpr (M::Rotating::has_load)
            torque = m.rotation.load.template torque_B<double>(t + 0.5 * h, x.q * half, guess);
          return 0.5 * h * torque;
        });
    if (!found) failure = turn_failure;
    if constexpr (M::Rotating::has_load)
      x.L += h * to_space<double>(x.q * exp_rotation<double>(0.5 * h * w), torque);
    x.q = x.q * exp_rotation<double>(h * w);
    return next<4>(m, h, y, x);
  }
};

struct ExplicitTorque : MomentumForm {
  std::int64_t rhs_evals = 0;  // torques, and iterates of the turns
  const char* failure = nullptr;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    Carried x = carried_of(m, y);
    const Vec3& inverse = m.rotation.inverse_moments();
    kick(m, t, h, x, rhs_evals);
    Vec3 w = rates_of(m, x);
    for (int part = 0; part < 2; ++part) {
      if (!find_middle(w, 0.5 * h, inverse, x.body_momentum(), rhs_evals,
                       [](const Quaternion&, const Vec3&) -> Vec3 { return Vec3::Zero(); }))
        failure = turn_failure;
      x.q = x.q * exp_rotation<double>(0.5 * h * w);
    }
    if (!kick_back(m, t + h, h, x, rhs_evals)) failure = kick_failure;
    return next<4>(m, h, y, x);
  }
};

constexpr Claims claims = {.attitude_order = 2,
                           .rate_order = 2,
                           .energy_order = 2,
                           .momentum_order = 2,
                           .unit_attitude = Claim::yes,
                           .momentum_magnitude = Claim::yes,
                           .space_momentum = Claim::yes,
                           .energy_bounded = Claim::yes,
                           .reversible = Claim::yes};
constexpr std::string_view source =
    "Krysl, Int. J. Numer. Meth. Eng. 63 (2005), 2171; Krysl & Endres, ibid. 62 (2005), 2154";

constinit const Method rows[] = {
    {.id = "krysl-liemid",
     .family = "Lie group",
     .summary = "LIEMID[EA]: two half-steps of the midpoint Lie rule between explicit kicks of the torque",
     .source = source,
     .by_steps = true,
     .claims = claims,
     .prepare = run_fixed_step<ExplicitTorque>},
    {.id = "krysl-liemid-implicit",
     .family = "Lie group",
     .summary = "LIEMID[I]: turn by the rates of the momentum carried to the middle, torque there",
     .source = source,
     .by_steps = true,
     .in_studies = false,
     .claims = claims,
     .prepare = run_fixed_step<ImplicitMiddle>},
};

}  // namespace
extern const MethodRows krysl_liemid;
const MethodRows krysl_liemid = rows;
}  // namespace polhode
