// Compensated summation: what rounding cuts off a step's sum is carried into the next one.
//
//   s = increment(y) + c,   y' = y + s rounded,   c' = what that rounding lost, exactly
//
// y + c is known to twice the digits of y; the increment is computed from y alone. So the error that a step
// makes by rounding is no longer half a unit of the state but one of the increment, h times smaller.
//
// Measured with rk4 on a free body over 10 s: the attitude error of 1e5 and 1e6 steps is 1.2e-13 and 1.2e-12
// rad plain (in proportion to the steps, worse than a random walk) and 2e-15 rad compensated, both times.
//
// Source: Kahan, Comm. ACM 8 (1965); Neumaier, ZAMM 54 (1974); Hairer, Lubich & Wanner, Geometric Numerical
// Integration (2006), VIII.5. The lost part is Knuth's two-sum, right for either order of size.
#pragma once
#include "solvers/fixed_step.hpp"

namespace polhode {

/// A stepper that tells its `increment(model, t, h, y)`, its sum compensated.
template <class Stepper>
struct Compensated {
  static constexpr int rhs_per_step = Stepper::rhs_per_step;

  template <class S>
  struct InTwoParts {
    S y, low;
    auto begin() const { return y.begin(); }
    auto end() const { return y.end(); }
  };

  template <AnyModel M>
  static InTwoParts<typename M::State> start(const M& m) {
    return {m.initial, {}};
  }
  template <AnyModel M>
  InTwoParts<typename M::State> step(const M& m, double t, double h,
                                     const InTwoParts<typename M::State>& x) const {
    const typename M::State increment = Stepper().increment(m, t, h, x.y);
    InTwoParts<typename M::State> next;
    for (std::size_t i = 0; i < increment.size(); ++i) {
      const double y = x.y[i], s = increment[i] + x.low[i], sum = y + s, in_sum = sum - y;
      next.y[i] = sum;
      next.low[i] = (y - (sum - in_sum)) + (s - in_sum);
    }
    return next;
  }
  template <AnyModel M>
  static Sample sample(const M& m, double t, const InTwoParts<typename M::State>& x) {
    return observe(m, t, x.y.data());
  }
};

}  // namespace polhode
