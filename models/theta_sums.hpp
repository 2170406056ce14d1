// Theta series along a polhode: Jacobi functions and theta_1 off the real axis at one phase, a handful of
// terms.
//
// "Inside", k^2 <= 1/2: trigonometric series in the nome p of k. "Outside": Jacobi's imaginary transformation
// of the same, hyperbolic series in the nome p' of k'. Source: DLMF 20.2, 20.7(viii), 22.2.
#pragma once
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>

namespace polhode {

/// A point of a polhode.
/// Jacobi functions, and e^(i angle) times a positive number for the part of the
/// turn about L that is not uniform.
template <class S>
struct PolhodePoint {
  S sn, cn, dn;  // of the true phase
  S re, im;
  S weight;  // a theta function, by which |re + i im| is known without a root
};

template <class S>
struct ThetaSums {
  /// The next term would be nome^(terms^2), at most 0.0433^(terms^2).
  static constexpr int terms = std::numeric_limits<S>::digits10 < 20 ? 4 : 7;
  using Series = std::array<S, terms>;
  using Pair = Eigen::Array<S, 2, 1>;  // two sums at once

  S nome{};
  Series square{}, oblong{};                                  // nome^(n^2), nome^(n (n + 1))
  std::array<Pair, terms> odd_pairs, even_pairs, turn_pairs;  // factors of the terms; turn: set by the owner
  S sn{}, cn{}, dn{};                                         // of the quotients, from the theta constants

  void set_up(const S& p, bool is_inside) {
    nome = p;
    S power(1), t2(1), t3(1), t4(1);
    square[0] = oblong[0] = S(1);
    for (std::size_t n = 1; n < terms; ++n) {
      square[n] = oblong[n - 1] * power * p;
      power *= p;
      oblong[n] = square[n] * power;
      t2 += oblong[n];
      t3 += S(2) * square[n];
      t4 += (n % 2 ? S(-2) : S(2)) * square[n];
    }
    sn = is_inside ? S(t3 / t2) : S(t3 / t4);
    cn = is_inside ? S(t4 / t2) : S(t2 / t4);
    dn = is_inside ? S(t4 / t3) : S(t2 / t3);
    for (std::size_t n = 0; n < terms; ++n) {
      const S flip(n % 2 ? -1 : 1);
      odd_pairs[n] = is_inside ? Pair(flip * oblong[n], oblong[n]) : Pair(flip, S(1));
      even_pairs[n] = is_inside ? Pair(S(2) * square[n], S(2) * flip * square[n]) : Pair(S(1), -flip);
    }
  }

  /// The same numbers, rounded.
  template <class Wider>
  void narrow(const ThetaSums<Wider>& x) {
    static_assert(ThetaSums<Wider>::terms == terms);
    nome = static_cast<S>(x.nome);
    for (std::size_t i = 0; i < terms; ++i) {
      square[i] = static_cast<S>(x.square[i]);
      oblong[i] = static_cast<S>(x.oblong[i]);
      odd_pairs[i] = x.odd_pairs[i].template cast<S>();
      even_pairs[i] = x.even_pairs[i].template cast<S>();
      turn_pairs[i] = x.turn_pairs[i].template cast<S>();
    }
    sn = static_cast<S>(x.sn);
    cn = static_cast<S>(x.cn);
    dn = static_cast<S>(x.dn);
  }

  /// z = pi u/(2 K)
  PolhodePoint<S> inside(const S& z) const {
    using std::cos;
    using std::sin;
    const S s = sin(z), c = cos(z), twice = S(2) * (c - s) * (c + s);  // 2 cos 2z
    Pair now(s, c), before(-s, c);                                     // sin and cos of (2n + 1) z
    Pair even_now(twice / S(2), twice / S(2)), even_before(S(1), S(1));
    Pair odd_sums = now, even_sums(S(1), S(1)), turn = turn_pairs[0] * now;
    for (std::size_t n = 1; n < terms; ++n) {
      const Pair next = twice * now - before;
      before = now;
      now = next;
      odd_sums += odd_pairs[n] * now;
      turn += turn_pairs[n] * now;
      even_sums += even_pairs[n] * even_now;
      const Pair even_next = twice * even_now - even_before;
      even_before = even_now;
      even_now = even_next;
    }
    const S inverse = S(1) / even_sums[1];
    return {sn * odd_sums[0] * inverse,
            cn * odd_sums[1] * inverse,
            dn * even_sums[0] * inverse,
            turn[0],
            turn[1],
            even_sums[1]};
  }

  /// x = pi u/(2 K') less so many whole spans
  PolhodePoint<S> outside(const S& x, const S& turns) const {
    using std::abs;
    using std::exp;
    using std::round;
    // Everything times 2 e^(-|x|): sinh and cosh of (2n + 1)|x|; cosh of 2n|x| times another e^|x|.
    const S e = exp(-abs(x)), E = e * e, P = nome > S(0) ? S(nome / E) : S(0);  // e^(-2|x|), p' e^(2|x|)
    Pair odd_sums(S(0), S(0)), even_sums(S(1), S(1)), turn(S(0), S(0));
    S power_E = E, power_P(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = square[n] * power_P, down = oblong[n] * power_E;
      const Pair hyperbolic(up - down, up + down);
      odd_sums += odd_pairs[n] * hyperbolic;
      turn += turn_pairs[n] * hyperbolic;
      power_P *= P;
      if (n + 1 < terms) even_sums += (oblong[n] * power_P + square[n + 1] * power_E) * even_pairs[n];
      power_E *= E;
    }
    const S inverse = S(1) / odd_sums[1], decay = S(2) * e * inverse;
    const bool odd = turns / S(2) != round(S(turns / S(2)));
    const S flip(odd ? -1 : 1), side(x < S(0) ? -1 : 1);
    PolhodePoint<S> p{flip * side * sn * odd_sums[0] * inverse,
                      flip * cn * even_sums[1] * decay,
                      dn * even_sums[0] * decay,
                      side * turn[0],
                      turn[1],
                      odd_sums[1]};
    if (odd) {  // theta_1 and n2 + i n1 change sign together from one span to the next
      p.re = -p.re;
      p.im = -p.im;
    }
    return p;
  }
};

}  // namespace polhode
