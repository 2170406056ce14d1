// run.json and datapackage.json.
#include "experiments/provenance.hpp"

#include <ctime>
#include <fstream>
#include <set>
#include <thread>

#include <Eigen/Core>
#include <boost/version.hpp>
#include <nlohmann/json.hpp>

#include "solvers/registry.hpp"

namespace polhode {
namespace {

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.starts_with("model name")) {
      const auto colon = line.find(": ");
      if (colon != std::string::npos) return line.substr(colon + 2);
    }
  return "unknown";
}

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

const char* type_name(ColumnType type) {
  switch (type) {
    case ColumnType::text:
      return "string";
    case ColumnType::integer:
      return "integer";
    case ColumnType::number:
      return "number";
    case ColumnType::boolean:
      return "boolean";
  }
  return "";
}

/// Solvers that wrap a library name it in their rows (engines are told of apart); the rest is what the models
/// are built with.
std::set<std::string> libraries_used() {
  std::set<std::string> libraries{
      "Boost " + std::to_string(BOOST_VERSION / 100000) + "." + std::to_string(BOOST_VERSION / 100 % 1000),
      "Eigen " + std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
          std::to_string(EIGEN_MINOR_VERSION)};
  for (const Method* m : all_methods())
    if (!m->version.empty() && m->family != "engine") libraries.emplace(m->version);
  return libraries;
}

}  // namespace

bool contraction_is_on() {
  // 1 + 2^-27 squared minus its rounded square is zero unless the product is kept exact inside a fused
  // operation.
  volatile double a = 1 + 0x1p-27;
  const double x = a, square = x * x;
  volatile double kept = square;
  return x * x - kept != 0;
}

std::vector<std::pair<std::string, std::string>> build_facts() {
  std::string libraries;
  for (const std::string& l : libraries_used()) libraries += (libraries.empty() ? "" : ", ") + l;
  return {{"version", polhode_version},   {"commit", *POLHODE_COMMIT ? POLHODE_COMMIT : "unknown"},
          {"compiler", POLHODE_COMPILER}, {"flags", POLHODE_FLAGS},
          {"libraries", libraries},       {"CPU", cpu_model()}};
}

std::string run_json(const std::string& command_line, std::span<const TruthCost> truths,
                     const std::string& fingerprint, bool interrupted) {
  nlohmann::ordered_json j;
  j["program"] = "polhode";
  j["version"] = polhode_version;
  j["commit"] = POLHODE_COMMIT;
  j["command"] = command_line;
  j["date"] = utc_now();
  j["fingerprint"] = fingerprint;
  j["interrupted"] = interrupted;
  j["compiler"] = POLHODE_COMPILER;
  j["flags"] = POLHODE_FLAGS;
  j["contraction"] = contraction_is_on() ? "on" : "off";
  j["libraries"] = libraries_used();
  nlohmann::ordered_json engines = nlohmann::ordered_json::array();
  for (const EngineStatus& e : all_engines()) {
    nlohmann::ordered_json entry = {{"id", e.id}, {"what", e.summary}, {"available", e.available}};
    if (e.available && !e.methods.empty()) entry["version"] = e.methods.front()->version;
    if (!e.available) entry["missing"] = e.missing;
    engines.push_back(entry);
  }
  j["engines"] = engines;
  nlohmann::ordered_json costs = nlohmann::ordered_json::array();
  for (const TruthCost& t : truths)
    costs.push_back({{"scene", t.scene}, {"kind", t.kind}, {"cost_s", t.seconds}});
  j["truths"] = costs;
  j["cpu"] = cpu_model();
  j["cores"] = std::thread::hardware_concurrency();
  j["clock"] = "CPU time of the measuring thread";
  j["seed"] = nullptr;
  return j.dump(2) + "\n";
}

std::string datapackage_json(std::span<const Table> tables) {
  nlohmann::ordered_json j;
  j["profile"] = "tabular-data-package";
  j["name"] = "polhode-results";
  j["resources"] = nlohmann::ordered_json::array();
  for (const Table& t : tables) {
    nlohmann::ordered_json fields = nlohmann::ordered_json::array();
    for (const Column& c : t.columns)
      fields.push_back({{"name", c.name}, {"type", type_name(c.type)}, {"description", c.meaning}});
    nlohmann::ordered_json schema = {{"fields", fields}, {"missingValues", {""}}};
    if (t.keys > 0) {
      schema["primaryKey"] = nlohmann::ordered_json::array();
      for (std::size_t i = 0; i < t.keys; ++i) schema["primaryKey"].push_back(t.columns[i].name);
    }
    std::string name(t.file.substr(0, t.file.find('.')));
    for (char& ch : name)
      if (ch == '_') ch = '-';
    j["resources"].push_back(
        {{"name", name}, {"path", t.file}, {"profile", "tabular-data-resource"}, {"schema", schema}});
  }
  return j.dump(2) + "\n";
}

}  // namespace polhode
