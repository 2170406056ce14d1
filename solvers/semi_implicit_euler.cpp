// Semi-implicit Euler, as game-physics engines step: velocities first, then positions with the new
// velocities.
//   w_B <- w_B + h I^-1((I w_B) x w_B + tau_B),   q <- q exp(h w_B);   v <- v + h F/m,   p <- p + h v
// Order 1. |q| stays at one to rounding, because the exponential is a unit quaternion. The name promises more
// than it holds for rotations: (q, w_B) are not canonical, so neither momentum nor energy is kept. Source:
// Iserles, Munthe-Kaas, Norsett & Zanna, Lie-group methods, Acta Numerica 9 (2000).
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

struct SemiImplicitEuler : QuaternionForm {
  static constexpr int rhs_per_step = 1;
  static constexpr std::string_view needs = "";

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State next = y;
    if constexpr (M::has_rotation) {
      using R = typename M::Rotating;
      const auto q = R::attitude_of(y.data());
      const Vec3 w0 = R::w_of(y.data());
      const Vec3 w = w0 + h * m.rotation.template angular_acceleration<double>(t, q, w0);
      if constexpr (M::has_attitude) {
        const Quaternion turned = held_to_unit(q * exp_rotation<double>(h * w));
        next[0] = turned.w();
        next[1] = turned.x();
        next[2] = turned.y();
        next[3] = turned.z();
      }
      for (int i = 0; i < 3; ++i) next[static_cast<std::size_t>(R::w_at + i)] = w[i];
    }
    if constexpr (M::has_translation) {
      constexpr std::size_t at = M::rotation_size;
      const Vec3 v0 = m.velocity(y.data());
      const Vec3 v = v0 + h * m.translation.force.template acceleration<double>(v0);
      for (std::size_t i = 0; i < 3; ++i) {
        next[at + i] = y[at + i] + h * v[static_cast<int>(i)];
        next[at + 3 + i] = v[static_cast<int>(i)];
      }
    }
    return next;
  }
};

constinit const Method rows[] = {
    {.id = "semi-implicit-euler",
     .family = "classical",
     .summary = "new w_B first, then q by the exponential of the new w_B",
     .source = "Iserles, Munthe-Kaas, Norsett & Zanna, Acta Numerica 9 (2000)",
     .by_steps = true,
     .claims = {.attitude_order = 1,
                .rate_order = 1,
                .energy_order = 1,
                .momentum_order = 1,
                .unit_attitude = Claim::yes,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .prepare = run_fixed_step<SemiImplicitEuler>},
};

}  // namespace
extern const MethodRows semi_implicit_euler;
const MethodRows semi_implicit_euler = rows;
}  // namespace polhode
