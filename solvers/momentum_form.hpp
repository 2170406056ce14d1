// The state form of methods that carry the angular momentum in space: [q][L_S][p v].
//
// A method that keeps a momentum keeps it to rounding only if that momentum is its state. To go through the
// rates and back every step multiplies it by I and by a rounded 1/I, whose product is not one, and to turn it
// along in the body rounds entries near one the same way each time: a drift of |L| in proportion to the
// number of steps, 2e-16 a step. In space nothing but a torque changes L: the free body's stays as it is, bit
// for bit.
#pragma once
#include "solvers/iteration.hpp"
#include "solvers/lie_group.hpp"

namespace polhode {

/// Attitude, and angular momentum in space.
struct Carried {
  Quaternion q;
  Vec3 L;  // kg m^2/s

  Vec3 body_momentum() const { return to_body<double>(q, L); }
};

struct MomentumForm {
  static constexpr std::string_view needs = LieGroupForm::needs;

  template <WithAttitude M>
  static typename M::State start(const M& m) {
    typename M::State y = m.initial;
    const Turning x = turning_of(m, y);
    put(y, to_space<double>(x.q, m.rotation.momentum_B(x.w)));
    return y;
  }

  template <WithAttitude M>
  static Carried carried_of(const M&, const typename M::State& y) {
    return {M::Rotating::attitude_of(y.data()), M::Rotating::w_of(y.data())};
  }

  /// w_B = I^-1 R^T L [rad/s].
  template <WithAttitude M>
  static Vec3 rates_of(const M& m, const Carried& x) {
    return m.rotation.inverse_moments().cwiseProduct(x.body_momentum());
  }

  template <WithAttitude M>
  static Sample sample(const M& m, double t, typename M::State y) {
    const Carried x = carried_of(m, y);
    put(y, rates_of(m, x));
    Sample s = observe(m, t, y.data());
    s.L = x.L;
    return s;
  }

  /// The state after a step that ended at x.
  template <int order, WithAttitude M>
  static typename M::State next(const M& m, double h, const typename M::State& y, const Carried& x) {
    return moved<order>(m, h, y, {x.q, x.L});
  }

 private:
  template <class State>
  static void put(State& y, const Vec3& v) {
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(4 + i)] = v[i];
  }
};

/// A kick of the torque for half a step, before the motion: L + h/2 tau_S(t, q, L).
template <WithAttitude M>
void kick(const M& m, double t, double h, Carried& x, std::int64_t& torques) {
  if constexpr (M::Rotating::has_load) {
    const Vec3 w = MomentumForm::rates_of(m, x);
    x.L += to_space<double>(x.q, 0.5 * h * m.rotation.load.template torque_B<double>(t, x.q, w));
    ++torques;
  }
}

/// The adjoint of that, after the motion: the L for which L - h/2 tau_S(t, q, L) is what came in. A torque
/// that depends on the rates (drag) makes it implicit. False if the iteration does not rest.
template <WithAttitude M>
bool kick_back(const M& m, double t, double h, Carried& x, std::int64_t& torques) {
  if constexpr (M::Rotating::has_load) {
    const Vec3 before = x.body_momentum();
    Vec3 after = before;
    if (!iterate_to_rounding(after, torques, [&](const Vec3& end) -> Vec3 {
          const Vec3 w = m.rotation.inverse_moments().cwiseProduct(end);
          return before + 0.5 * h * m.rotation.load.template torque_B<double>(t, x.q, w);
        }))
      return false;
    x.L += to_space<double>(x.q, after - before);
  }
  return true;
}
inline constexpr const char* kick_failure =
    "the fixed-point iteration for the kick at the end of the step does not converge";

}  // namespace polhode
