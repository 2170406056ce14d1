// Engines: other programs' integrators, each built as a module of its own (bullet.cpp and so on in this
// folder).
//
// A module exports one C function, `polhode_engine_rows`, that hands out its rows. It is opened with
// RTLD_LOCAL, because two builds of one engine (single and double precision) share their symbol names.
#pragma once
#include <vector>

#include "solvers/registry.hpp"

namespace polhode {

/// Opens every module of engines.def that is there; those that are not come back with what is missing.
std::vector<EngineStatus> load_engines();

using EngineRows = const MethodRows* (*)();
constexpr const char* engine_entry = "polhode_engine_rows";

/// What a module was compiled against; one that differs from the program's would be read as garbage. Modules
/// export it as the variable `polhode_engine_stamp`.
constexpr std::size_t engine_stamp =
    sizeof(Method) + 1000 * (sizeof(Sample) + 1000 * (sizeof(Scene) + 1000 * sizeof(Claims)));
constexpr const char* engine_stamp_name = "polhode_engine_stamp";

}  // namespace polhode
