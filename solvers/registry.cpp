// The registry: rows of methods.def, then the engine modules found beside the program.
#include "solvers/registry.hpp"

#include <algorithm>

#include "models/errors.hpp"
#include "solvers/engines/engines.hpp"

namespace polhode {

#define METHOD(name) extern const MethodRows name;
#include "solvers/methods.def"
#undef METHOD

const std::vector<EngineStatus>& all_engines() {
  static const std::vector<EngineStatus> engines = load_engines();
  return engines;
}

const std::vector<const Method*>& all_methods() {
  static const std::vector<const Method*> methods = [] {
    std::vector<const Method*> all;
#define METHOD(name) \
  for (const Method& m : name) all.push_back(&m);
#include "solvers/methods.def"
#undef METHOD
    for (const EngineStatus& e : all_engines()) all.insert(all.end(), e.methods.begin(), e.methods.end());
    return all;
  }();
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
  for (const EngineStatus& e : all_engines())
    if (!e.available && id.starts_with(e.id)) throw MissingError("solver '" + id + "': " + e.missing);
  std::vector<std::string> ids;
  for (const Method* m : all_methods()) ids.emplace_back(m->id);
  const std::string near = nearest_name(id, ids);
  throw UsageError("unknown solver '" + id + "'" + (near.empty() ? "" : "; did you mean '" + near + "'?") +
                   " ('polhode list solvers' shows all)");
}

}  // namespace

const Method& find_method(const std::string& id) {
  for (const Method* m : all_methods())
    if (m->id == id) return *m;
  unknown_solver(id);
}

std::vector<const Method*> select_methods(const std::vector<std::string>& patterns) {
  const auto& all = all_methods();
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
  }
  return "";
}

}  // namespace polhode
