// The free rigid body in closed form: attitude and body rates at any time, in any number type.
//
// Rates are Jacobi functions, w = (a1 cn, a2 sn, a3 dn)(lambda t + u0), with axis 3 the one that the polhode
// goes round. The attitude is a turn about the constant momentum L after the shortest turn that takes L/|L|
// from body to space; the angle of that turn is At plus the argument of a theta function. Everything is
// evaluated by theta series, in the nome p of k where k^2 <= 1/2 ("inside") and in that of k' by Jacobi's
// imaginary transformation beyond ("outside", up to the separatrix k = 1 itself): either nome is at most
// 0.0433, so that four terms give a double and seven give 50 digits. Phases come from the
// arithmetic-geometric mean with Landen's transformation on sines and cosines (or their hyperbolic kin), as
// quotients of sums of terms of one sign; no elliptic integral is called. What would cancel is formed
// otherwise: amplitudes and 1 - k^2 from the rates, never from L^2 - 2 E I.
//
// Sources: Jacobi, J. reine angew. Math. 39 (1850), attitude by theta functions; van Zon & Schofield, J.
// Comput. Phys. 225 (2007); Celledoni, Fasso, Safstrom & Zanna, SIAM J. Sci. Comput. 30 (2008); regimes as in
// the documentation of Principia's Euler solver; theta series, Landen and imaginary transformations: DLMF 20,
// 19.8, 22.7.
#pragma once
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "models/attitude.hpp"
#include "models/landen.hpp"
#include "models/momentum_excess.hpp"
#include "models/theta_sums.hpp"

namespace polhode {

/// The motion of a free rigid body.
///
/// S   number type: double, long double or Wide
template <class S>
class FreeRotation {
 public:
  struct State {
    QuaternionT<S> q;  // principal -> space, unit
    Vec3T<S> w_B;      // rad/s
  };

  /// moments   principal moments [kg m^2], positive; need not be sorted, nor belong to a possible body
  /// q0        attitude at t = 0, principal to space, of any length but zero
  /// w0        rates at t = 0 [rad/s], principal components
  template <class M>
  FreeRotation(const Eigen::MatrixBase<M>& given_moments, const QuaternionT<S>& q0, const Vec3T<S>& given_w0)
      : q0_(normalised<S>(q0)),
        unit_rate_(power_of_two_near(given_w0)),
        w0_(without_minus_zeros(given_w0 / unit_rate_)) {
    // In units in which rates and moments are about one: their squares neither vanish nor overflow, and since
    // both units are powers of two nothing is rounded.
    const Vec3T<S> moments =
        given_moments.template cast<S>() / power_of_two_near<S>(given_moments.template cast<S>());
    const Vec3T<S>& w0 = w0_;
    const Vec3T<S> d(moments.y() - moments.z(), moments.z() - moments.x(), moments.x() - moments.y());
    const auto still = [&](int i, int j, int k) { return d[i] == S(0) || w0[j] == S(0) || w0[k] == S(0); };
    if (still(0, 1, 2) && still(1, 2, 0) && still(2, 0, 1)) {
      kind_ = Kind::steady;
    } else if (d.x() == S(0) || d.y() == S(0) || d.z() == S(0)) {
      set_up_symmetric(moments, d);
    } else {
      set_up_triaxial(moments, w0);
    }
  }

  /// The state at time t, which may be negative.
  State at(const S& t) const {
    State state = at_scaled(S(t * unit_rate_));
    state.w_B *= unit_rate_;
    return state;
  }

  /// Time in which the rates return [s]; infinite where they are constant or never do (on the separatrix).
  S period() const { return scaled_period() / unit_rate_; }

  /// The complementary parameter 1 - k^2; one where the rates are trigonometric or constant.
  const S& complementary_parameter() const { return m1_; }

 private:
  /// 2^k <= largest modulus < 2^(k + 1); one for zero and for what is not finite.
  template <class T>
  static T power_of_two_near(const Vec3T<T>& v) {
    using std::abs;
    using std::frexp;
    using std::ldexp;
    T largest(0);
    for (int i = 0; i < 3; ++i)
      if (abs(v[i]) > largest) largest = abs(v[i]);
    if (!(largest > T(0)) || !(largest <= std::numeric_limits<T>::max())) return T(1);
    int exponent = 0;
    frexp(largest, &exponent);
    return ldexp(T(1), exponent - 1);
  }

  /// A sign taken from a zero must not depend on how it was written.
  static Vec3T<S> without_minus_zeros(Vec3T<S> v) {
    for (int i = 0; i < 3; ++i)
      if (v[i] == S(0)) v[i] = S(0);
    return v;
  }

  /// Of two components, one of which may be so small that its square vanishes.
  static S length(const S& a, const S& b) {
    if constexpr (std::is_floating_point_v<S>) {
      return std::hypot(a, b);
    } else {
      using std::sqrt;
      return sqrt(a * a + b * b);
    }
  }

  // ---- in units of unit_rate_

  State at_scaled(const S& t) const {
    switch (kind_) {
      case Kind::steady:
        return {q0_ * exp_rotation<S>(Vec3T<S>(w0_ * t)), w0_};
      case Kind::symmetric: {
        const QuaternionT<S> spin = exp_rotation<S>(Vec3T<S>(spin_ * t));
        return {q0_ * exp_rotation<S>(Vec3T<S>(precession_ * t)) * spin, to_body<S>(spin, w0_)};
      }
      case Kind::inside: {
        // The turn first: nothing waits for it, and it waits for nothing.
        const auto half_angle = direction(phase(half_turn_, t, S(0)));
        return place(sums_.inside(direction(phase(rate_, t, start_))), half_angle);
      }
      case Kind::outside: {
        S turns(0);
        const Phase x = outside_phase(t, turns);
        const auto half_angle = direction(phase(half_turn_, t, S(half_jump_ * turns)));
        return place(outside_point(x, turns), half_angle);
      }
    }
    return {q0_, w0_};
  }

  S scaled_period() const {
    if (kind_ == Kind::inside) return S(2) * pi() / rate_;
    if (kind_ == Kind::outside) return S(2) * span_ / rate_;
    if (kind_ == Kind::symmetric) return S(2) * pi() / spin_.norm();
    return std::numeric_limits<S>::infinity();
  }

  enum class Kind { steady, symmetric, inside, outside };
  using Sums = ThetaSums<S>;
  using Pair = typename Sums::Pair;
  using Polhode = PolhodePoint<S>;
  static constexpr int terms = Sums::terms;
  static const S& pi() { return half_turn<S>(); }
  using Mean = LandenMean<S>;

  // ---- set-up

  friend class ExtendedFreeRotation;

  void set_up_symmetric(const Vec3T<S>& moments, const Vec3T<S>& d) {
    kind_ = Kind::symmetric;
    const int axis = d.x() == S(0) ? 0 : d.y() == S(0) ? 1 : 2;
    const S &across = moments[(axis + 1) % 3], &along = moments[axis];
    precession_ = Vec3T<S>(w0_);
    precession_[axis] = along / across * w0_[axis];  // L_B/across
    spin_ = Vec3T<S>(S(0), S(0), S(0));
    spin_[axis] = S((across - along) / across) * w0_[axis];
  }

  void set_up_triaxial(const Vec3T<S>& moments, const Vec3T<S>& w0) {
    using std::abs;
    using std::sqrt;
    // Sorted: least, middle, largest moment.
    axis_ = {0, 1, 2};
    for (const std::size_t i : {0u, 1u, 0u})
      if (moments[axis_[i]] > moments[axis_[i + 1]]) std::swap(axis_[i], axis_[i + 1]);
    const S excess = momentum_excess<S>(Vec3T<S>(moments[axis_[0]], moments[axis_[1]], moments[axis_[2]]),
                                        w0[axis_[0]], w0[axis_[2]]);
    about_largest_ = excess >= S(0);
    if (!about_largest_) std::swap(axis_[0], axis_[2]);
    // Signs that make w1 and w3 non-negative; the third makes the frame right-handed.
    const bool even = (axis_[1] - axis_[0] + 3) % 3 == 1;
    sign_[0] = S(w0[axis_[0]] < S(0) ? -1 : 1);
    sign_[2] = S(w0[axis_[2]] < S(0) ? -1 : 1);
    sign_[1] = S(even ? 1 : -1) * sign_[0] * sign_[2];

    const S &I1 = moments[axis_[0]], &I2 = moments[axis_[1]], &I3 = moments[axis_[2]];
    const S w1(sign_[0] * w0[axis_[0]]), w2(sign_[1] * w0[axis_[1]]), w3(sign_[2] * w0[axis_[2]]);
    // Differences of the given doubles, all with the sign of I3 - I1.
    const S d31 = abs(I3 - I1), d32 = abs(I3 - I2), d21 = abs(I2 - I1);
    const S rho = I2 * d32 / (I1 * d31), root_rho = sqrt(rho);
    const S a1 = length(w1, root_rho * w2), a2 = a1 / root_rho;
    const S axial = I3 * d31 * w3 * w3 + I2 * d21 * w2 * w2;
    const S a3 = length(w3, sqrt(S(I2 * d21 / (I3 * d31))) * w2);
    const S L = sqrt(I1 * I1 * w1 * w1 + I2 * I2 * w2 * w2 + I3 * I3 * w3 * w3);
    const S lambda = a3 * sqrt(d32 * d31 / (I1 * I2));
    const S m = d21 * a1 * a2 / (I3 * a3 * lambda);
    m1_ = d31 * abs(excess) / (d32 * axial);
    if (!(a1 > S(0)) || !(a3 > S(0))) {  // rates so small that their squares vanish
      kind_ = Kind::steady;
      return;
    }
    const S side = about_largest_ ? S(1) : S(-1);
    amplitude_ = Vec3T<S>(sign_[0] * a1, sign_[1] * side * a2, sign_[2] * a3);
    n_ = Vec3T<S>(I1 * a1, side * I2 * a2, I3 * a3) / L;
    tilt_ = side * I2 * a2 / (I1 * a1);
    S turn = L / (about_largest_ ? I3 : I1);  // the mean rate of the turn about L, less a positive term
    const S sine = side * w2 / a2, cosine = w1 / a1;
    // The amplitude of the turn about L: tan = sqrt(I1 (I2 - I3)/(I3 (I1 - I2))), a property of the body.
    const S tangent = sqrt(I1 * d32 / (I3 * d21)), k = sqrt(m), k1 = sqrt(m1_);
    if (m <= m1_)
      turn += set_up_inside(Mean(k1, m), nome(m, k1), lambda, sine, cosine, tangent, k);
    else
      turn += set_up_outside(Mean(k, m1_), nome(m1_, k), lambda, sine, cosine, tangent, k, k1);
    if (kind_ == Kind::inside) sums_.finish_inside();
    half_turn_ = turn / S(2);
    S turns(0);
    const Polhode p = kind_ == Kind::inside ? sums_.inside(direction(Phase{start_, S(0)}))
                                            : outside_point(outside_phase(S(0), turns), turns);
    const S x = tilt_ * p.sn, y = p.cn;
    modulus_ = sqrt((p.re * p.re + p.im * p.im) / (x * x + y * y));
    const auto given = [&](std::size_t i) { return S(sign_[i] * q0_.coeffs()[axis_[i]]); };
    const Scaled about = about_momentum(p, direction(Phase{S(half_jump_ * turns), S(0)}));
    from_momentum_ = QuaternionT<S>(q0_.w(), given(0), given(1), given(2)) * about.q.conjugate();
    from_momentum_.coeffs() *= about.scale;
  }

  /// Returns that term.
  S set_up_inside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
                  const S& tangent, const S& k) {
    using std::exp;
    using std::expm1;
    kind_ = Kind::inside;
    sums_.set_up(p, true);
    start_ = mean.circular(sine, cosine);
    rate_ = mean.limit() * lambda;
    // eta and eta' add to ln(1/p)/2; the smaller tangent gives the smaller of the two.
    const bool direct = tangent * tangent * k <= S(1);
    const S eta = mean.hyperbolic(direct ? tangent : S(S(1) / (k * tangent)));
    const S near = exp(S(-2) * eta), far = p / near, gap = -expm1(S(-2) * eta);  // gap = 1 - near
    const S E = direct ? near : far, P = direct ? far : near;  // e^(-2 eta), p e^(2 eta) = e^(-2 eta')
    S power_E = E, power_P(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = sums_.square[n] * power_P, down = sums_.oblong[n] * power_E;
      const S flip(n % 2 ? -1 : 1);
      sums_.turn_pairs[n] = Pair(flip * (up + down), n == 0 && direct ? gap : S(flip * (up - down)));
      power_E *= E;
      power_P *= P;
    }
    // The mean rate of the turn: L/I3 or L/I1 and a positive term beside it, whichever of the two equal forms
    // has that sign. X = e^(-2 eta) or e^(-2 eta'), Y = p/X.
    const S &X = about_largest_ ? P : E, &Y = about_largest_ ? E : P;
    const bool exact_gap = direct != about_largest_;
    S top(0), bottom(0), power_X = X, power_Y(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = sums_.square[n] * power_Y, down = sums_.oblong[n] * power_X;
      const S odd(2 * static_cast<int>(n) + 1), flip(n % 2 ? -1 : 1);
      // minus the sine series where the turn is counted from L/I3: theta_4 at eta is theta_1 at eta'
      top += flip * (about_largest_ ? S((odd - 1) * up + (odd + 1) * down) : S(odd * (up + down)));
      bottom += n == 0 && exact_gap ? gap : S(flip * (up - down));
      power_X *= X;
      power_Y *= Y;
    }
    return rate_ * top / bottom;
  }

  S set_up_outside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
                   const S& tangent, const S& k, const S& k1) {
    using std::abs;
    using std::cos;
    using std::log;
    using std::sin;
    using std::sqrt;
    kind_ = Kind::outside;
    sums_.set_up(p, false);
    rate_ = mean.limit() * lambda;
    span_ = p > S(0) ? S(-log(p)) : std::numeric_limits<S>::infinity();
    // Beyond the middle of the quarter period the complement is the shorter way: tan -> cot/k'.
    if (abs(sine) * sqrt(k1) <= cosine) {
      start_ = mean.hyperbolic(sine / cosine);
    } else {
      const S beyond = span_ / S(2) - mean.hyperbolic(S(cosine / (k1 * abs(sine))));
      start_ = sine < S(0) ? S(-beyond) : beyond;
    }
    // Half the jump and its complement to pi/2 have tangents whose product is 1/k; the smaller gives both.
    const S w = about_largest_ ? S(S(1) / (k * tangent)) : tangent, cot = S(1) / (k * w);
    const S smaller = w < cot ? w : cot, r = sqrt(S(1) + smaller * smaller);
    const S angle = mean.circular(S(smaller / r), S(S(1) / r));
    const S rest = S(pi() / S(2) - angle);
    half_jump_ = about_largest_ ? S(w < cot ? -rest : -angle) : w < cot ? angle : rest;
    const S s = w < cot ? sin(angle) : cos(angle), c = w < cot ? cos(angle) : sin(angle);
    const S twice = S(2) * (c - s) * (c + s);
    S s_now = s, c_now = c, s_before = -s, c_before = c, top(0), bottom(0);
    for (std::size_t n = 0; n < terms; ++n) {
      const S odd(2 * static_cast<int>(n) + 1), flip(n % 2 ? -1 : 1);
      top += flip * odd * sums_.oblong[n] * c_now;
      bottom += flip * sums_.oblong[n] * s_now;
      // y = pi/2 - half_jump where the turn is counted from L/I3: cos((2n+1) y) = (-1)^n sin((2n+1)
      // half_jump)
      sums_.turn_pairs[n] = about_largest_ ? Pair(s_now, c_now) : Pair(flip * c_now, flip * s_now);
      const S s_next = twice * s_now - s_before, c_next = twice * c_now - c_before;
      s_before = s_now;
      c_before = c_now;
      s_now = s_next;
      c_now = c_next;
    }
    return rate_ * top / bottom;
  }

  // ---- phases and angles at a time, with what a double loses of the product and the sum: the error of a
  // phase is then that of its rate alone
  struct Phase {
    S high, low;
  };
  static Phase phase(const S& rate, const S& t, const S& start) {
    const S way = rate * t, high = way + start;
    if constexpr (std::is_same_v<S, double>) return {high, std::fma(rate, t, -way) + (start - (high - way))};
    return {high, S(0)};
  }
  static Direction<S> direction(const Phase& x) {
    using std::cos;
    using std::sin;
    const S c = cos(x.high), s = sin(x.high);
    return {S(c - x.low * s), S(s + x.low * c)};
  }
  /// Less whole spans, whose number is `turns`.
  Phase outside_phase(const S& t, S& turns) const {
    using std::round;
    Phase x = phase(rate_, t, start_);
    if (!(sums_.nome > S(0))) return x;
    turns = round(S(x.high / span_));
    x.high -= turns * span_;
    return x;
  }
  Polhode outside_point(const Phase& x, const S& turns) const {
    using std::abs;
    using std::exp;
    const S side(x.high < S(0) ? -1 : 1), e = exp(S(-abs(x.high)));
    return sums_.outside(S(e - e * side * x.low), side, turns);
  }

  // ---- evaluation

  struct Scaled {
    QuaternionT<S> q;
    S scale;  // by which q is of unit length
  };
  /// The attitude in a frame whose third axis is L, up to a constant turn about it. The scale, a root and a
  /// quotient, is apart: what is done with q need not wait for it.
  Scaled about_momentum(const Polhode& p, const Direction<S>& half_angle) const {
    using std::sqrt;
    const S side = about_largest_ ? S(1) : S(-1);
    // n = L_B/|L|, and n2 + i n1 over I1 a1/|L|, so that it has a direction however small it is; all times
    // the weight.
    const S n1 = n_[0] * p.cn, n2 = n_[1] * p.sn, n3 = n_[2] * p.dn;
    const S x = tilt_ * p.sn, y = p.cn;
    // side (re - i side im)(x + i y) has a positive real part and the angle of the rest of the turn: its half
    // needs no arctangent, and the attitude stays on its branch, q(t) continuous with q(0). Its modulus is
    // the product of two that are proportional.
    const S im = side * p.im;
    const S u = side * (p.re * x + im * y), v = side * (p.re * y - im * x);
    const S r = modulus_ * (x * x + y * y), c = r + u, top = p.weight + n3;
    const S scale = S(0.5) / sqrt((r * p.weight) * (c * top));
    const S half_c = c * half_angle.cosine - v * half_angle.sine;
    const S half_s = c * half_angle.sine + v * half_angle.cosine;
    // (half_c, 0, 0, half_s) (1 + n3, n2, -n1, 0)
    return {{half_c * top, half_c * n2 + half_s * n1, half_s * n2 - half_c * n1, half_s * top}, scale};
  }

  State place(const Polhode& p, const Direction<S>& half_angle) const {
    const Scaled about = about_momentum(p, half_angle);
    const QuaternionT<S> q = from_momentum_ * about.q;
    const S inverse = S(1) / p.weight;
    const Vec3T<S> v(sign_[0] * q.x(), sign_[1] * q.y(), sign_[2] * q.z());
    const Vec3T<S> w(amplitude_[0] * p.cn, amplitude_[1] * p.sn, amplitude_[2] * p.dn);
    State state;
    state.q.w() = q.w() * about.scale;
    for (std::size_t i = 0; i < 3; ++i) {
      state.q.coeffs()[axis_[i]] = v[static_cast<int>(i)] * about.scale;
      state.w_B[axis_[i]] = w[static_cast<int>(i)] * inverse;
    }
    return state;
  }

  Kind kind_ = Kind::steady;
  QuaternionT<S> q0_;
  S unit_rate_;  // rad/s
  Vec3T<S> w0_;
  Vec3T<S> precession_, spin_;  // symmetric: rates of the two turns, body components

  // triaxial, in axes (1, 2, 3): axis_[i] is the body's, taken with sign_[i]
  std::array<int, 3> axis_{0, 1, 2};
  std::array<S, 3> sign_{S(1), S(1), S(1)};
  bool about_largest_ = true;
  S m1_{1};
  Vec3T<S> amplitude_;  // of the rates, with the signs of the body's own axes
  Vec3T<S> n_;          // and of L_B/|L|
  S modulus_{};         // |re + i im| over |n2 + i n1|
  S tilt_{};            // n_[1]/n_[0]
  S start_{}, rate_{},
      half_turn_{};         // phase at t = 0 and its rate, half the uniform rate of the turn about L
  S span_{}, half_jump_{};  // outside: the phase between jumps, half the jump
  Sums sums_;
  QuaternionT<S> from_momentum_{S(1), S(0), S(0), S(0)};  // to space, by way of q0; in axes (1, 2, 3)
};

}  // namespace polhode
