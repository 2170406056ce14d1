// Result tables: a schema (columns with type, unit and meaning) and rows, written as CSV (RFC 4180, UTF-8,
// LF).
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace polhode {

enum class ColumnType { text, integer, number, boolean };

struct Column {
  std::string_view name;  // lower-case snake_case, unit last
  ColumnType type;
  std::string_view meaning;  // with the unit
};

/// An empty cell, a text, an integer, or a number (shortest text that round-trips; not finite: empty).
using Cell = std::variant<std::monostate, std::string, std::int64_t, double>;

struct Table {
  std::string_view file;            // "convergence.csv"
  std::span<const Column> columns;  // the schema lives as long as the program
  std::vector<std::vector<Cell>> rows;
  std::size_t keys = 0;  // so many leading columns name a row; the others are what was found. 0: not said

  void add(std::vector<Cell> row);  // as many cells as columns
};

/// The table as CSV text.
std::string csv(const Table& table);

/// The table as JSON text: an array of objects, one a row; an empty cell is null.
std::string json(const Table& table);

/// Text of one number: shortest that round-trips.
std::string shortest(double x);

}  // namespace polhode
