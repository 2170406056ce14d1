// Runs gnuplot on a script.
#pragma once
#include <chrono>
#include <filesystem>
#include <string>

namespace polhode::report {

/// How a child process ended.
struct GnuplotRun {
  enum class End { drawn, not_installed, failed, timed_out } end = End::failed;
  std::string message;  // last line that gnuplot wrote to stderr
};

/// Runs `gnuplot -d SCRIPT` in a folder, without a shell, and waits for it.
///
/// folder   working folder of the child
/// script   path of the script, relative to the folder
/// timeout  after which the child is killed
GnuplotRun run_gnuplot(const std::filesystem::path& folder, const std::filesystem::path& script,
                       std::chrono::milliseconds timeout);

}  // namespace polhode::report
