// The free rigid body in closed form with two more digits: results right to the rounding of a double until t
// is thousands of periods.
//
// Set up and summed in long double. The two phases, whose errors grow with t, are products of two words each,
// reduced before they are rounded; their sines and cosines are those of doubles, corrected by what was
// rounded away, which is where an error of half a unit of a double enters. On machines whose long double is a
// double only the phases are better.
#pragma once
#include "models/double_double.hpp"
#include "models/free_rotation.hpp"

namespace polhode {

class ExtendedFreeRotation {
 public:
  using State = FreeRotation<double>::State;

  /// As FreeRotation's.
  ExtendedFreeRotation(const Vec3& moments, const Quaternion& q0, const Vec3& w0)
      : motion_(moments, q0.cast<Real>(), w0.cast<Real>()),
        start_(words(motion_.start_)),
        rate_(words(motion_.rate_)),
        half_turn_(words(motion_.half_turn_)),
        span_(words(motion_.span_)),
        half_jump_(words(motion_.half_jump_)) {}

  State at(double given_t) const {
    using Kind = Motion::Kind;
    const auto unit_rate = static_cast<double>(motion_.unit_rate_);
    const double t = given_t * unit_rate;
    switch (motion_.kind_) {
      case Kind::steady:
      case Kind::symmetric:
        break;
      case Kind::inside: {
        const auto half_angle = direction(half_turn_ * DoubleDouble{t});
        return rounded(
            motion_.place(motion_.sums_.inside(direction(rate_ * DoubleDouble{t} + start_)), half_angle));
      }
      case Kind::outside: {
        DoubleDouble x = rate_ * DoubleDouble{t} + start_;
        double turns = 0;
        if (motion_.sums_.nome > 0) {
          turns = std::round(x.high / span_.high);
          x = x + span_ * DoubleDouble{-turns};
        }
        const auto half_angle = direction(half_turn_ * DoubleDouble{t} + half_jump_ * DoubleDouble{turns});
        const double side = x.high < 0 ? -1 : 1;
        const Real e = std::exp(-std::abs(x.high));
        return rounded(motion_.place(
            motion_.sums_.outside(e - e * static_cast<Real>(side * x.low), side, turns), half_angle));
      }
    }
    return rounded(motion_.at_scaled(t));
  }

 private:
  using Real = long double;
  using Motion = FreeRotation<Real>;

  static DoubleDouble words(Real x) {
    const auto high = static_cast<double>(x);
    return {high, std::isfinite(high) ? static_cast<double>(x - static_cast<Real>(high)) : 0};
  }
  /// The circular functions reduce a double by themselves: it is the number that it says.
  static Direction<Real> direction(const DoubleDouble& x) {
    const Real c = std::cos(x.high), s = std::sin(x.high), low = x.low;
    return {c - low * s, s + low * c};
  }
  State rounded(const Motion::State& x) const {
    return {x.q.cast<double>(), (x.w_B * motion_.unit_rate_).cast<double>()};
  }

  Motion motion_;
  DoubleDouble start_, rate_, half_turn_, span_, half_jump_;
};

}  // namespace polhode
