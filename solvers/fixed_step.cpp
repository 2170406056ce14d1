#include "solvers/fixed_step.hpp"

#include <algorithm>

namespace polhode {
namespace {

constexpr std::int64_t steps_per_look = 4096;  // at the clock and at the state

void integrate(FixedSteps& run, const Sample& start, const Setting& setting, int rhs_per_step,
               const Grid& grid, Trajectory& out) {
  Record record(setting, grid, out);
  run.restart();
  record.start(start);
  double t_start = 0;
  Outcome outcome = Outcome::ok;
  for (const auto& stretch : grid.stretches) {
    for (std::int64_t i = 0; i < stretch.steps;) {
      const std::int64_t from = i, until = std::min(stretch.steps, i + steps_per_look);
      i = run.advance(t_start, stretch.h, i, until, outcome, out.reason);
      out.work.steps += i - from;
      const double t = t_start + static_cast<double>(i) * stretch.h;
      if (outcome != Outcome::ok) {
        record.end(outcome, out.reason.empty() ? "a state that is not finite" : out.reason, t);
        break;
      }
      if (!record.in_time(t)) break;
    }
    out.work.rhs_evals = out.work.steps * rhs_per_step;
    if (out.outcome != Outcome::ok || !record.keep(run.sample(stretch.t_end))) return;
    t_start = stretch.t_end;
  }
}

}  // namespace

Prepared run_fixed_steps(std::shared_ptr<FixedSteps> steps, const Setting& setting, int rhs_per_step) {
  const Sample start = steps->sample(0.0);
  return {[steps = std::move(steps), start, setting, rhs_per_step](const Grid& grid, Trajectory& out) {
            integrate(*steps, start, setting, rhs_per_step, grid, out);
          },
          {}};
}

}  // namespace polhode
