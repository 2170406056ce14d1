// The tables of the page, each as a piece of HTML; empty where there is nothing to show.
#pragma once
#include <string>

#include "reports/results.hpp"

namespace polhode::report {

/// Cheapest solver of every scene at 1e-4 and 1e-8.
std::string verdict_table(const Results& results);
/// Every solver of a scene: cost at 1e-2, 1e-4, 1e-8 and the least error that it reached.
std::string cost_table(const Results& results, const SceneCard& scene);
/// Observed orders beside the claimed ones, a row for each solver, a column for each quantity.
std::string orders_table(const Results& results, const SceneCard& scene);
/// Classes of drift, a row for each solver and setting, a column for each quantity.
std::string drift_table(const Results& results, const SceneCard& scene);
/// Largest stable steps beside theory.
std::string stability_table(const Results& results, const SceneCard& scene);
/// All runs that did not end well, with their outcomes; runs of one kind share a row.
std::string failures_table(const Results& results);
/// Who the solvers are.
std::string solvers_table(const Results& results);

}  // namespace polhode::report
