// The one loop of every solver of fixed step.
//
// A stepper is a struct with `step(model, t, h, state) -> state` and, by its base, the form of its state:
// `QuaternionForm` (the model's own [q][w_B][p v]) or a form of the solver's own. The time is t_start + i h
// with an integer i. Nothing is allocated inside; the state is looked at only at the asked times and every
// few thousand steps, when the clock is.
#pragma once
#include <algorithm>
#include <chrono>
#include <string>

#include "models/model.hpp"
#include "solvers/observe.hpp"

namespace polhode {

/// State form of most steppers: the flat state of the model.
struct QuaternionForm {
  template <AnyModel M>
  static auto start(const M& m) {
    return m.initial;
  }
  template <AnyModel M>
  static Sample sample(const M& m, double t, const typename M::State& y) {
    return observe(m, t, y.data());
  }
};

/// q <- q/|q| in a flat state, the step that the `-renormalised` variants add.
template <class State>
void renormalise_attitude(State& y) {
  const double scale = 1 / std::sqrt(y[0] * y[0] + y[1] * y[1] + y[2] * y[2] + y[3] * y[3]);
  for (std::size_t i = 0; i < 4; ++i) y[i] *= scale;
}

/// What the concept asks is what a solver file may leave out: no step for a model, no support of it.
template <class S, class M>
concept Stepper = requires(const S& s, const M& m, decltype(S::start(m)) y) {
  { s.step(m, 0.0, 0.0, y) } -> std::convertible_to<decltype(S::start(m))>;
  { S::sample(m, 0.0, y) } -> std::convertible_to<Sample>;
};

/// Right-hand sides per step, for the work counters.
template <class S>
concept CountsRhs = requires {
  S::rhs_per_step;
};

/// Kinetic energy beyond which a run counts as diverged: 1e12 times what the body started with. No scene here
/// gains that much; an unstable step size does within a few dozen steps.
inline bool has_diverged(const Sample& start, const Sample& now) {
  return now.rotational_energy > 1e12 * (start.rotational_energy + std::abs(start.total_energy)) &&
         now.rotational_energy > 1e-300;
}

template <class S, class M>
requires Stepper<S, M>
void integrate_fixed(const S& stepper, const M& m, const Setting& setting, const Grid& grid,
                     Trajectory& out) {
  using clock = std::chrono::steady_clock;
  constexpr std::int64_t steps_per_look = 4096;
  const bool timed = setting.timeout_s < 1e9;
  const auto began = timed ? clock::now() : clock::time_point{};
  out.samples.clear();
  out.samples.reserve(grid.stretches.size() + 1);
  out.work = {};
  out.outcome = Outcome::ok;
  out.reason.clear();
  auto y = S::start(m);
  const Sample first = S::sample(m, 0.0, y);
  if (grid.from_start) out.samples.push_back(first);
  double t_start = 0;
  for (const auto& stretch : grid.stretches) {
    const double h = stretch.h;
    for (std::int64_t i = 0; i < stretch.steps;) {
      const std::int64_t until = std::min(stretch.steps, i + steps_per_look);
      for (; i < until; ++i) {
        const double t = t_start + static_cast<double>(i) * h;
        if constexpr (requires { stepper.advance(m, t, h, y); })
          stepper.advance(m, t, h, y);  // in place: a library's stepper that would have to copy the state
        else
          y = stepper.step(m, t, h, y);
      }
      if (timed && std::chrono::duration<double>(clock::now() - began).count() > setting.timeout_s) {
        out.outcome = Outcome::timeout;
        out.reason = "still running after " + std::to_string(setting.timeout_s) + " s";
        return;
      }
      if (!all_finite(y)) break;
    }
    out.work.steps += stretch.steps;
    if constexpr (CountsRhs<S>) out.work.rhs_evals += stretch.steps * S::rhs_per_step;
    Sample s = S::sample(m, stretch.t_end, y);
    if (!all_finite(y)) {
      out.outcome = Outcome::not_finite;
      out.reason = "a state that is not finite before t = " + std::to_string(stretch.t_end) + " s";
      return;
    }
    if (has_diverged(first, s)) {
      out.outcome = Outcome::diverged;
      out.reason =
          "kinetic energy beyond 1e12 times its start before t = " + std::to_string(stretch.t_end) + " s";
      return;
    }
    out.samples.push_back(s);
    t_start = stretch.t_end;
  }
}

/// `prepare` of a fixed-step solver. S::needs says what a scene lacks that it cannot serve.
template <class S>
Prepared run_fixed_step(const Scene& scene, const Setting& setting) {
  return with_model(scene, [&](auto model) -> Prepared {
    using M = decltype(model);
    if constexpr (Stepper<S, M>)
      return {[model = std::move(model), setting, stepper = S{}](const Grid& grid, Trajectory& out) {
                integrate_fixed(stepper, model, setting, grid, out);
              },
              {}};
    else
      return {{}, std::string(S::needs)};
  });
}

}  // namespace polhode
