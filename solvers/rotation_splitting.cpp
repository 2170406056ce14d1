// Splittings of the free motion into turns about axes, with the torque as kicks between: symmetric, order 2.
//
//   splitting-12321    kick(h/2) A1(h/2) A2(h/2) A3(h) A2(h/2) A1(h/2) kick(h/2), and the other five orders
//   no-squish          is the order 32123
//   symmetric-split    kick(h/2) A3'(h/2) T(h) A3'(h/2) kick(h/2)
//
// A_i turns by the angle w_i t about axis i, exactly what the energy m_i^2/(2 I_i) alone does; T is the free
// motion of the symmetric top with moments (I1, I2, I2), and A3' the rest, m3^2 (1/I3 - 1/I2)/2: three
// factors instead of five, and a smaller error, because the rest is small for most bodies; the axes are
// numbered so that it is least, and a symmetric body has none. Each factor is a rotation that carries L
// along: the momentum of a free body is kept in space, magnitude and direction, to rounding; its energy
// oscillates, bounded. |q| = 1 to rounding; reversible. Between them a torque is a kick at fixed attitude,
// solved exactly (solvers/kicks.hpp), drag included. Source: Miller et al., J. Chem. Phys. 116 (2002), 8649;
// Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107 (1997), 5840; Fasso, J. Comput. Phys. 189 (2003),
// 527.
#include "solvers/free_motion.hpp"
#include "solvers/kicks.hpp"

namespace polhode {
namespace {

/// The free motion for a time h: turns about three axes, the third in the middle.
template <int a, int b, int c>
struct ThreeAxes {
  template <Angles angles>
  [[gnu::always_inline]] static void flow(Spinning& x, const Vec3& inverse, double h) {
    turn_about<angles>(x, a, inverse[a], 0.5 * h);
    turn_about<angles>(x, b, inverse[b], 0.5 * h);
    turn_about<angles>(x, c, inverse[c], h);
    turn_about<angles>(x, b, inverse[b], 0.5 * h);
    turn_about<angles>(x, a, inverse[a], 0.5 * h);
  }
};

template <int first>
struct Top {
  template <Angles angles>
  [[gnu::always_inline]] static void flow(Spinning& x, const Vec3& inverse, double h) {
    SymmetricTop<first>::template flow<angles>(x, inverse, 0.5 * h, h, 0.5 * h);
  }
};

template <class Free>
[[gnu::noinline]] void flow_by_any_angle(Spinning& x, const Vec3& inverse, double h) {
  Free::template flow<Angles::any>(x, inverse, h);
}
template <class Free>
[[gnu::always_inline]] inline void flow(Spinning& x, const Vec3& inverse, double h) {
  if (turns_are_small(x.m, inverse, h)) {
    Free::template flow<Angles::small>(x, inverse, h);
  } else {
    Spinning copy = x;  // of which an address is taken: x itself stays in registers
    flow_by_any_angle<Free>(copy, inverse, h);
    x = copy;
  }
}
/// Beside a torque or a translation a call does not count, and compiling the flow once is enough.
template <class Free>
[[gnu::noinline]] void call_flow(Spinning& x, const Vec3& inverse, double h) {
  flow<Free>(x, inverse, h);
}

/// The top about the axis that leaves the least rest; with the moments in the usual order that is the first.
struct NearestTop {};
template <>
[[gnu::noinline]] void call_flow<NearestTop>(Spinning& x, const Vec3& inverse, double h) {
  const int first = nearest_top(inverse);
  if (first == 0)
    flow<Top<0>>(x, inverse, h);
  else if (first == 1)
    flow<Top<1>>(x, inverse, h);
  else
    flow<Top<2>>(x, inverse, h);
}
template <>
[[gnu::always_inline]] inline void flow<NearestTop>(Spinning& x, const Vec3& inverse, double h) {
  if (nearest_top(inverse) == 0 && turns_are_small(x.m, inverse, h)) {
    Top<0>::flow<Angles::small>(x, inverse, h);
  } else {
    Spinning copy = x;
    call_flow<NearestTop>(copy, inverse, h);
    x = copy;
  }
}

template <class Free>
struct RotationSplitting : MomentumForm {
  std::int64_t rhs_evals = 0;  // torques
  Kicks kicks;

  template <WithAttitude M>
  [[gnu::always_inline]] typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    constexpr double half[] = {0.5};
    kicks.set_up(m, y, h, half);
    const Vec3& inverse = m.rotation.inverse_moments();
    Spinning x = spinning_in(m, y);
    kicks.kick(m, t, x.q, x.m, 0, 0.5 * h);
    if constexpr (M::Rotating::has_load || M::has_translation)
      call_flow<Free>(x, inverse, h);
    else
      flow<Free>(x, inverse, h);
    kicks.kick(m, t + h, x.q, x.m, 0, 0.5 * h);
    if constexpr (M::Rotating::has_load) rhs_evals += 2;
    return spun_in_space(m, h, y, x);
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
    "Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107 (1997), 5840; Reich, Physica D 76 (1994), 375";

template <int a, int b, int c>
constexpr Method splitting(std::string_view id, std::string_view summary, std::string_view from = source) {
  return {.id = id,
          .family = "splitting",
          .summary = summary,
          .source = from,
          .by_steps = true,
          .in_studies = a == 2 && b == 1,  // the others differ by the body's axes alone
          .claims = claims,
          .prepare = run_fixed_step<RotationSplitting<ThreeAxes<a, b, c>>>};
}

constinit const Method rows[] = {
    splitting<2, 1, 0>("no-squish", "five turns about principal axes in the order 3 2 1 2 3, torque as kicks",
                       "Miller et al., J. Chem. Phys. 116 (2002), 8649"),
    splitting<0, 1, 2>("splitting-12321", "turns about the axes in the order 1 2 3 2 1, torque as kicks"),
    splitting<0, 2, 1>("splitting-13231", "turns about the axes in the order 1 3 2 3 1, torque as kicks"),
    splitting<1, 0, 2>("splitting-21312", "turns about the axes in the order 2 1 3 1 2, torque as kicks"),
    splitting<1, 2, 0>("splitting-23132", "turns about the axes in the order 2 3 1 3 2, torque as kicks"),
    splitting<2, 0, 1>("splitting-31213", "turns about the axes in the order 3 1 2 1 3, torque as kicks"),
    {.id = "symmetric-split",
     .family = "splitting",
     .summary = "the free symmetric top and a turn for the rest, torque as kicks",
     .source = "Fasso, J. Comput. Phys. 189 (2003), 527",
     .by_steps = true,
     .claims = claims,
     .prepare = run_fixed_step<RotationSplitting<NearestTop>>},
};

}  // namespace
extern const MethodRows rotation_splitting;
const MethodRows rotation_splitting = rows;
}  // namespace polhode
