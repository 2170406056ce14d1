// Each solver climbs its own ladder from coarse to fine, all of them one rung a round; where the goal lies
// between two rungs, bisection follows. Work is compared by CPU time, roughly while searching and carefully
// at the end.
#include "experiments/search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "models/errors.hpp"
#include "solvers/thread_time.hpp"

namespace polhode {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr Norm norms[] = {{"attitude", "attitude_error_max_rad", &Errors::attitude_max, "rad"},
                          {"rate", "rate_error_max_rel", &Errors::rate_max, ""},
                          {"position", "position_error_max_m", &Errors::position_max, "m"},
                          {"energy", "energy_error_max_rel", &Errors::energy_max, ""},
                          {"momentum", "momentum_error_max_rel", &Errors::momentum_max, ""}};

constexpr std::size_t kept = 12;  // so many solvers are looked at to the end
constexpr double hopeless = 3;    // times the time of the last of those
constexpr int bisections = 6;     // steps to 1 %, tolerances to 4 %
constexpr double largest_steps = 1 << 22;
constexpr double tightest = 1e-15;

struct Rung {
  MeasuredRun run;
  double error = infinite, seconds = infinite;
};

struct Climber {
  const Method* method;
  Knob knob;
  std::vector<Rung> tried;      // coarse to fine as far as the ladder, then bisections
  double coarse = 0, fine = 0;  // around the goal, once both are known (values of the knob)
  double next = 0;              // to be tried in this round; 0: at rest
  int bisected = 0;
  double least = infinite;  // error so far
  int without_gain = 0;
  Found::Status status = Found::Status::out_of_reach;
};

/// CPU time of a run that is made anyway: the second where the first is short, which is cold.
double rough_time(const Options& options, const Scene& scene, const MeasuredRun& m, bool careful) {
  const auto run = timed_run(options, scene, m);
  double best = infinite, spent = 0;
  for (int i = 0; i < (careful ? 50 : 3) && spent < (careful ? 2e-3 : 3e-4); ++i) {
    const double began = thread_seconds();
    run();
    const double took = thread_seconds() - began;
    best = std::min(best, took);
    spent += took;
  }
  return best;
}

bool reaches(const Goal& goal, const Rung& r) {
  return goal.error ? r.error <= *goal.error : r.seconds <= *goal.budget_s;
}

/// Finer by one rung; 0 where the ladder ends.
double finer(const Climber& c) {
  if (c.knob == Knob::steps) return c.next * 2 <= largest_steps ? c.next * 2 : 0;
  const double tenth = std::pow(10.0, std::round(std::log10(c.next)) - 1);  // 1e-9, not 1.0000000000000003e-9
  return tenth >= tightest ? tenth : 0;
}

/// Between coarse and fine, a multiple of the samples for steps; 0 where there is nothing between.
double between(const Climber& c, double samples) {
  const double middle = std::sqrt(c.coarse * c.fine);
  if (c.knob == Knob::tolerance) return std::stod(fmt::format("{:.3g}", middle));
  const double rounded = std::round(middle / samples) * samples;
  return rounded > c.coarse && rounded < c.fine ? rounded : 0;
}

/// Where to go after the rung that was tried last.
void decide(Climber& c, const Goal& goal, double samples) {
  const Rung& last = c.tried.back();
  const double value = c.next;
  const Outcome outcome = last.run.run.outcome;
  c.next = 0;
  if (outcome == Outcome::unsupported) {
    c.status = Found::Status::unsupported;
    return;
  }
  const bool good = outcome == Outcome::ok && reaches(goal, last);
  if (c.knob == Knob::none || goal.steps) {
    c.status = outcome != Outcome::ok      ? Found::Status::failed
               : goal.steps && !goal.error ? Found::Status::found
               : good                      ? Found::Status::found
                                           : Found::Status::out_of_reach;
    return;
  }
  // Of an error the fine side is good, of a budget the coarse side.
  const bool goal_is_fine = goal.error.has_value();
  if (c.bisected == 0) {
    c.without_gain = last.error < 0.7 * c.least ? 0 : c.without_gain + 1;
    c.least = std::min(c.least, last.error);
    if (good == goal_is_fine && outcome == Outcome::ok) {  // the goal has been passed
      if (c.tried.size() == 1) {
        c.status = goal_is_fine ? Found::Status::found : Found::Status::too_slow;
        return;
      }
      c.coarse = c.tried[c.tried.size() - 2].run.value;
      c.fine = value;
      c.status = Found::Status::found;
    } else {
      if (good) c.status = Found::Status::found;
      // A ladder that has stopped to gain has met rounding (failures at its coarse end are no such sign).
      if (c.without_gain >= 3 && c.least < infinite && c.least < 1e-3) return;
      if (outcome == Outcome::timeout || outcome == Outcome::step_limit) return;
      c.next = value;
      c.next = finer(c);
      return;
    }
  } else {
    (good == goal_is_fine ? c.fine : c.coarse) = value;
  }
  if (c.bisected++ < bisections) {
    c.next = between(c, samples);
    if (c.next == c.coarse || c.next == c.fine) c.next = 0;
  }
}

/// The rung that answers the goal: the least work that reaches the error, or the least error in the budget;
/// among those of less time than `below`.
const Rung* best_of(const Climber& c, const Goal& goal, double below = infinite) {
  const Rung* best = nullptr;
  for (const Rung& r : c.tried) {
    const bool any_will_do = goal.steps && !goal.error;
    if (r.run.run.outcome != Outcome::ok || (!any_will_do && !reaches(goal, r)) || !(r.seconds < below))
      continue;
    // Work is counted, where it can be: times of single runs are rough.
    const auto work = [](const Rung& x) {
      const Work& w = x.run.run.work;
      return w.rhs_evals > 0 ? w.rhs_evals : w.steps;
    };
    if (!best || (goal.error ? work(r) < work(*best) : r.error < best->error)) best = &r;
  }
  return best;
}

/// Times the best carefully. What this clock finds above a budget gives way to the next cheaper run of its
/// solver.
void time_carefully(const Options& options, const Scene& scene, const Goal& goal,
                    const std::vector<Climber>& all, std::span<Found> best) {
  std::vector<Found*> open;
  for (Found& f : best) open.push_back(&f);
  for (int pass = 0; pass < 4 && !open.empty(); ++pass) {
    std::vector<std::function<void()>> timed;
    for (const Found* f : open) timed.push_back(timed_run(options, scene, f->best));
    const auto measured =
        time_interleaved(timed, options.quick ? TimingPlan{5, 50e-6, 10e-3} : TimingPlan{11, 200e-6, 100e-3});
    std::vector<Found*> above;
    for (std::size_t i = 0; i < open.size(); ++i) {
      Found& f = *open[i];
      const double rough = f.best.timing.min;
      f.best.timing = measured[i];
      const double end[] = {scene.duration};
      f.work = run_once(*f.best.method, scene, setting_of(options, f.best), grid_of(f.best, end)).work;
      if (!goal.budget_s || measured[i].min <= *goal.budget_s) continue;
      const auto climber = std::ranges::find(all, f.best.method, &Climber::method);
      const Rung* less = best_of(*climber, goal, rough * std::min(0.99, *goal.budget_s / measured[i].min));
      f.status = Found::Status::too_slow;
      if (!less || pass == 3) continue;
      f = {less->run, less->error, {}, Found::Status::found};
      f.best.timing.min = less->seconds;
      above.push_back(&f);
    }
    open = std::move(above);
  }
}

}  // namespace

std::span<const Norm> all_norms() { return norms; }

const Norm& norm_of(const Scene& scene, const std::string& name) {
  const bool rotates = scene.rotation.has_value(), attitude = rotates && scene.rotation->attitude;
  for (const Norm& n : norms) {
    const bool has = n.name == "attitude"                       ? attitude
                     : n.name == "rate" || n.name == "momentum" ? rotates
                     : n.name == "position"                     ? scene.translation.has_value()
                                                                : true;
    if (name.empty() ? has : n.name == name) {
      if (has) return n;
      throw UsageError(fmt::format("--norm {}: '{}' has no such error", name, scene.id));
    }
  }
  throw UsageError("--norm: got '" + name + "'");
}

std::vector<Found> search(const Options& options, const Scene& scene, const SceneTruth& truth,
                          std::span<const double> times, const std::vector<const Method*>& methods,
                          const Norm& norm, const Goal& goal) {
  const auto samples = static_cast<double>(times.size());
  std::vector<Climber> all;
  for (const Method* m : methods) {
    if (m->family == "truth") continue;
    if (goal.steps && !m->by_steps) continue;
    Climber c{m, goal.steps ? Knob::steps : m->default_knob(), {}};
    // Sixteen samples need sixteen steps; a tolerance starts where the error asked for is no accident.
    c.next = goal.steps                  ? static_cast<double>(*goal.steps)
             : c.knob == Knob::steps     ? samples
             : c.knob == Knob::tolerance ? 1e-2
                                         : 1;
    all.push_back(std::move(c));
  }
  for (int round = 0; !interrupted(); ++round) {
    std::vector<Climber*> moving;
    for (Climber& c : all)
      if (c.next > 0) moving.push_back(&c);
    if (moving.empty()) break;
    progress(options, fmt::format("advise: {}, round {}", scene.id, round + 1));
    for_each_run(options, moving.size(), [&](std::size_t i) {
      Climber& c = *moving[i];
      Rung r;
      r.run = {c.method, c.knob, c.next};
      find_errors(options, scene, truth, times, r.run);
      if (r.run.run.outcome == Outcome::ok) {
        r.error = r.run.errors.*norm.error;
        if (!std::isfinite(r.error)) r.error = infinite;
        r.seconds = rough_time(options, scene, r.run, goal.budget_s.has_value());
      }
      r.run.run.samples.clear();
      c.tried.push_back(std::move(r));
      decide(c, goal, samples);
    });
    if (!goal.error || goal.steps) continue;
    // Who has already spent several times what the last of the best dozen needs will not be among them.
    std::vector<double> best;
    for (const Climber& c : all)
      if (const Rung* r = best_of(c, goal)) best.push_back(r->seconds);
    if (best.size() < kept) continue;
    std::nth_element(best.begin(), best.begin() + kept - 1, best.end());
    for (Climber& c : all) {
      if (c.next == 0 || c.tried.back().seconds == infinite) continue;
      const Rung* reached = best_of(c, goal);
      // Bisection saves at most half of what reached the goal; a ladder only grows.
      const double least_to_come = reached ? reached->seconds / 2 : c.tried.back().seconds;
      if (least_to_come > hopeless * best[kept - 1]) {
        c.next = 0;
        if (!reached) c.status = Found::Status::too_slow;
      }
    }
  }

  std::vector<Found> found, others;
  for (const Climber& c : all) {
    if (const Rung* r = best_of(c, goal)) {
      found.push_back({r->run, r->error, {}, Found::Status::found});
      found.back().best.timing.min = r->seconds;
    } else {
      const bool failed =
          std::ranges::none_of(c.tried, [](const Rung& t) { return t.run.run.outcome == Outcome::ok; });
      Found f{c.tried.empty() ? MeasuredRun{c.method, c.knob, 0} : c.tried.back().run, c.least, {}, c.status};
      if (failed && f.status == Found::Status::out_of_reach) f.status = Found::Status::failed;
      others.push_back(std::move(f));
    }
  }
  const bool by_time = goal.error.has_value();
  const auto better = [by_time](const Found& a, const Found& b) {
    return by_time ? a.best.timing.min < b.best.timing.min
                   : std::pair(a.error, a.best.timing.min) < std::pair(b.error, b.best.timing.min);
  };
  std::ranges::stable_sort(found, better);
  progress(options, "advise: " + scene.id + ", clock");
  time_carefully(options, scene, goal, all, std::span(found).first(std::min(found.size(), 2 * kept)));
  std::ranges::stable_sort(found, better);
  std::stable_partition(found.begin(), found.end(),
                        [](const Found& f) { return f.status == Found::Status::found; });
  found.insert(found.end(), others.begin(), others.end());
  return found;
}

}  // namespace polhode
