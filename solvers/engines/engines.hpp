// Engines: other programs' integrators, each built as a module of its own (bullet.cpp and so on in this
// folder).
//
// A module exports one C function, `polhode_engine_rows`, that hands out its rows. It is opened when somebody
// asks for it, and with RTLD_LOCAL, because two builds of one engine (single and double precision) share
// their symbol names.
#pragma once
#include <vector>

#include "solvers/registry.hpp"

namespace polhode {

/// How many engines engines.def has.
std::size_t engine_count();

/// Could a row of engine i have this id, or one that this glob matches? Asked of the names alone: opens
/// nothing.
bool may_serve(std::size_t i, std::string_view pattern);

/// Engine i, in the order of engines.def, its module opened if it has not been. One that is not there, cannot
/// be opened or is of another version comes back with what is missing. Not to be called from two threads.
const EngineStatus& open_engine(std::size_t i);

using EngineRows = const MethodRows* (*)();
constexpr const char* engine_entry = "polhode_engine_rows";

/// What a module was compiled against; one that differs from the program's would be read as garbage. Modules
/// export it as the variable `polhode_engine_stamp`.
constexpr std::size_t engine_stamp =
    sizeof(Method) + 1000 * (sizeof(Sample) + 1000 * (sizeof(Scene) + 1000 * sizeof(Claims)));
constexpr const char* engine_stamp_name = "polhode_engine_stamp";

}  // namespace polhode
