// The short verdict that a study prints: read from the result folder, as the page is.
#pragma once
#include <filesystem>
#include <string>

#include "experiments/table.hpp"

namespace polhode {

/// A table of the cheapest solver per scene and accuracy, what failed, and where the results lie.
///
/// folder  where the results are now;  place: what to call it in the text
std::string result_summary(const std::filesystem::path& folder, const std::string& place);

/// The cheapest solver per scene and accuracy as a table.
Table summary_table(const std::filesystem::path& folder);

}  // namespace polhode
