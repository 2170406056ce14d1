// The classical Runge-Kutta method on a quaternion of any length, brought back towards one by feedback.
//   q' = 1/2 q (0, w_B) + c (1 - |q|^2) q,   w_B' = I^-1((I w_B) x w_B + tau_B(R(q/|q|))),   c = |w_B|
// Every quaternion but zero is an attitude, R(q/|q|), and to add a multiple of q to q' turns nothing: 1/2 q w
// is the least of all slopes that turn the body alike. So |q| needs no care, only room: with c = 0 this is
// the row `rk4`, whose torques are taken at q/|q| as well, and |q| leaves one for good with order 5 of the
// step. The feedback, for which c = |w_B| is a choice of ours that has the unit of a rate and no scale of its
// own, pulls |q| back within a radian or two of the turn; it makes no attitude better. Order 4; nothing is
// kept. Source: Rucker, Integrating rotations using nonunit quaternions, IEEE Robotics and Automation Letters
// 3 (2018), 2979.
#include "solvers/fixed_step.hpp"
#include "solvers/runge_kutta_4.hpp"

namespace polhode {
namespace {

struct RuckerRk4 : QuaternionForm {
  static constexpr int rhs_per_step = 4;
  static constexpr std::string_view needs = "needs an attitude: it is about the length of a quaternion";

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    const auto rhs = [&m](double s, const double* x, double* d) {
      m.rhs(s, x, d);
      const double excess = x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 1;
      const double pull = -excess * m.rotation.w_of(x).norm();
      for (int i = 0; i < 4; ++i) d[i] += pull * x[i];
    };
    return runge_kutta_4(rhs, t, h, y);
  }
};

constinit const Method rows[] = {
    {.id = "rucker-rk4",
     .family = "classical",
     .summary = "classical Runge-Kutta on (q, w_B), |q| drawn to one by a term along q",
     .source = "Rucker, IEEE Robotics and Automation Letters 3 (2018), 2979",
     .by_steps = true,
     .claims = {.attitude_order = 4,
                .rate_order = 4,
                .energy_order = 4,
                .momentum_order = 4,
                .unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = run_fixed_step<RuckerRk4>},
};

}  // namespace
extern const MethodRows rucker_rk4;
const MethodRows rucker_rk4 = rows;
}  // namespace polhode
