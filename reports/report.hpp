// The report of a result folder: figures and one HTML page.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace polhode {

/// What a report was made of.
struct ReportOutcome {
  int figures = 0;                 // drawn; scripts are written even where nothing can draw them
  std::vector<std::string> notes;  // what a user should know: no gnuplot, a figure that failed
};

/// Writes `index.html` and `figures/NAME.gp`, `.svg`, `.pdf` into a result folder from the tables that it
/// holds.
///
/// folder   holds any of convergence, orders, work_precision, drift, drift_verdict, stability, solvers and
///          scenes `.csv` and run.json; what is missing is left out of the page
/// returns  the number of figures drawn, and notes
/// throws   std::runtime_error with the path where a file cannot be read or written
ReportOutcome write_report(const std::filesystem::path& folder);

}  // namespace polhode
