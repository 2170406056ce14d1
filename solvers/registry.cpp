// The registry: rows of methods.def, then those of the engine modules found beside the program, which are
// opened when they are asked for.
#include "solvers/registry.hpp"

#include <algorithm>

#include "models/errors.hpp"
#include "solvers/engines/engines.hpp"

namespace polhode {

#define METHOD(name) extern const MethodRows name;
#include "solvers/methods.def"
#undef METHOD

const std::vector<const Method*>& own_methods() {
  static const std::vector<const Method*> methods = [] {
    std::vector<const Method*> own;
#define METHOD(name) \
  for (const Method& m : name) own.push_back(&m);
#include "solvers/methods.def"
#undef METHOD
    return own;
  }();
  return methods;
}

namespace {

/// Our own rows, and those of the engines that may have one of these ids or globs; no other is opened.
std::vector<const Method*> methods_for(const std::vector<std::string>& patterns) {
  std::vector<const Method*> methods = own_methods();
  for (std::size_t i = 0; i < engine_count(); ++i)
    if (std::any_of(patterns.begin(), patterns.end(), [i](const auto& p) { return may_serve(i, p); })) {
      const EngineStatus& e = open_engine(i);
      methods.insert(methods.end(), e.methods.begin(), e.methods.end());
    }
  return methods;
}

}  // namespace

const std::vector<EngineStatus>& all_engines() {
  static const std::vector<EngineStatus> engines = [] {
    std::vector<EngineStatus> all;
    for (std::size_t i = 0; i < engine_count(); ++i) all.push_back(open_engine(i));
    return all;
  }();
  return engines;
}

const std::vector<const Method*>& all_methods() {
  static const std::vector<const Method*> methods = methods_for({"*"});
  return methods;
}

namespace {

bool matches(std::string_view pattern, std::string_view text) {
  if (pattern.empty()) return text.empty();
  if (pattern[0] == '*') {
    for (std::size_t i = 0; i <= text.size(); ++i)
      if (matches(pattern.substr(1), text.substr(i))) return true;
    return false;
  }
  return !text.empty() && (pattern[0] == '?' || pattern[0] == text[0]) &&
         matches(pattern.substr(1), text.substr(1));
}

[[noreturn]] void unknown_solver(const std::string& id) {
  // Of an engine in two precisions, the module whose rows end as the id does.
  for (std::size_t i = 0; i < engine_count(); ++i)
    if (may_serve(i, id))
      if (const EngineStatus& e = open_engine(i); !e.available) {
        const std::size_t dash = e.id.find('-');
        if (dash == std::string::npos || id.ends_with(e.id.substr(dash)))
          throw MissingError("solver '" + id + "': " + e.missing);
      }
  std::vector<std::string> ids;
  for (const Method* m : all_methods()) ids.emplace_back(m->id);
  const std::string near = nearest_name(id, ids);
  throw UsageError("unknown solver '" + id + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?") +
                   " ('polhode list solvers' shows all)");
}

}  // namespace

const Method& find_method(const std::string& id) {
  for (const Method* m : methods_for({id}))
    if (m->id == id) return *m;
  unknown_solver(id);
}

std::vector<const Method*> select_methods(const std::vector<std::string>& patterns) {
  const auto all = methods_for(patterns);
  std::vector<bool> chosen(all.size(), false);
  for (const std::string& pattern : patterns) {
    // A glob of many stars would take exponential time; nobody needs more than a few.
    if (std::count(pattern.begin(), pattern.end(), '*') > 4)
      throw UsageError("solver pattern '" + pattern + "' has more than four '*'");
    bool any = false;
    for (std::size_t i = 0; i < all.size(); ++i)
      if (matches(pattern, all[i]->id)) chosen[i] = any = true;
    if (!any) unknown_solver(pattern);
  }
  std::vector<const Method*> result;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (chosen[i]) result.push_back(all[i]);
  return result;
}

std::string_view name_of(Knob knob) {
  return knob == Knob::steps ? "steps" : knob == Knob::tolerance ? "rtol" : "none";
}

std::string_view name_of(Outcome outcome) {
  switch (outcome) {
    case Outcome::ok:
      return "ok";
    case Outcome::not_finite:
      return "not_finite";
    case Outcome::diverged:
      return "diverged";
    case Outcome::solver_failed:
      return "solver_failed";
    case Outcome::step_limit:
      return "step_limit";
    case Outcome::timeout:
      return "timeout";
    case Outcome::clamped:
      return "clamped";
    case Outcome::asleep:
      return "asleep";
    case Outcome::unsupported:
      return "unsupported";
    case Outcome::no_truth:
      return "no_truth";
  }
  return "";
}

}  // namespace polhode
