// Where a result comes from: command, versions, compiler, machine; the run.json and datapackage.json of a
// folder.
#pragma once
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "experiments/table.hpp"

namespace polhode {

constexpr const char* polhode_version = POLHODE_VERSION;

/// What the truth of a scene at 17 times cost on this machine.
struct TruthCost {
  std::string scene, kind;
  double seconds;
};

/// Does the compiler fuse a multiplication with an addition here? It must not.
bool contraction_is_on();

/// Version, commit, compiler, flags, libraries and CPU, each with its name.
std::vector<std::pair<std::string, std::string>> build_facts();

/// run.json: command, version and commit, compiler, flags, contraction, library versions, engine precision,
/// CPU, cores, date, seed (none is used: every result is deterministic). `fingerprint`:
/// experiments/earlier.hpp.
std::string run_json(const std::string& command_line, std::span<const TruthCost> truths,
                     const std::string& fingerprint, bool interrupted);

/// datapackage.json: each table with its columns, types and meanings.
std::string datapackage_json(std::span<const Table> tables);

}  // namespace polhode
