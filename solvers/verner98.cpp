// Verner's "most efficient" pair of orders 9 and 8.
//   k_i = f(t + c_i h, y + h sum_{j<i} a_ij k_j),  y <- y + h sum b_i k_i;  fifteen stages
//
// A sixteenth stage makes the embedded formula of order 8, whose difference controls the step, in the root
// mean square of its components over atol + rtol |y_i|; at fixed step it is not computed. Asked times within
// a step are reached by a shorter step of the same formula: solvers/explicit_runge_kutta.hpp.
//
// Order 9. Keeps no invariant. Of the explicit pairs here the cheapest from errors of 1e-5 down:
// on the free body of Hairer & Vilmart 0.85 of the time of dop853 at 1e-6, 0.65 at 1e-12. Known as Vern9
// elsewhere. Source: Verner, Numer. Algorithms 53 (2010).
#include "solvers/explicit_runge_kutta.hpp"
#include "solvers/verner98_table.hpp"

namespace polhode {
namespace {

struct Verner98 : Verner98Table {
  static constexpr int error_order = 9;

  template <int n>
  [[gnu::noinline]] static double error(const Pairs<n>* k, double h, const Pairs<n>& y, const Pairs<n>& next,
                                        double atol, double rtol) {
    const Pairs<n> weights = error_weights<n>(y, next, atol, rtol);
    Pair sum{};
    for (int i = 0; i < Pairs<n>::count; ++i) {
      Pair e{};
      unroll<stages>([&](auto s) __attribute__((always_inline)) {
        if constexpr (order_8_minus_b[s] != 0) e += order_8_minus_b[s] * k[s].p[i];
      });
      e *= weights.p[i];
      sum += e * e;
    }
    return std::abs(h) * std::sqrt((sum[0] + sum[1]) / n);
  }
};

constexpr auto amplification = stability_polynomial_of<Verner98Table>();

constinit const Method rows[] = {
    {.id = "verner98",
     .family = "explicit Runge-Kutta",
     .summary = "Verner's most efficient 9(8) pair on (q, w_B), error-controlled or fixed step",
     .source = "Verner, Numer. Algorithms 53 (2010)",
     .by_steps = true,
     .by_tolerance = true,
     // No order is claimed where doubles do not show it: errors fall with h^10 until they meet rounding. That
     // the conditions of order 9 hold, and not those of order 10, is tested on the coefficients.
     .claims = {.unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no,
                .reversible = Claim::no},
     .stability_polynomial = amplification,
     .prepare = run_explicit<Verner98>},
};

}  // namespace
extern const MethodRows verner98;
const MethodRows verner98 = rows;
}  // namespace polhode
