// What the command line says, the same words with the same meaning for every verb.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace polhode {

struct Options {
  std::vector<std::string> scenes;    // ids or paths
  std::vector<std::string> solvers;   // ids or globs
  std::optional<std::int64_t> steps;  // fixed steps over the whole duration
  std::optional<double> h;            // s
  std::optional<double> duration;     // s, instead of the scene's own
  std::optional<double> rtol, atol;
  std::optional<std::int64_t> samples;       // N: rows at 0, T/N, ..., T
  std::vector<double> times;                 // s, exactly these rows
  std::optional<std::string> dial;           // of stability: the place of a number in the scene file,
  std::optional<double> dial_from, dial_to;  // and its range; all three or none
  std::optional<std::string> output;         // folder, file, or "-" for stdout
  bool quick = false, json = false, force = false, quiet = false, verbose = false;
  int jobs = 0;  // parallel error runs; 0: as many as there are cores. Timing is never parallel.
  std::optional<double> timeout_s;  // per run
  int digits = 17;                  // of simulate --solver reference
  std::string command_line;         // as typed, for run.json

  bool chooses_steps() const { return steps || h; }
};

}  // namespace polhode
