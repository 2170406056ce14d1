// One solver at one setting: what work-precision tabulates and advise searches. First the error pass, against
// the truth at sample times; then the clock, with the end alone asked for and no errors computed.
#pragma once
#include <functional>
#include <span>

#include "experiments/question.hpp"
#include "experiments/stopwatch.hpp"

namespace polhode {

struct MeasuredRun {
  const Method* method = nullptr;
  Knob knob = Knob::none;
  double value = 0;  // steps or rtol
  Trajectory run{};
  Errors errors{};  // where the outcome is ok
  Timing timing{};  // where it was timed
};

/// The setting of the solver, with the absolute tolerance and the time limit that the options say.
Setting setting_of(const Options& options, const MeasuredRun& m);

/// Steps or asked times.
Grid grid_of(const MeasuredRun& m, std::span<const double> times);

/// Fills `run` and `errors`; without a truth, `run` says so. times: those of the truth without t = 0.
void find_errors(const Options& options, const Scene& scene, const SceneTruth& truth,
                 std::span<const double> times, MeasuredRun& m);

/// The run to the end of the scene, set up, for the clock.
std::function<void()> timed_run(const Options& options, const Scene& scene, const MeasuredRun& m);

}  // namespace polhode
