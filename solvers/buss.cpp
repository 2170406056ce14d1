// Buss's methods: one rotation a step, by the series of its rotation vector in the derivatives of the rates.
//   R <- exp(u) R,   L <- L + h tau + h^2/2 tau' + ...     (in space, up to h^p for order p)
//   buss2             u = h w + h^2/2 w'
//   buss2-augmented   u = h w + h^2/2 w'            + h^3/12 w' x w
//   buss3             u = h w + h^2/2 w' + h^3/6 w'' + h^3/12 w' x w
//   buss4             u = h w + h^2/2 w' + h^3/6 w'' + h^4/24 w''' + h^3/12 w' x w + h^4/24 w'' x w
// The sums alone would be the vector of turns about an axis that does not move; the cross products say what
// turns that do not commute add. buss1, u = h w, is lie-euler-momentum. The augmented method is of order 3
// where w'' vanishes, and pays where w turns slowly in space: for a fast top its attitude is 90 times nearer
// than that of buss2. For a free body that tumbles it is three times farther, since the mean of the h^3/6 w''
// that it leaves out makes up for half of the cross product, and the energy drifts twice as fast.
//
// Orders 2, 2, 3, 4. |q| = 1 to rounding. The momentum in space is the state: a free body keeps it to the
// last bit. The energy drifts: nothing turns along with it. (The paper's correction of the energy, which
// moves the attitude after the step, is not made here.) The derivatives follow from Euler's equations as
// Taylor series, those of a torque from the load itself. Source: Buss, Accurate and efficient simulation of
// rigid-body rotations, J. Comput. Phys. 164 (2000), 377; the series is that of Magnus, Comm. Pure Appl.
// Math. 7 (1954), 649.
#include "solvers/momentum_form.hpp"
#include "solvers/truncated_series.hpp"

namespace polhode {
namespace {

struct Terms {
  int order;
  bool cross;  // with the cross products
};

/// Derivatives 0..3 in time at the start of a step, body components.
using Derivatives = std::array<Vec3, TruncatedSeries::terms>;

/// The derivatives in space of R v, in the body axes at the start of the step: d/dt (R v) = R (v' + w x v).
Derivatives in_space(const Derivatives& w, const Derivatives& v) {
  const Vec3 x0 = v[1] + w[0].cross(v[0]);
  const Vec3 x1 = v[2] + w[1].cross(v[0]) + w[0].cross(v[1]);
  const Vec3 x2 = v[3] + w[2].cross(v[0]) + 2 * w[1].cross(v[1]) + w[0].cross(v[2]);
  const Vec3 y0 = x1 + w[0].cross(x0);
  const Vec3 y1 = x2 + w[1].cross(x0) + w[0].cross(x1);
  return {v[0], x0, y0, y1 + w[0].cross(y0)};
}

/// u, in the body axes at the start of the step.
Vec3 rotation_vector(const Derivatives& w_B, double h, const Terms& terms) {
  const Derivatives w = in_space(w_B, w_B);
  Vec3 u = h * (w[0] + 0.5 * h * w[1]);
  if (terms.order > 2) u += h * h * h / 6 * w[2];
  if (terms.order > 3) u += h * h * h * h / 24 * (w[3] + w[2].cross(w[0]));
  if (terms.cross) u += h * h * h / 12 * w[1].cross(w[0]);
  return u;
}

/// The impulse of the torque, in the same axes.
Vec3 impulse(const Derivatives& w_B, const Derivatives& tau_B, double h, const Terms& terms) {
  const Derivatives tau = in_space(w_B, tau_B);
  Vec3 sum = Vec3::Zero();
  double factor = h;
  for (int k = 0; k < terms.order; ++k) {
    sum += factor * tau[static_cast<std::size_t>(k)];
    factor *= h / (k + 2);
  }
  return sum;
}

/// The next derivative of w by Euler's equations: I w^(k+1) = (I w x w)^(k) + tau^(k).
void differentiate(Derivatives& w, std::size_t k, const Vec3& moments, const Vec3& inverse, const Vec3& tau) {
  Vec3 sum = tau;
  double binomial = 1;
  for (std::size_t j = 0; j <= k; ++j) {
    sum += binomial * moments.cwiseProduct(w[j]).cross(w[k - j]);
    binomial *= static_cast<double>(k - j) / static_cast<double>(j + 1);
  }
  w[k + 1] = inverse.cwiseProduct(sum);
}

struct Buss : MomentumForm {
  std::int64_t rhs_evals = 0;
  Terms choice{};

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    Carried x = carried_of(m, y);
    const auto order = static_cast<std::size_t>(choice.order);
    Derivatives w;
    w.fill(Vec3::Zero());
    w[0] = rates_of(m, x);
    if constexpr (M::Rotating::has_load) {
      Derivatives tau;
      tau.fill(Vec3::Zero());
      Along along(t, x.q, w[0]);
      for (std::size_t k = 0;; ++k) {
        const Vec3T<TruncatedSeries> series =
            m.rotation.load.template torque_B<TruncatedSeries>(along.t, along.q, along.w);
        ++rhs_evals;
        tau[k] = derivative(series, static_cast<int>(k));
        if (k + 1 == order) break;
        differentiate(w, k, m.rotation.moments(), m.rotation.inverse_moments(), tau[k]);
        along.extend(static_cast<int>(k) + 1, w[k + 1]);
      }
      x.L += to_space<double>(x.q, impulse(w, tau, h, choice));
    } else {
      for (std::size_t k = 0; k + 1 < order; ++k)
        differentiate(w, k, m.rotation.moments(), m.rotation.inverse_moments(), Vec3::Zero());
      ++rhs_evals;
    }
    x.q = x.q * exp_rotation<double>(rotation_vector(w, h, choice));
    return next<4>(m, h, y, x);
  }

 private:
  static constexpr double factorial[] = {1, 1, 2, 6};
  static Vec3 derivative(const Vec3T<TruncatedSeries>& v, int k) {
    return factorial[k] * Vec3(v.x()[k], v.y()[k], v.z()[k]);
  }

  /// Time, attitude and rates as series about the start of the step, known to a growing degree.
  struct Along {
    TruncatedSeries t;
    QuaternionT<TruncatedSeries> q;
    Vec3T<TruncatedSeries> w;

    Along(double t0, const Quaternion& q0, const Vec3& w0)
        : t(t0), q(q0.w(), q0.x(), q0.y(), q0.z()), w(w0.x(), w0.y(), w0.z()) {
      t[1] = 1;
    }
    void extend(int k, const Vec3& w_derivative) {
      // q' = 1/2 q (0, w), coefficient k - 1, before w knows its own of degree k
      const Vec3T<TruncatedSeries> u(q.x(), q.y(), q.z());
      const Vec3T<TruncatedSeries> turned = u.cross(w);
      const TruncatedSeries scalar = q.x() * w.x() + q.y() * w.y() + q.z() * w.z();
      const double half = 0.5 / k;
      const std::array<double, 4> next = {-half * scalar[k - 1], half * (q.w() * w.x() + turned.x())[k - 1],
                                          half * (q.w() * w.y() + turned.y())[k - 1],
                                          half * (q.w() * w.z() + turned.z())[k - 1]};
      q.w()[k] = next[0];
      q.x()[k] = next[1];
      q.y()[k] = next[2];
      q.z()[k] = next[3];
      for (int i = 0; i < 3; ++i) w[i][k] = w_derivative[i] / factorial[k];
    }
  };
};

template <int order>
constexpr Claims claims_of = {.attitude_order = order,
                              .rate_order = order,
                              .energy_order = order,
                              .momentum_order = order,
                              .unit_attitude = Claim::yes,
                              .momentum_magnitude = Claim::yes,
                              .space_momentum = Claim::yes,
                              .energy_bounded = Claim::no,
                              .reversible = Claim::no};
template <int order, bool cross>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_fixed_step<Buss>(scene, setting, {order, cross});
}
constexpr std::string_view source = "Buss, J. Comput. Phys. 164 (2000), 377";

constinit const Method rows[] = {
    {.id = "buss2",
     .family = "Lie group",
     .summary = "one turn by h w + h^2/2 w', momentum in space",
     .source = source,
     .by_steps = true,
     .in_studies = false,
     .claims = claims_of<2>,
     .prepare = prepare<2, false>},
    {.id = "buss2-augmented",
     .family = "Lie group",
     .summary = "the same with h^3/12 w' x w, Buss's augmented second-order method",
     .source = source,
     .by_steps = true,
     .claims = claims_of<2>,
     .prepare = prepare<2, true>},
    {.id = "buss3",
     .family = "Lie group",
     .summary = "one turn by the series of the rotation vector to third order, momentum in space",
     .source = source,
     .by_steps = true,
     .in_studies = false,
     .claims = claims_of<3>,
     .prepare = prepare<3, true>},
    {.id = "buss4",
     .family = "Lie group",
     .summary = "one turn by the series of the rotation vector to fourth order, momentum in space",
     .source = source,
     .by_steps = true,
     .claims = claims_of<4>,
     .prepare = prepare<4, true>},
};

}  // namespace
extern const MethodRows buss;
const MethodRows buss = rows;
}  // namespace polhode
