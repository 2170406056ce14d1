// Reader of our own result files: RFC 4180 tables with one header line.
//
// Fields are kept as text; numbers are converted where they are asked for, so that an empty field of a failed
// run stays distinguishable from a zero.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace polhode::report {

/// A table of text with named columns.
class CsvTable {
 public:
  CsvTable() = default;
  /// lines  where each record begins, counted from 1
  CsvTable(std::vector<std::vector<std::string>> records, std::vector<std::size_t> lines);

  std::size_t rows() const { return rows_.size(); }
  bool empty() const { return rows_.empty(); }
  bool has(std::string_view column) const;
  const std::vector<std::string>& header() const { return header_; }

  /// Some of the rows, in the order given.
  CsvTable selection(const std::vector<std::size_t>& rows) const;
  /// The table as RFC 4180 text with LF.
  std::string csv() const;
  std::size_t fields(std::size_t row) const { return rows_[row].size(); }
  /// The line of the text that a row begins in, counted from 1.
  std::size_t line(std::size_t row) const { return lines_[row + 1]; }

  /// One field; empty where the column is absent or the row is too short.
  const std::string& text(std::size_t row, std::string_view column) const;

  /// One field as a number.
  ///
  /// returns  the value; NaN where the field is absent, empty, or not a number read whole
  double number(std::size_t row, std::string_view column) const;

  /// True unless the field says `0`, `false` or `no`.
  bool flag(std::size_t row, std::string_view column) const;

 private:
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> lines_;  // of the header, then of the rows
  std::unordered_map<std::string, std::size_t> index_;
};

/// Splits RFC 4180 text: quoted fields may hold commas, line breaks and doubled quotes; LF and CRLF both end
/// a record; a UTF-8 byte order mark and blank lines are passed over.
CsvTable parse_csv(std::string_view text);

/// Reads a table from a file.
///
/// returns  an empty table where the file does not exist
/// throws   std::runtime_error with the path if it exists and cannot be read
CsvTable read_csv(const std::filesystem::path& path);

}  // namespace polhode::report
