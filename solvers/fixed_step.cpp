#include "solvers/fixed_step.hpp"

#include <algorithm>

namespace polhode {
namespace {

constexpr std::int64_t steps_per_look = 4096;  // at the clock and at the state

void integrate(FixedSteps& run, const Sample& start, const Setting& setting, const Grid& grid,
               Trajectory& out) {
  Record record(setting, grid, out);
  run.restart();
  record.start(start);
  double t_start = 0;
  for (const auto& stretch : grid.stretches) {
    for (std::int64_t i = 0; i < stretch.steps;) {
      const std::int64_t until = std::min(stretch.steps, i + steps_per_look);
      const Advance done = run.advance(t_start, stretch.h, i, until);
      out.work.steps += done.next - i;
      out.work.rhs_evals += done.rhs_evals;
      i = done.next;
      const double t = t_start + static_cast<double>(i) * stretch.h;
      if (done.outcome != Outcome::ok) {
        record.end(done.outcome, done.reason, t);
        break;
      }
      if (!record.in_time(t)) break;
    }
    if (out.outcome != Outcome::ok || !record.keep(run.sample(stretch.t_end))) return;
    t_start = stretch.t_end;
  }
}

}  // namespace

Prepared run_fixed_steps(std::shared_ptr<FixedSteps> steps, const Setting& setting) {
  const Sample start = steps->sample(0.0);
  return {[steps = std::move(steps), start, setting](const Grid& grid, Trajectory& out) {
            integrate(*steps, start, setting, grid, out);
          },
          {}};
}

}  // namespace polhode
