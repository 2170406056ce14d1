// Phases of elliptic functions by the arithmetic-geometric mean, and the nome, in any number type.
//
// With a_0 = 1, b_0 = k', the amplitude phi_n of a Landen step obeys tan(phi_{n+1} - phi_n) = (b_n/a_n) tan
// phi_n, and F(phi | k^2) = phi_N/(2^N a_N); for an imaginary amplitude the tangents are hyperbolic. Carried
// here on sine and cosine, whose recurrences are quotients of sums: no arctangent is taken before the last
// step, and nothing cancels. Sources: DLMF 19.8, 20.9, 22.20; Abramowitz & Stegun 17.3.21 (the series of the
// nome).
#pragma once
#include <array>
#include <cmath>
#include <limits>

namespace polhode {

/// Half a turn, in S.
template <class S>
const S& half_turn() {
  using std::atan;
  static const S value = S(4) * atan(S(1));
  return value;
}

/// The arithmetic-geometric mean of 1 and b, and Landen's transformation along it.
template <class S>
class LandenMean {
 public:
  /// d0 = 1 - b0^2, given apart because it may be tiny.
  LandenMean(const S& b0, const S& d0) {
    using std::sqrt;
    S x(1), y = b0, z = d0;
    // Along a hyperbola d is multiplied by cosh^2 of the phase, at most about its own inverse square root.
    while (z > epsilon() * epsilon() && steps_ < longest) {
      const auto n = static_cast<std::size_t>(steps_++);
      if (z > epsilon() / 4) circular_steps_ = steps_;
      a_[n] = x;
      b_[n] = y;
      d_[n] = z;
      const S next = (x + y) / 2;
      y = sqrt(x * y);
      x = next;
      z = z / (S(4) * x);
      z = z * z;
    }
    limit_ = x;
  }

  /// limit * F(phi | d0) for sin and cos of an amplitude phi in [-pi/2, pi/2]. Odd, and exact at 0 and at a
  /// quarter turn, where the sign of a zero would otherwise decide.
  S circular(S sine, S cosine) const {
    using std::atan2;
    using std::round;
    const bool negative = sine < S(0);
    if (negative) sine = -sine;
    const auto signed_phase = [negative](const S& x) { return negative ? S(-x) : x; };
    if (sine == S(0)) return S(0);
    if (cosine == S(0)) return signed_phase(half_turn<S>() / S(2));
    if (circular_steps_ == 0) return signed_phase(atan2(sine, cosine));
    // Only their quotient matters: (sine, cosine) lose length in a step, at most by b, and no root restores
    // it.
    S estimate(0);
    for (int n = 0; n < circular_steps_; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const S s = (a_[i] + b_[i]) * sine * cosine;
      cosine = a_[i] * cosine * cosine - b_[i] * sine * sine;
      sine = s;
      if (n == 0) estimate = roughly_atan2(sine, cosine);
    }
    const S phase = atan2(sine, cosine);
    if (circular_steps_ == 1) return signed_phase(phase / S(2));
    // The first step is within the range of atan2; later ones double the phase to within 0.03 of a turn, and
    // the 0.004 rad of the estimate to at most half of one.
    estimate *= S(1 << (circular_steps_ - 1));
    return signed_phase(
        S((phase + S(2) * half_turn<S>() * round((estimate - phase) / (S(2) * half_turn<S>()))) /
          S(1 << circular_steps_)));
  }

  /// limit * integral of 1/sqrt(1 + d0 sinh^2) from 0 to asinh(s).
  S hyperbolic(S s) const {
    using std::asinh;
    using std::sqrt;
    S c = sqrt(S(1) + s * s);
    for (int n = 0; n < steps_; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const S r = sqrt(b_[i] * b_[i] + d_[i] * c * c);
      const S next = (a_[i] + b_[i]) * s * c / r;
      c = (a_[i] * c * c + b_[i] * s * s) / r;
      s = next;
    }
    return asinh(s) / S(1 << steps_);
  }

  /// The inverse of `circular` over limit(): the amplitude phi at an argument u of any size, F(phi | d0) = u.
  /// sin(2 phi_n - phi_{n+1}) = (a_n - b_n)/(a_n + b_n) sin phi_{n+1}, with the cosine beside it, so that no
  /// arcsine is taken near one.
  S amplitude(const S& u) const {
    using std::atan2;
    using std::cos;
    using std::sin;
    using std::sqrt;
    S phi = limit_ * u * S(1 << circular_steps_);
    for (int n = circular_steps_; n-- > 0;) {
      const auto i = static_cast<std::size_t>(n);
      const S sum = a_[i] + b_[i], s = sin(phi), c = cos(phi);
      const S ratio = d_[i] / (sum * sum), rest = S(4) * a_[i] * b_[i] / (sum * sum);
      phi = (phi + atan2(S(ratio * s), S(sqrt(S(c * c + rest * s * s))))) / S(2);
    }
    return phi;
  }

  /// The mean itself: pi/2 over the complete integral.
  const S& limit() const { return limit_; }

 private:
  static constexpr int longest = 9;  // d is squared at each step: the eighth is beyond any type used here
  static S epsilon() { return std::numeric_limits<S>::epsilon(); }
  /// atan2 to 0.004 rad: in the first octant a quotient t and t (pi/4 + 0.273 (1 - t)).
  static S roughly_atan2(const S& y, const S& x) {
    using std::abs;
    const S ax = abs(x), ay = abs(y);
    const bool steep = ay > ax;
    const S t = steep ? S(ax / ay) : S(ay / ax);
    const S octant = t * (S(0.7853981633974483) + S(0.273) * (S(1) - t));
    const S quadrant = steep ? S(S(1.5707963267948966) - octant) : octant;
    const S half = x < S(0) ? S(S(3.141592653589793) - quadrant) : quadrant;
    return y < S(0) ? S(-half) : half;
  }
  std::array<S, longest> a_, b_, d_;  // d = a^2 - b^2
  int steps_ = 0, circular_steps_ = 0;
  S limit_;
};

/// The nome of parameter m <= 1/2 (nearly) and complementary modulus k1.
template <class S>
S nome(S m, S k1) {
  using std::sqrt;
  // A descending Landen step squares the nome; below 1e-3 or so the series has its last term beyond 50
  // digits.
  int squarings = 0;
  if constexpr (std::numeric_limits<S>::digits10 > 19)
    for (; m > S(1e-12); ++squarings) {
      const S k = m / ((S(1) + k1) * (S(1) + k1));
      m = k * k;
      k1 = S(2) * sqrt(k1) / (S(1) + k1);
    }
  const S root = S(1) + sqrt(k1);
  const S e = m / (S(2) * root * root * (S(1) + k1)), e4 = e * e * e * e;
  S p = e * (S(1) + e4 * (S(2) + e4 * (S(15) + e4 * (S(150) + e4 * S(1707)))));
  for (; squarings > 0; --squarings) p = sqrt(p);
  return p;
}

}  // namespace polhode
