// What every experiment shares: a plan in (scenes, solvers, options), tables out.
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "experiments/earlier.hpp"
#include "experiments/options.hpp"
#include "experiments/table.hpp"
#include "experiments/truth.hpp"
#include "solvers/registry.hpp"

namespace polhode {

struct Plan {
  std::vector<Scene> scenes;
  std::vector<const Method*> methods;
  Options options;
  Earlier earlier = {};  // rows of this command's run that was interrupted
};

/// Answers one question about every scene and solver of the plan. Stops early, with what there is, when
/// interrupted.
using Answer = std::vector<Table> (*)(const Plan&);

struct Question {
  const char *id, *summary;
  Answer answer;
};
const std::vector<Question>& all_questions();

/// Runs f(0..n-1) on as many threads as the options say; every result goes to its own place, so that the
/// order of rows does not depend on the threads. No new item is begun after an interrupt.
void for_each_run(const Options& options, std::size_t n, const std::function<void(std::size_t)>& f);

/// The scene of an id or a path, as long as the options say.
Scene asked_scene(const Options& options, const std::string& id);

/// The setting that the options ask for of a solver with this knob.
Setting setting_of(const Options& options, Knob knob);

/// Throws UsageError if an option is given that the question cannot follow: `why` completes "--steps: ...".
void refuse_options(const Options& options, const std::string& why, bool steps, bool tolerances, bool times);

/// With --verbose, why a run failed, on standard error.
void tell_failure(const Options& options, const Scene& scene, const Method& method, const Trajectory& run);

/// So many of the parts of what is being done are done; the line of progress tells it, and how long the rest
/// will take at that pace. for_each_run counts by itself.
void count_progress(std::size_t done, std::size_t total);

/// A line of progress on a terminal, nothing elsewhere.
void progress(const Options& options, const std::string& what);

/// A sentence for the user on standard error, unless --quiet.
void tell_note(const Options& options, const std::string& note);

/// The same run, an exception in it turned into outcome `solver_failed`: one bad solver stops no study.
Integration guarded(Integration run);

/// One run, guarded; a solver that does not serve the scene gives outcome `unsupported` with its reason.
Trajectory run_once(const Method& method, const Scene& scene, const Setting& setting, const Grid& grid);

/// The truth for a question, which goes on without it: where there is none, a note says so once, and its rows
/// have outcome `no_truth`. After an interrupt it is such a truth, too; no note then, and no row.
///
/// question    in the line of progress
/// with_floor  found here, so that errors_of does not have to
std::shared_ptr<const SceneTruth> truth_for(const Plan& plan, const Scene& scene,
                                            std::span<const double> times, const std::string& question,
                                            bool with_floor);

/// In place of a run that has nothing to be measured against: outcome `no_truth`, or `unsupported` if the
/// solver does not serve the scene anyway.
Trajectory run_without_truth(const Method& method, const Scene& scene, const Setting& setting,
                             const SceneTruth& truth);

/// "double" or "single": what a solver computes in.
inline const char* precision_of(const Method& method) { return method.epsilon > 1e-10 ? "single" : "double"; }

/// An empty cell for NaN, the number otherwise.
inline Cell number(double x) { return x == x ? Cell(x) : Cell(); }
inline Cell text(std::string_view s) { return Cell(std::string(s)); }

}  // namespace polhode
