// What the tables say, in words: who reaches an error cheapest, which orders were met, what drifts.
//
// All sentences here are plain text (UTF-8); whoever puts them on a page escapes them.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "reports/results.hpp"

namespace polhode::report {

/// Cost of one solver at one error.
struct Cost {
  std::string solver;
  double cost = 0;  // s, or right-hand-side evaluations
};

/// All solvers of a scene that reach an error, cheapest first. A solver's cost is that of its cheapest run
/// that ended well and whose error is at most the level: measured, never interpolated, so that it can be had.
///
/// cost_column  of work_precision.csv: `time_min_s` or `rhs_evals`; runs without it are passed over
std::vector<Cost> ranking(const Results& results, const SceneCard& scene, std::string_view cost_column,
                          double level);

/// True where a level of error lies under the rounding floor, so that nobody may be ranked there.
bool below_floor(const SceneCard& scene, const Quantity& quantity, double level);

/// Was there nothing to measure the runs of this scene against?
bool lacks_truth(const CsvTable& table, std::string_view scene);

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
  double largest = 0, near_rest = 0, theory = 0;  // s; NaN where there is none
  /// What theory speaks of: next to rest, where there is rest.
  double beside_theory() const { return near_rest > 0 ? near_rest : largest; }
};
/// Limits of a scene, one for each solver and value of the parameter, in file order.
///
/// table  stability.csv or rows of it
std::vector<StabilityLimit> stability_limits(const CsvTable& table, const SceneCard& scene);

/// Rows of a table that a figure of a scene can show without crowding: of all its solvers if they are few,
/// else of the best of each family, the cheapest at the level that tells most, or else the one with the least
/// error.
CsvTable telling_rows(const Results& results, const SceneCard& scene, const CsvTable& table,
                      std::size_t most_solvers);

}  // namespace polhode::report
