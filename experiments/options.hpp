// What the command line says, the same words with the same meaning for every verb.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polhode {

struct Options {
  std::vector<std::string> scenes;    // what the verb works on: ids or paths
  std::vector<std::string> solvers;   // ids or globs
  std::optional<std::int64_t> steps;  // fixed steps over the whole duration
  std::optional<double> h;            // s
  std::optional<double> duration;     // s, instead of the scene's own
  std::optional<double> rtol, atol;
  std::optional<std::int64_t> samples;       // N: rows at 0, T/N, ..., T
  std::vector<double> times;                 // s, exactly these rows
  std::optional<std::string> dial;           // of stability: the place of a number in the scene file,
  std::optional<double> dial_from, dial_to;  // and its range; all three or none
  std::optional<double> error;               // to be reached, in the unit of `norm`
  std::optional<double> max_error;           // beyond which a check has failed
  std::optional<double> budget_s;            // CPU time of one run
  std::optional<double> engine_step;         // s
  std::string norm;                   // attitude, rate, energy, momentum, position; "": the scene decides
  std::string quaternion, frame;      // of a trajectory file; "": its header decides
  std::optional<std::string> output;  // folder, file, or "-" for stdout
  bool quick = false, plot = false, json = false, force = false, quiet = false, verbose = false;
  int jobs = 0;  // parallel error runs; 0: as many as there are cores. Timing is never parallel.
  std::optional<double> timeout_s;  // per run
  double truth_budget_s = 60;       // CPU time of a truth, and of a rounding floor
  int digits = 17;                  // of simulate --solver reference
  std::string command_line;         // as typed, for run.json

  bool chooses_steps() const { return steps || h; }
};

/// A row of options.def.
struct OptionInfo {
  std::string_view names;  // "-o,--output"
  std::string_view takes;  // "": a flag
  std::string_view verbs, help;

  std::string_view long_name() const { return names.substr(names.find("--")); }
  bool followed_by(std::string_view verb) const;
  std::vector<std::string> choices() const;  // the only words it takes; empty: any
};
std::span<const OptionInfo> all_options();

/// The words between separators.
std::vector<std::string> split(std::string_view text, char separator);

}  // namespace polhode
