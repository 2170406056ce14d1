// Error against CPU time, in characters.
#pragma once
#include <filesystem>
#include <string>

namespace polhode {

/// A work-precision plot of each scene of a result folder, at most 80 columns wide: the solvers that reach
/// some error in the least time have a letter, the other runs are dots. "" if the folder has no such table.
///
/// coloured  with the escape sequences of a terminal
std::string work_precision_plot(const std::filesystem::path& folder, bool coloured);

/// Is standard output a terminal, and does NO_COLOR not forbid colours?
bool stdout_is_terminal();
bool stdout_is_coloured();

}  // namespace polhode
