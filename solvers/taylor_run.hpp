// Integration by Taylor series of high order, in any number type: the step is the largest for which the last
// two terms stay below a tolerance, for attitude, rates and translation apart; asked times are read off the
// series inside a step, so that they cost no step. Explicit: a decay of rate r costs about r/2.4 steps a
// second. Source: Jorba & Zou, Exp. Math. 14 (2005).
#pragma once
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "models/model.hpp"
#include "models/taylor_series.hpp"

namespace polhode {

/// log2 |x| of a number whose exponent a double may not hold; -inf for 0.
template <class S>
double log2_of(const S& x) {
  using std::abs;
  using std::frexp;
  if (x == S(0)) return -std::numeric_limits<double>::infinity();
  int e = 0;
  const S m = frexp(S(abs(x)), &e);
  return e + std::log2(static_cast<double>(m));
}

/// Largest h for which terms p - 1 and p stay below 2^log2_tolerance of the state, over groups of
/// coordinates.
template <class M>
double series_step(const TaylorSeries<M>& series, double log2_tolerance) {
  struct Group {
    int begin, end;
  };
  std::vector<Group> groups;
  if constexpr (M::has_attitude) groups.push_back({0, 4});
  if constexpr (M::has_rotation) groups.push_back({M::Rotating::w_at, M::Rotating::size});
  if constexpr (M::has_translation) {
    groups.push_back({M::rotation_size, M::rotation_size + 3});
    groups.push_back({M::rotation_size + 3, M::rotation_size + 6});
  }
  double log2_h = 200;
  for (const Group& g : groups) {
    const auto norm = [&](int k) {
      double largest = -std::numeric_limits<double>::infinity();
      for (int i = g.begin; i < g.end; ++i) largest = std::max(largest, log2_of(series.coefficients(i)[k]));
      return largest;
    };
    double scale = norm(0);
    if (std::isinf(scale)) scale = norm(1);  // from rest: the first slope, per second
    const int p = series.order();
    for (const int k : {p - 1, p}) {
      const double term = norm(k);
      if (std::isinf(term) || std::isinf(scale)) continue;
      log2_h = std::min(log2_h, (log2_tolerance + scale - term) / k);
    }
  }
  return std::exp2(log2_h);
}

struct Nothing {
  void operator()() const {}
};

/// Goes from (t, y) through the asked times (increasing, >= t), calling visit(time, state) at each and
/// begin() before each step. Returns the number of steps, or -1 if it was left for having taken `step_limit`;
/// t and y are where it stands.
template <class M, class Time, class Visit, class Begin = Nothing>
std::int64_t taylor_run(TaylorSeries<M>& series, typename M::Scalar& t, typename M::State& y,
                        std::span<const Time> times, double log2_tolerance, std::int64_t step_limit,
                        const Visit& visit, const Begin& begin = {}) {
  using S = typename M::Scalar;
  series.settle_signs(t, y);
  std::size_t next = 0;
  for (; next < times.size() && S(times[next]) <= t; ++next) visit(t, y);
  std::int64_t steps = 0;
  for (; next < times.size(); ++steps) {
    if (steps == step_limit) return -1;
    begin();
    series.expand(t, y);
    S h(series_step(series, log2_tolerance));
    const S left = S(times.back()) - t;
    if (h > left) h = left;
    int crossed = -1;
    h = series.first_sign_change(h, crossed);
    for (; next < times.size() && S(times[next]) <= t + h; ++next)
      visit(S(times[next]), series.at(S(times[next]) - t));
    y = series.at(h);
    t += h;
    if (crossed >= 0) series.flip_sign(crossed);
  }
  return steps;
}

}  // namespace polhode
