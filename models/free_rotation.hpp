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
#include "models/double_double.hpp"
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
  FreeRotation(const Vec3& moments, const QuaternionT<S>& q0, const Vec3T<S>& w0)
      : q0_(normalised<S>(q0)), w0_(w0) {
    const Vec3 d(moments.y() - moments.z(), moments.z() - moments.x(), moments.x() - moments.y());
    if ((d.x() == 0 || w0.y() * w0.z() == S(0)) && (d.y() == 0 || w0.z() * w0.x() == S(0)) &&
        (d.z() == 0 || w0.x() * w0.y() == S(0))) {
      kind_ = Kind::steady;
    } else if (d.x() == 0 || d.y() == 0 || d.z() == 0) {
      set_up_symmetric(moments, d);
    } else {
      set_up_triaxial(moments, w0);
    }
  }

  /// The same in doubles from a set-up in long double, whose phases keep low words: an error that hardly
  /// grows before t = 1000 periods, for three times the set-up.
  static FreeRotation extended(const Vec3& moments, const QuaternionT<S>& q0,
                               const Vec3T<S>& w0) requires std::is_same_v<S, double> {
    return FreeRotation(
        FreeRotation<long double>(moments, q0.template cast<long double>(), w0.template cast<long double>()),
        q0, w0);
  }

  /// The state at time t, which may be negative.
  State at(const S& t) const {
    switch (kind_) {
      case Kind::steady:
        return {q0_ * turn(long_spin_, w0_, t), w0_};
      case Kind::symmetric: {
        const QuaternionT<S> spin = turn(long_spin_, spin_, t);
        return {q0_ * turn(long_precession_, precession_, t) * spin, to_body<S>(spin, w0_)};
      }
      case Kind::inside: {
        // The turn first: nothing waits for it, and it waits for nothing.
        const Direction half_angle = half_turn_angle(t, S(0));
        return place(sums_.inside(inside_phase(t)), half_angle);
      }
      case Kind::outside: {
        S turns(0);
        const S x = outside_phase(t, turns);
        const Direction half_angle = half_turn_angle(t, turns);
        return place(sums_.outside(x, turns), half_angle);
      }
    }
    return {q0_, w0_};
  }

  /// Time in which the rates return [s]; infinite where they are constant or never do (on the separatrix).
  S period() const {
    using std::abs;
    if (kind_ == Kind::inside) return S(2) * pi() / rate_;
    if (kind_ == Kind::outside) return S(2) * span_ / rate_;
    if (kind_ == Kind::symmetric) return S(2) * pi() / spin_.norm();
    return std::numeric_limits<S>::infinity();
  }

  /// The complementary parameter 1 - k^2; one where the rates are trigonometric or constant.
  const S& complementary_parameter() const { return m1_; }

 private:
  enum class Kind { steady, symmetric, inside, outside };
  using Sums = ThetaSums<S>;
  using Pair = typename Sums::Pair;
  using Polhode = PolhodePoint<S>;
  static constexpr int terms = Sums::terms;
  static const S& pi() { return half_turn<S>(); }
  using Mean = LandenMean<S>;

  // ---- set-up

  template <class>
  friend class FreeRotation;

  /// From the constants of a wider type.
  FreeRotation(const FreeRotation<long double>& x, const QuaternionT<S>& q0,
               const Vec3T<S>& w0) requires std::is_same_v<S, double>
      : kind_(static_cast<Kind>(static_cast<int>(x.kind_))),
        extended_(true),
        q0_(normalised<S>(q0)),
        w0_(w0) {
    const auto words = [](long double from, S& to, S& low) {
      to = static_cast<S>(from);
      low = static_cast<S>(from - static_cast<long double>(to));
    };
    m1_ = static_cast<S>(x.m1_);
    if (kind_ == Kind::steady) {
      long_spin_ = x.w0_;
      return;
    }
    if (kind_ == Kind::symmetric) {
      precession_ = x.precession_.template cast<S>();
      spin_ = x.spin_.template cast<S>();
      long_precession_ = x.precession_;
      long_spin_ = x.spin_;
      return;
    }
    axis_ = x.axis_;
    about_largest_ = x.about_largest_;
    for (std::size_t i = 0; i < 3; ++i) sign_[i] = static_cast<S>(x.sign_[i]);
    amplitude_ = x.amplitude_.template cast<S>();
    n_ = x.n_.template cast<S>();
    tilt_ = static_cast<S>(x.tilt_);
    modulus_ = static_cast<S>(x.modulus_);
    words(x.start_, start_, low_.start);
    words(x.rate_, rate_, low_.rate);
    words(x.turn_, turn_, low_.turn);
    words(x.span_, span_, low_.span);
    words(x.half_jump_, half_jump_, low_.half_jump);
    sums_.narrow(x.sums_);
    from_momentum_ = x.from_momentum_.template cast<S>();
  }

  void set_up_symmetric(const Vec3& moments, const Vec3& d) {
    kind_ = Kind::symmetric;
    const int axis = d.x() == 0 ? 0 : d.y() == 0 ? 1 : 2;
    const S across(moments[(axis + 1) % 3]), along(moments[axis]);
    precession_ = Vec3T<S>(w0_);
    precession_[axis] = along / across * w0_[axis];  // L_B/across
    spin_ = Vec3T<S>(S(0), S(0), S(0));
    spin_[axis] = S((across - along) / across) * w0_[axis];
  }

  void set_up_triaxial(const Vec3& moments, const Vec3T<S>& w0) {
    using std::abs;
    using std::sqrt;
    // Sorted: least, middle, largest moment.
    axis_ = {0, 1, 2};
    for (const std::size_t i : {0u, 1u, 0u})
      if (moments[axis_[i]] > moments[axis_[i + 1]]) std::swap(axis_[i], axis_[i + 1]);
    const S excess = momentum_excess<S>(Vec3(moments[axis_[0]], moments[axis_[1]], moments[axis_[2]]),
                                        w0[axis_[0]], w0[axis_[2]]);
    about_largest_ = excess >= S(0);
    if (!about_largest_) std::swap(axis_[0], axis_[2]);
    // Signs that make w1 and w3 non-negative; the third makes the frame right-handed.
    const bool even = (axis_[1] - axis_[0] + 3) % 3 == 1;
    sign_[0] = S(w0[axis_[0]] < S(0) ? -1 : 1);
    sign_[2] = S(w0[axis_[2]] < S(0) ? -1 : 1);
    sign_[1] = S(even ? 1 : -1) * sign_[0] * sign_[2];

    const S I1(moments[axis_[0]]), I2(moments[axis_[1]]), I3(moments[axis_[2]]);
    const S w1(sign_[0] * w0[axis_[0]]), w2(sign_[1] * w0[axis_[1]]), w3(sign_[2] * w0[axis_[2]]);
    // Differences of the given doubles, all with the sign of I3 - I1.
    const S d31 = abs(I3 - I1), d32 = abs(I3 - I2), d21 = abs(I2 - I1);
    const S rho = I2 * d32 / (I1 * d31), root_rho = sqrt(rho);
    const S a1 = sqrt(w1 * w1 + rho * w2 * w2), a2 = a1 / root_rho;
    const S axial = I3 * d31 * w3 * w3 + I2 * d21 * w2 * w2, a3 = sqrt(axial / (I3 * d31));
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
    turn_ = L / (about_largest_ ? I3 : I1);
    const S sine = side * w2 / a2, cosine = w1 / a1;
    // The amplitude of the turn about L: tan = sqrt(I1 (I2 - I3)/(I3 (I1 - I2))), a property of the body.
    const S tangent = sqrt(I1 * d32 / (I3 * d21)), k = sqrt(m), k1 = sqrt(m1_);
    if (m <= m1_)
      set_up_inside(Mean(k1, m), nome(m, k1), lambda, sine, cosine, tangent, k);
    else
      set_up_outside(Mean(k, m1_), nome(m1_, k), lambda, sine, cosine, tangent, k, k1);
    S turns(0);
    const Polhode p =
        kind_ == Kind::inside ? sums_.inside(start_) : sums_.outside(outside_phase(S(0), turns), turns);
    const S x = tilt_ * p.sn, y = p.cn;
    modulus_ = sqrt((p.re * p.re + p.im * p.im) / (x * x + y * y)) / p.weight;
    const auto given = [&](std::size_t i) { return S(sign_[i] * q0_.coeffs()[axis_[i]]); };
    from_momentum_ = QuaternionT<S>(q0_.w(), given(0), given(1), given(2)) *
                     about_momentum(p, half_turn_angle(S(0), turns)).conjugate();
  }

  void set_up_inside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
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
    turn_ += rate_ * top / bottom;
  }

  void set_up_outside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
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
    turn_ += rate_ * top / bottom;
  }

  /// Turn of constant rate; in long double where low words are kept.
  QuaternionT<S> turn(const Vec3T<long double>& long_rate, const Vec3T<S>& rate, const S& t) const {
    if constexpr (std::is_same_v<S, double>)
      if (extended_)
        return exp_rotation<long double>(Vec3T<long double>(long_rate * static_cast<long double>(t)))
            .template cast<S>();
    return exp_rotation<S>(Vec3T<S>(rate * t));
  }

  // ---- phases and angles at a time; where low words are there, in twice the precision of S
  S inside_phase(const S& t) const {
    if constexpr (std::is_same_v<S, double>)
      if (extended_) {
        const DoubleDouble z =
            DoubleDouble{rate_, low_.rate} * DoubleDouble{t} + DoubleDouble{start_, low_.start};
        return less_turns(z, std::round(z.high / full_turn.high), full_turn);
      }
    return start_ + rate_ * t;
  }

  /// Less whole spans, whose number is `turns`.
  S outside_phase(const S& t, S& turns) const {
    using std::round;
    if constexpr (std::is_same_v<S, double>)
      if (extended_) {
        const DoubleDouble x =
            DoubleDouble{rate_, low_.rate} * DoubleDouble{t} + DoubleDouble{start_, low_.start};
        if (!(sums_.nome > 0)) return x.high;
        turns = std::round(x.high / span_);
        return less_turns(x, turns, {span_, low_.span});
      }
    const S x = start_ + rate_ * t;
    if (!(sums_.nome > S(0))) return x;
    turns = round(S(x / span_));
    return x - turns * span_;
  }

  struct Direction {
    S cosine, sine;
  };
  /// Half the uniform part of the turn about L.
  Direction half_turn_angle(const S& t, const S& turns) const {
    using std::cos;
    using std::sin;
    const S half = turn_angle(t, turns) / S(2);
    return {S(cos(half)), S(sin(half))};
  }
  S turn_angle(const S& t, const S& turns) const {
    if constexpr (std::is_same_v<S, double>)
      if (extended_) {
        const DoubleDouble angle = DoubleDouble{turn_, low_.turn} * DoubleDouble{t} +
                                   DoubleDouble{half_jump_, low_.half_jump} * DoubleDouble{2 * turns};
        return less_turns(angle, 2 * std::round(angle.high / (2 * full_turn.high)),
                          full_turn);  // q knows half turns
      }
    return turn_ * t + S(2) * half_jump_ * turns;
  }

  static constexpr DoubleDouble full_turn{6.283185307179586, 2.4492935982947064e-16};
  static double less_turns(const DoubleDouble& x, double n, const DoubleDouble& unit) {
    const DoubleDouble y = x + unit * DoubleDouble{-n};
    return y.high + y.low;
  }

  // ---- evaluation

  /// The attitude in a frame whose third axis is L, up to a constant turn about it.
  QuaternionT<S> about_momentum(const Polhode& p, const Direction& half_angle) const {
    using std::sqrt;
    const S side = about_largest_ ? S(1) : S(-1);
    // n = L_B/|L|, and n2 + i n1 over I1 a1/|L|, so that it has a direction however small it is.
    const S n1 = n_[0] * p.cn, n2 = n_[1] * p.sn, n3 = n_[2] * p.dn;
    const S x = tilt_ * p.sn, y = p.cn;
    // side (re - i side im)(x + i y) has a positive real part and the angle of the rest of the turn: its half
    // needs no arctangent, and the attitude stays on its branch, q(t) continuous with q(0). Its modulus is
    // the product of two that are proportional.
    const S im = side * p.im;
    const S u = side * (p.re * x + im * y), v = side * (p.re * y - im * x);
    const S r = modulus_ * p.weight * (x * x + y * y), c = r + u;
    const S scale = S(1) / (S(2) * sqrt(r * c * (S(1) + n3)));
    const S half_c = (c * half_angle.cosine - v * half_angle.sine) * scale;
    const S half_s = (c * half_angle.sine + v * half_angle.cosine) * scale;
    // (half_c, 0, 0, half_s) (1 + n3, n2, -n1, 0)
    return QuaternionT<S>(half_c * (S(1) + n3), half_c * n2 + half_s * n1, half_s * n2 - half_c * n1,
                          half_s * (S(1) + n3));
  }

  State place(const Polhode& p, const Direction& half_angle) const {
    const QuaternionT<S> q = from_momentum_ * about_momentum(p, half_angle);
    const Vec3T<S> v(sign_[0] * q.x(), sign_[1] * q.y(), sign_[2] * q.z());
    const Vec3T<S> w(amplitude_[0] * p.cn, amplitude_[1] * p.sn, amplitude_[2] * p.dn);
    State state;
    state.q.w() = q.w();
    for (std::size_t i = 0; i < 3; ++i) {
      state.q.coeffs()[axis_[i]] = v[static_cast<int>(i)];
      state.w_B[axis_[i]] = w[static_cast<int>(i)];
    }
    return state;
  }

  Kind kind_ = Kind::steady;
  bool extended_ = false;
  QuaternionT<S> q0_;
  Vec3T<S> w0_;
  Vec3T<S> precession_, spin_;  // symmetric: rates of the two turns, body components
  Vec3T<long double> long_precession_, long_spin_;

  // triaxial, in axes (1, 2, 3): axis_[i] is the body's, taken with sign_[i]
  std::array<int, 3> axis_{0, 1, 2};
  std::array<S, 3> sign_{S(1), S(1), S(1)};
  bool about_largest_ = true;
  S m1_{1};
  Vec3T<S> amplitude_;           // of the rates, with the signs of the body's own axes
  Vec3T<S> n_;                   // and of L_B/|L|
  S modulus_{};                  // |re + i im| over the weight and |n2 + i n1|
  S tilt_{};                     // n_[1]/n_[0]
  S start_{}, rate_{}, turn_{};  // phase at t = 0 and its rate, uniform rate of the turn about L
  struct {
    S start{}, rate{}, turn{}, span{}, half_jump{};
  } low_;                   // words below those of the same names
  S span_{}, half_jump_{};  // outside: the phase between jumps, half the jump
  Sums sums_;
  QuaternionT<S> from_momentum_{S(1), S(0), S(0), S(0)};  // to space, by way of q0; in axes (1, 2, 3)
};

}  // namespace polhode
