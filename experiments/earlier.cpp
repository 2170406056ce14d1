// Reading rows back.
#include "experiments/earlier.hpp"

#include <charconv>
#include <fstream>
#include <iterator>
#include <mutex>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/csv.hpp"

namespace polhode {
namespace {

/// FNV-1a of 64 bits.
void mix(std::uint64_t& hash, std::string_view bytes) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  hash = (hash ^ 0xffU) * 0x100000001b3U;
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string text_of(const Cell& cell) {
  if (const auto* s = std::get_if<std::string>(&cell)) return *s;
  if (const auto* n = std::get_if<std::int64_t>(&cell)) return std::to_string(*n);
  if (const auto* x = std::get_if<double>(&cell)) return shortest(*x);
  return {};
}

Cell cell_of(const std::string& text, ColumnType type) {
  if (text.empty()) return {};
  const char* const end = text.data() + text.size();
  if (type == ColumnType::text) return text;
  if (type == ColumnType::number) {
    double x = 0;
    std::from_chars(text.data(), end, x);
    return x;
  }
  std::int64_t n = 0;
  std::from_chars(text.data(), end, n);
  return n;
}

constexpr char between = '\x1f';  // no cell has it

}  // namespace

std::string fingerprint(const std::string& command_line, std::span<const Scene> scenes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  mix(hash, bytes_of("/proc/self/exe"));
  mix(hash, command_line);
  for (const Scene& s : scenes) mix(hash, bytes_of(s.file));
  return fmt::format("{:016x}", hash);
}

Earlier::Earlier(std::filesystem::path folder, const std::string& fingerprint) {
  const auto run = nlohmann::json::parse(bytes_of(folder / "run.json"), nullptr, false);
  if (run.is_object() && run.value("interrupted", false) && run.value("fingerprint", "") == fingerprint)
    folder_ = std::move(folder);
}

std::optional<std::vector<Cell>> Earlier::find(const Table& table, std::span<const Cell> key) const {
  if (folder_.empty()) return std::nullopt;
  static std::mutex guard;
  const std::lock_guard lock(guard);
  const auto [found, is_new] =
      known_.try_emplace(std::string(table.file) + between + std::to_string(key.size()));
  Rows& rows = found->second;
  if (is_new) {
    const report::CsvTable csv = report::read_csv(folder_ / table.file);
    for (std::size_t i = 0; i < csv.rows(); ++i) {
      std::string name;
      std::vector<std::string> cells;
      for (const Column& c : table.columns) {
        cells.push_back(csv.text(i, c.name));
        if (cells.size() <= key.size()) name += cells.back() + between;
      }
      rows.emplace(std::move(name), std::move(cells));
    }
  }
  std::string name;
  for (const Cell& c : key) name += text_of(c) + between;
  const auto row = rows.find(name);
  if (row == rows.end()) return std::nullopt;
  std::vector<Cell> cells;
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    cells.push_back(cell_of(row->second[i], table.columns[i].type));
  return cells;
}

}  // namespace polhode
