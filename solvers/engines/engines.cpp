// Finds and opens the engine modules of engines.def, in lib/polhode beside the folder of the binary.
#include "solvers/engines/engines.hpp"

#include <filesystem>

#include <dlfcn.h>

namespace polhode {
namespace {

std::filesystem::path module_folder() {
  std::error_code failed;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", failed);
  return binary.parent_path().parent_path() / "lib" / "polhode";
}

EngineStatus open_engine(const char* id, const char* package, const char* summary) {
  EngineStatus e;
  e.id = id;
  e.summary = summary;
  e.package = package;
  e.module = (module_folder() / ("polhode-" + e.id + ".so")).string();
  if (!std::filesystem::exists(e.module)) {
    e.missing =
        "the engine '" + e.id + "' was not built; install the package " + e.package + " and build again";
    return e;
  }
  // Never closed: the rows live in it.
  void* handle = dlopen(e.module.c_str(), RTLD_NOW | RTLD_LOCAL);
  const auto rows = handle ? reinterpret_cast<EngineRows>(dlsym(handle, engine_entry)) : nullptr;
  if (!rows) {
    const char* why = dlerror();
    e.missing = "the engine '" + e.id + "' cannot be opened: " + (why ? why : "no entry point");
    return e;
  }
  const auto* const stamp = static_cast<const std::size_t*>(dlsym(handle, engine_stamp_name));
  if (!stamp || *stamp != engine_stamp) {
    e.missing = "the engine '" + e.id + "' was built for another version of polhode; build again";
    return e;
  }
  e.available = true;
  for (const Method& m : *rows()) e.methods.push_back(&m);
  return e;
}

}  // namespace

std::vector<EngineStatus> load_engines() {
  std::vector<EngineStatus> engines;
#define ENGINE(id, file, package, config, summary) engines.push_back(open_engine(#id, #package, summary));
#include "solvers/engines/engines.def"
#undef ENGINE
  return engines;
}

}  // namespace polhode
