// Dormand and Prince's method of order 8 with step control by estimates of orders 5 and 3: DOP853.
//   k_i = f(t + c_i h, y + h sum_{j<i} a_ij k_j),  y <- y + h sum b_i k_i;  twelve stages
//
// The estimate is err = e5^2/sqrt(e5^2 + e3^2/100), e5 and e3 being root-mean-squares of the differences to
// embedded formulas of orders 5 and 3 over atol + rtol |y_i|: e5 ~ h^6 and e3 ~ h^4 make an estimate that
// falls with h^8, one power short of the error of the step. States within a step come from the dense output
// of order 7, which asks for the slope at the end and three more, only in steps that hold an asked time.
//
// Order 8. Keeps no invariant. Two thirds of the time of Odeint's Fehlberg pair of the same order at the same
// error: a stage less, a smaller error, and the first slope of a rejected step used again. Source: Hairer,
// Norsett & Wanner, Solving ODEs I (1993), II.5, II.6, II.10; Dormand & Prince, J. Comput. Appl. Math. 6
// (1980).
//
// dop853-compensated carries the rounding of the sum y + increment along: solvers/compensated.hpp.
#include "solvers/compensated.hpp"
#include "solvers/dop853_table.hpp"
#include "solvers/explicit_runge_kutta.hpp"

namespace polhode {
namespace {

struct Dop853 : Dop853Table {
  static constexpr int error_order = 8;

  template <int n>
  [[gnu::noinline]] static double error(const Pairs<n>* k, double h, const Pairs<n>& y, const Pairs<n>& next,
                                        double atol, double rtol) {
    const Pairs<n> weights = error_weights<n>(y, next, atol, rtol);
    Pair sum5{}, sum3{};
    for (int i = 0; i < Pairs<n>::count; ++i) {
      Pair e5{}, e3{};
      unroll<stages>([&](auto s) __attribute__((always_inline)) {
        if constexpr (b_minus_order_5[s] != 0) e5 += b_minus_order_5[s] * k[s].p[i];
        if constexpr (b[s] != b_order_3[s]) e3 += (b[s] - b_order_3[s]) * k[s].p[i];
      });
      e5 *= weights.p[i];
      e3 *= weights.p[i];
      sum5 += e5 * e5;
      sum3 += e3 * e3;
    }
    const double square5 = sum5[0] + sum5[1], square3 = sum3[0] + sum3[1];
    const double both = square5 + 0.01 * square3;
    return both > 0 ? std::abs(h) * square5 / std::sqrt(both * n) : both;  // 0, or no number
  }

  /// y(t + s h) = r0 + s (r1 + (1-s) (r2 + s (r3 + (1-s) (r4 + s (r5 + (1-s) (r6 + s r7))))))
  template <int n>
  class DenseOutput {
   public:
    template <AnyModel M>
    [[gnu::noinline]] void prepare(const M& m, double t, double h, const Pairs<n>& start, const Pairs<n>& end,
                                   const Pairs<n>* k) {
      Pairs<n> all[dense_stages];
      std::copy(k, k + stages, all);
      all[stages] = slope(m, t + h, end);
      for (int s = stages + 1; s < dense_stages; ++s) {
        const double* const a_s = a_dense[s - stages - 1];
        Pairs<n> x = start;
        for (int j = 0; j < s; ++j)
          for (int i = 0; i < Pairs<n>::count; ++i) x.p[i] += (h * a_s[j]) * all[j].p[i];
        all[s] = slope(m, t + c_dense[s - stages - 1] * h, x);
      }
      for (int i = 0; i < Pairs<n>::count; ++i) {
        const Pair way = end.p[i] - start.p[i], bend = h * all[0].p[i] - way;
        r_[0].p[i] = start.p[i];
        r_[1].p[i] = way;
        r_[2].p[i] = bend;
        r_[3].p[i] = way - h * all[stages].p[i] - bend;
        for (int term = 0; term < 4; ++term) {
          Pair sum{};
          for (int s = 0; s < dense_stages; ++s) sum += dense[term][s] * all[s].p[i];
          r_[4 + term].p[i] = h * sum;
        }
      }
    }
    Pairs<n> at(double s) const {
      Pairs<n> y = r_[7];
      for (int term = 6; term >= 0; --term)
        for (int i = 0; i < Pairs<n>::count; ++i)
          y.p[i] = r_[term].p[i] + (term % 2 == 0 ? s : 1 - s) * y.p[i];
      return y;
    }

   private:
    Pairs<n> r_[8];
  };
};

constexpr auto amplification = stability_polynomial_of<Dop853Table>();
constexpr std::string_view source =
    "Hairer, Norsett & Wanner, Solving ODEs I (1993), II.5, II.6, II.10; Dormand & Prince (1980)";
// No order is claimed where doubles do not show it: errors fall with h^8.4 until they meet rounding. That the
// conditions of order 8 hold, and not those of order 9, is tested on the coefficients.
constexpr Claims claims = {.unit_attitude = Claim::no,
                           .momentum_magnitude = Claim::no,
                           .space_momentum = Claim::no,
                           .energy_bounded = Claim::no,
                           .reversible = Claim::no};

constinit const Method rows[] = {
    {.id = "dop853",
     .family = "explicit Runge-Kutta",
     .summary = "Dormand & Prince 8(5,3) on (q, w_B), error-controlled or fixed step",
     .source = source,
     .by_steps = true,
     .by_tolerance = true,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_explicit<Dop853>},
    {.id = "dop853-compensated",
     .family = "explicit Runge-Kutta",
     .summary = "dop853 at fixed step, the rounding of its sums carried along",
     .source = "Kahan, Comm. ACM 8 (1965); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.5",
     .by_steps = true,
     .in_studies = false,
     .claims = claims,
     .stability_polynomial = amplification,
     .prepare = run_fixed_step<Compensated<ExplicitFixed<Dop853>>>},
};

}  // namespace
extern const MethodRows dop853;
const MethodRows dop853 = rows;
}  // namespace polhode
