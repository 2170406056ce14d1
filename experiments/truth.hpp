// The truth of a scene at asked times, computed once per run of the program, and what a solver's samples miss
// of it.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "models/scene.hpp"
#include "solvers/reference.hpp"

namespace polhode {

/// The truth with its certainty, and what double precision can reach on this scene.
struct SceneTruth {
  Truth truth;
  // Largest growth of a relative disturbance of the initial rates over the times, as an angle [rad], as a
  // relative rate, and the larger of the two.
  double attitude_growth = 1, rate_growth = 1, conditioning = 1;
  // What rounding alone does: the epsilon of a double times the largest growth of any disturbance from any
  // time on, but at least the resolution. Where a scene is too stiff to follow disturbances, growth is not a
  // number and floors are the resolution.
  double attitude_floor = 0;  // rad
  double rate_floor = 0;      // relative
};

/// The truth at the times (increasing; t = 0 is added in front). Computed once, then shared; safe to call
/// from several threads.
std::shared_ptr<const SceneTruth> truth_of(const Scene& scene, std::span<const double> times);

/// What one sample misses of the truth at its time. NaN where a scene has no such quantity.
struct SampleErrors {
  double attitude, rate, position;         // rad, relative, m
  double rotational_energy, total_energy;  // (E - exact)/scale, signed
  double momentum, momentum_direction;     // |L - L_exact|/|L(0)|, rad
  double unit_defect;
};
SampleErrors errors_at(const Scene& scene, const SceneTruth& truth, const Sample& s, const WideSample& exact);

/// Errors of one run against the truth. NaN where a scene has no such quantity.
struct Errors {
  double attitude_max, attitude_end;  // rad
  double rate_max;                    // relative
  double energy_max;    // relative to the energy at the start: of the rotation where there is one
  double momentum_max;  // |L - L_exact|/|L(0)|
  double position_max;  // m
  double unit_defect_max;
  bool above_floor = true;  // false: no digit of the attitude (rates, position) error means anything
};

/// samples    of one run, at truth times [first, first + size)
/// epsilon    of the arithmetic that made them: floors scale with it
Errors errors_of(const Scene& scene, const SceneTruth& truth, std::span<const Sample> samples,
                 std::size_t first, double epsilon);

/// The scale by which energy errors are divided: |E(0)|, or the largest |E| if the motion starts from
/// nothing.
double energy_scale(const SceneTruth& truth, bool rotational);

}  // namespace polhode
