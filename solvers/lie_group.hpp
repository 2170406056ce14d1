// What the Lie-group methods share: the attitude moves by exponentials, rates and translation by sums.
//
// The state is the model's own, [q][w_B][p v]. A stage is a pair (rotation vector, change of w_B), both in
// body components; composition is from the right, q exp(u). A step ends with q <- q (3 - |q|^2)/2, which
// takes back the rounding of its turns: a body that turns by the same angle over and over makes the same
// rounding error of |q| each time, and would leave one in proportion to the number of steps.
#pragma once
#include "solvers/fixed_step.hpp"
#include "solvers/runge_kutta_4.hpp"

namespace polhode {

/// A rotation in progress: attitude and rates.
struct Turning {
  Quaternion q;
  Vec3 w;  // rad/s, body
};

struct LieGroupForm : QuaternionForm {
  static constexpr std::string_view needs = "needs an attitude: it moves by rotations";
};

template <WithAttitude M>
Turning turning_of(const M&, const typename M::State& y) {
  return {M::Rotating::attitude_of(y.data()), M::Rotating::w_of(y.data())};
}

/// w_B' [rad/s^2].
template <WithAttitude M>
[[gnu::always_inline]] inline Vec3 slope(const M& m, double t, const Turning& x) {
  return m.rotation.template angular_acceleration<double>(t, x.q, x.w);
}

/// The step of a translation [p v], which no load of a rotation touches: explicit Euler (order 1) or the
/// classical Runge-Kutta method.
template <int order, AnyModel M>
[[gnu::always_inline]] inline void move_translation(const M& m, double h, const double* from, double* to) {
  if constexpr (M::has_translation) {
    std::array<double, 6> part;
    std::copy(from, from + 6, part.begin());
    const auto rhs = [&m](double s, const double* v, double* d) { m.translation.rhs(s, v, d); };
    if constexpr (order == 1) {
      std::array<double, 6> d;
      rhs(0, part.data(), d.data());
      for (std::size_t i = 0; i < 6; ++i) part[i] += h * d[i];
    } else {
      part = runge_kutta_4(rhs, 0.0, h, part);
    }
    std::copy(part.begin(), part.end(), to);
  }
}

/// q <- q (3 - |q|^2)/2: of unit length to rounding, for a q that has left it by rounding only.
inline Quaternion held_to_unit(const Quaternion& q) {
  const double scale = 1.5 - 0.5 * squared_norm(q);
  return {scale * q.w(), scale * q.x(), scale * q.y(), scale * q.z()};
}

/// The state with a new rotation, and the translation's own step.
template <int order, WithAttitude M>
[[gnu::always_inline]] inline typename M::State moved(const M& m, double h, const typename M::State& y,
                                                      const Turning& x) {
  typename M::State next;
  const Quaternion q = held_to_unit(x.q);
  next[0] = q.w();
  next[1] = q.x();
  next[2] = q.y();
  next[3] = q.z();
  for (int i = 0; i < 3; ++i) next[static_cast<std::size_t>(4 + i)] = x.w[i];
  move_translation<order>(m, h, y.data() + M::rotation_size, next.data() + M::rotation_size);
  return next;
}

/// The inverse of the derivative of the exponential, for q exp(u) with body rates w: u' = w + u x w/2
/// + (1 - (a/2) cot(a/2))/a^2 u x (u x w), a = |u|. Source: Iserles et al., Acta Numerica 9 (2000), appendix
/// B.
inline Vec3 dexpinv(const Vec3& u, const Vec3& w) {
  const double a2 = u.squaredNorm();
  double c = 1.0 / 12 + a2 * (1.0 / 720 + a2 / 30240);
  if (a2 > 1e-3) {
    const double half = 0.5 * std::sqrt(a2);
    c = (1 - half / std::tan(half)) / a2;
  }
  const Vec3 uw = u.cross(w);
  return w + 0.5 * uw + c * u.cross(uw);
}

}  // namespace polhode
