// The setting of every solver that a question asks for, found by steps and bisection rather than on a plain
// grid.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "experiments/measured_run.hpp"

namespace polhode {

/// Which error counts.
struct Norm {
  std::string_view name, column;  // "attitude", its column in work_precision.csv
  double Errors::*error;
  std::string_view unit;  // "rad", "m", or "" for a ratio
};

/// The norm of that name; "": the first that the scene has. Throws UsageError if the scene has no such error.
const Norm& norm_of(const Scene& scene, const std::string& name);

/// All of them, in the order in which a scene's default is chosen.
std::span<const Norm> all_norms();

/// What the search looks for: the least work that reaches `error`, or the least error within `budget_s` of
/// CPU time, or what `steps` fixed steps give.
struct Goal {
  std::optional<double> error, budget_s;
  std::optional<std::int64_t> steps;
};

/// A solver and the best that was found for it.
struct Found {
  MeasuredRun best;  // timed if `status` is found
  double error = 0;  // in the norm
  Work work{};       // of the run that was timed: sample times may cost steps
  enum class Status { found, out_of_reach, too_slow, failed, unsupported } status = Status::out_of_reach;
};

/// Searches for every solver, in rounds; one that would need several times what the best dozen need is given
/// up as too slow. Those found come first, best first: by least time, or by least error if the goal is a
/// budget or a step without an error.
///
/// samples  at so many equal times errors are taken; steps are multiples of it
std::vector<Found> search(const Options& options, const Scene& scene, const SceneTruth& truth,
                          std::span<const double> times, const std::vector<const Method*>& methods,
                          const Norm& norm, const Goal& goal);

}  // namespace polhode
