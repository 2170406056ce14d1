// CSV text of result tables.
#include "experiments/table.hpp"

#include <cassert>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace polhode {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string q = "\"";
  for (const char c : text) {
    if (c == '"') q += '"';
    q += c;
  }
  return q + '"';
}

struct CellText {
  std::string operator()(std::monostate) const { return {}; }
  std::string operator()(const std::string& s) const { return quoted(s); }
  std::string operator()(std::int64_t i) const { return fmt::format("{}", i); }
  std::string operator()(double x) const { return std::isfinite(x) ? shortest(x) : std::string(); }
};

using Json = nlohmann::ordered_json;

struct CellValue {
  bool boolean;
  Json operator()(std::monostate) const { return nullptr; }
  Json operator()(const std::string& s) const { return s; }
  Json operator()(std::int64_t i) const { return boolean ? Json(i != 0) : Json(i); }
  Json operator()(double x) const { return std::isfinite(x) ? Json(x) : Json(nullptr); }
};

}  // namespace

std::string shortest(double x) { return fmt::format("{}", x); }

void Table::add(std::vector<Cell> row) {
  assert(row.size() == columns.size());
  rows.push_back(std::move(row));
}

std::string csv(const Table& table) {
  std::string text;
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    if (i) text += ',';
    text += table.columns[i].name;
  }
  text += '\n';
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i) text += ',';
      text += std::visit(CellText{}, row[i]);
    }
    text += '\n';
  }
  return text;
}

std::string json(const Table& table) {
  Json rows = Json::array();
  for (const auto& row : table.rows) {
    Json object = Json::object();
    for (std::size_t i = 0; i < row.size(); ++i)
      object[std::string(table.columns[i].name)] =
          std::visit(CellValue{table.columns[i].type == ColumnType::boolean}, row[i]);
    rows.push_back(std::move(object));
  }
  return rows.dump(2) + "\n";
}

}  // namespace polhode
