// Compositions: a symmetric step of order 2, run forwards and backwards by fractions of h that cancel its
// error up to a higher order. One step is
//   kick(k_0 h) flow_1 kick(k_1 h) flow_2 ... flow_s kick(k_s h),
// where a kick is the torque at fixed attitude, solved exactly (solvers/kicks.hpp), and a flow is free
// motion:
//
//   symmetric-split-*   rest(a h) top(b h) rest(c h), as in symmetric-split (solvers/rotation_splitting.cpp)
//   free-flow-*         the free body's closed form (models/free_rotation.hpp), set up anew from each state:
//                       no error but that of the kicks, none at all without a torque, for ten times the cost
//
// with fractions from one list. A symmetric composition of s steps gamma_i h has the Strang step inside; the
// partitioned splittings of Blanes & Moan for two flows A, B, with coefficients a_i, b_i, are compositions of
// the Lie-Trotter map and its adjoint with alpha_1 = a_1, alpha_2 = b_1 - alpha_1, alpha_3 = a_2 - alpha_2,
// ..., and so serve three flows (kick, rest, top) at the same order (McLachlan, SIAM J. Sci. Comput. 16
// (1995), 151). Two turns of the rest that meet, where no torque is between, are made in one.
//
// Orders 2 to 10. Every part keeps L of the free body in space, to rounding, and |q|; all are symmetric,
// hence reversible, and the energy oscillates, bounded. Substeps backwards in time: a fast decay (stiff drag)
// grows in them, and limits the step. Sources: Yoshida, Phys. Lett. A 150 (1990), 262; Suzuki, Phys. Lett. A
// 146 (1990), 319; Kahan & Li, Math. Comp. 66 (1997), 1089; Sofroniou & Spaletta, Optim. Methods Softw. 20
// (2005), 597; Blanes & Moan, J. Comput. Appl. Math. 142 (2002), 313; coefficients as printed in Hairer,
// Lubich & Wanner, Geometric Numerical Integration (2006), V.3.
#include "models/free_rotation.hpp"
#include "solvers/free_motion.hpp"
#include "solvers/kicks.hpp"

namespace polhode {
namespace {

constexpr std::size_t most_stages = 35;

/// Fractions of h of one step's parts.
struct Composition {
  std::size_t stages = 0;
  // A kick before each stage and one at the end; without torque, the turn of the rest that takes its place.
  std::array<double, most_stages + 1> kick{};
  std::array<double, most_stages> before{}, flow{}, after{};  // parts of the free motion in a stage
  double longest = 0;                                         // of all parts, in size

  /// From the fractions of the maps forwards and adjoint, in turn.
  template <std::size_t n>
  static constexpr Composition of_adjoints(const std::array<double, n>& alpha) {
    static_assert(n % 2 == 0 && n <= 2 * most_stages);
    Composition c;
    c.stages = n / 2;
    for (std::size_t i = 0; i < c.stages; ++i) {
      c.before[i] = alpha[2 * i];
      c.after[i] = alpha[2 * i + 1];
      c.flow[i] = alpha[2 * i] + alpha[2 * i + 1];
      c.kick[i] += alpha[2 * i];
      c.kick[i + 1] += alpha[2 * i + 1];
    }
    for (std::size_t i = 0; i < c.stages; ++i)
      for (const double part : {c.kick[i], c.kick[i + 1], c.flow[i]})
        c.longest = std::max({c.longest, part, -part});
    return c;
  }
  /// Of 2 n - 1 symmetric steps, given by those up to the middle; the middle one is what is left of 1.
  template <std::size_t n>
  static constexpr Composition symmetric(const double (&given)[n]) {
    std::array<double, 2 * (2 * n + 1)> alpha{};
    double rest = 1;
    for (std::size_t i = 0; i < n; ++i) {
      rest -= 2 * given[i];
      alpha[2 * i] = alpha[2 * i + 1] = given[i] / 2;
      alpha[4 * n - 2 * i] = alpha[4 * n + 1 - 2 * i] = given[i] / 2;
    }
    alpha[2 * n] = alpha[2 * n + 1] = rest / 2;
    return of_adjoints(alpha);
  }
  /// Of the splitting A(a_1) B(b_1) A(a_2) ... B(b_1) A(a_1), by its first half less the middle A and the
  /// last B.
  template <std::size_t n>
  static constexpr Composition partitioned(const double (&a)[n], const double (&b)[n - 1]) {
    std::array<double, 4 * n> alpha{};
    double before = 0, rest = 0.5;
    for (std::size_t i = 0; i < n; ++i) {
      alpha[2 * i] = a[i] - before;
      const double flow = i + 1 < n ? b[i] : rest;
      rest -= flow;
      before = alpha[2 * i + 1] = flow - alpha[2 * i];
    }
    for (std::size_t i = 0; i < 2 * n; ++i) alpha[4 * n - 1 - i] = alpha[i];
    return of_adjoints(alpha);
  }
};

// The middle fraction follows from the sum; HLW (II.4.4), (II.4.5), (V.3.11) to (V.3.15).
constexpr double two_thirds_root = 1.2599210498948731648, cube_root_of_4 = 1.5874010519681994748;
constexpr std::array<double, 2> one_step{0.5, 0.5};
constexpr Composition strang = Composition::of_adjoints(one_step);
constexpr Composition yoshida4 = Composition::symmetric({1 / (2 - two_thirds_root)});
constexpr Composition suzuki4 = Composition::symmetric({1 / (4 - cube_root_of_4), 1 / (4 - cube_root_of_4)});
constexpr Composition yoshida6 =
    Composition::symmetric({0.78451361047755726382, 0.23557321335935813368, -1.17767998417887100695});
constexpr Composition kahan_li6 = Composition::symmetric(
    {0.39216144400731413928, 0.33259913678935943860, -0.70624617255763935981, 0.08221359629355080023});
constexpr Composition yoshida8 =
    Composition::symmetric({0.914844246229740, 0.253693336566229, -1.44485223686048, -0.158240635368243,
                            1.93813913762276, -1.96061023297549, 0.102799849391985});
constexpr Composition kahan_li8 = Composition::symmetric(
    {0.13020248308889008088, 0.56116298177510838456, -0.38947496264484728641, 0.15884190655515560090,
     -0.39590389413323757734, 0.18453964097831570709, 0.25837438768632204729, 0.29501172360931029887});
constexpr Composition sofroniou_spaletta10 = Composition::symmetric(
    {0.07879572252168641926, 0.31309610341510852776, 0.02791838323507806611, -0.22959284159390709415,
     0.13096206107716486317, -0.26973340565451071434, 0.07497334315589143567, 0.11199342399981020489,
     0.36613344954622675119, -0.39910563013603589788, 0.10308739852747107732, 0.41143087395589023782,
     -0.00486636058313526176, -0.39203335370863990645, 0.05194250296244964704, 0.05066509075992449634,
     0.04967437063972987906});
constexpr Composition blanes_moan4 = Composition::partitioned(
    {0.0792036964311957, 0.353172906049774, -0.0420650803577195}, {0.209515106613362, -0.143851773179818});
constexpr Composition blanes_moan6 = Composition::partitioned(
    {0.0502627644003922, 0.413514300428344, 0.0450798897943977, -0.188054853819569, 0.541960678450780},
    {0.148816447901042, -0.132385865767784, 0.067307604692185, 0.432666402578175});

/// rest, top, rest, with the top about the axis that leaves the least rest.
struct TopFlow {
  static void flow(Spinning& x, const Vec3&, const Vec3& inverse, double before, double top, double after) {
    const double longest = std::max({std::abs(before), std::abs(top), std::abs(after)});
    choose(x, inverse, longest, [&]<int first, Angles angles>() {
      SymmetricTop<first>::template flow<angles>(x, inverse, before, top, after);
    });
  }
  /// A whole step of the free body.
  static void step(Spinning& x, const Vec3&, const Vec3& inverse, double h, const Composition& c) {
    choose(x, inverse, h * c.longest, [&]<int first, Angles angles>() {
      for (std::size_t i = 0; i < c.stages; ++i) {
        SymmetricTop<first>::template turn_rest<angles>(x, inverse, h * c.kick[i]);
        SymmetricTop<first>::template turn_as_top<angles>(x, inverse, h * c.flow[i]);
      }
      SymmetricTop<first>::template turn_rest<angles>(x, inverse, h * c.kick[c.stages]);
    });
  }

 private:
  template <class Move>
  static void choose(const Spinning& x, const Vec3& inverse, double longest, const Move& move) {
    const bool small = turns_are_small(x.m, inverse, longest);
    const auto about = [&]<int first>() {
      if (small)
        move.template operator()<first, Angles::small>();
      else
        move.template operator()<first, Angles::any>();
    };
    const int first = nearest_top(inverse);
    if (first == 0)
      about.template operator()<0>();
    else if (first == 1)
      about.template operator()<1>();
    else
      about.template operator()<2>();
  }
};

/// The closed form.
struct FreeFlow {
  static void flow(Spinning& x, const Vec3& moments, const Vec3& inverse, double, double flow, double) {
    const Quaternion here(1, 0, 0, 0);
    const Quaternion turn = FreeRotation<double>(moments, here, Vec3(inverse.cwiseProduct(x.m))).at(flow).q;
    // Its vector alone says by how much less than one its scalar is, with all digits, as long as it is small.
    const double sign = turn.w() < 0 ? -1 : 1, vv = turn.vec().squaredNorm();
    const double less = vv < 0.5 ? -vv / (1 + std::sqrt(1 - vv)) : sign * turn.w() - 1;
    const SmallTurn by{less, sign * turn.x(), sign * turn.y(), sign * turn.z()};
    turn_attitude(x.q, by);
    turn_momentum(x.m, by);
  }
  static void step(Spinning& x, const Vec3& moments, const Vec3& inverse, double h, const Composition&) {
    flow(x, moments, inverse, 0, h, 0);
  }
};

template <class Free>
[[gnu::noinline]] void flow_of(Spinning& x, const Vec3& moments, const Vec3& inverse, double before,
                               double flow, double after) {
  Free::flow(x, moments, inverse, before, flow, after);
}
template <class Free>
[[gnu::noinline]] void step_of(Spinning& x, const Vec3& moments, const Vec3& inverse, double h,
                               const Composition& c) {
  Free::step(x, moments, inverse, h, c);
}

template <class Free>
struct Composed : MomentumForm {
  const Composition* choice = nullptr;
  std::int64_t rhs_evals = 0;  // torques
  Kicks kicks;

  template <WithAttitude M>
  [[gnu::always_inline]] typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    const Composition& c = *choice;
    const Vec3 &moments = m.rotation.moments(), &inverse = m.rotation.inverse_moments();
    Spinning x = spinning_in(m, y);
    if constexpr (M::Rotating::has_load) {
      kicks.set_up(m, y, h, std::span(c.kick).first(c.stages + 1));
      double part = 0;  // of h, gone by
      for (std::size_t i = 0; i < c.stages; ++i) {
        kicks.kick(m, t + part * h, x.q, x.m, i, h * c.kick[i]);
        flow_of<Free>(x, moments, inverse, h * c.before[i], h * c.flow[i], h * c.after[i]);
        part += c.flow[i];
      }
      kicks.kick(m, t + h, x.q, x.m, c.stages, h * c.kick[c.stages]);
      rhs_evals += static_cast<std::int64_t>(c.stages) + 1;
    } else {
      step_of<Free>(x, moments, inverse, h, c);
    }
    return spun_in_space(m, h, y, x);
  }
};

template <class Free, const Composition& composition>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_fixed_step<Composed<Free>>(scene, setting, &composition);
}

template <const Composition& composition>
constexpr Method top(std::string_view id, std::string_view summary, std::string_view source, double p,
                     bool in_studies = false) {
  return {.id = id,
          .family = "splitting",
          .summary = summary,
          .source = source,
          .by_steps = true,
          .in_studies = in_studies,
          .claims = {.attitude_order = p,
                     .rate_order = p,
                     .energy_order = p,
                     .momentum_order = p,
                     .unit_attitude = Claim::yes,
                     .momentum_magnitude = Claim::yes,
                     .space_momentum = Claim::yes,
                     .energy_bounded = Claim::yes,
                     .reversible = Claim::yes},
          .prepare = prepare<TopFlow, composition>};
}
template <const Composition& composition>
constexpr Method free_flow(std::string_view id, std::string_view summary, std::string_view source, double p,
                           bool in_studies = false) {
  Method row = top<composition>(id, summary, source, p, in_studies);
  row.prepare = prepare<FreeFlow, composition>;
  return row;
}

constexpr std::string_view by_yoshida = "Yoshida, Phys. Lett. A 150 (1990), 262",
                           by_suzuki = "Suzuki, Phys. Lett. A 146 (1990), 319",
                           by_kahan_li = "Kahan & Li, Math. Comp. 66 (1997), 1089",
                           by_sofroniou_spaletta =
                               "Sofroniou & Spaletta, Optim. Methods Softw. 20 (2005), 597",
                           by_blanes_moan = "Blanes & Moan, J. Comput. Appl. Math. 142 (2002), 313",
                           by_reich =
                               "Reich, Physica D 76 (1994), 375; Celledoni, Fasso, Safstrom & Zanna, "
                               "SIAM J. Sci. Comput. 30 (2008)";

// An error of order 10 falls from coarse to rounding within two halvings of a step: no ladder of halvings can
// measure it. A test of its own does.
constexpr double too_steep = Claims::none;

constinit const Method rows[] = {
    top<yoshida4>("symmetric-split-yoshida4", "three steps of symmetric-split, order 4", by_yoshida, 4),
    top<suzuki4>("symmetric-split-suzuki4", "five steps of symmetric-split, order 4", by_suzuki, 4),
    top<blanes_moan4>("symmetric-split-blanes-moan4", "partitioned splitting S6, order 4", by_blanes_moan, 4),
    top<yoshida6>("symmetric-split-yoshida6", "seven steps of symmetric-split, order 6", by_yoshida, 6),
    top<kahan_li6>("symmetric-split-kahan-li6", "nine steps of symmetric-split, order 6", by_kahan_li, 6),
    top<blanes_moan6>("symmetric-split-blanes-moan6", "partitioned splitting S10, order 6", by_blanes_moan, 6,
                      true),
    top<yoshida8>("symmetric-split-yoshida8", "15 steps of symmetric-split, order 8", by_yoshida, 8),
    top<kahan_li8>("symmetric-split-kahan-li8", "17 steps of symmetric-split, order 8", by_kahan_li, 8, true),
    top<sofroniou_spaletta10>("symmetric-split-ss10", "35 steps of symmetric-split, order 10",
                              by_sofroniou_spaletta, too_steep),
    free_flow<strang>("free-flow-split", "exact free motion between half kicks of the torque", by_reich, 2,
                      true),
    free_flow<suzuki4>("free-flow-suzuki4", "five steps of free-flow-split, order 4", by_suzuki, 4),
    free_flow<blanes_moan4>("free-flow-blanes-moan4", "partitioned splitting S6 of free motion and kicks",
                            by_blanes_moan, 4),
    free_flow<kahan_li6>("free-flow-kahan-li6", "nine steps of free-flow-split, order 6", by_kahan_li, 6),
    free_flow<blanes_moan6>("free-flow-blanes-moan6", "partitioned splitting S10 of free motion and kicks",
                            by_blanes_moan, 6),
    free_flow<kahan_li8>("free-flow-kahan-li8", "17 steps of free-flow-split, order 8", by_kahan_li, 8),
    free_flow<sofroniou_spaletta10>("free-flow-ss10", "35 steps of free-flow-split, order 10",
                                    by_sofroniou_spaletta, too_steep),
};

}  // namespace
extern const MethodRows composition;
const MethodRows composition = rows;
}  // namespace polhode
