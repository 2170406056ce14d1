// Error pass and timing pass of one run.
#include "experiments/measured_run.hpp"

#include "experiments/grid.hpp"

namespace polhode {

Setting setting_of(const Options& options, const MeasuredRun& m) {
  Setting s = setting_of(options, m.knob);
  if (m.knob == Knob::tolerance) {
    s.rtol = m.value;
    s.atol = options.atol.value_or(0);
  }
  return s;
}

Grid grid_of(const MeasuredRun& m, std::span<const double> times) {
  return m.knob == Knob::steps ? grid_of_steps(times, static_cast<std::int64_t>(m.value))
                               : grid_of_times(times);
}

void find_errors(const Options& options, const Scene& scene, const SceneTruth& truth,
                 std::span<const double> times, MeasuredRun& m) {
  if (!truth.is_known()) {
    m.run = run_without_truth(*m.method, scene, setting_of(options, m), truth);
    return;
  }
  m.run = run_once(*m.method, scene, setting_of(options, m), grid_of(m, times));
  if (m.run.outcome == Outcome::ok) m.errors = errors_of(scene, truth, m.run.samples, 1, m.method->epsilon);
}

std::function<void()> timed_run(const Options& options, const Scene& scene, const MeasuredRun& m) {
  const double end[] = {scene.duration};
  return [run = m.method->prepare(scene, setting_of(options, m)).integrate, grid = grid_of(m, end),
          out = Trajectory{}]() mutable { run(grid, out); };
}

}  // namespace polhode
