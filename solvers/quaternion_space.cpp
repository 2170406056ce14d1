// Quaternion and angular velocity in space components, the quaternion form of the lecture notes' equations.
//   q' = 1/2 (0, w_S) q,   w_S' = I^-1(tau_S - w_S x I w_S),   I = R I_B R^T with R = R(q/|q|)
//   euler-space-renormalised   one explicit Euler step and q/|q|
//   rk4-space-renormalised     one classical Runge-Kutta step, R(q/|q|) at every stage, and q/|q| at its end
// Orders 1 and 4. |q| = 1 by the division; nothing else is kept. Since R is a rotation whatever the length of
// q, I^-1 is R I_B^-1 R^T exactly, and w_S' = R w_B': the equations are evaluated in the body. Steps of the
// same method in body components (euler-renormalised, rk4-renormalised) differ, because a straight line in
// one frame is none in the other. Source: lecture notes on rigid body dynamics; Kutta (1901).
#include "solvers/lie_group.hpp"

namespace polhode {
namespace {

struct SpaceRatesForm {
  static constexpr std::string_view needs = "needs an attitude: its rates are in space components";

  template <WithAttitude M>
  static typename M::State start(const M& m) {
    typename M::State y = m.initial;
    const Turning x = turning_of(m, y);
    put(y.data(), to_space<double>(x.q, x.w));
    return y;
  }
  template <WithAttitude M>
  static Sample sample(const M& m, double t, typename M::State y) {
    const Turning x = turning_of(m, y);
    put(y.data(), to_body<double>(x.q, x.w));
    return observe(m, t, y.data());
  }

  template <WithAttitude M>
  static void rhs(const M& m, double t, const double* y, double* d) {
    const Quaternion q = M::Rotating::attitude_of(y);
    const Vec3 w = M::Rotating::w_of(y);
    const Quaternion dq = Quaternion(0, 0.5 * w.x(), 0.5 * w.y(), 0.5 * w.z()) * q;
    d[0] = dq.w();
    d[1] = dq.x();
    d[2] = dq.y();
    d[3] = dq.z();
    put(d, to_space<double>(q, slope(m, t, {q, to_body<double>(q, w)})));
    m.translation.rhs(t, y + M::rotation_size, d + M::rotation_size);
  }

 private:
  static void put(double* y, const Vec3& w) {
    for (int i = 0; i < 3; ++i) y[4 + i] = w[i];
  }
};

struct EulerSpace : SpaceRatesForm {
  static constexpr int rhs_per_step = 1;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State d, next;
    rhs(m, t, y.data(), d.data());
    for (std::size_t i = 0; i < y.size(); ++i) next[i] = y[i] + h * d[i];
    renormalise_attitude(next);
    return next;
  }
};

struct Rk4Space : SpaceRatesForm {
  static constexpr int rhs_per_step = 4;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    auto next = runge_kutta_4([&m](double s, const double* x, double* d) { rhs(m, s, x, d); }, t, h, y);
    renormalise_attitude(next);
    return next;
  }
};

constexpr double euler_amplification[] = {1, 1}, rk4_amplification[] = {1, 1, 1.0 / 2, 1.0 / 6, 1.0 / 24};
template <int order>
constexpr Claims claims_of = {.attitude_order = order,
                              .rate_order = order,
                              .energy_order = order,
                              .momentum_order = order,
                              .unit_attitude = Claim::yes,
                              .momentum_magnitude = Claim::no,
                              .space_momentum = Claim::no,
                              .energy_bounded = Claim::no,
                              .reversible = Claim::no};

constinit const Method rows[] = {
    {.id = "euler-space-renormalised",
     .family = "lecture notes",
     .summary = "explicit Euler on (q, w_S) with q/|q| after each step",
     .source = "lecture notes on rigid body dynamics",
     .by_steps = true,
     .in_studies = false,
     .claims = claims_of<1>,
     .stability_polynomial = euler_amplification,
     .prepare = run_fixed_step<EulerSpace>},
    {.id = "rk4-space-renormalised",
     .family = "lecture notes",
     .summary = "classical Runge-Kutta on (q, w_S) with q/|q| after each step",
     .source = "lecture notes on rigid body dynamics; Kutta (1901)",
     .by_steps = true,
     .in_studies = false,
     .claims = claims_of<4>,
     .stability_polynomial = rk4_amplification,
     .prepare = run_fixed_step<Rk4Space>},
};

}  // namespace
extern const MethodRows quaternion_space;
const MethodRows quaternion_space = rows;
}  // namespace polhode
