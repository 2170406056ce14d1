// What double precision can reach on a scene: how disturbances grow, and what rounding makes of it.
#pragma once
#include <span>

#include "models/allowance.hpp"
#include "models/scene.hpp"
#include "solvers/reference.hpp"

namespace polhode {

/// Growth of disturbances and the floor that rounding sets.
struct Floor {
  // Largest growth of a relative disturbance of the initial rates over the times, as an angle [rad], as a
  // relative rate, and the larger of the two. At least 1; not a number where it is not known.
  double attitude_growth = 1, rate_growth = 1, conditioning = 1;
  // What rounding alone does, rad (up to pi) and relative (up to 2): the largest at any time until the end,
  // so that it never falls where the duration grows. Where a motion cannot be followed to its end, as far as
  // it can.
  double attitude = 0, rate = 0;
};

/// A rounding: 2^-52 rad of the attitude, and 2^-52 of each component of the rates. What it has become later
/// is told by the linear equations of disturbances (solvers/sensitivity.hpp).
///
/// times   increasing, the first is 0
/// truth   the motion at these times; if it starts from other numbers than the doubles of the scene, the
/// floor
///         is at least their difference at these times
/// throws  as the allowance says
Floor floor_of(const Scene& scene, std::span<const double> times, const Truth& truth,
               const Allowance& allowance);

}  // namespace polhode
