// Finds and opens the engine modules of engines.def, in lib/polhode beside the folder of the binary.
#include "solvers/engines/engines.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>

#include <dlfcn.h>
#include <link.h>

namespace polhode {
namespace {

struct Listed {
  std::string_view id, package, summary;
};
constexpr Listed listed[] = {
#define ENGINE(id, file, package, config, summary) {#id, #package, summary},
#include "solvers/engines/engines.def"
#undef ENGINE
};

std::filesystem::path module_folder() {
  std::error_code failed;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", failed);
  return binary.parent_path().parent_path() / "lib" / "polhode";
}

/// A file that was cut off would end the program on the first page that is not there: is it as long as its
/// own header says?
bool is_whole(const std::string& module) {
  std::ifstream file(module, std::ios::binary);
  ElfW(Ehdr) header{};
  if (!file.read(reinterpret_cast<char*>(&header), sizeof header)) return false;
  std::error_code failed;
  const auto size = std::filesystem::file_size(module, failed);
  return !failed && size >= header.e_shoff + std::size_t{header.e_shnum} * header.e_shentsize;
}

EngineStatus opened(const Listed& engine) {
  EngineStatus e;
  e.id = engine.id;
  e.summary = engine.summary;
  e.package = engine.package;
  e.module = (module_folder() / ("polhode-" + e.id + ".so")).string();
  if (!std::filesystem::exists(e.module)) {
    e.missing =
        "the engine '" + e.id + "' was not built; install the package " + e.package + " and build again";
    return e;
  }
  if (!is_whole(e.module)) {
    e.missing = "the engine '" + e.id + "' cannot be opened: " + e.module + " is cut off; build again";
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

std::size_t engine_count() { return std::size(listed); }

bool may_serve(std::size_t i, std::string_view pattern) {
  const std::string_view id = listed[i].id;
  const std::string name(id.substr(0, id.find('-'))), dashed = name + '-';
  const std::string_view literal = pattern.substr(0, pattern.find_first_of("*?"));
  const bool is_glob = literal.size() < pattern.size();
  return literal == name || literal.starts_with(dashed) || (is_glob && dashed.starts_with(literal));
}

const EngineStatus& open_engine(std::size_t i) {
  static std::array<std::optional<EngineStatus>, std::size(listed)> engines;
  if (!engines[i]) engines[i] = opened(listed[i]);
  return *engines[i];
}

}  // namespace polhode

// Simbody's CPODES leaves its vectors behind each time it begins anew, which is not ours to mend. The leak
// checker of sanitizer builds asks for this name.
#ifdef POLHODE_FEW_TYPES
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libSimTKmath.so"; }
#endif
