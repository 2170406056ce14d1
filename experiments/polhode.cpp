// The command line: reads options, calls a verb, turns errors into one sentence and an exit code.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>

#include <CLI/CLI.hpp>

#include "experiments/interrupt.hpp"
#include "experiments/provenance.hpp"
#include "experiments/verbs.hpp"
#include "models/errors.hpp"
#include "models/scene.hpp"

namespace polhode {
namespace {

/// What was typed, as text: numbers are read by us, whole, so that 1e-3x, nan and "" are errors.
struct Typed {
  std::vector<std::string> scenes, more_scenes, solvers;
  std::string dial, from, to, duration, steps, h, rtol, atol, samples, times, output, jobs, timeout, digits;
  bool has_output = false, quick = false, json = false, force = false, quiet = false, verbose = false;
};

double real(const std::string& option, const std::string& text, double low, double high, const char* need) {
  double x = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (failed != std::errc() || end != text.data() + text.size() || !std::isfinite(x) || x < low || x > high)
    throw UsageError(option + ": got '" + text + "', needs " + need);
  return x;
}

std::int64_t whole(const std::string& option, const std::string& text, std::int64_t low, std::int64_t high) {
  std::int64_t x = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (failed != std::errc() || end != text.data() + text.size() || x < low || x > high)
    throw UsageError(option + ": got '" + text + "', needs a whole number from " + std::to_string(low) +
                     " to " + std::to_string(high));
  return x;
}

Options options_of(const Typed& typed, const CLI::App& verb) {
  const auto given = [&verb](const char* name) { return verb.get_option(name)->count() > 0; };
  const auto exclusive = [&](const char* a, const char* b) {
    if (given(a) && given(b))
      throw UsageError(std::string(a) + " and " + b + " exclude each other: give one");
  };
  constexpr double tiny = 1e-300, huge = 1e300;
  exclusive("--steps", "--h");
  exclusive("--steps", "--rtol");
  exclusive("--h", "--rtol");
  exclusive("--times", "--samples");
  exclusive("--quiet", "--verbose");
  Options o;
  o.scenes = typed.scenes;
  o.scenes.insert(o.scenes.end(), typed.more_scenes.begin(), typed.more_scenes.end());
  o.solvers = typed.solvers;
  if (given("--duration"))
    o.duration = real("--duration", typed.duration, 1e-12, 1e12, "seconds, from 1e-12 to 1e12");
  if (given("--steps")) o.steps = whole("--steps", typed.steps, 1, 1'000'000'000'000);
  if (given("--h")) o.h = real("--h", typed.h, tiny, huge, "a step size > 0 in seconds");
  if (given("--rtol")) o.rtol = real("--rtol", typed.rtol, 1e-30, 1, "a tolerance from 1e-30 to 1");
  if (given("--atol")) o.atol = real("--atol", typed.atol, tiny, huge, "a tolerance > 0");
  if (given("--samples")) o.samples = whole("--samples", typed.samples, 1, 10'000'000);
  if (given("--times")) {
    std::size_t from = 0;
    for (bool more = true; more;) {
      const std::size_t comma = typed.times.find(',', from);
      more = comma != std::string::npos;
      o.times.push_back(real("--times", typed.times.substr(from, more ? comma - from : std::string::npos), 0,
                             huge, "times >= 0 in seconds, separated by commas"));
      from = comma + 1;
    }
  }
  if (given("--dial") != given("--from") || given("--dial") != given("--to"))
    throw UsageError("--dial, --from and --to belong together: a place in the scene file and its range");
  if (given("--dial")) {
    if (o.scenes.empty()) throw UsageError("--dial: which scene's? Name one");
    o.dial = typed.dial;
    o.dial_from = real("--from", typed.from, 1e-30, 1e30, "a number from 1e-30 to 1e30");
    o.dial_to = real("--to", typed.to, 1e-30, 1e30, "a number from 1e-30 to 1e30");
    if (!(*o.dial_to > *o.dial_from)) throw UsageError("--to: got " + typed.to + ", needs more than --from");
  }
  if (given("--output")) {
    if (typed.output.empty())
      throw UsageError("-o: got '', needs a folder, a file, or - for standard output");
    o.output = typed.output;
  }
  if (given("--jobs")) o.jobs = static_cast<int>(whole("--jobs", typed.jobs, 1, 1024));
  if (given("--timeout"))
    o.timeout_s = real("--timeout", typed.timeout, 1e-3, 1e9, "seconds, at least 0.001");
  if (given("--digits")) o.digits = static_cast<int>(whole("--digits", typed.digits, 1, 30));
  o.quick = typed.quick;
  o.json = typed.json;
  o.force = typed.force;
  o.quiet = typed.quiet;
  o.verbose = typed.verbose;
  return o;
}

void add_options(CLI::App& verb, Typed& typed) {
  verb.add_option("SCENE", typed.scenes, "built-in ids or paths of TOML files");
  verb.add_option("--scene", typed.more_scenes, "the same, repeatable")->allow_extra_args(false);
  verb.add_option("--dial", typed.dial,
                  "stability: the number of the scene file to vary (load[0].coefficients, duration, ...)");
  verb.add_option("--from", typed.from, "and its least value");
  verb.add_option("--to", typed.to, "and its largest; between them, one value a decade");
  verb.add_option("--solver", typed.solvers, "solver id or glob, repeatable ('cvode-*')")
      ->allow_extra_args(false);
  verb.add_option("--duration", typed.duration, "how long the motion lasts, s; default: the scene's");
  verb.add_option("--steps", typed.steps, "fixed steps over the whole duration");
  verb.add_option("--h", typed.h, "step size, s; must divide the interval between two samples");
  verb.add_option("--rtol", typed.rtol, "relative tolerance of solvers that choose their steps");
  verb.add_option("--atol", typed.atol, "absolute tolerance; default: equal to --rtol");
  verb.add_option("--samples", typed.samples, "N: rows at 0, T/N, ..., T");
  verb.add_option("--times", typed.times, "t1,t2,...: exactly these rows, s");
  verb.add_option("-o,--output", typed.output, "folder or file for results; - is standard output");
  verb.add_option("--jobs", typed.jobs, "parallel error runs (timing is never parallel); default: all cores");
  verb.add_option("--timeout", typed.timeout, "limit of one run, s; default 60");
  verb.add_option("--digits", typed.digits, "digits of simulate --solver reference, up to 30");
  verb.add_flag("--quick", typed.quick, "a smaller study: coarser ladders, fewer repeats");
  verb.add_flag("--json", typed.json, "machine-readable output of list and show");
  verb.add_flag("--force", typed.force, "replace a folder that polhode did not make");
  verb.add_flag("-q,--quiet", typed.quiet, "no progress, no summary");
  verb.add_flag("-v,--verbose", typed.verbose, "more words");
}

int run(int argc, char** argv) {
  CLI::App app{"polhode: how wrong, how stable and how expensive is this integrator on this spinning body?",
               "polhode"};
  app.set_version_flag("--version", std::string("polhode ") + polhode_version);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::simple);
  app.footer(
      "Exit codes: 0 done, 1 a check failed, 2 usage, 65 bad input file, 69 something is not installed,\n"
      "70 internal error, 73 output cannot be written, 130 interrupted.");
  Typed typed;
  std::vector<std::string> verbs;
  for (const Verb& v : all_verbs()) {
    add_options(*app.add_subcommand(v.id, v.summary), typed);
    verbs.emplace_back(v.id);
  }
  if (argc > 1 && argv[1][0] != '-' && std::find(verbs.begin(), verbs.end(), argv[1]) == verbs.end()) {
    const std::string near = nearest_name(argv[1], verbs);
    throw UsageError("unknown verb '" + std::string(argv[1]) + "'" +
                     (near.empty() ? "" : "; did you mean '" + near + "'?") +
                     " ('polhode --help' shows all)");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // help and version
  } catch (const CLI::ParseError& e) {
    throw UsageError(std::string(e.what()) + " ('polhode VERB --help' shows the options)");
  }
  const CLI::App& verb = *app.get_subcommands().front();
  Options options = options_of(typed, verb);
  options.command_line = "polhode";
  for (int i = 1; i < argc; ++i) options.command_line += std::string(" ") + argv[i];
  if (options.dial && verb.get_name() != "stability") throw UsageError("--dial: only stability turns dials");
  for (const Verb& v : all_verbs())
    if (verb.get_name() == v.id) return v.run(options);
  return 70;
}

}  // namespace
}  // namespace polhode

int main(int argc, char** argv) {
  polhode::watch_interrupts();
  try {
    return polhode::run(argc, argv);
  } catch (const polhode::Error& e) {
    std::fprintf(stderr, "polhode: %s\n", e.what());
    return e.exit_code;
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "polhode: out of memory\n");
    return 70;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "polhode: internal error: %s\n", e.what());
    return 70;
  }
}
