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
template <class S>
struct PolhodePoint {
  S sn, cn, dn;  // Jacobi functions of the true phase, times `weight`
  S re, im;      // e^(i angle) times a positive number: the part of the turn about L that is not uniform
  S weight;      // a theta function
};

/// Cosine and sine of an angle.
template <class S>
struct Direction {
  S cosine, sine;
};

template <class S>
struct ThetaSums {
  /// The next term would be nome^(terms^2), at most 0.0433^(terms^2).
  static constexpr int terms = std::numeric_limits<S>::digits10 < 20 ? 4 : 7;
  using Series = std::array<S, terms>;
  using Pair = Eigen::Array<S, 2, 1>;  // two sums at once

  S nome{};
  Series square{}, oblong{};  // nome^(n^2), nome^(n (n + 1))
  using Pairs = std::array<Pair, terms>;
  // Factors of the terms, once it is set up inside those of the powers of cos 2z; turn: set by the owner.
  Pairs odd_pairs, even_pairs, turn_pairs;

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
    const S sn = is_inside ? S(t3 / t2) : S(t3 / t4), cn = is_inside ? S(t4 / t2) : S(t2 / t4);
    const S dn = is_inside ? S(t4 / t3) : S(t2 / t3);
    // The quotients' factors, but for the weight, go into the terms.
    const Pair odd = is_inside ? Pair(sn, cn) : Pair(sn, S(1)),
               even = is_inside ? Pair(dn, S(1)) : Pair(dn, cn);
    for (std::size_t n = 0; n < terms; ++n) {
      const S flip(n % 2 ? -1 : 1), twice = n == 0 ? S(1) : S(2);
      odd_pairs[n] = odd * (is_inside ? Pair(flip * oblong[n], oblong[n]) : Pair(flip, S(1)));
      even_pairs[n] =
          even * (is_inside ? Pair(twice * square[n], twice * flip * square[n]) : Pair(S(1), flip));
    }
  }

  /// From series in sin and cos of multiples of z to polynomials in cos 2z, when turn_pairs are there: half
  /// the work of a point, and no term waits for the one before it.
  void finish_inside() {
    to_powers(odd_pairs, odd_powers);
    to_powers(turn_pairs, odd_powers);
    to_powers(even_pairs, even_powers);
  }

  /// z = pi u/(2 K)
  PolhodePoint<S> inside(const Direction<S>& z) const {
    const S cos_2z = (z.cosine - z.sine) * (z.cosine + z.sine), square_2z = cos_2z * cos_2z;
    const Pair direction(z.sine, z.cosine);
    const Pair odd = direction * sum(odd_pairs, cos_2z, square_2z);
    const Pair even = sum(even_pairs, cos_2z, square_2z);
    const Pair turn = direction * sum(turn_pairs, cos_2z, square_2z);
    return {odd[0], odd[1], even[0], turn[0], turn[1], even[1]};
  }

  /// x = pi u/(2 K') less so many whole spans; e^(-|x|) and the sign of x
  PolhodePoint<S> outside(const S& e, const S& side, const S& turns) const {
    using std::round;
    // Everything times 2 e^(-|x|): sinh and cosh of (2n + 1)|x|; cosh of 2n|x| times another e^|x|.
    const S E = e * e, P = nome > S(0) ? S(nome / E) : S(0);  // e^(-2|x|), p' e^(2|x|)
    Pair odd_sums(S(0), S(0)), even_sums = even_pairs[0], turn(S(0), S(0));
    S power_E = E, power_P(1);
    for (std::size_t n = 0; n < terms; ++n) {
      const S up = square[n] * power_P, down = oblong[n] * power_E;
      const Pair hyperbolic(up - down, up + down);
      odd_sums += odd_pairs[n] * hyperbolic;
      turn += turn_pairs[n] * hyperbolic;
      power_P *= P;
      if (n + 1 < terms) even_sums += (oblong[n] * power_P + square[n + 1] * power_E) * even_pairs[n + 1];
      power_E *= E;
    }
    // theta_1 and n2 + i n1 change sign together from one span to the next.
    const S flip(turns / S(2) != round(S(turns / S(2))) ? -1 : 1), decay = S(2) * e;
    return {flip * side * odd_sums[0],
            flip * even_sums[1] * decay,
            even_sums[0] * decay,
            flip * side * turn[0],
            flip * turn[1],
            odd_sums[1]};
  }

 private:
  using Powers = std::array<std::array<std::array<int, 2>, 7>, 7>;
  /// Coefficients of cos^k 2z in sin((2n + 1) z)/sin z and cos((2n + 1) z)/cos z, or in cos 2nz twice.
  static constexpr Powers powers(bool odd) {
    Powers m{};
    for (std::size_t i = 0; i < 2; ++i) {
      m[0][0][i] = 1;
      m[1][0][i] = odd ? (i == 0 ? 1 : -1) : 0;
      m[1][1][i] = odd ? 2 : 1;
      for (std::size_t n = 2; n < 7; ++n)
        for (std::size_t k = 0; k <= n; ++k)
          m[n][k][i] = (k > 0 ? 2 * m[n - 1][k - 1][i] : 0) - m[n - 2][k][i];
    }
    return m;
  }
  static constexpr Powers odd_powers = powers(true), even_powers = powers(false);

  static void to_powers(Pairs& factors, const Powers& m) {
    for (std::size_t k = 0; k < terms; ++k) {
      Pair c = factors[k] * Pair(S(m[k][k][0]), S(m[k][k][1]));
      for (std::size_t n = k + 1; n < terms; ++n) c += factors[n] * Pair(S(m[n][k][0]), S(m[n][k][1]));
      factors[k] = c;
    }
  }
  static Pair sum(const Pairs& c, const S& x, const S& square) {
    constexpr std::size_t last = terms - 1;
    Pair even = c[last - last % 2], odd = c[last - (last + 1) % 2];
    for (std::size_t k = last - last % 2; k >= 2; k -= 2) even = even * square + c[k - 2];
    for (std::size_t k = last - (last + 1) % 2; k >= 3; k -= 2) odd = odd * square + c[k - 2];
    return even + x * odd;
  }
};

}  // namespace polhode
