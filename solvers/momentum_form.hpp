// State forms that carry the angular momentum in the place of the rates: [q][m_B or L_S][p v].
//
// A method that keeps a momentum keeps it to rounding only if that momentum is its state. To go through the
// rates and back every step multiplies it by I and by a rounded 1/I, whose product is not one: the same ulp
// in the same direction each time, a drift in proportion to the number of steps.
#pragma once
#include "solvers/iteration.hpp"
#include "solvers/lie_group.hpp"

namespace polhode {

/// Attitude and angular momentum, in the body frame ("m") or in space ("L") as the form says.
struct Spinning {
  Quaternion q;
  Vec3 momentum;  // kg m^2/s
};

enum class MomentumIn { body, space };

template <MomentumIn frame>
struct MomentumForm {
  static constexpr std::string_view needs = LieGroupForm::needs;

  template <WithAttitude M>
  static typename M::State start(const M& m) {
    typename M::State y = m.initial;
    const Turning x = turning_of(m, y);
    const Vec3 momentum_B = m.rotation.momentum_B(x.w);
    put(y, frame == MomentumIn::space ? to_space<double>(x.q, momentum_B) : momentum_B);
    return y;
  }

  template <WithAttitude M>
  static Spinning spinning_of(const M&, const typename M::State& y) {
    return {M::Rotating::attitude_of(y.data()), M::Rotating::w_of(y.data())};
  }

  /// The rates [rad/s, body] that belong to a momentum.
  template <WithAttitude M>
  static Vec3 rates_of(const M& m, const Spinning& x) {
    const Vec3 momentum_B = frame == MomentumIn::space ? to_body<double>(x.q, x.momentum) : x.momentum;
    return m.rotation.inverse_moments().cwiseProduct(momentum_B);
  }

  template <WithAttitude M>
  static Sample sample(const M& m, double t, typename M::State y) {
    const Spinning x = spinning_of(m, y);
    put(y, rates_of(m, x));
    Sample s = observe(m, t, y.data());
    s.L = frame == MomentumIn::space ? x.momentum : to_space<double>(x.q, x.momentum);
    return s;
  }

  /// The state after a step that ended at x.
  template <int order, WithAttitude M>
  static typename M::State next(const M& m, double h, const typename M::State& y, const Spinning& x) {
    return moved<order>(m, h, y, {x.q, x.momentum});
  }

 private:
  template <class State>
  static void put(State& y, const Vec3& v) {
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(4 + i)] = v[i];
  }
};
using BodyMomentumForm = MomentumForm<MomentumIn::body>;
using SpaceMomentumForm = MomentumForm<MomentumIn::space>;

/// A kick of the torque for half a step, before the motion: m + h/2 tau_B(t, q, I^-1 m).
template <WithAttitude M>
Vec3 kicked(const M& m, double t, double h, const Quaternion& q, const Vec3& momentum_B) {
  if constexpr (M::Rotating::has_load)
    return momentum_B + 0.5 * h *
                            m.rotation.load.template torque_B<double>(
                                t, q, m.rotation.inverse_moments().cwiseProduct(momentum_B));
  else
    return momentum_B;
}

/// The adjoint of that, after the motion: the momentum m for which m - h/2 tau_B(t, q, I^-1 m) is what came
/// in. A torque that depends on the rates (drag) makes it implicit. False if the iteration does not rest.
template <WithAttitude M>
bool kick_back(const M& m, double t, double h, const Quaternion& q, Vec3& momentum_B, std::int64_t& torques) {
  if constexpr (M::Rotating::has_load) {
    const Vec3 before = momentum_B;
    return iterate_to_rounding(momentum_B, torques, [&](const Vec3& end) -> Vec3 {
      return before + 0.5 * h *
                          m.rotation.load.template torque_B<double>(
                              t, q, m.rotation.inverse_moments().cwiseProduct(end));
    });
  }
  return true;
}
inline constexpr const char* kick_failure =
    "the fixed-point iteration for the kick at the end of the step does not converge";

}  // namespace polhode
