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

#include <boost/multiprecision/cpp_bin_float.hpp>

#include "models/attitude.hpp"

namespace polhode {

/// The motion of a free rigid body.
///
/// S   number type of the result: double, long double or Wide. The problem itself is given in doubles.
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
  FreeRotation(const Vec3& moments, const Quaternion& q0, const Vec3& w0)
      : q0_(normalised<S>(q0.cast<S>())), w0_(w0.cast<S>()) {
    const Vec3 d(moments.y() - moments.z(), moments.z() - moments.x(), moments.x() - moments.y());
    if ((d.x() == 0 || w0.y() * w0.z() == 0) && (d.y() == 0 || w0.z() * w0.x() == 0) &&
        (d.z() == 0 || w0.x() * w0.y() == 0)) {
      kind_ = Kind::steady;
    } else if (d.x() == 0 || d.y() == 0 || d.z() == 0) {
      set_up_symmetric(moments, d);
    } else {
      set_up_triaxial(moments, w0);
    }
  }

  /// The state at time t, which may be negative.
  State at(const S& t) const {
    switch (kind_) {
      case Kind::steady:
        return {q0_ * exp_rotation<S>(Vec3T<S>(w0_ * t)), w0_};
      case Kind::symmetric: {
        const QuaternionT<S> spin = exp_rotation<S>(Vec3T<S>(spin_ * t));
        return {q0_ * exp_rotation<S>(Vec3T<S>(precession_ * t)) * spin, to_body<S>(spin, w0_)};
      }
      case Kind::inside:
        return place(inside(start_ + rate_ * t), turn_ * t);
      case Kind::outside:
        return place(outside(start_ + rate_ * t), turn_ * t);
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
  static constexpr int digits = std::numeric_limits<S>::digits10 + 1;
  static constexpr int terms = digits <= 20 ? 4 : 7;  // the next would be p^(terms^2) <= 0.0433^(terms^2)
  static constexpr int longest_mean = 9;
  using Series = std::array<S, terms>;

  static S pi() { return S(4) * one_atan(); }
  static S one_atan() {
    using std::atan;
    static const S value = atan(S(1));
    return value;
  }
  static S epsilon() { return std::numeric_limits<S>::epsilon(); }

  // ---- the arithmetic-geometric mean of 1 and b, and Landen's transformation along it

  struct Mean {
    std::array<S, longest_mean> a, b, d;  // d = a^2 - b^2
    int steps = 0, circular_steps = 0;
    S limit;

    /// d0 = 1 - b0^2, given apart because it may be tiny.
    Mean(const S& b0, const S& d0) {
      using std::sqrt;
      S x(1), y = b0, z = d0;
      // Along a hyperbola d is multiplied by cosh^2 of the phase, at most about its own inverse square root.
      while (z > epsilon() * epsilon() && steps < longest_mean) {
        const auto n = static_cast<std::size_t>(steps++);
        if (z > epsilon() / 4) circular_steps = steps;
        a[n] = x;
        b[n] = y;
        d[n] = z;
        const S next = (x + y) / 2;
        y = sqrt(x * y);
        x = next;
        z = z / (S(4) * x);
        z = z * z;
      }
      limit = x;
    }

    /// limit * F(phi | d0) for sin and cos of an amplitude phi in [-pi/2, pi/2].
    S circular(S sine, S cosine) const {
      using std::atan2;
      using std::round;
      using std::sqrt;
      S estimate = atan2(sine, cosine);
      if (circular_steps == 0) return estimate;
      for (int n = 0; n < circular_steps; ++n) {
        const auto i = static_cast<std::size_t>(n);
        const S r = sqrt(b[i] * b[i] + d[i] * cosine * cosine);
        const S s = (a[i] + b[i]) * sine * cosine / r;
        cosine = (a[i] * cosine * cosine - b[i] * sine * sine) / r;
        sine = s;
        estimate = n == 0 ? atan2(sine, cosine) : S(2) * estimate;
      }
      if (circular_steps == 1) return estimate / S(2);
      // The first step is within the range of atan2; later ones double the phase to within 0.03 of a turn.
      S phase = atan2(sine, cosine);
      phase += S(2) * pi() * round((estimate - phase) / (S(2) * pi()));
      return phase / S(1 << circular_steps);
    }

    /// limit * integral of 1/sqrt(1 + d0 sinh^2) from 0 to asinh(s).
    S hyperbolic(S s) const {
      using std::asinh;
      using std::sqrt;
      S c = sqrt(S(1) + s * s);
      for (int n = 0; n < steps; ++n) {
        const auto i = static_cast<std::size_t>(n);
        const S r = sqrt(b[i] * b[i] + d[i] * c * c);
        const S next = (a[i] + b[i]) * s * c / r;
        c = (a[i] * c * c + b[i] * s * s) / r;
        s = next;
      }
      return asinh(s) / S(1 << steps);
    }
  };

  /// The nome of parameter m <= 1/2 (nearly) and complementary modulus k1.
  static S nome(S m, S k1) {
    using std::sqrt;
    // A descending Landen step squares the nome; below 1e-3 or so the series has its last term beyond 50
    // digits.
    int squarings = 0;
    if constexpr (digits > 20)
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

  // ---- set-up

  void set_up_symmetric(const Vec3& moments, const Vec3& d) {
    kind_ = Kind::symmetric;
    const int axis = d.x() == 0 ? 0 : d.y() == 0 ? 1 : 2;
    const S across(moments[(axis + 1) % 3]), along(moments[axis]);
    precession_ = Vec3T<S>(w0_);
    precession_[axis] = along / across * w0_[axis];  // L_B/across
    spin_ = Vec3T<S>(S(0), S(0), S(0));
    spin_[axis] = S((across - along) / across) * w0_[axis];
  }

  /// L^2 - 2 E I_mid from min, mid, max, exactly where it may cancel: its terms are products of four doubles.
  static S momentum_excess(const Vec3& I, const Vec3& w) {
    if constexpr (std::is_same_v<S, double>) {
      const double low = I[0] * (I[1] - I[0]) * (w[0] * w[0]), high = I[2] * (I[2] - I[1]) * (w[2] * w[2]);
      if (!(std::abs(high - low) < 1e-3 * high)) return high - low;
    }
    using Exact = boost::multiprecision::number<
        boost::multiprecision::cpp_bin_float<480, boost::multiprecision::digit_base_2>,
        boost::multiprecision::et_off>;
    const Exact a(I[0]), b(I[1]), c(I[2]), u(w[0]), v(w[2]);
    return static_cast<S>(Exact(c * (c - b) * v * v - a * (b - a) * u * u));
  }

  void set_up_triaxial(const Vec3& moments, const Vec3& w0) {
    using std::abs;
    using std::sqrt;
    // Sorted: least, middle, largest moment.
    axis_ = {0, 1, 2};
    if (moments[axis_[0]] > moments[axis_[1]]) std::swap(axis_[0], axis_[1]);
    if (moments[axis_[1]] > moments[axis_[2]]) std::swap(axis_[1], axis_[2]);
    if (moments[axis_[0]] > moments[axis_[1]]) std::swap(axis_[0], axis_[1]);
    const S excess = momentum_excess(Vec3(moments[axis_[0]], moments[axis_[1]], moments[axis_[2]]),
                                     Vec3(w0[axis_[0]], w0[axis_[1]], w0[axis_[2]]));
    about_largest_ = excess >= S(0);
    if (!about_largest_) std::swap(axis_[0], axis_[2]);
    // Signs that make w1 and w3 non-negative; the third makes the frame right-handed.
    const bool even = (axis_[1] - axis_[0] + 3) % 3 == 1;
    sign_[0] = S(w0[axis_[0]] < 0 ? -1 : 1);
    sign_[2] = S(w0[axis_[2]] < 0 ? -1 : 1);
    sign_[1] = S(even ? 1 : -1) * sign_[0] * sign_[2];

    const S I1(moments[axis_[0]]), I2(moments[axis_[1]]), I3(moments[axis_[2]]);
    const S w1(sign_[0] * S(w0[axis_[0]])), w2(sign_[1] * S(w0[axis_[1]])), w3(sign_[2] * S(w0[axis_[2]]));
    // Differences of the given doubles, all with the sign of I3 - I1.
    const S d31 = abs(I3 - I1), d32 = abs(I3 - I2), d21 = abs(I2 - I1);
    const S rho = I2 * d32 / (I1 * d31), root_rho = sqrt(rho);
    a1_ = sqrt(w1 * w1 + rho * w2 * w2);
    a2_ = a1_ / root_rho;
    const S a3_squared_I = I3 * d31 * w3 * w3 + I2 * d21 * w2 * w2;  // I3 d31 a3^2
    a3_ = sqrt(a3_squared_I / (I3 * d31));
    I_ = Vec3T<S>(I1, I2, I3);
    L_ = sqrt(I1 * I1 * w1 * w1 + I2 * I2 * w2 * w2 + I3 * I3 * w3 * w3);
    const S lambda = a3_ * sqrt(d32 * d31 / (I1 * I2));
    const S m = d21 * a1_ * a2_ / (I3 * a3_ * lambda);
    m1_ = d31 * abs(excess) / (d32 * a3_squared_I);
    if (!(a1_ > S(0)) || !(a3_ > S(0))) {  // rates so small that their squares vanish
      kind_ = Kind::steady;
      return;
    }
    const S sine = (about_largest_ ? w2 : S(-w2)) / a2_, cosine = w1 / a1_;
    // The amplitude of the turn about L: tan = sqrt(I1 (I2 - I3)/(I3 (I1 - I2))), a property of the body, and
    // its complement.
    const S tangent = sqrt(I1 * d32 / (I3 * d21)), k = sqrt(m), k1 = sqrt(m1_);
    if (m <= m1_)
      set_up_inside(Mean(k1, m), nome(m, k1), lambda, sine, cosine, tangent, k);
    else
      set_up_outside(Mean(k, m1_), nome(m1_, k), lambda, sine, cosine, tangent, k, k1);
    if (!about_largest_) a2_ = -a2_;
    n_ = Vec3T<S>(I1 * a1_, I2 * a2_, I3 * a3_) / L_;
    tilt_ = I2 * a2_ / (I1 * a1_);
    // The attitude relative to the momentum at t = 0.
    const Polhode p = kind_ == Kind::inside ? inside(start_) : outside(start_);
    const QuaternionT<S> start = q0_;
    const std::array<S, 3> v = {start.x(), start.y(), start.z()};
    const auto turned = [&](std::size_t n) { return S(sign_[n] * v[static_cast<std::size_t>(axis_[n])]); };
    from_momentum_ =
        QuaternionT<S>(start.w(), turned(0), turned(1), turned(2)) * about_momentum(p, S(0)).conjugate();
  }

  void set_up_inside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
                     const S& tangent, const S& k) {
    using std::exp;
    using std::expm1;
    kind_ = Kind::inside;
    start_ = mean.circular(sine, cosine);
    rate_ = mean.limit * lambda;
    // eta and eta' add to ln(1/p)/2; the smaller tangent gives the smaller of the two.
    const bool direct = tangent * tangent * k <= S(1);
    const S eta = mean.hyperbolic(direct ? tangent : S(S(1) / (k * tangent)));
    const S near = exp(S(-2) * eta), far = p / near, gap = -expm1(S(-2) * eta);  // gap = 1 - near
    const S E = direct ? near : far, P = direct ? far : near;  // e^(-2 eta), p e^(2 eta) = e^(-2 eta')
    set_powers(p);
    S power_E = E, power_P(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = square_[n] * power_P, down = oblong_[n] * power_E;
      re_[n] = up + down;
      im_[n] = n == 0 && direct ? gap : S(up - down);
      power_E *= E;
      power_P *= P;
    }
    // The mean rate of the turn: L/I3 or L/I1 and a positive term beside it, whichever of the two equal forms
    // has that sign. X = e^(-2 eta) or e^(-2 eta'), Y = p/X.
    const S &X = about_largest_ ? P : E, &Y = about_largest_ ? E : P;
    const bool exact_gap = direct != about_largest_;
    S top(0), bottom(0), power_X = X, power_Y(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = square_[n] * power_Y, down = oblong_[n] * power_X;
      const S odd(2 * static_cast<int>(n) + 1), flip(n % 2 ? -1 : 1);
      // minus the sine series where the turn is counted from L/I3: theta_4 at eta is theta_1 at eta'
      top += flip * (about_largest_ ? S((odd - 1) * up + (odd + 1) * down) : S(odd * (up + down)));
      bottom += n == 0 && exact_gap ? gap : S(flip * (up - down));
      power_X *= X;
      power_Y *= Y;
    }
    turn_ = L_ / (about_largest_ ? I_[2] : I_[0]) + rate_ * top / bottom;
    S t2(0), t3(1), t4(1);
    for (std::size_t n = 0; n < terms; ++n) t2 += oblong_[n];
    for (std::size_t n = 1; n < terms; ++n) {
      t3 += S(2) * square_[n];
      t4 += (n % 2 ? S(-2) : S(2)) * square_[n];
    }
    cn_ = t4 / t2;
    sn_ = t3 / t2;
    dn_ = t4 / t3;
  }

  void set_up_outside(const Mean& mean, const S& p, const S& lambda, const S& sine, const S& cosine,
                      const S& tangent, const S& k, const S& k1) {
    using std::abs;
    using std::cos;
    using std::log;
    using std::sin;
    using std::sqrt;
    kind_ = Kind::outside;
    rate_ = mean.limit * lambda;
    nome_ = p;
    span_ = p > S(0) ? S(-log(p)) : std::numeric_limits<S>::infinity();
    // Beyond the middle of the quarter period the complement is the shorter way: tan -> cot/k'.
    if (abs(sine) * sqrt(k1) <= cosine) {
      start_ = mean.hyperbolic(sine / cosine);
    } else {
      const S rest = span_ / S(2) - mean.hyperbolic(S(cosine / (k1 * abs(sine))));
      start_ = sine < S(0) ? S(-rest) : rest;
    }
    // Half the jump and its complement to pi/2 have tangents whose product is 1/k; the smaller gives both.
    const S w = about_largest_ ? S(S(1) / (k * tangent)) : tangent, cot = S(1) / (k * w);
    const S smaller = w < cot ? w : cot, r = sqrt(S(1) + smaller * smaller);
    const S angle = mean.circular(S(smaller / r), S(S(1) / r));
    half_jump_ = w < cot ? angle : S(pi() / S(2) - angle);
    set_powers(p);
    const S s = w < cot ? sin(angle) : cos(angle), c = w < cot ? cos(angle) : sin(angle);
    const S twice = S(2) * (c - s) * (c + s);
    S s_now = s, c_now = c, s_before = -s, c_before = c, top(0), bottom(0);
    for (std::size_t n = 0; n < terms; ++n) {
      const S odd(2 * static_cast<int>(n) + 1), flip(n % 2 ? -1 : 1);
      top += flip * odd * oblong_[n] * c_now;
      bottom += flip * oblong_[n] * s_now;
      // y = pi/2 - half_jump where the turn is counted from L/I3: cos((2n+1) y) = (-1)^n sin((2n+1)
      // half_jump)
      re_[n] = about_largest_ ? S(flip * s_now) : c_now;
      im_[n] = about_largest_ ? S(flip * c_now) : s_now;
      const S s_next = twice * s_now - s_before, c_next = twice * c_now - c_before;
      s_before = s_now;
      c_before = c_now;
      s_now = s_next;
      c_now = c_next;
    }
    turn_ = L_ / (about_largest_ ? I_[2] : I_[0]) + rate_ * top / bottom;
    S t2(0), t3(1), t4(1);
    for (std::size_t n = 0; n < terms; ++n) t2 += oblong_[n];
    for (std::size_t n = 1; n < terms; ++n) {
      t3 += S(2) * square_[n];
      t4 += (n % 2 ? S(-2) : S(2)) * square_[n];
    }
    sn_ = t3 / t4;
    cn_ = t2 / t4;
    dn_ = t2 / t3;
  }

  /// p^(n^2) and p^(n (n + 1)).
  void set_powers(const S& p) {
    S power(1);
    square_[0] = oblong_[0] = S(1);
    for (std::size_t n = 1; n < terms; ++n) {
      square_[n] = oblong_[n - 1] * power * p;
      power *= p;
      oblong_[n] = square_[n] * power;
    }
  }

  // ---- evaluation

  /// A point of the polhode: Jacobi functions, and e^(i angle) times a positive number for the part of the
  /// turn about L that is not uniform.
  struct Polhode {
    S sn, cn, dn;  // of the true phase
    S re, im;
    S jump{};  // of the uniform part of the angle
  };

  /// z = pi u/(2 K)
  Polhode inside(const S& z) const {
    using std::cos;
    using std::sin;
    const S s = sin(z), c = cos(z), twice = S(2) * (c - s) * (c + s);  // 2 cos 2z
    S s_now = s, c_now = c, s_before = -s, c_before = c;               // of (2n + 1) z
    S even_now = twice / S(2), even_before(1);                         // cos 2nz
    S S1 = s, C2 = c, t3(1), t4(1), re = re_[0] * s, im = im_[0] * c;
    for (std::size_t n = 1; n < terms; ++n) {
      const S s_next = twice * s_now - s_before, c_next = twice * c_now - c_before;
      s_before = s_now;
      c_before = c_now;
      s_now = s_next;
      c_now = c_next;
      const S even = S(2) * square_[n] * even_now;
      t3 += even;
      C2 += oblong_[n] * c_now;
      if (n % 2) {
        t4 -= even;
        S1 -= oblong_[n] * s_now;
        re -= re_[n] * s_now;
        im -= im_[n] * c_now;
      } else {
        t4 += even;
        S1 += oblong_[n] * s_now;
        re += re_[n] * s_now;
        im += im_[n] * c_now;
      }
      const S even_next = twice * even_now - even_before;
      even_before = even_now;
      even_now = even_next;
    }
    const S inverse = S(1) / t4;
    return {sn_ * S1 * inverse, cn_ * C2 * inverse, dn_ * t3 * inverse, re, im, S(0)};
  }

  /// x = pi u/(2 K')
  Polhode outside(S x) const {
    using std::abs;
    using std::exp;
    using std::round;
    S turns(0);
    if (nome_ > S(0)) {
      turns = round(x / span_);
      x -= turns * span_;
    }
    const S E = exp(S(-2) * abs(x)), P = nome_ > S(0) ? S(nome_ / E) : S(0);  // e^(-2|x|), p' e^(2|x|)
    // Everything times e^(-|x|): sinh and cosh of (2n + 1)|x|, and cosh of 2n|x| times e^|x|.
    S S1(0), C2(0), t3(1), t4(1), re(0), im(0), power_E = E, power_P(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = square_[n] * power_P, down = oblong_[n] * power_E;
      const S sinh_n = up - down, cosh_n = up + down, flip(n % 2 ? -1 : 1);
      S1 += flip * sinh_n;
      C2 += cosh_n;
      re += flip * sinh_n * re_[n];
      im += flip * cosh_n * im_[n];
      power_P *= P;
      if (n + 1 < terms) {
        const S even = oblong_[n] * power_P + square_[n + 1] * power_E;
        t3 += even;
        t4 += n % 2 ? even : S(-even);
      }
      power_E *= E;
    }
    const S inverse = S(1) / C2, decay = S(2) * exp(-abs(x)) * inverse;
    const bool odd = turns / S(2) != round(S(turns / S(2)));
    const S flip(odd ? -1 : 1);
    if (x < S(0)) {
      S1 = -S1;
      re = -re;
    }
    Polhode p{flip * sn_ * S1 * inverse, flip * cn_ * t4 * decay, dn_ * t3 * decay, re, im,
              S(2) * half_jump_ * turns};
    // theta_1 and n2 + i n1 change sign together from one span to the next, and about_momentum sees only the
    // latter; counted from L/I3 the angle jumps by pi as well.
    if (odd != (about_largest_ && odd)) {
      p.re = -p.re;
      p.im = -p.im;
    }
    return p;
  }

  /// The attitude in a frame whose third axis is L, up to a constant turn about it.
  QuaternionT<S> about_momentum(const Polhode& p, const S& angle) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const S side = about_largest_ ? S(1) : S(-1);
    // n = L_B/|L|, and n2 + i n1 over I1 a1/|L|, so that it has a direction however small it is.
    const S n1 = n_[0] * p.cn, n2 = n_[1] * p.sn, n3 = n_[2] * p.dn;
    const S x = tilt_ * p.sn, y = p.cn;
    // e^(i angle) (re - i side im)(x + i y) has the angle of the turn; its half, from |.|, needs no
    // arctangent.
    const S im = side * p.im, total = angle + p.jump;
    const S u = p.re * x + im * y, v = p.re * y - im * x;
    const S ca = cos(total), sa = sin(total);
    const S c = u * ca - v * sa, s = u * sa + v * ca, r = sqrt(c * c + s * s);
    const bool near = c >= S(0);
    const S sum = near ? S(r + c) : S(r - c);
    const S scale = S(1) / sqrt(S(4) * r * sum * (S(1) + n3));
    const S half_c = (near ? sum : s) * scale, half_s = (near ? s : sum) * scale;
    // (half_c, 0, 0, half_s) (1 + n3, n2, -n1, 0)
    return QuaternionT<S>(half_c * (S(1) + n3), half_c * n2 + half_s * n1, half_s * n2 - half_c * n1,
                          half_s * (S(1) + n3));
  }

  State place(const Polhode& p, const S& angle) const {
    const QuaternionT<S> q = from_momentum_ * about_momentum(p, angle);
    const Vec3T<S> v(sign_[0] * q.x(), sign_[1] * q.y(), sign_[2] * q.z());
    const Vec3T<S> w(sign_[0] * a1_ * p.cn, sign_[1] * a2_ * p.sn, sign_[2] * a3_ * p.dn);
    State state;
    state.q.w() = q.w();
    for (std::size_t i = 0; i < 3; ++i) {
      state.q.coeffs()[axis_[i]] = v[static_cast<int>(i)];
      state.w_B[axis_[i]] = w[static_cast<int>(i)];
    }
    return state;
  }

  Kind kind_ = Kind::steady;
  QuaternionT<S> q0_;
  Vec3T<S> w0_;
  Vec3T<S> precession_, spin_;  // symmetric: rates of the two turns, body components

  // triaxial, in axes (1, 2, 3): axis_[i] is the body's, taken with sign_[i]
  std::array<int, 3> axis_{0, 1, 2};
  std::array<S, 3> sign_{S(1), S(1), S(1)};
  bool about_largest_ = true;
  Vec3T<S> I_;
  S L_{}, a1_{}, a2_{}, a3_{}, m1_{1};  // amplitudes of the rates; a2 has the sign of I3 - I1
  Vec3T<S> n_;                          // and of L_B/|L|
  S tilt_{};                            // n_[1]/n_[0]
  S start_{}, rate_{}, turn_{};         // phase at t = 0 and its rate, uniform rate of the turn about L
  S nome_{}, span_{}, half_jump_{};     // outside: p', the phase between jumps, half the jump
  S sn_{}, cn_{}, dn_{};                // factors of the theta quotients
  Series square_{}, oblong_{}, re_{}, im_{};
  QuaternionT<S> from_momentum_{S(1), S(0), S(0), S(0)};  // to space, by way of q0; in axes (1, 2, 3)
};

}  // namespace polhode
