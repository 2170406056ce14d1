// A truth proves itself before it is used, each time.
//
// Against the scene: its start is what the file says. Against itself: what the motion conserves, it has at
// every asked time. Against the equations: over a first stretch from the file's own state, and over stretches
// at some of the asked times, it goes where a second method goes that shares nothing with what found it
// (solvers/second_method.hpp).
#pragma once
#include <span>
#include <string>

#include "solvers/exact_motion.hpp"

namespace polhode {

/// Throws Error with exit code 70, with both values, where the motion is not as it must be by more than its
/// uncertainty.
///
/// scene         how the message names it
/// until         the end of the motion: nothing is asked of it beyond
/// samples       of the motion (at least one; increasing)
/// uncertainty   stated of them
void prove(const std::string& scene, const ExactScene& exact, const ExactMotion& motion, double until,
           std::span<const WideSample> samples, const ExactMotion::Uncertainty& uncertainty,
           const Allowance& allowance);

/// What 50 digits leave of a turn as long as this motion's: no truth is more certain.
double least_uncertainty(const ExactScene& exact, std::span<const WideSample> samples);

}  // namespace polhode
