// What the tables say, in words: who reaches an error cheapest, which orders were met, what drifts.
//
// All sentences here are plain text (UTF-8); whoever puts them on a page escapes them.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reports/results.hpp"

namespace polhode::report {

/// One run on the way from coarse to fine.
struct CostPoint {
  double error = 0;
  double cost = 0;  // s, or right-hand-side evaluations
};

/// Cost of one solver at one error.
struct Cost {
  std::string solver;
  double cost = 0;
};

/// Least cost at which a ladder of runs reaches an error.
///
/// points   runs of one solver, any order; those with a non-positive cost or a NaN are passed over
/// level    the error to be reached, > 0
/// returns  nothing if no run gets there; the cost of the cheapest run if that one is there already; else the
///          log-log interpolation between the cheapest run that gets there and the best one that is cheaper
std::optional<double> cost_at(std::vector<CostPoint> points, double level);

/// All solvers of a scene that reach an error, cheapest first.
///
/// cost_column  of work_precision.csv: `time_min_s` or `rhs_evals`
std::vector<Cost> ranking(const Results& results, const SceneCard& scene, std::string_view cost_column,
                          double level);

/// True where a level of error lies under the rounding floor, so that nobody may be ranked there.
bool below_floor(const SceneCard& scene, const Quantity& quantity, double level);

/// `At 10⁻⁸ rad, a is the cheapest of 14 solvers: 12 µs; b needs 1.4 times that, ...`
std::string work_sentence(const Results& results, const SceneCard& scene);
/// The same counted in right-hand-side evaluations, with the change against the clock.
std::string evaluations_sentence(const Results& results, const SceneCard& scene);
/// How many fitted orders agree with the claim, and which is farthest off.
std::string orders_sentence(const Results& results, const SceneCard& scene);
/// Best and worst keeper of one drift column after the longest time.
std::string drift_sentence(const Results& results, const SceneCard& scene, std::string_view column,
                           std::string_view what);
/// How the largest stable steps compare with theory.
std::string stability_sentence(const Results& results, const SceneCard& scene);
/// The whole folder in one or two sentences.
std::string summary_sentence(const Results& results);

/// True if a fitted order is the claimed one within 0.15, or within twice its own error if that is more.
bool order_met(double claimed, double order, double order_error);

/// One measured stability limit.
struct StabilityLimit {
  std::string solver, parameter, value;
  double largest = 0, theory = 0;  // s; NaN where there is none
};
/// Limits of a scene, one for each solver and value of the parameter, in file order.
std::vector<StabilityLimit> stability_limits(const Results& results, const SceneCard& scene);

}  // namespace polhode::report
