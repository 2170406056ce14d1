// The lecture notes' loop, as it stands there: explicit Euler on (p, v, R, w) with w in space components.
//   I = R I_B R^T,  w' = I^-1(tau - w x I w);  p += h v, v += h a, R += h [w]x R, w += h w'   (all from the
//   old state)
// Order 1. R leaves SO(3), because a tangent step lengthens every column: unless it is projected back, the
// inertia R I_B R^T grows with it, and so does everything that is computed from it. Who spares the inversion
// and writes I^-1 = R I_B^-1 R^T (euler-matrix-turned-inverse) has another method as soon as R is no
// rotation: the first step is the same, the second is not. Source: lecture notes on rigid body dynamics;
// projection by Gram-Schmidt on the columns.
#include "solvers/matrix_form.hpp"

namespace polhode {
namespace {

struct Variant {
  bool orthonormalised, turned_inverse;
};

struct EulerMatrix : MatrixForm {
  static constexpr int rhs_per_step = 1;
  Variant choice{};

  template <WithAttitude M>
  State<M> step(const M& m, double t, double h, const State<M>& y) const {
    State<M> d, next;
    rhs(m, t, y.data(), d.data(), choice.turned_inverse);
    for (std::size_t i = 0; i < y.size(); ++i) next[i] = y[i] + h * d[i];
    if (choice.orthonormalised) orthonormalise(next);
    return next;
  }
};

constexpr Claims claims = {.attitude_order = 1,
                           .rate_order = 1,
                           .energy_order = 1,
                           .momentum_order = 1,
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
constexpr double amplification[] = {1, 1};

template <bool orthonormalised, bool turned_inverse>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_fixed_step<EulerMatrix>(scene, setting, {orthonormalised, turned_inverse});
}

constinit const Method rows[] = {
    {.id = "euler-matrix",
     .family = "lecture notes",
     .summary = "explicit Euler on (p, v, R, w), the rotation matrix left as it comes",
     .source = "lecture notes on rigid body dynamics",
     .by_steps = true,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = prepare<false, false>},
    {.id = "euler-matrix-turned-inverse",
     .family = "lecture notes",
     .summary = "the same with R I_B^-1 R^T for the inverse of R I_B R^T",
     .source = "lecture notes on rigid body dynamics",
     .by_steps = true,
     .in_studies = false,  // as euler-matrix while R is near a rotation, and no use afterwards
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = prepare<false, true>},
    {.id = "euler-matrix-orthonormalised",
     .family = "lecture notes",
     .summary = "the same, R brought back to SO(3) after each step (Gram-Schmidt on its columns)",
     .source = "lecture notes on rigid body dynamics",
     .by_steps = true,
     .claims = orthonormalised_claims,
     .stability_polynomial = amplification,
     .prepare = prepare<true, false>},
};

}  // namespace
extern const MethodRows euler_matrix;
const MethodRows euler_matrix = rows;
}  // namespace polhode
