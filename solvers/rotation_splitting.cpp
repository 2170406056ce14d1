// Splittings of the free motion into turns about axes, with the torque as kicks between: symmetric, order 2.
//
//   splitting-12321    kick(h/2) A1(h/2) A2(h/2) A3(h) A2(h/2) A1(h/2) kick(h/2), and the other five orders
//   no-squish          is the order 32123
//   symmetric-split    kick(h/2) A3'(h/2) T(h) A3'(h/2) kick(h/2)
//
// A_i turns by the angle w_i t about axis i, exactly what the energy m_i^2/(2 I_i) alone does; T is the free
// motion of the symmetric top with moments (I1, I2', I2'), and A3' the rest, m3^2 (1/I3 - 1/I2)/2: three
// factors instead of five, and a smaller error, because the rest is small for most bodies. Each factor is a
// rotation that carries L along, and L in space is the state: a free body keeps it, magnitude and direction,
// to the last bit; its energy oscillates, bounded. |q| = 1 to rounding; reversible. A torque that depends on
// the rates (drag) is taken at the rates of the kick, which makes a kick of order 1 in it: second order in
// all is kept by the midpoint of the two half-kicks, one explicit and one implicit. Source: Miller et al., J.
// Chem. Phys. 116 (2002), 8649; Dullweber, Leimkuhler & McLachlan, J. Chem. Phys. 107 (1997), 5840; Fasso, J.
// Comput. Phys. 189 (2003), 527.
#include "solvers/momentum_form.hpp"

namespace polhode {
namespace {

/// Attitude and angular momentum in the body.
struct Spinning {
  Quaternion q;
  Vec3 m;  // kg m^2/s
};

inline void turn(Spinning& x, const Quaternion& by) {
  x.q = x.q * by;
  x.m = to_body<double>(by, x.m);
}

/// Turn about one axis by the rate that its component of the momentum has.
inline void about(Spinning& x, int axis, double inverse_moment, double h) {
  Vec3 angle = Vec3::Zero();
  angle[axis] = h * inverse_moment * x.m[axis];
  turn(x, exp_rotation<double>(angle));
}

/// The free motion for a time h: turns about three axes, the third in the middle.
template <int a, int b, int c>
struct ThreeAxes {
  static void flow(Spinning& x, const Vec3& inverse, double h) {
    about(x, a, inverse[a], 0.5 * h);
    about(x, b, inverse[b], 0.5 * h);
    about(x, c, inverse[c], h);
    about(x, b, inverse[b], 0.5 * h);
    about(x, a, inverse[a], 0.5 * h);
  }
};

/// The symmetric top about axis 1, and the rest as a turn about axis 3.
struct SymmetricTop {
  static void flow(Spinning& x, const Vec3& inverse, double h) {
    const double rest = inverse.z() - inverse.y();
    about(x, 2, rest, 0.5 * h);
    // As a whole with L/I2, and about axis 1 with (1/I1 - 1/I2) m1; the former leaves L where it is.
    const Quaternion whole = exp_rotation<double>(h * inverse.y() * x.m);
    const Quaternion own = exp_rotation<double>(Vec3(h * (inverse.x() - inverse.y()) * x.m.x(), 0, 0));
    x.q = x.q * whole * own;
    x.m = to_body<double>(own, x.m);
    about(x, 2, rest, 0.5 * h);
  }
};

template <class Free>
struct RotationSplitting : MomentumForm {
  std::int64_t rhs_evals = 0;  // torques
  const char* failure = nullptr;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    Carried x = carried_of(m, y);
    kick(m, t, h, x, rhs_evals);
    Spinning turning{x.q, x.body_momentum()};
    Free::flow(turning, m.rotation.inverse_moments(), h);
    x.q = turning.q;
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
     .prepare = run_fixed_step<RotationSplitting<SymmetricTop>>},
};

}  // namespace
extern const MethodRows rotation_splitting;
const MethodRows rotation_splitting = rows;
}  // namespace polhode
