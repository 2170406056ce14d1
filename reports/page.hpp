// The page of a result folder: one HTML file that carries its data, its scripts and its style.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "reports/figures.hpp"
#include "reports/results.hpp"

namespace polhode::report {

/// Where results come from: names and values in the order of run.json, nested names joined by a space.
using Provenance = std::vector<std::pair<std::string, std::string>>;

/// Reads run.json of a result folder, whatever its keys are.
///
/// returns  nothing where the file is missing; one entry that says so where it is not JSON
Provenance read_provenance(const std::filesystem::path& folder);

/// What the page is told, as JSON: the tables of the folder with numbers of five digits, what they say in
/// words, and the looks of the solvers.
///
/// folder   where the tables lie
/// drawn    figures that stand in where scripts for charts were not installed: a figure and its SVG
/// notes    shown at the top
/// throws   std::runtime_error with the path where a table cannot be read
std::string page_data(const Results& results, const std::filesystem::path& folder,
                      const std::vector<std::pair<Figure, std::string>>& drawn, const Provenance& provenance,
                      const std::vector<std::string>& notes);

/// The page with its data.
///
/// data  of page_data; it is packed, so that no text in it can become markup
std::string page(std::string_view data);

/// The page without its data: reports/page/, put together when this program was built.
extern const std::string_view page_template;
/// Debian packages that were missing then, by name; the page goes without what they bring.
extern const std::string_view page_missing_packages;

}  // namespace polhode::report
