// The page of a result folder.
#pragma once
#include <filesystem>
#include <set>
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

/// The page as HTML: one file without scripts, that refers to figures and tables beside it by relative path.
///
/// figures  in the order in which they appear
/// drawn    names of those whose SVG is there
/// notes    shown at the top
std::string page(const Results& results, const std::vector<Figure>& figures,
                 const std::set<std::string>& drawn, const Provenance& provenance,
                 const std::vector<std::string>& notes);

/// The style sheet of the page.
std::string_view style_sheet();

}  // namespace polhode::report
