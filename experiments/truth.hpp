// The truth of a scene at asked times, found once and kept, in memory and on disk, by what the scene says and
// not by its name; and what a solver's samples miss of it.
#pragma once
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/options.hpp"
#include "models/scene.hpp"
#include "solvers/floor.hpp"
#include "solvers/reference.hpp"

namespace polhode {

/// The truth with its certainty, and what double precision can reach on this scene.
class SceneTruth {
 public:
  SceneTruth(const Scene& scene, std::vector<double> times, const Options& options)
      : scene_(scene), times_(std::move(times)), options_(options) {}

  Truth truth;
  bool more_time_helps = false;  // the refusal is one of the budget

  bool is_known() const { return truth.refusal.empty(); }
  double budget_s() const { return options_.truth_budget_s; }

  /// Growth of disturbances and what rounding alone does. Found when it is first asked for, within the same
  /// budget as the truth; safe to call from several threads. Where it cannot be had in that time, growths are
  /// not numbers, and floors are the least that they can be. throws   Stopped after an interrupt
  const Floor& floor() const;

 private:
  Scene scene_;
  std::vector<double> times_;
  Options options_;
  mutable std::mutex guard_;
  mutable std::optional<Floor> floor_;
};

/// The truth at the times (increasing; t = 0 is added in front). Found once for scenes of one content, by
/// several threads at once if it has to be; others are not held up. What the budget of the options does not
/// reach is a truth without samples, which says why. throws   Stopped after an interrupt; Error with exit
/// code 70 if the truth contradicts itself
std::shared_ptr<const SceneTruth> truth_of(const Scene& scene, std::span<const double> times,
                                           const Options& options = {});

/// The same for what is nothing without it: throws Error with exit code 1 and the refusal.
std::shared_ptr<const SceneTruth> needed_truth_of(const Scene& scene, std::span<const double> times,
                                                  const Options& options = {});

/// "no truth of 'heavy-top': it takes more than 60 s of computing; --truth-budget S allows more"
std::string refusal_text(const Scene& scene, const SceneTruth& truth);

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
/// throws     Stopped after an interrupt, from the floor
Errors errors_of(const Scene& scene, const SceneTruth& truth, std::span<const Sample> samples,
                 std::size_t first, double epsilon);

/// The scale by which energy errors are divided: |E(0)|, or the largest |E| if the motion starts from
/// nothing.
double energy_scale(const SceneTruth& truth, bool rotational);

}  // namespace polhode
