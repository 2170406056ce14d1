#include "solvers/adaptive_step.hpp"

#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

constexpr std::int64_t attempts_per_look = 1024;  // at the clock and at the state

void integrate(AdaptiveSteps& run, const Sample& start, const Setting& setting, const Grid& grid,
               Trajectory& out) {
  Record record(setting, grid, out);
  const double t_end = grid.end();
  Progress p;
  run.restart(t_end, p);
  record.start(start);
  const auto count = [&] { out.work = {p.accepted, p.attempts - p.accepted, p.rhs_evals, p.jacobian_evals}; };
  std::int64_t next_look = attempts_per_look;
  for (auto asked = grid.stretches.begin(); asked != grid.stretches.end();) {
    run.cruise(asked->t_end, std::min(next_look, setting.step_limit), p);
    const double t_before = p.t;
    bool good = false;
    if (!p.stuck && p.attempts < setting.step_limit && p.t + p.h >= asked->t_end) {
      const bool last = p.t + p.h >= t_end;
      if (last) p.h = t_end - p.t;
      const double whole = t_before + p.h;  // what a stepper that goes all the way reaches
      good = run.attempt(p);
      if (good && last && p.t == whole) p.t = t_end;
    }
    if (p.stuck || p.attempts >= next_look || good) count();
    if (p.stuck) {
      record.end(Outcome::solver_failed, "no acceptable step size: last tried " + std::to_string(p.h) + " s",
                 p.t);
      return;
    }
    if (p.attempts >= next_look) {
      next_look = p.attempts + attempts_per_look;
      if (!record.in_time(p.t)) return;
    }
    if (!run.is_finite()) {  // a controller accepts a step whose error is not a number, and keeps its size
      count();
      record.end(Outcome::not_finite, "a state that is not finite", p.t);
      return;
    }
    if (good) {
      for (; asked != grid.stretches.end() && asked->t_end <= p.t; ++asked) {
        Sample s;
        if (asked->t_end == p.t) {
          s = run.sample(p.t);
        } else if (!run.sample_within(t_before, asked->t_end, s)) {
          record.end(Outcome::solver_failed, "no acceptable step to the asked time", asked->t_end);
          return;
        }
        if (!record.keep(s)) return;
      }
    } else if (p.attempts >= setting.step_limit) {
      count();
      record.end(Outcome::step_limit, "gave up after " + std::to_string(p.attempts) + " steps", p.t);
      return;
    }
  }
}

}  // namespace

double first_step(std::span<const double> y, std::span<const double> d, const Setting& setting) {
  double size = 0, rate = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double scale = setting.absolute_tolerance() + setting.rtol * std::abs(y[i]);
    size = std::max(size, std::abs(y[i]) / scale);
    rate = std::max(rate, std::abs(d[i]) / scale);
  }
  return size < 1e-5 || rate < 1e-5 ? 0 : 0.01 * size / rate;
}

Prepared run_adaptive_steps(std::shared_ptr<AdaptiveSteps> steps, const Setting& setting) {
  const Sample start = steps->sample(0.0);
  return {[steps = std::move(steps), start, setting](const Grid& grid, Trajectory& out) {
            integrate(*steps, start, setting, grid, out);
          },
          {}};
}

}  // namespace polhode
