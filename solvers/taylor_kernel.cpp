// Compiled once for each instruction set: POLHODE_KERNEL is its name, as in the list of solvers/taylor.cpp.
//
// No fused multiply-adds, and one order of summation written down: a sum of products is the same on every
// machine. What limits a step is the way from one coefficient to the next: so the terms with the newest
// coefficient are apart from those of older ones, which the processor can add up before it is there, and the
// shuffles and signs of every coefficient are made once, when it is new.
#include "solvers/taylor_kernel.hpp"

#include <cstdint>
#include <type_traits>

namespace polhode {
namespace {

#define POLHODE_INLINE [[gnu::always_inline]] inline

// Four doubles, in one register or in two.
using Bits = std::int64_t;
constexpr Bits minus = INT64_MIN;  // the sign of a double
#ifdef __AVX__
using Four = double __attribute__((vector_size(32)));
using FourBits = Bits __attribute__((vector_size(32)));
POLHODE_INLINE Four all(double s) { return Four{s, s, s, s}; }
template <int a, int b, int c, int d>
POLHODE_INLINE Four shuffled(Four v) {
  return __builtin_shufflevector(v, v, a, b, c, d);
}
template <Bits a, Bits b, Bits c, Bits d>
POLHODE_INLINE Four flipped(Four v) {
  return reinterpret_cast<Four>(reinterpret_cast<FourBits>(v) ^ FourBits{a, b, c, d});
}
#else
using Two = double __attribute__((vector_size(16)));
using TwoBits = Bits __attribute__((vector_size(16)));
struct Four {
  Two low, high;
};
POLHODE_INLINE Four operator+(Four a, Four b) { return {a.low + b.low, a.high + b.high}; }
POLHODE_INLINE Four operator-(Four a, Four b) { return {a.low - b.low, a.high - b.high}; }
POLHODE_INLINE Four operator*(Four a, Four b) { return {a.low * b.low, a.high * b.high}; }
POLHODE_INLINE Four all(double s) { return {Two{s, s}, Two{s, s}}; }
template <int a, int b, int c, int d>
POLHODE_INLINE Four shuffled(Four v) {
  return {__builtin_shufflevector(v.low, v.high, a, b), __builtin_shufflevector(v.low, v.high, c, d)};
}
template <Bits a, Bits b, Bits c, Bits d>
POLHODE_INLINE Four flipped(Four v) {
  return {reinterpret_cast<Two>(reinterpret_cast<TwoBits>(v.low) ^ TwoBits{a, b}),
          reinterpret_cast<Two>(reinterpret_cast<TwoBits>(v.high) ^ TwoBits{c, d})};
}
#endif
POLHODE_INLINE Four loaded(const double* from) {
  Four v;
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}
POLHODE_INLINE void store(Four v, double* to) { __builtin_memcpy(to, &v, sizeof v); }

POLHODE_INLINE Four yzx(Four w) { return shuffled<1, 2, 0, 3>(w); }
POLHODE_INLINE Four zxy(Four w) { return shuffled<2, 0, 1, 3>(w); }

// q (0, w) = q_x w_x + q_y w_y + q_z w_z with signed shuffles of q = (w, x, y, z); the same signs on the
// other factor make it unsigned shuffles of q.
POLHODE_INLINE Four sign_x(Four v) { return flipped<minus, 0, 0, minus>(v); }
POLHODE_INLINE Four sign_y(Four v) { return flipped<minus, minus, 0, 0>(v); }
POLHODE_INLINE Four sign_z(Four v) { return flipped<minus, 0, minus, 0>(v); }
POLHODE_INLINE Four for_x(Four q) { return shuffled<1, 0, 3, 2>(q); }
POLHODE_INLINE Four for_y(Four q) { return shuffled<2, 3, 0, 1>(q); }
POLHODE_INLINE Four for_z(Four q) { return shuffled<3, 2, 1, 0>(q); }

/// A coefficient as the factors that it is in sums of products.
struct Coefficient {
  Four q_x, q_y, q_z;       // signed
  Four w_x, w_y, w_z;       // each four times
  Four w_zxy, w_yzx, gyro;  // the last: g * w_yzx
  Four down_yzx, down_zxy;  // of gamma
};
template <bool gravity>
POLHODE_INLINE Coefficient factors(Four q, Four w, Four down, Four gyro) {
  Coefficient c;
  c.q_x = sign_x(for_x(q));
  c.q_y = sign_y(for_y(q));
  c.q_z = sign_z(for_z(q));
  c.w_x = shuffled<0, 0, 0, 0>(w);
  c.w_y = shuffled<1, 1, 1, 1>(w);
  c.w_z = shuffled<2, 2, 2, 2>(w);
  c.w_zxy = zxy(w);
  const Four turned = yzx(w);
  c.gyro = turned * gyro;
  if constexpr (gravity) {
    c.w_yzx = turned;
    c.down_yzx = yzx(down);
    c.down_zxy = zxy(down);
  }
  return c;
}

/// Gravity in body components, by the inverse of q, of any length.
POLHODE_INLINE Four to_body(const double* q, const double* g) {
  // q* g q = (w^2 - u u) g + 2 (u g) u - 2 w u x g, over |q|^2
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double own = w * w - (x * x + y * y + z * z), dot = 2 * (x * g[0] + y * g[1] + z * g[2]);
  const double scale = 1 / (w * w + (x * x + y * y + z * z));
  const double v[4] = {(own * g[0] + dot * x - 2 * w * (y * g[2] - z * g[1])) * scale,
                       (own * g[1] + dot * y - 2 * w * (z * g[0] - x * g[2])) * scale,
                       (own * g[2] + dot * z - 2 * w * (x * g[1] - y * g[0])) * scale, 0};
  return loaded(v);
}

struct Reciprocals {
  double of[TaylorLine::most + 1] = {};
  constexpr Reciprocals() {
    for (int i = 1; i <= TaylorLine::most; ++i) of[i] = 1.0 / i;
  }
};
constexpr Reciprocals reciprocal;

POLHODE_INLINE double absolute(double x) { return x < 0 ? -x : x; }
POLHODE_INLINE double larger(double a, double b) { return a > b ? a : b; }
POLHODE_INLINE double largest(const double* v, int n) {
  double m = absolute(v[0]);
  for (int i = 1; i < n; ++i) m = larger(m, absolute(v[i]));
  return m;
}

using Load = TaylorBody::Load;

POLHODE_INLINE Four times(const double (&columns)[3][4], Four a, Four b, Four c) {
  return (loaded(columns[0]) * a + loaded(columns[1]) * b) + loaded(columns[2]) * c;
}

/// The terms of Load::any, and the course of the centre of mass. Not in registers, and not hurried: its
/// bodies pay for what they have.
class OtherTerms {
 public:
  OtherTerms(const TaylorBody& body, TaylorLine& line) : body_(body), line_(line) {
    for (int i = 0; i < body.carried_count; ++i) {
      const CarriedVector& u = body.carried[i];
      double now[4] = {u.space[0], u.space[1], u.space[2], 0};
      if (u.rate != 0) {
        const double angle = absolute(u.rate) * line.t, c = __builtin_cos(angle), s = __builtin_sin(angle);
        now[0] = c * u.space[0] - s * u.space[1];
        now[1] = s * u.space[0] + c * u.space[1];
      }
      u_[i][0] = to_body(line.q, now);
    }
    if (body.has_spring) {
      const double* q = line.q;
      const double length = __builtin_sqrt(q[0] * q[0] + q[1] * q[1] + (q[2] * q[2] + q[3] * q[3]));
      for (int i = 0; i < 4; ++i) spring_[i] = loaded(body.spring[i]) * all(line.side / length);
    }
    if (body.has_course) {
      store(loaded(line.p), line.course[0]);
      store(loaded(line.v), line.course[0] + 4);
    }
  }

  /// Coefficient k of the terms of w', and what coefficient k makes of coefficient k + 1 of the rest: `step`
  /// is h/(k + 1).
  Four at(int k, double step, Four q, Four w) {
    w_[k] = w;
    Four sum =
        times(body_.damping, shuffled<0, 0, 0, 0>(w), shuffled<1, 1, 1, 1>(w), shuffled<2, 2, 2, 2>(w));
    if (k == 0) sum = sum + loaded(body_.constant);
    if (body_.has_spring)
      sum = sum + ((spring_[0] * shuffled<0, 0, 0, 0>(q) + spring_[1] * shuffled<1, 1, 1, 1>(q)) +
                   (spring_[2] * shuffled<2, 2, 2, 2>(q) + spring_[3] * shuffled<3, 3, 3, 3>(q)));
    for (int i = 0; i < body_.carried_count; ++i) {
      const Four u = u_[i][k];
      sum = sum + times(body_.carried[i].map, shuffled<0, 0, 0, 0>(u), shuffled<1, 1, 1, 1>(u),
                        shuffled<2, 2, 2, 2>(u));
      Four slope = {};
      for (int j = 0; j <= k; ++j) {
        const Four a = u_[i][k - j], b = w_[j];
        slope = slope + (yzx(a) * zxy(b) - zxy(a) * yzx(b));
      }
      if (body_.carried[i].rate != 0) slope = slope + all(body_.carried[i].rate) * partner(i, k);
      u_[i][k + 1] = slope * all(step);
    }
    if (body_.carried_count > 0 && body_.carried[0].rate != 0) {
      Four product = {};
      for (int j = 0; j <= k; ++j) product = product + yzx(u_[0][k - j]) * zxy(u_[0][j]);
      sum = sum + loaded(body_.gradient) * product;
    }
    if (body_.has_course) {
      const Four v = loaded(line_.course[k] + 4);
      store(v * all(step), line_.course[k + 1]);
      const Four slope = (k == 0 ? loaded(body_.fall) : Four{}) - all(body_.drag) * v;
      store(slope * all(step), line_.course[k + 1] + 4);
    }
    return sum;
  }

 private:
  /// Turning vectors come in pairs: u' = rate s, s' = -rate u in space; the second one's rate is negative.
  Four partner(int i, int k) const { return body_.carried[i].rate > 0 ? u_[i + 1][k] : u_[i - 1][k]; }

  const TaylorBody& body_;
  TaylorLine& line_;
  Four u_[TaylorBody::most_carried][TaylorLine::most + 1], w_[TaylorLine::most];
  Four spring_[4];
};

/// Fills the series about the line's state, scaled by the step h.
template <Load load>
POLHODE_INLINE void expand(const TaylorBody& body, TaylorLine& line, double h) {
  constexpr bool gravity = load == Load::gravity, any = load == Load::any;
  Coefficient c[TaylorLine::most];
  const Four gyro = loaded(body.gyro);
  Four q = loaded(line.q), w = loaded(line.w), down{};
  [[maybe_unused]] Four lever_yzx{}, lever_zxy{};
  if constexpr (gravity) {
    down = to_body(line.q, body.gravity_S);
    const Four inverse = loaded(body.inverse_moments), lever = loaded(body.lever);
    lever_yzx = yzx(lever) * inverse;
    lever_zxy = zxy(lever) * inverse;
  }
  store(q, line.series[0]);
  store(w, line.series[0] + 4);
  struct Nothing {
    Nothing(const TaylorBody&, const TaylorLine&) {}
  };
  [[maybe_unused]] std::conditional_t<any, OtherTerms, Nothing> others(body, line);

  const Coefficient first = c[0] = factors<gravity>(q, w, down, gyro);
  const Four first_x = sign_x(first.w_x), first_y = sign_y(first.w_y), first_z = sign_z(first.w_z);
  const Four first_gyro_zxy = first.w_zxy * gyro;
  {
    const Four step = all(h);
    const Four next_q =
        ((first.q_x * first.w_x + first.q_y * first.w_y) + first.q_z * first.w_z) * all(0.5 * h);
    Four slope = first.w_zxy * first.gyro;
    if constexpr (gravity) {
      slope = slope + (lever_yzx * first.down_zxy - lever_zxy * first.down_yzx);
      down = (first.down_yzx * first.w_zxy - first.down_zxy * first.w_yzx) * step;
    }
    if constexpr (any) slope = slope + others.at(0, h, q, w);
    q = next_q;
    w = slope * step;
    store(q, line.series[1]);
    store(w, line.series[1] + 4);
  }
  for (int k = 1; k < body.order; ++k) {
    const Coefficient& now = c[k] = factors<gravity>(q, w, down, gyro);
    Four x{}, y{}, z{}, slope{};
    [[maybe_unused]] Four fall{}, rise{};
    for (int j = 1; j < k; ++j) {
      const Coefficient &a = c[k - j], &b = c[j];
      x = x + a.q_x * b.w_x;
      y = y + a.q_y * b.w_y;
      z = z + a.q_z * b.w_z;
      slope = slope + a.w_zxy * b.gyro;
      if constexpr (gravity) {
        fall = fall + a.down_yzx * b.w_zxy;
        rise = rise + a.down_zxy * b.w_yzx;
      }
    }
    const double step = h * reciprocal.of[k + 1];
    const Four with_rates =
        ((x + y) + z) + ((first.q_x * now.w_x + first.q_y * now.w_y) + first.q_z * now.w_z);
    const Four next_q =
        ((with_rates + for_x(q) * first_x) + (for_y(q) * first_y + for_z(q) * first_z)) * all(0.5 * step);
    slope = (slope + yzx(w) * first_gyro_zxy) + now.w_zxy * first.gyro;
    if constexpr (gravity) {
      slope = slope + (lever_yzx * now.down_zxy - lever_zxy * now.down_yzx);
      fall = (fall + first.down_yzx * now.w_zxy) + now.down_yzx * first.w_zxy;
      rise = (rise + first.down_zxy * now.w_yzx) + now.down_zxy * first.w_yzx;
      down = (fall - rise) * all(step);
    }
    if constexpr (any) slope = slope + others.at(k, step, q, w);
    q = next_q;
    w = slope * all(step);
    store(q, line.series[k + 1]);
    store(w, line.series[k + 1] + 4);
  }
}

/// 2^y and log2 x to 6 %: a step size needs no more.
POLHODE_INLINE double rough_exp2(double y) {
  const auto bits = static_cast<Bits>((y + 1023 - 0.043) * 0x1p52);
  return __builtin_bit_cast(double, bits);
}
POLHODE_INLINE double rough_log2(double x) {
  return static_cast<double>(__builtin_bit_cast(Bits, x)) * 0x1p-52 - 1023 + 0.043;
}

POLHODE_INLINE double limited(double y) { return y < -10 ? -10 : y > 3 ? 3 : y; }

/// The factor by which the step would make the larger of the last two terms equal to the tolerance, in
/// [2^-10, 2^3].
template <Load load>
POLHODE_INLINE double stretch(const TaylorBody& body, const TaylorLine& line) {
  const int p = body.order;
  const double *last = line.series[p], *before = line.series[p - 1];
  const double allowed_q = body.atol + body.rtol,
               allowed_w = body.atol + body.rtol * largest(line.series[0] + 4, 3);
  const double of_q = larger(largest(last, 4), largest(before, 4)) / allowed_q;
  const double of_w = larger(largest(last + 4, 3), largest(before + 4, 3)) / allowed_w;
  const double excess = larger(of_q, of_w);
  double factor = 8;
  if (excess > 1e-290) factor = rough_exp2(limited(-rough_log2(excess) * reciprocal.of[p - 1]));
  if constexpr (load == Load::any) {
    // A fast decay makes terms that are large and cancel: what rounding takes from the largest is an error
    // too.
    for (int k = 2; k < p; ++k) {
      const double rounded = 0x1p-53 * larger(largest(line.series[k], 4) / allowed_q,
                                              largest(line.series[k] + 4, 3) / allowed_w);
      if (rounded > 1) {
        const double less = rough_exp2(limited(-rough_log2(rounded) * reciprocal.of[k]));
        if (less < factor) factor = less;
      }
    }
  }
  return factor;
}

/// What the state changes by in `part` of the step: terms from the smallest to the largest, even and odd
/// powers apart, so that one addition need not wait for the other. Added in two words.
POLHODE_INLINE void add(const double (&series)[TaylorLine::most + 1][8], int order, double part,
                        double* first, double* second, double* low) {
  Four a_even{}, b_even{}, a_odd{}, b_odd{};
  if (part == 1) {
    for (int k = order; k > 0; k -= 2) {
      a_even = a_even + loaded(series[k]);
      b_even = b_even + loaded(series[k] + 4);
      a_odd = a_odd + loaded(series[k - 1]);
      b_odd = b_odd + loaded(series[k - 1] + 4);
    }
  } else {
    const Four square = all(part * part);
    for (int k = order; k > 0; k -= 2) {
      a_even = a_even * square + loaded(series[k]);
      b_even = b_even * square + loaded(series[k] + 4);
      a_odd = a_odd * square + loaded(series[k - 1]);
      b_odd = b_odd * square + loaded(series[k - 1] + 4);
    }
    a_even = a_even * square;
    b_even = b_even * square;
    a_odd = a_odd * all(part);
    b_odd = b_odd * all(part);
  }
  const auto change = [](Four by, double* state, double* rest) {
    const Four before = loaded(state), whole = by + loaded(rest), after = before + whole;
    store(after, state);
    store(whole - (after - before), rest);
  };
  change(a_even + a_odd, first, low);
  change(b_even + b_odd, second, low + 4);
}

/// turned . q at `part` of the step.
POLHODE_INLINE double spring_side(const TaylorBody& body, const TaylorLine& line, double part) {
  double sum[4] = {};
  for (int k = body.order; k >= 0; --k)
    for (int i = 0; i < 4; ++i) sum[i] = sum[i] * part + line.series[k][i];
  return (body.turned[0] * sum[0] + body.turned[1] * sum[1]) +
         (body.turned[2] * sum[2] + body.turned[3] * sum[3]);
}

/// Where the spring's torque jumps: `part`, or the first part of it at which its sign no longer holds.
POLHODE_INLINE double up_to_jump(const TaylorBody& body, const TaylorLine& line, double part) {
  if (!(spring_side(body, line, part) * line.side < 0)) return part;
  double low = 0, high = part;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (spring_side(body, line, middle) * line.side < 0 ? high : low) = middle;
  }
  return high;
}

/// A step to `end`, or to where the series holds if that is less; a first step, whose size is a guess, also
/// beyond it, up to `farthest`.
template <Load load>
POLHODE_INLINE void step_to(const TaylorBody& body, TaylorLine& line, double end, double farthest) {
  line.start = line.t;
  double factor = 0;
  for (int tries = 0; tries < 100; ++tries) {
    line.step = end - line.t;  // what the time moves by
    expand<load>(body, line, line.step);
    factor = stretch<load>(body, line);
    if (factor > 0x1p-9) break;
    // Far too long: what the last terms say of so much shorter a step is no longer true.
    end = line.start + factor * line.step;
    farthest = end;
  }
  double part = 1;
  if (factor < 0.9 || line.fresh) {  // no work is lost: the same series at another time
    const double wanted = line.start + factor * line.step;
    end = wanted < farthest ? wanted : farthest;
    part = (end - line.start) / line.step;
  }
  line.h = 0.95 * factor * line.step;
  if constexpr (load == Load::any)
    if (body.has_spring) {
      const double jump = up_to_jump(body, line, part);
      if (jump < part) {  // the next step begins on the other side, the time of the jump rounded
        end = line.start + jump * line.step;
        part = (end - line.start) / line.step;
        line.side = -line.side;
      }
    }
  add(line.series, body.order, part, line.q, line.w, line.low);
  if constexpr (load == Load::any)
    if (body.has_course) add(line.course, body.order, part, line.p, line.v, line.low + 8);
  line.t = end;
  line.fresh = false;
  ++line.steps;
}

template <Load load>
void cruise_with(const TaylorBody& body, TaylorLine& line, double t_stop, std::int64_t limit) {
  while (line.t + line.h < t_stop && line.steps < limit)
    step_to<load>(body, line, line.t + line.h, line.t + line.h);
}
void cruise(const TaylorBody& body, TaylorLine& line, double t_stop, std::int64_t limit) {
  switch (body.load) {
    case Load::none:
      return cruise_with<Load::none>(body, line, t_stop, limit);
    case Load::gravity:
      return cruise_with<Load::gravity>(body, line, t_stop, limit);
    case Load::any:
      return cruise_with<Load::any>(body, line, t_stop, limit);
  }
}

template <Load load>
void step_with(const TaylorBody& body, TaylorLine& line, double end) {
  const double guessed = line.t + line.h;
  step_to<load>(body, line, line.fresh && guessed < end ? guessed : end, end);
}
void step(const TaylorBody& body, TaylorLine& line, double end) {
  switch (body.load) {
    case Load::none:
      return step_with<Load::none>(body, line, end);
    case Load::gravity:
      return step_with<Load::gravity>(body, line, end);
    case Load::any:
      return step_with<Load::any>(body, line, end);
  }
}

}  // namespace

#define POLHODE_TEXT(name) #name
#define POLHODE_ROW(name)                  \
  extern const TaylorKernel taylor_##name; \
  const TaylorKernel taylor_##name{POLHODE_TEXT(name), cruise, step};
#define POLHODE_EXPAND(name) POLHODE_ROW(name)
POLHODE_EXPAND(POLHODE_KERNEL)

}  // namespace polhode
