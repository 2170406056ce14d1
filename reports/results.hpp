// A result folder as a report sees it: its tables, its scenes and solvers in order, and what was measured in
// words.
#pragma once
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "reports/csv.hpp"

namespace polhode::report {

/// A scene of the folder; what scenes.csv does not say stays NaN or empty.
struct SceneCard {
  std::string id, title, left_out, unknowns, truth;
  double duration = std::numeric_limits<double>::quiet_NaN();           // s
  double truth_uncertainty = std::numeric_limits<double>::quiet_NaN();  // rad
  double floor = std::numeric_limits<double>::quiet_NaN();              // rad; below it rounding decides
  std::string file;                                                     // stem for figure names, unique

  const std::string& name() const { return title.empty() ? id : title; }
};

/// How a solver looks in every figure of every folder made with the same registry.
struct Mark {
  std::string colour;  // #rrggbb
  int filled = 7;      // gnuplot point type; the hollow one is the number below
  int dash = 1;        // gnuplot dash type

  int hollow() const { return filled - 1; }
};

/// The error that a scene is ranked by: the attitude where there is one.
struct Quantity {
  std::string column;  // of work_precision.csv and convergence.csv
  std::string name;    // `attitude error`
  std::string unit;    // `rad`, or empty for a ratio

  std::string with_unit(std::string_view value) const;
};

/// Everything that a report reads.
struct Results {
  CsvTable convergence, orders, work_precision, drift, drift_verdict, stability, stability_map, solver_table;
  std::vector<SceneCard> scenes;     // order of scenes.csv, then of appearance
  std::vector<std::string> solvers;  // that appear in an experiment; order of solvers.csv, then of appearance
  std::map<std::string, std::string> families;  // of the solvers that solvers.csv knows
  std::map<std::string, Mark> marks;            // of all solvers
  std::vector<std::string> files;               // every table of the folder, by name

  /// Rows of a table that belong to a scene, in file order.
  static std::vector<std::size_t> rows_of(const CsvTable& table, std::string_view scene);
  /// The solvers among those rows, in the order of `solvers`.
  std::vector<std::string> solvers_in(const CsvTable& table, std::string_view scene) const;
  /// Family of a solver, empty where solvers.csv does not know it.
  std::string family_of(const std::string& solver) const;
  /// The first of attitude, rate, position and energy error that a scene has any value of.
  Quantity quantity_of(const CsvTable& table, std::string_view scene) const;
  /// True where drift.csv has no rotational energy for a scene, so that the total one is shown.
  bool drift_quantity_is_total(std::string_view scene) const;
};

/// Reads what there is of a result folder; files that are missing are empty tables.
///
/// throws   std::runtime_error with the path if a file that is there cannot be read
Results read_results(const std::filesystem::path& folder);

}  // namespace polhode::report
