// Attitude, and the angular momentum in the body instead of the rates: the state of discrete Moser-Veselov
// steps, whose sums are compensated, and what splittings step within a step.
//
// What carries L along keeps it to rounding only if L itself is what it stores: I (L/I) is not L in the last
// digit, and the same way at each step.
#pragma once
#include "solvers/fixed_step.hpp"
#include "solvers/free_motion.hpp"
#include "solvers/momentum_form.hpp"

namespace polhode {

/// [q][I w_B][p v], in the array of the model's own state.
struct BodyMomentumForm {
  static constexpr std::string_view needs = "needs an attitude: it moves by rotations";

  template <WithAttitude M>
  static typename M::State start(const M& m) {
    typename M::State y = m.initial;
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(4 + i)] *= m.rotation.moments()[i];
    return y;
  }
  template <WithAttitude M>
  static Sample sample(const M& m, double t, typename M::State y) {
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(4 + i)] /= m.rotation.moments()[i];
    return observe(m, t, y.data());
  }
};

template <class State>
[[gnu::always_inline]] inline Spinning spinning_of(const State& y) {
  return {Quaternion(y[0], y[1], y[2], y[3]), Vec3(y[4], y[5], y[6])};
}

/// The state with a new rotation, and the centre of mass where its own equation, linear in v, takes it.
template <WithAttitude M>
[[gnu::always_inline]] inline typename M::State spun(const M& m, double h, const typename M::State& y,
                                                     const Spinning& x) {
  typename M::State next;
  next[0] = x.q.w();
  next[1] = x.q.x();
  next[2] = x.q.y();
  next[3] = x.q.z();
  next[4] = x.m.x();
  next[5] = x.m.y();
  next[6] = x.m.z();
  if constexpr (M::has_translation) {
    double z = 0;
    if constexpr (requires { m.translation.force.drag_per_mass; }) z = -h * m.translation.force.drag_per_mass;
    // phi_1(z) and phi_2(z) = (phi_1(z) - 1)/z
    double one = 1, two = 0.5;
    if (std::abs(z) > 0.1) {
      one = std::expm1(z) / z;
      two = (one - 1) / z;
    } else if (z != 0) {
      two = 0;
      for (int k = 12; k >= 2; --k) two = (1 + z * two) / k;
      one = 1 + z * two;
    }
    const Vec3 v = m.velocity(y.data()), a = m.translation.force.template acceleration<double>(v);
    const Vec3 p = m.position(y.data()) + h * (v + h * two * a), u = v + h * one * a;
    constexpr std::size_t at = M::rotation_size;
    for (int i = 0; i < 3; ++i) {
      next[at + static_cast<std::size_t>(i)] = p[i];
      next[at + static_cast<std::size_t>(3 + i)] = u[i];
    }
  }
  return next;
}

/// The same from a state of MomentumForm, for motions that have L in the body within a step alone.
template <WithAttitude M>
[[gnu::always_inline]] inline Spinning spinning_in(const M&, const typename M::State& y) {
  const Spinning x = spinning_of(y);
  return {x.q, to_body<double>(x.q, x.m)};
}
/// Back to it: where nothing turns the body its L is what it was, to the last bit.
template <WithAttitude M>
[[gnu::always_inline]] inline typename M::State spun_in_space(const M& m, double h,
                                                              const typename M::State& y, const Spinning& x) {
  if constexpr (M::Rotating::has_load)
    return spun(m, h, y, {x.q, to_space<double>(x.q, x.m)});
  else
    return spun(m, h, y, {x.q, spinning_of(y).m});
}

}  // namespace polhode
