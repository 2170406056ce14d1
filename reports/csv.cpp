// Reader of our own result files. Source of the format: RFC 4180.
#include "reports/csv.hpp"

#include <charconv>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace polhode::report {

CsvTable::CsvTable(std::vector<std::vector<std::string>> records, std::vector<std::size_t> lines)
    : lines_(std::move(lines)) {
  if (records.empty()) return;
  header_ = std::move(records.front());
  for (std::size_t i = 0; i < header_.size(); ++i) index_.emplace(header_[i], i);
  rows_.assign(std::make_move_iterator(records.begin() + 1), std::make_move_iterator(records.end()));
}

bool CsvTable::has(std::string_view column) const { return index_.count(std::string(column)) > 0; }

const std::string& CsvTable::text(std::size_t row, std::string_view column) const {
  static const std::string nothing;
  const auto found = index_.find(std::string(column));
  if (found == index_.end() || row >= rows_.size() || found->second >= rows_[row].size()) return nothing;
  return rows_[row][found->second];
}

CsvTable CsvTable::selection(const std::vector<std::size_t>& rows) const {
  CsvTable out;
  out.header_ = header_;
  out.index_ = index_;
  if (!lines_.empty()) out.lines_.push_back(lines_.front());
  for (const std::size_t i : rows) {
    out.rows_.push_back(rows_.at(i));
    if (!lines_.empty()) out.lines_.push_back(lines_.at(i + 1));
  }
  return out;
}

std::string CsvTable::csv() const {
  std::string out;
  const auto add = [&out](const std::vector<std::string>& fields) {
    for (std::size_t k = 0; k < fields.size(); ++k) {
      if (k) out += ',';
      if (fields[k].find_first_of(",\"\n\r") == std::string::npos) {
        out += fields[k];
        continue;
      }
      out += '"';
      for (const char c : fields[k]) out += c == '"' ? "\"\"" : std::string(1, c);
      out += '"';
    }
    out += '\n';
  };
  add(header_);
  for (const auto& row : rows_) add(row);
  return out;
}

double CsvTable::number(std::size_t row, std::string_view column) const {
  const std::string& field = text(row, column);
  double value = 0;
  const char* end = field.data() + field.size();
  const auto [stop, error] = std::from_chars(field.data(), end, value);
  if (field.empty() || stop != end) return std::numeric_limits<double>::quiet_NaN();
  // from_chars leaves the value alone out of range: below it is a zero to any figure, above it is no number.
  if (error == std::errc::result_out_of_range)
    return field.find("e-") != std::string::npos ? 0.0 : std::numeric_limits<double>::infinity();
  return error == std::errc() ? value : std::numeric_limits<double>::quiet_NaN();
}

bool CsvTable::flag(std::size_t row, std::string_view column) const {
  const std::string& field = text(row, column);
  return field != "0" && field != "false" && field != "no";
}

CsvTable parse_csv(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::vector<std::vector<std::string>> records;
  std::vector<std::string> record;
  std::vector<std::size_t> lines;
  std::string field;
  bool quoted = false;
  std::size_t line = 1, began = 1;  // of the text, of the record
  const auto end_record = [&] {
    record.push_back(std::exchange(field, {}));
    if (record.size() > 1 || !record.front().empty()) {
      records.push_back(std::move(record));
      lines.push_back(began);
    }
    record.clear();
    began = line;
  };
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') ++line;
    if (quoted) {
      if (c != '"') {
        field += c;
      } else if (i + 1 < text.size() && text[i + 1] == '"') {
        field += c;
        ++i;
      } else {
        quoted = false;
      }
    } else if (c == '"') {
      quoted = true;
    } else if (c == ',') {
      record.push_back(std::exchange(field, {}));
    } else if (c == '\n') {
      end_record();
    } else if (c != '\r') {
      field += c;
    }
  }
  if (!field.empty() || !record.empty()) end_record();
  return CsvTable(std::move(records), std::move(lines));
}

CsvTable read_csv(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {};
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  // An empty file sets failbit on `text` alone, which is no failure.
  if (!file || file.bad()) throw std::runtime_error("cannot read " + path.string());
  return parse_csv(text.str());
}

}  // namespace polhode::report
