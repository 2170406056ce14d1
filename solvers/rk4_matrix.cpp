// The classical Runge-Kutta method on the lecture notes' state (p, v, R, w_S).
//   R' = [w]x R,  w' = I^-1(tau - w x I w),  I = R I_B R^T at every stage, nothing projected inside a step
// Order 4. R leaves SO(3) with order 5 of the step unless it is projected back.
// Source: lecture notes on rigid body dynamics; Hairer, Norsett & Wanner, Solving ODEs I (1993), II.1.
#include "solvers/matrix_form.hpp"
#include "solvers/runge_kutta_4.hpp"

namespace polhode {
namespace {

template <bool orthonormalised>
struct Rk4Matrix : MatrixForm {
  static constexpr int rhs_per_step = 4;

  template <WithAttitude M>
  State<M> step(const M& m, double t, double h, const State<M>& y) const {
    auto next = runge_kutta_4([&m](double s, const double* x, double* d) { rhs(m, s, x, d); }, t, h, y);
    if constexpr (orthonormalised) orthonormalise(next);
    return next;
  }
};

constexpr Claims claims = {.attitude_order = 4,
                           .rate_order = 4,
                           .energy_order = 4,
                           .momentum_order = 4,
                           .unit_attitude = Claim::no,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no,
                           .reversible = Claim::no};
constexpr Claims orthonormalised_claims = [] {
  Claims c = claims;
  c.unit_attitude = Claim::yes;
  return c;
}();
constexpr double amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};

constinit const Method rows[] = {
    {.id = "rk4-matrix",
     .family = "lecture notes",
     .summary = "classical Runge-Kutta on (p, v, R, w), the rotation matrix left as it comes",
     .source = "lecture notes on rigid body dynamics; Kutta (1901)",
     .by_steps = true,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Rk4Matrix<false>>},
    {.id = "rk4-matrix-orthonormalised",
     .family = "lecture notes",
     .summary = "the same, R brought back to SO(3) after each step (Gram-Schmidt on its columns)",
     .source = "lecture notes on rigid body dynamics; Kutta (1901)",
     .by_steps = true,
     .claims = orthonormalised_claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Rk4Matrix<true>>},
};

}  // namespace
extern const MethodRows rk4_matrix;
const MethodRows rk4_matrix = rows;
}  // namespace polhode
