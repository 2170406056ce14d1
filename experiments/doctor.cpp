// `doctor`: can results of this build on this machine be trusted? What it is made of, what the floating-point
// unit and the clock do, and a self-check of a second against published numbers.
#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

#include <fmt/format.h>
#include <stdlib.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "experiments/columns.hpp"
#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/provenance.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/stopwatch.hpp"
#include "models/errors.hpp"
#include "solvers/thread_time.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"check", ColumnType::text, "what was looked at"},
    {"status", ColumnType::text,
     "good, bad (exit 1), note (timing may suffer, or something is not installed), info"},
    {"found", ColumnType::text, "what was found"},
    {"need", ColumnType::text, "what is needed; empty: nothing"},
};

class Findings {
 public:
  void check(const char* what, bool good, const std::string& found, const std::string& need) {
    add(what, good ? "good" : "bad", found, need);
    if (!good) ++bad;
  }
  void hint(const char* what, bool good, const std::string& found, const std::string& need) {
    add(what, good ? "good" : "note", found, need);
  }
  void info(const char* what, const std::string& found) { add(what, "info", found, ""); }
  Table table{"doctor.csv", columns, {}, 1};
  int bad = 0;

 private:
  void add(const char* what, const char* status, const std::string& found, const std::string& need) {
    table.add({text(what), text(status), found, need});
  }
};

std::string first_line(const char* file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

/// The attitude at t = 10 s of the free body of Hairer & Vilmart, J. Phys. A 39 (2006) 13225.
void closed_form(Findings& f) {
  const Scene scene = find_scene("hairer-vilmart");
  const double end[] = {10.0};
  const Trajectory run = run_once(find_method("exact"), scene, {Knob::none}, grid_of_times(end));
  const Quaternion published(-0.73606136416079394, -0.57078695124035073, -0.29938857183079009,
                             -0.20683908610467319);
  const double error = attitude_error(published, run.samples.at(0).q);
  // The closed form in double is good to a few ulp, times a growth of 10.
  f.check("closed form", error < 1e-14, fmt::format("{:.1e} rad beside the published attitude", error),
          "below 1e-14 rad");
  const auto truth = needed_truth_of(scene, end);
  const double other =
      attitude_error<Wide>(truth->truth.samples.back().q, published.cast<Wide>()).convert_to<double>();
  f.check("truth in 50 digits", other < 4e-15, fmt::format("{:.1e} rad beside the same", other),
          "below 4e-15 rad: 17 decimals, and a scene in doubles");
}

void order_of_rk4(Findings& f) {
  const Scene scene = find_scene("hairer-vilmart");
  const auto times = uniform_times(scene.duration, 4);
  const auto truth = needed_truth_of(scene, times);
  std::vector<double> h, error;
  for (const int steps : {256, 512, 1024, 2048}) {
    const Trajectory run = run_once(find_method("rk4"), scene, {}, grid_of_steps(times, steps));
    h.push_back(scene.duration / steps);
    error.push_back(errors_of(scene, *truth, run.samples, 1, 2.3e-16).attitude_max);
  }
  const auto line = observed_order(h, error, truth->floor().attitude, 0.1);
  const double order = line ? line->slope : std::nan("");
  f.check("order of rk4", std::abs(order - 4) < 0.15, fmt::format("{:.2f}", order), "4 within 0.15");
}

/// scpeters/benchmark, 'boxes', complex case, Bullet in double with its default flag, h = 1 ms: the largest
/// momentum error over all steps is published as 0.0124501.
void bullet(Findings& f) {
  const auto& engines = all_engines();
  const auto engine = std::ranges::find(engines, "bullet", &EngineStatus::id);
  if (engine == engines.end() || !engine->available) return;
  const Scene scene = find_scene("tumbling-box");
  constexpr std::int64_t steps = 10'000;
  Grid grid = grid_of_steps(uniform_times(scene.duration, steps), steps);
  grid.from_start = true;
  const Trajectory run = run_once(find_method("bullet-implicit-body"), scene, {}, grid);
  double largest = 0;
  const Vec3 L0 = run.samples.at(0).L;
  for (const Sample& s : run.samples) largest = std::max(largest, (s.L - L0).norm() / L0.norm());
  f.check("Bullet's published error", std::abs(largest - 0.0124501) < 1e-7, fmt::format("{:.7f}", largest),
          "0.0124501 (momentum of the tumbling box at 1 ms)");
}

/// Runs a check of ours; whatever it throws is a finding.
void tried(Findings& f, const char* what, void (*check)(Findings&)) {
  try {
    check(f);
  } catch (const Stopped&) {
    throw;  // nothing was found out
  } catch (const std::exception& e) {
    f.check(what, false, e.what(), "to run at all");
  }
}

void floating_point(Findings& f) {
  f.check("contraction to fused operations", !contraction_is_on(), contraction_is_on() ? "on" : "off",
          "off: build with the presets");
  volatile double tiny = 1e-308;
  const bool flushed = tiny / 16 == 0;
  std::string found = flushed ? "flushed to zero" : "kept";
#if defined(__x86_64__)
  const unsigned mxcsr = _mm_getcsr();
  found += fmt::format(" (MXCSR 0x{:04x}: FTZ {}, DAZ {})", mxcsr, mxcsr & 0x8000 ? "on" : "off",
                       mxcsr & 0x0040 ? "on" : "off");
#endif
  f.check("numbers below 2e-308", !flushed, found, "kept: a library built with fast-math sets this for all");
  f.check("rounding", std::fegetround() == FE_TONEAREST,
          std::fegetround() == FE_TONEAREST ? "to nearest" : "another mode", "to nearest");
  // One term at a time, 1 + 1e-16 stays 1; compensated, the rest is kept, unless a compiler thinks it knows
  // better.
  volatile double sum = 1, rest = 0;
  for (int i = 0; i < 1000; ++i) {
    const double y = 1e-16 - rest, t = sum + y;
    rest = (t - sum) - y;
    sum = t;
  }
  f.check("compensated sums", std::abs(sum - (1 + 1e-13)) < 4e-16, fmt::format("1 + {:.2e}", sum - 1),
          "1 + 1e-13");
#if defined(__x86_64__)
  std::string units;
  const auto unit = [&units](bool there, const char* name) {
    if (there) units += (units.empty() ? "" : ", ") + std::string(name);
  };
  unit(__builtin_cpu_supports("avx"), "AVX");
  unit(__builtin_cpu_supports("avx2"), "AVX2");
  unit(__builtin_cpu_supports("fma"), "FMA");
  unit(__builtin_cpu_supports("avx512f"), "AVX-512");
  f.info("instruction sets", units.empty() ? "SSE2 alone" : units);
#endif
}

void clock_and_noise(Findings& f) {
  // The shortest difference that the clock shows, and how evenly the same work is timed.
  double finest = 1;
  for (int i = 0; i < 2000; ++i) {
    const double began = thread_seconds();
    double now = thread_seconds();
    while (now == began) now = thread_seconds();
    finest = std::min(finest, now - began);
  }
  f.hint("clock", finest < 5e-6, fmt::format("CPU time of the thread, resolves {}", duration_text(finest)),
         "below 5 us");
  const Scene scene = find_scene("hairer-vilmart");
  const double end[] = {scene.duration};
  const Grid grid = grid_of_steps(end, 1000);
  const std::function<void()> run = [integrate = find_method("rk4").prepare(scene, {}).integrate, &grid,
                                     out = Trajectory{}]() mutable { integrate(grid, out); };
  const Timing t = time_interleaved(std::span(&run, 1), {25, 500e-6, 1})[0];
  f.hint("repeatability of times", t.mad < 0.03 * t.median,
         fmt::format("{:.1f} % spread of the same run ({} +- {})", 100 * t.mad / t.median,
                     duration_text(t.median), duration_text(t.mad)),
         "below 3 %: an idle machine");
  const std::string governor = first_line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  if (governor.empty())
    f.info("frequency governor", "not visible here");
  else
    f.hint("frequency governor", governor == "performance", governor, "performance");
  double load = 0;
  if (getloadavg(&load, 1) == 1) {
    const double cores = std::max(1U, std::thread::hardware_concurrency());
    f.hint("load", load < 0.5 * cores, fmt::format("{:.2f} on {} cores", load, cores),
           "below half of the cores");
  }
}

}  // namespace

int doctor_verb(const Options& options) {
  if (!options.scenes.empty())
    throw UsageError("doctor looks at the program and the machine; got '" + options.scenes[0] + "'");
  Findings f;
  for (const auto& [name, value] : build_facts()) f.info(name.c_str(), value);
  for (const EngineStatus& e : all_engines()) {
    std::string found = e.available ? "available" : e.missing;
    if (e.available && !e.methods.empty())
      found = fmt::format("{}, steps in {} digits", e.methods.front()->version,
                          std::lround(-std::log10(e.methods.front()->epsilon)));
    f.hint(("engine " + e.id).c_str(), e.available, found, e.available ? "" : e.package);
  }
  floating_point(f);
  clock_and_noise(f);
  tried(f, "closed form", closed_form);
  tried(f, "order of rk4", order_of_rk4);
  tried(f, "Bullet's published error", bullet);

  if (options.json) {
    write_stdout(json(f.table));
    return f.bad > 0 ? 1 : 0;
  }
  std::vector<std::vector<std::string>> lines;
  for (const auto& row : f.table.rows) {
    const auto cell = [&row](std::size_t i) { return std::get<std::string>(row[i]); };
    const bool ask = (cell(1) == "bad" || cell(1) == "note") && !cell(3).empty();
    lines.push_back({cell(1) == "info"  ? ""
                     : cell(1) == "bad" ? "BAD"
                                        : cell(1),
                     cell(0), cell(2) + (ask ? "; needs " + cell(3) : "")});
  }
  write_stdout(in_columns(lines) + (f.bad > 0 ? fmt::format("\n{} of the checks failed.\n", f.bad)
                                              : std::string("\nAll checks passed.\n")));
  return f.bad > 0 ? 1 : 0;
}

}  // namespace polhode
