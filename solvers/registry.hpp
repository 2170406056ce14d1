// All solvers there are, from methods.def and from the engine modules that are installed.
#pragma once
#include <string>
#include <vector>

#include "solvers/method.hpp"

namespace polhode {

/// An engine: a solver from another program's library, in a module of its own that may be absent.
struct EngineStatus {
  std::string id, summary, module, package;  // the Debian package that the module is built with
  bool available = false;
  std::string missing;  // if not available: what is missing and how to get it
  std::vector<const Method*> methods;
};

/// Our own solvers and those of libraries, in the order of methods.def: all but the engines'.
const std::vector<const Method*>& own_methods();

/// Every solver, in the order of methods.def, then the engines' rows. Opens every engine; the functions below
/// open only those that may have what they are asked for.
const std::vector<const Method*>& all_methods();
const std::vector<EngineStatus>& all_engines();

/// The solver of an id; throws UsageError with the nearest id (or with the missing package of an engine).
const Method& find_method(const std::string& id);

/// The solvers that ids or globs ('*', '?') name, in registry order, each once. A glob that matches nothing
/// and an id that does not exist throw UsageError.
std::vector<const Method*> select_methods(const std::vector<std::string>& patterns);

}  // namespace polhode
