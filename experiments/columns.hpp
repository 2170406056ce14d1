// Text for the terminal.
#pragma once
#include <string>
#include <vector>

namespace polhode {

/// Lines of cells, each column as wide as its widest cell; ends with a line break.
std::string in_columns(const std::vector<std::vector<std::string>>& lines);

/// "12.3 us"
std::string duration_text(double seconds);

}  // namespace polhode
