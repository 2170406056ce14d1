// The torque-free part of a splitting: attitude and momentum carried along by turns.
//
// A turn by the unit quaternion (c, s u) is added to what it turns, q + q (c - 1, s u) and
// m + 2 s (...): what is rounded is the change, and a turn that repeats does not lengthen q or m step by step
// by the same last digit. The sines are polynomials for turns below one radian, and no root is taken.
#pragma once
#include <algorithm>

#include "models/attitude.hpp"

namespace polhode {

/// Attitude and angular momentum in the body.
struct Spinning {
  Quaternion q;
  Vec3 m;  // kg m^2/s
};

/// Component by component, in scalars: as a packet it would be loaded from where scalars have just been
/// stored, which a processor can only do after a delay of a dozen cycles.
[[gnu::always_inline]] inline Vec3 product(const Vec3& a, const Vec3& b) {
  return {a.x() * b.x(), a.y() * b.y(), a.z() * b.z()};
}

/// A unit quaternion less one.
struct SmallTurn {
  double w, x, y, z;  // w = cos - 1
};

/// How large the half-angles of a flow may be: one question a flow, asked before it, instead of one a turn.
enum class Angles { small, any };  // small: a^2 <= 1/4

/// cos a - 1 and sin(a)/a of a^2; Taylor where a is small, whose next term is below 1e-18.
template <Angles angles>
struct HalfAngle {
  double cosine_less_one, sinc;

  [[gnu::always_inline]] explicit HalfAngle(double a2) {
    if (angles == Angles::small || a2 <= 0.25) {
      const double a4 = a2 * a2, a8 = a4 * a4;
      cosine_less_one = a2 * (((-1.0 / 2 + a2 * (1.0 / 24)) + a4 * (-1.0 / 720 + a2 * (1.0 / 40320))) +
                              a8 * ((-1.0 / 3628800 + a2 * (1.0 / 479001600)) + a4 * (-1.0 / 87178291200)));
      sinc = ((1.0 - a2 * (1.0 / 6)) + a4 * (1.0 / 120 - a2 * (1.0 / 5040))) +
             a8 * ((1.0 / 362880 - a2 * (1.0 / 39916800)) +
                   a4 * (1.0 / 6227020800 - a2 * (1.0 / 1307674368000)));
    } else {
      const double a = std::sqrt(a2), half = std::sin(0.5 * a);
      cosine_less_one = -2 * half * half;
      sinc = std::sin(a) / a;
    }
  }
};

/// Are the half-angles of all turns of length h small? No turn is faster than |m| over the least moment.
inline bool turns_are_small(const Vec3& m, const Vec3& inverse, double h) {
  const double fastest = std::max(std::max(inverse.x(), inverse.y()), inverse.z()) * h;
  return fastest * fastest * (m.x() * m.x() + (m.y() * m.y() + m.z() * m.z())) <= 1;
}

/// q (1 + by) - q
[[gnu::always_inline]] inline Quaternion change_of(const Quaternion& q, const SmallTurn& by) {
  const double w = q.w(), x = q.x(), y = q.y(), z = q.z();
  return {(w * by.w - x * by.x) - (y * by.y + z * by.z), (x * by.w + w * by.x) + (y * by.z - z * by.y),
          (y * by.w + w * by.y) + (z * by.x - x * by.z), (z * by.w + w * by.z) + (x * by.y - y * by.x)};
}
[[gnu::always_inline]] inline void turn_attitude(Quaternion& q, const SmallTurn& by) {
  const Quaternion change = change_of(q, by);
  q.w() += change.w();
  q.x() += change.x();
  q.y() += change.y();
  q.z() += change.z();
}

/// m turned back: conj(1 + by) m (1 + by)
[[gnu::always_inline]] inline void turn_momentum(Vec3& m, const SmallTurn& by) {
  const Vec3 v(by.x, by.y, by.z), across = v.cross(m), twice = v.cross(across);
  m.x() += 2 * (twice.x() - (across.x() + by.w * across.x()));
  m.y() += 2 * (twice.y() - (across.y() + by.w * across.y()));
  m.z() += 2 * (twice.z() - (across.z() + by.w * across.z()));
}

/// Turn about one axis by an angle; the momentum's components across it turn back.
template <Angles angles>
struct AxisTurn {
  double cosine_less_one, sine;  // of half the angle

  [[gnu::always_inline]] explicit AxisTurn(double half_angle) {
    const HalfAngle<angles> f(half_angle * half_angle);
    cosine_less_one = f.cosine_less_one;
    sine = half_angle * f.sinc;
  }
  /// a, b: the components along the two axes after the axis of the turn, in cyclic order.
  [[gnu::always_inline]] void turn_back(double& a, double& b) const {
    const double twice = 2 * sine;
    const double da = twice * ((b + cosine_less_one * b) - sine * a);
    const double db = twice * ((a + cosine_less_one * a) + sine * b);
    a += da;
    b -= db;
  }
};

/// Turn about one axis by the rate that its component of the momentum has.
template <Angles angles>
[[gnu::always_inline]] inline void turn_about(Spinning& x, int axis, double inverse_moment, double h) {
  const AxisTurn<angles> by(0.5 * h * inverse_moment * x.m[axis]);
  const int next = (axis + 1) % 3, last = (axis + 2) % 3;
  auto& q = x.q.coeffs();  // x, y, z, w
  const double c = by.cosine_less_one, s = by.sine, w = q[3], k = q[axis], i = q[next], j = q[last];
  q[3] = w + (w * c - k * s);
  q[axis] = k + (k * c + w * s);
  q[next] = i + (i * c + j * s);
  q[last] = j + (j * c - i * s);
  by.turn_back(x.m[next], x.m[last]);
}

/// The free motion as a symmetric top about one axis (here the first of three in cyclic order), with moments
/// I1, I2, I2, and the rest, which is a turn about the third axis by (1/I3 - 1/I2) m3.
template <int first>
struct SymmetricTop {
  static constexpr int second = (first + 1) % 3, third = (first + 2) % 3;

  template <Angles angles>
  [[gnu::always_inline]] static void turn_rest(Spinning& x, const Vec3& inverse, double h) {
    turn_about<angles>(x, third, inverse[third] - inverse[second], h);
  }
  template <Angles angles>
  [[gnu::always_inline]] static void turn_as_top(Spinning& x, const Vec3& inverse, double h) {
    // As a whole with L/I2, and about the first axis with (1/I1 - 1/I2) m1; the former leaves L where it is.
    const double half = 0.5 * h * inverse[second];
    const double along = half * x.m[first], y = half * x.m[second], z = half * x.m[third];
    const HalfAngle<angles> f(along * along + (y * y + z * z));
    const double a = f.sinc * along, b = f.sinc * y, c = f.sinc * z;
    const AxisTurn<angles> own(0.5 * h * (inverse[first] - inverse[second]) * x.m[first]);
    const double w = f.cosine_less_one, v = own.cosine_less_one, s = own.sine;
    const double turn[] = {(a + s) + (a * v + w * s), b + (b * v + c * s), c + (c * v - b * s)};
    turn_attitude(x.q,
                  {(w + v) + (w * v - a * s), turn[(3 - first) % 3], turn[(4 - first) % 3], turn[2 - first]});
    own.turn_back(x.m[second], x.m[third]);
  }
  /// The rest for a time, the top, the rest.
  template <Angles angles>
  [[gnu::always_inline]] static void flow(Spinning& x, const Vec3& inverse, double before, double top,
                                          double after) {
    turn_rest<angles>(x, inverse, before);
    turn_as_top<angles>(x, inverse, top);
    turn_rest<angles>(x, inverse, after);
  }
};

/// The first axis of the top that leaves the least rest: the inverses of the other two moments are nearest.
[[gnu::always_inline]] inline int nearest_top(const Vec3& inverse) {
  const double x = std::abs(inverse.y() - inverse.z()), y = std::abs(inverse.z() - inverse.x()),
               z = std::abs(inverse.x() - inverse.y());
  return x <= y && x <= z ? 0 : y <= z ? 1 : 2;
}

}  // namespace polhode
