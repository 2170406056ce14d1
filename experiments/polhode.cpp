// The command line: reads options, calls a verb, turns errors into one sentence and an exit code.
#include <charconv>
#include <cmath>
#include <cstdio>
#include <exception>
#include <map>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "experiments/interrupt.hpp"
#include "experiments/provenance.hpp"
#include "experiments/verbs.hpp"
#include "models/allowance.hpp"
#include "models/errors.hpp"
#include "models/scene.hpp"

namespace polhode {
namespace {

/// What was typed, as text: numbers are read by us, whole, so that 1e-3x, nan and "" are errors.
struct Typed {
  std::vector<std::string> operands, more_scenes, solvers;
  std::map<std::string_view, std::string> text;  // by the long name of the option
  std::map<std::string_view, bool> flag;
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

/// "1/60" or "0.0125"
double ratio(const std::string& option, const std::string& text) {
  constexpr const char* need = "a step size > 0 in seconds, or a ratio such as 1/60";
  const std::size_t slash = text.find('/');
  const double above = real(option, text.substr(0, slash), 1e-12, 1e12, need);
  return slash == std::string::npos ? above : above / real(option, text.substr(slash + 1), 1e-12, 1e12, need);
}

/// "10us", "2 ms", "1.5s"
double duration(const std::string& option, const std::string& text) {
  constexpr const char* need = "a time with its unit: ns, us, ms or s (10us)";
  constexpr std::pair<std::string_view, double> units[] = {
      {"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"s", 1}};
  for (const auto& [unit, seconds] : units)
    if (text.ends_with(unit)) {
      std::string number = text.substr(0, text.size() - unit.size());
      if (number.ends_with(' ')) number.pop_back();
      return seconds * real(option, number, 1e-300, 1e12, need);
    }
  throw UsageError(option + ": got '" + text + "', needs " + need);
}

Options options_of(const Typed& typed, const CLI::App& verb) {
  const auto given = [&verb](const char* name) { return verb.get_option(name)->count() > 0; };
  const auto exclusive = [&](const char* a, const char* b) {
    if (given(a) && given(b))
      throw UsageError(std::string(a) + " and " + b + " exclude each other: give one");
  };
  for (const OptionInfo& info : all_options()) {
    const std::string name(info.long_name());
    if (!given(name.c_str())) continue;
    if (!info.followed_by(verb.get_name()))
      throw UsageError(name + ": " + verb.get_name() + " cannot follow it; it is for " +
                       std::string(info.verbs));
    const std::vector<std::string> words = info.choices();
    if (words.empty()) continue;
    const std::string& word = typed.text.at(info.long_name());
    if (std::find(words.begin(), words.end(), word) == words.end())
      throw UsageError(name + ": got '" + word + "', needs one of " + name_list(words));
  }
  exclusive("--steps", "--h");
  exclusive("--steps", "--rtol");
  exclusive("--h", "--rtol");
  exclusive("--times", "--samples");
  exclusive("--budget", "--engine-step");
  exclusive("--quiet", "--verbose");
  constexpr double tiny = 1e-300, huge = 1e300;
  Options o;
  o.scenes = typed.operands;
  o.scenes.insert(o.scenes.end(), typed.more_scenes.begin(), typed.more_scenes.end());
  o.solvers = typed.solvers;
  const auto number = [&](const char* name, double low, double high, const char* need) {
    return given(name) ? std::optional(real(name, typed.text.at(name), low, high, need)) : std::nullopt;
  };
  const auto count = [&](const char* name, std::int64_t high) {
    return given(name) ? std::optional(whole(name, typed.text.at(name), 1, high)) : std::nullopt;
  };
  o.duration = number("--duration", 1e-12, 1e12, "seconds, from 1e-12 to 1e12");
  o.steps = count("--steps", 1'000'000'000'000);
  o.h = number("--h", tiny, huge, "a step size > 0 in seconds");
  o.rtol = number("--rtol", 1e-30, 1, "a tolerance from 1e-30 to 1");
  o.atol = number("--atol", tiny, huge, "a tolerance > 0");
  o.samples = count("--samples", 10'000'000);
  if (given("--times"))
    for (const std::string& t : split(typed.text.at("--times"), ','))
      o.times.push_back(real("--times", t, 0, huge, "times >= 0 in seconds, separated by commas"));
  if (given("--dial") != given("--from") || given("--dial") != given("--to"))
    throw UsageError("--dial, --from and --to belong together: a place in the scene file and its range");
  if (given("--dial")) {
    if (o.scenes.empty()) throw UsageError("--dial: which scene's? Name one");
    o.dial = typed.text.at("--dial");
    o.dial_from = number("--from", 1e-30, 1e30, "a number from 1e-30 to 1e30");
    o.dial_to = number("--to", 1e-30, 1e30, "a number from 1e-30 to 1e30");
    if (!(*o.dial_to > *o.dial_from))
      throw UsageError("--to: got " + typed.text.at("--to") + ", needs more than --from");
  }
  o.error = number("--error", tiny, huge, "an error > 0");
  o.max_error = number("--max-error", tiny, huge, "an error > 0");
  if (given("--budget")) o.budget_s = duration("--budget", typed.text.at("--budget"));
  if (given("--engine-step")) o.engine_step = ratio("--engine-step", typed.text.at("--engine-step"));
  o.norm = typed.text.at("--norm");
  o.quaternion = typed.text.at("--quaternion");
  o.frame = typed.text.at("--frame");
  if (given("--output")) {
    o.output = typed.text.at("--output");
    if (o.output->empty()) throw UsageError("-o: got '', needs a folder, a file, or - for standard output");
  }
  o.jobs = static_cast<int>(count("--jobs", 1024).value_or(0));
  o.timeout_s = number("--timeout", 1e-3, 1e9, "seconds, at least 0.001");
  o.truth_budget_s =
      number("--truth-budget", 1e-3, 1e9, "seconds, from 0.001 to 1e9").value_or(o.truth_budget_s);
  if (given("--digits")) o.digits = static_cast<int>(*count("--digits", 30));
  o.quick = typed.flag.at("--quick");
  o.plot = typed.flag.at("--plot");
  o.json = typed.flag.at("--json");
  o.force = typed.flag.at("--force");
  o.quiet = typed.flag.at("--quiet");
  o.verbose = typed.flag.at("--verbose");
  return o;
}

/// Every verb knows every option, so that one that it cannot follow is refused with a reason; its help shows
/// those that it follows.
void add_options(CLI::App& verb, const Verb& v, Typed& typed) {
  verb.add_option("WHAT", typed.operands, v.operands)->type_name("");
  for (const OptionInfo& info : all_options()) {
    const std::string names(info.names), help(info.help);
    CLI::Option* option = nullptr;
    if (info.long_name() == "--solver" || info.long_name() == "--scene")
      option =
          verb.add_option(names, info.long_name() == "--solver" ? typed.solvers : typed.more_scenes, help)
              ->allow_extra_args(false);
    else if (info.takes.empty())
      option = verb.add_flag(names, typed.flag[info.long_name()], help);
    else
      option = verb.add_option(names, typed.text[info.long_name()], help);
    if (!info.takes.empty()) option->type_name(std::string(info.takes));
    if (!info.followed_by(v.id)) option->group("");
  }
}

int run(int argc, char** argv) {
  CLI::App app{"polhode: how wrong, how stable and how expensive is this integrator on this spinning body?",
               "polhode"};
  app.set_version_flag("--version", std::string("polhode ") + polhode_version);
  // Newer CLI11 takes -h and --h for the same name: -h is turned into --help before it looks.
  app.set_help_flag("--help", "print this and exit; also -h");
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::simple);
  app.footer(
      "Exit codes: 0 done, 1 a check failed, 2 usage, 65 bad input file, 69 something is not installed,\n"
      "70 internal error, 73 output cannot be written, 130 interrupted.");
  Typed typed;
  std::vector<std::string> verbs;
  for (const Verb& v : all_verbs()) {
    add_options(*app.add_subcommand(v.id, v.summary), v, typed);
    verbs.emplace_back(v.id);
  }
  if (argc > 1 && argv[1][0] != '-' && std::find(verbs.begin(), verbs.end(), argv[1]) == verbs.end()) {
    const std::string near = nearest_name(argv[1], verbs);
    throw UsageError("unknown verb '" + std::string(argv[1]) + "'" +
                     (near.empty() ? "" : "; did you mean '" + near + "'?") +
                     " ('polhode --help' shows all)");
  }
  std::vector<const char*> arguments(argv, argv + argc);
  for (const char*& argument : arguments)
    if (std::string_view(argument) == "-h") argument = "--help";
  try {
    app.parse(argc, arguments.data());
  } catch (const CLI::Success& e) {
    return app.exit(e);  // help and version
  } catch (const CLI::ParseError& e) {
    throw UsageError(std::string(e.what()) + " ('polhode VERB --help' shows the options)");
  }
  const CLI::App& verb = *app.get_subcommands().front();
  Options options = options_of(typed, verb);
  options.command_line = "polhode";
  for (int i = 1; i < argc; ++i) options.command_line += std::string(" ") + argv[i];
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
  } catch (const polhode::Stopped& e) {
    std::fprintf(stderr, "polhode: %s\n", e.what());
    return 130;
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
