// `compare`: two result folders, row by row. Is an error larger than it was? Is anything slower?
//
// Rows are matched by the primary key that datapackage.json states for each table. What a column holds is
// told by its name: time_*, ns_per_*, *_per_s are of the clock; *error*, *drift*, *defect* are errors, the
// larger the worse; the rest is compared as it stands.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "experiments/columns.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"
#include "reports/csv.hpp"

namespace polhode {
namespace {

using report::CsvTable;

constexpr Column columns[] = {
    {"change", ColumnType::text, "worse, better, changed, slower, faster, gone, new"},
    {"table", ColumnType::text, "file of the table"},
    {"row", ColumnType::text, "its key"},
    {"column", ColumnType::text, "name of the column; empty: the whole row"},
    {"before", ColumnType::text, "as it stands in the first folder"},
    {"after", ColumnType::text, "as it stands in the second"},
    {"ratio", ColumnType::number, "after/before of numbers"},
};

// Worse is what differs by more than a tenth and by more than rounding can: ten times the floor of the scene.
constexpr double noticeable = 1.1, floors = 10;
// A spread is a median absolute deviation: three of both are two standard deviations of the difference and
// more.
constexpr double spreads = 3;

struct Folder {
  std::filesystem::path path;
  nlohmann::json package, run;
};

nlohmann::json read_json(const std::filesystem::path& file) {
  std::ifstream in(file);
  nlohmann::json j = nlohmann::json::parse(in, nullptr, false);
  if (j.is_discarded() || !j.is_object())
    throw InputError("'" + file.string() + "' is not JSON; needs a result folder that polhode made");
  return j;
}

Folder read_folder(const std::string& place) {
  Folder f{place, {}, {}};
  if (!std::filesystem::exists(f.path / "run.json") || !std::filesystem::exists(f.path / "datapackage.json"))
    throw InputError("'" + place + "' is not a result folder: it has no run.json and datapackage.json");
  f.package = read_json(f.path / "datapackage.json");
  f.run = read_json(f.path / "run.json");
  return f;
}

CsvTable read_table(const Folder& folder, const std::string& file) {
  try {
    return report::read_csv(folder.path / file);
  } catch (const std::runtime_error& e) {
    throw InputError(e.what());
  }
}

std::string key_of(const CsvTable& table, std::size_t row, const std::vector<std::string>& key) {
  std::string text;
  for (const std::string& column : key) text += (text.empty() ? "" : " ") + table.text(row, column);
  return text;
}

/// The primary key that the folder states; where it states none, the shortest run of leading columns that
/// names every row of both tables once.
std::vector<std::string> key_columns(const nlohmann::json& resource, const CsvTable& a, const CsvTable& b) {
  std::vector<std::string> key;
  if (resource.contains("schema") && resource["schema"].contains("primaryKey")) {
    const auto& stated = resource["schema"]["primaryKey"];
    if (stated.is_array())
      for (const auto& column : stated)
        if (column.is_string()) key.push_back(column.get<std::string>());
    if (!key.empty()) return key;
  }
  const auto names_each = [&key](const CsvTable& t) {
    std::set<std::string> seen;
    for (std::size_t i = 0; i < t.rows(); ++i)
      if (!seen.insert(key_of(t, i, key)).second) return false;
    return true;
  };
  for (const std::string& column : a.header()) {
    key.push_back(column);
    if (names_each(a) && names_each(b)) break;
  }
  return key;
}

bool of_clock(std::string_view column) {
  return column.starts_with("time_") || column.starts_with("ns_per_") || column == "steps_per_s" ||
         column == "repeats" || column == "real_time_factor";
}
bool of_error(std::string_view column) {
  for (const char* word : {"error", "drift", "defect"})
    if (column.find(word) != std::string_view::npos && column.find("exponent") == std::string_view::npos &&
        column.find("order") == std::string_view::npos)
      return true;
  return column == "max_abs";
}

struct Floors {
  double attitude = 0, rate = 0;
};

class Comparison {
 public:
  explicit Comparison(std::map<std::string, Floors> floors_of_scenes)
      : floors_(std::move(floors_of_scenes)) {}

  void tables(const std::string& file, const CsvTable& a, const CsvTable& b,
              const std::vector<std::string>& key) {
    std::map<std::string, std::size_t> in_b;
    for (std::size_t i = 0; i < b.rows(); ++i) in_b.emplace(key_of(b, i, key), i);
    std::set<std::string> seen;
    for (std::size_t i = 0; i < a.rows(); ++i) {
      const std::string k = key_of(a, i, key);
      seen.insert(k);
      const auto other = in_b.find(k);
      if (other == in_b.end())
        tell("gone", file, k, "", "", "");
      else
        rows(file, k, key, a, i, b, other->second);
    }
    for (std::size_t i = 0; i < b.rows(); ++i)
      if (const std::string k = key_of(b, i, key); !seen.count(k)) tell("new", file, k, "", "", "");
    compared += a.rows();
  }

  Table found{"comparison.csv", columns, {}, 4};
  std::size_t compared = 0;
  std::map<std::string, int> counts;

 private:
  void rows(const std::string& file, const std::string& k, const std::vector<std::string>& key,
            const CsvTable& a, std::size_t i, const CsvTable& b, std::size_t j) {
    timing(file, k, a, i, b, j);
    for (const std::string& column : a.header()) {
      if (of_clock(column) || std::ranges::find(key, column) != key.end()) continue;
      const std::string &x = a.text(i, column), &y = b.text(j, column);
      if (x == y) continue;
      const double before = a.number(i, column), after = b.number(j, column);
      const char* change = "changed";
      if (column == "outcome") {
        change = x == "ok" ? "worse" : y == "ok" ? "better" : "changed";
      } else if (of_error(column) && std::isfinite(before) && std::isfinite(after)) {
        const double least = floors * floor_of(a.text(i, "scene"), column);
        const double from = std::abs(before), to = std::abs(after);
        if (to > noticeable * from && to - from > least) change = "worse";
        if (from > noticeable * to && from - to > least) change = "better";
        // Neither means anything below the floor.
        if (a.has("above_floor") && !a.flag(i, "above_floor") && !b.flag(j, "above_floor"))
          change = "changed";
      }
      tell(change, file, k, column, x, y);
    }
  }

  /// Of the times, the least is compared, with the spreads of both.
  void timing(const std::string& file, const std::string& k, const CsvTable& a, std::size_t i,
              const CsvTable& b, std::size_t j) {
    for (const auto& [time, spread] :
         {std::pair("time_min_s", "time_mad_s"), std::pair("ns_per_step", "ns_per_step_mad")}) {
      const double before = a.number(i, time), after = b.number(j, time);
      const double allowed = spreads * (a.number(i, spread) + b.number(j, spread));
      if (!std::isfinite(before) || !std::isfinite(after) || !(std::abs(after - before) > allowed)) continue;
      tell(after > before ? "slower" : "faster", file, k, time, a.text(i, time), b.text(j, time));
    }
  }

  void tell(const std::string& change, const std::string& file, const std::string& k,
            const std::string& column, const std::string& before, const std::string& after) {
    const auto number = [](const std::string& text) {
      double x = 0;
      const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), x);
      return failed == std::errc() && end == text.data() + text.size() ? std::optional(x) : std::nullopt;
    };
    const auto x = number(before), y = number(after);
    found.add({change, file, k, column, before, after, x && y && *x != 0 ? Cell(*y / *x) : Cell()});
    ++counts[change];
  }

  double floor_of(const std::string& scene, std::string_view column) const {
    const auto f = floors_.find(scene);
    if (f == floors_.end()) return 0;
    return column.starts_with("attitude") ? f->second.attitude : f->second.rate;
  }

  std::map<std::string, Floors> floors_;
};

std::map<std::string, Floors> floors_in(const Folder& folder) {
  const CsvTable scenes = read_table(folder, "scenes.csv");
  std::map<std::string, Floors> all;
  const auto or_zero = [](double x) { return std::isfinite(x) ? x : 0.0; };
  for (std::size_t i = 0; i < scenes.rows(); ++i)
    all[scenes.text(i, "scene")] = {or_zero(scenes.number(i, "floor_attitude_rad")),
                                    or_zero(scenes.number(i, "floor_rate_rel"))};
  return all;
}

std::string text_of(const nlohmann::json& run, const char* key) {
  return run.contains(key) && run[key].is_string() ? run[key].get<std::string>() : "";
}

}  // namespace

int compare_verb(const Options& options) {
  if (options.scenes.size() != 2)
    throw UsageError("compare needs two result folders: polhode compare BEFORE AFTER");
  const Folder a = read_folder(options.scenes[0]), b = read_folder(options.scenes[1]);
  Comparison comparison(floors_in(a));
  std::vector<std::string> only_one;
  const auto files_of = [](const Folder& f) {
    std::map<std::string, nlohmann::json> files;
    if (f.package.contains("resources") && f.package["resources"].is_array())
      for (const auto& r : f.package["resources"])
        if (r.contains("path") && r["path"].is_string()) files[r["path"].get<std::string>()] = r;
    return files;
  };
  const auto files_a = files_of(a), files_b = files_of(b);
  for (const auto& [file, resource] : files_a) {
    if (!files_b.count(file)) {
      only_one.push_back(file + " only in " + options.scenes[0]);
      continue;
    }
    const CsvTable x = read_table(a, file), y = read_table(b, file);
    comparison.tables(file, x, y, key_columns(resource, x, y));
  }
  for (const auto& [file, resource] : files_b)
    if (!files_a.count(file)) only_one.push_back(file + " only in " + options.scenes[1]);

  std::map<std::string, int>& counts = comparison.counts;
  const int exit_code = counts["worse"] > 0 ? 1 : 0;
  if (options.json) {
    write_stdout(json(comparison.found));
    return exit_code;
  }
  std::string out = fmt::format("{} rows of {} tables compared\n", comparison.compared, files_a.size());
  for (const char* what : {"version", "commit", "compiler", "cpu"})
    if (const std::string x = text_of(a.run, what), y = text_of(b.run, what); x != y)
      out += fmt::format("  {}: '{}' before, '{}' after\n", what, x, y);
  if (text_of(a.run, "cpu") != text_of(b.run, "cpu"))
    out += "  (times of two machines say nothing about a change)\n";
  for (const std::string& line : only_one) out += "  " + line + '\n';
  constexpr std::size_t most = 15;
  for (const auto& [change, heading] :
       {std::pair("worse", "accuracy got worse"), std::pair("better", "accuracy got better"),
        std::pair("changed", "changed otherwise"), std::pair("slower", "slower beyond the spread"),
        std::pair("faster", "faster beyond the spread"), std::pair("gone", "rows that are gone"),
        std::pair("new", "rows that are new")}) {
    if (counts[change] == 0) continue;
    out += fmt::format("\n{}: {}\n", heading, counts[change]);
    std::vector<const std::vector<Cell>*> rows;
    for (const auto& row : comparison.found.rows)
      if (std::get<std::string>(row[0]) == change) rows.push_back(&row);
    // The largest ratio first, up or down.
    const auto size = [](const std::vector<Cell>* row) {
      const double* ratio = std::get_if<double>(&(*row)[6]);
      return ratio && *ratio != 0 ? std::abs(std::log(std::abs(*ratio))) : 0;
    };
    std::ranges::stable_sort(rows, [&](const auto* x, const auto* y) { return size(x) > size(y); });
    std::vector<std::vector<std::string>> lines;
    for (std::size_t i = 0; i < std::min(rows.size(), options.verbose ? rows.size() : most); ++i) {
      const auto& row = *rows[i];
      const auto cell = [&row](std::size_t k) { return std::get<std::string>(row[k]); };
      const double* ratio = std::get_if<double>(&row[6]);
      lines.push_back({"  " + cell(1), cell(2), cell(3),
                       cell(3).empty() ? ""
                                       : fmt::format("{} -> {}", cell(4).empty() ? "nothing" : cell(4),
                                                     cell(5).empty() ? "nothing" : cell(5)),
                       ratio ? fmt::format("x {:.3g}", *ratio) : ""});
    }
    out += in_columns(lines);
    if (rows.size() > lines.size())
      out += fmt::format("  and {} more (-v shows all)\n", rows.size() - lines.size());
  }
  if (comparison.found.rows.empty() && only_one.empty()) out += "No difference.\n";
  write_stdout(out);
  return exit_code;
}

}  // namespace polhode
