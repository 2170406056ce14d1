// Rows of an interrupted run, so that the same command goes on where it stopped.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "experiments/table.hpp"
#include "models/scene.hpp"

namespace polhode {

/// What rows of accuracy are a pure function of, in sixteen hexadecimal digits: the program's bytes, the
/// command line and the scene files.
std::string fingerprint(const std::string& command_line, std::span<const Scene> scenes);

/// The rows in a result folder whose run was interrupted and has this fingerprint.
class Earlier {
 public:
  Earlier() = default;
  /// No such folder, or one of another run: no rows.
  Earlier(std::filesystem::path folder, const std::string& fingerprint);

  /// The row of a table that begins with the cells of `key`. Safe to call from several threads.
  std::optional<std::vector<Cell>> find(const Table& table, std::span<const Cell> key) const;

 private:
  using Rows = std::map<std::string, std::vector<std::string>>;  // by their first cells
  std::filesystem::path folder_;
  mutable std::map<std::string, Rows> known_;  // by file and length of the key
};

}  // namespace polhode
