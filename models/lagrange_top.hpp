// The nutation of Lagrange's top (symmetric, held on its axis) by elliptic functions, in any number type.
//
// With u the cosine of the angle between the axis and the vertical, A and C the moments across and along,
// b = C w3 and a = L_z constant, E' = E - C w3^2/2:
//   u'^2 = (2/A)(E' - m g l u)(1 - u^2) - ((a - b u)/A)^2 = beta (u - u1)(u - u2)(u - u3),  beta = 2 m g l/A
//   u = u1 + (u2 - u1) sn^2(sqrt(beta (u3 - u1)) t/2 + delta, k),  k^2 = (u2 - u1)/(u3 - u1)
// Source: Whittaker, Analytical Dynamics (1937), section 71; Goldstein, Classical Mechanics, 5-7.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "models/jacobi.hpp"
#include "models/scene.hpp"

namespace polhode {

template <class S>
class LagrangeNutation {
 public:
  /// Of a scene whose only load is gravity about a pivot, with two equal moments and the centre of mass on
  /// the third axis; nothing for any other.
  static std::optional<LagrangeNutation> of(const Scene& scene) {
    if (!scene.rotation || scene.rotation->loads.size() != 1) return {};
    const RotationData& r = *scene.rotation;
    const auto* load = std::get_if<GravityAboutPivot<double>>(&r.loads.front());
    if (!load) return {};
    for (int axis = 0; axis < 3; ++axis) {
      const int j = (axis + 1) % 3, k = (axis + 2) % 3;
      if (r.moments[j] == r.moments[k] && load->center_B[j] == 0 && load->center_B[k] == 0 &&
          load->center_B[axis] != 0 && load->acceleration_S.norm() > 0)
        return LagrangeNutation(r, *load, axis);
    }
    return {};
  }

  /// Cosine of the angle between the axis (from the pivot to the centre of mass) and the vertical at time t.
  S cosine(const S& t) const {
    if (!(range_ > S(0))) return lowest_;  // regular precession
    const S sn = functions_->at(S(rate_ * t + start_)).sn;
    return lowest_ + range_ * sn * sn;
  }
  /// From one lowest point to the next [s].
  S period() const { return S(2) * quarter_ / rate_; }

 private:
  LagrangeNutation(const RotationData& r, const GravityAboutPivot<double>& load, int axis) {
    using std::abs;
    using std::sqrt;
    const Vec3T<S> g = load.acceleration_S.template cast<S>(), w = r.w0.template cast<S>();
    const QuaternionT<S> q = normalised<S>(r.q0.template cast<S>());
    const Vec3T<S> up = to_body<S>(q, Vec3T<S>(-g / g.norm()));  // of the vertical, in the body
    const S A(r.moments[(axis + 1) % 3]), l(load.center_B[axis]), side(l < S(0) ? -1 : 1);
    const S weight = S(load.mass) * g.norm() * abs(l);
    // The axis points to the centre of mass, so that beta > 0.
    Vec3T<S> n(S(0), S(0), S(0));
    n[axis] = side;
    const S u0 = up.dot(n), slope = up.dot(Vec3T<S>(w.cross(n)));
    const Vec3T<S> L = r.moments.template cast<S>().cwiseProduct(w);
    const S a = L.dot(up) / A, b = L.dot(n) / A, across = w.squaredNorm() - w[axis] * w[axis];
    const S beta = S(2) * weight / A, alpha = across + beta * u0;
    const std::array<S, 3> u = roots(beta, -(alpha + b * b), S(2) * a * b - beta, alpha - a * a);
    lowest_ = u[0];
    range_ = u[1] - u[0];
    if (!(range_ > S(0))) return;
    rate_ = sqrt(beta * (u[2] - u[0])) / S(2);
    const S m = range_ / (u[2] - u[0]), m1 = (u[2] - u[1]) / (u[2] - u[0]);
    const S zero(0), one(1), part = std::min(one, std::max(zero, S((u0 - u[0]) / range_)));
    functions_.emplace(m, m1);
    quarter_ = functions_->quarter_period();
    start_ = functions_->argument(S(sqrt(part)), S(sqrt(S(one - part))));
    if (slope < S(0)) start_ = -start_;
  }

  /// Real roots of a x^3 + b x^2 + c x + d, increasing: Viete's in doubles, then Newton's method in S.
  static std::array<S, 3> roots(const S& a, const S& b, const S& c, const S& d) {
    const double p = static_cast<double>(S(c / a)), q = static_cast<double>(S(d / a)),
                 shift = static_cast<double>(S(b / a)) / 3;
    const double P = p - 3 * shift * shift, Q = 2 * shift * shift * shift - p * shift + q;
    const double radius = 2 * std::sqrt(std::max(0.0, -P / 3));
    const double angle =
        radius > 0 ? std::acos(std::clamp(-4 * Q / (radius * radius * radius), -1.0, 1.0)) : 0;
    std::array<S, 3> x;
    for (int i = 0; i < 3; ++i) {
      S root(radius * std::cos((angle + 2 * i * static_cast<double>(half_turn<S>())) / 3) - shift);
      for (int n = 0; n < 8; ++n) {
        const S slope = (S(3) * a * root + S(2) * b) * root + c;
        if (slope == S(0)) break;
        root -= (((a * root + b) * root + c) * root + d) / slope;
      }
      x[static_cast<std::size_t>(i)] = root;
    }
    std::sort(x.begin(), x.end());
    return x;
  }

  S lowest_{0}, range_{0}, rate_{1}, start_{0}, quarter_{0};
  std::optional<JacobiFunctions<S>> functions_;
};

}  // namespace polhode
