// The list of questions and what they share.
#include "experiments/question.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <mutex>
#include <set>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "experiments/interrupt.hpp"
#include "models/errors.hpp"

namespace polhode {

#define QUESTION(function, verb, summary) std::vector<Table> function(const Plan& plan);
#include "experiments/questions.def"
#undef QUESTION

const std::vector<Question>& all_questions() {
  static const std::vector<Question> questions = {
#define QUESTION(function, verb, summary) {verb, summary, function},
#include "experiments/questions.def"
#undef QUESTION
  };
  return questions;
}

void for_each_run(const Options& options, std::size_t n, const std::function<void(std::size_t)>& f) {
  const unsigned cores = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t workers =
      std::min<std::size_t>(n, options.jobs > 0 ? static_cast<unsigned>(options.jobs) : cores);
  std::atomic<std::size_t> next{0}, done{0};
  count_progress(0, n);
  std::exception_ptr failure;
  std::mutex guard;
  const auto work = [&] {
    give_back_wide_constants();  // of closed forms that doubles cannot hold
    for (std::size_t i = next++; i < n && !interrupted(); i = next++) {
      try {
        f(i);
        count_progress(++done, n);
      } catch (const Stopped&) {
        next = n;  // after an interrupt; no item is begun then
      } catch (...) {
        const std::lock_guard lock(guard);
        failure = std::current_exception();
        next = n;
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 1; k < workers; ++k) threads.emplace_back(work);
    work();
  }
  count_progress(n, n);
  if (failure) std::rethrow_exception(failure);
}

Scene asked_scene(const Options& options, const std::string& id) {
  Scene scene = find_scene(id);
  if (options.duration) scene.duration = *options.duration;
  if (options.dial) {
    Dial dial;
    if (scene.dial && scene.dial->place == *options.dial) dial.followers = scene.dial->followers;
    dial.place = *options.dial;
    // Whole powers of ten from end to end where that comes out even, else as many points as decades, rounded
    // up.
    const double decades = std::log10(*options.dial_to / *options.dial_from);
    const int n = std::max(1, static_cast<int>(std::ceil(decades - 1e-9)));
    for (int i = 0; i <= n; ++i)
      dial.values.push_back(i == n ? *options.dial_to : *options.dial_from * std::pow(10, decades * i / n));
    scene.dial = dial;
    (void)scene.with_dial(dial.values.front());  // a place that is not there is said now
  }
  return scene;
}

Setting setting_of(const Options& options, Knob knob) {
  Setting s;
  s.knob = knob;
  if (options.rtol) s.rtol = *options.rtol;
  if (options.atol) s.atol = *options.atol;
  // No run may hang a study: a minute is far beyond any useful setting here.
  s.timeout_s = options.timeout_s.value_or(60);
  return s;
}

void refuse_options(const Options& options, const std::string& why, bool steps, bool tolerances, bool times) {
  const auto refuse = [&why](bool given, const char* name) {
    if (given) throw UsageError(std::string(name) + ": " + why);
  };
  refuse(steps && options.steps, "--steps");
  refuse(steps && options.h, "--h");
  refuse(tolerances && options.rtol, "--rtol");
  refuse(times && options.samples, "--samples");
  refuse(times && !options.times.empty(), "--times");
}

void tell_failure(const Options& options, const Scene& scene, const Method& method, const Trajectory& run) {
  if (!options.verbose || run.outcome == Outcome::ok) return;
  progress(options, "");
  std::fprintf(stderr, "polhode: %s, %s: %s: %s\n", scene.id.c_str(), std::string(method.id).c_str(),
               std::string(name_of(run.outcome)).c_str(), run.reason.c_str());
}

namespace {

/// How far the stage is that the progress line tells of.
struct Pace {
  std::mutex guard;
  std::size_t done = 0, total = 0;
  std::chrono::steady_clock::time_point began;
} pace;

/// " (12 of 140, 8 s left)"
std::string pace_text() {
  const std::lock_guard lock(pace.guard);
  if (pace.total == 0) return "";
  std::string text = fmt::format(" ({} of {}", pace.done, pace.total);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - pace.began).count();
  // The pace of the first second says little.
  if (pace.done > 0 && seconds > 1) {
    const double left =
        seconds * static_cast<double>(pace.total - pace.done) / static_cast<double>(pace.done);
    text += left < 90 ? fmt::format(", {:.0f} s left", left) : fmt::format(", {:.0f} min left", left / 60);
  }
  return text + ')';
}

}  // namespace

void count_progress(std::size_t done, std::size_t total) {
  const std::lock_guard lock(pace.guard);
  if (done == 0) pace.began = std::chrono::steady_clock::now();
  pace.done = done;
  pace.total = done < total ? total : 0;  // the last one ends the stage
}

void progress(const Options& options, const std::string& what) {
  static const bool terminal = isatty(STDERR_FILENO) == 1;
  if (!terminal || options.quiet) return;
  std::fprintf(stderr, "\r\033[K%s", what.empty() ? "" : (what + pace_text()).c_str());
  std::fflush(stderr);
}

void tell_note(const Options& options, const std::string& note) {
  if (options.quiet) return;
  progress(options, "");
  std::fprintf(stderr, "polhode: note: %s\n", note.c_str());
}

Integration guarded(Integration run) {
  return [run = std::move(run)](const Grid& grid, Trajectory& out) {
    try {
      run(grid, out);
    } catch (const std::exception& e) {
      out.outcome = Outcome::solver_failed;
      out.reason = e.what();
    }
  };
}

Trajectory run_once(const Method& method, const Scene& scene, const Setting& setting, const Grid& grid) {
  Trajectory out;
  Prepared prepared = method.prepare(scene, setting);
  if (!prepared.integrate) {
    out.outcome = Outcome::unsupported;
    out.reason = prepared.unsupported;
    return out;
  }
  guarded(std::move(prepared.integrate))(grid, out);
  return out;
}

std::shared_ptr<const SceneTruth> truth_for(const Plan& plan, const Scene& scene,
                                            std::span<const double> times, const std::string& question,
                                            bool with_floor) {
  progress(plan.options, question + ": " + scene.id + ", truth");
  std::shared_ptr<const SceneTruth> truth;
  try {
    truth = truth_of(scene, times, plan.options);
    if (with_floor) (void)truth->floor();
  } catch (const Stopped& e) {
    const auto none = std::make_shared<SceneTruth>(scene, std::vector<double>(), plan.options);
    none->truth.refusal = e.what();
    return none;
  }
  static std::mutex guard;
  static std::set<std::string> told;
  if (truth->is_known()) return truth;
  const std::string note = refusal_text(scene, *truth);
  const std::lock_guard lock(guard);
  if (told.insert(note).second) tell_note(plan.options, note);
  return truth;
}

Trajectory run_without_truth(const Method& method, const Scene& scene, const Setting& setting,
                             const SceneTruth& truth) {
  Trajectory out;
  const Prepared prepared = method.prepare(scene, setting);
  out.outcome = prepared.integrate ? Outcome::no_truth : Outcome::unsupported;
  out.reason = prepared.integrate ? truth.truth.refusal : prepared.unsupported;
  return out;
}

}  // namespace polhode
