// The verdict table on the terminal.
#include "experiments/summary.hpp"

#include <vector>

#include <fmt/format.h>

#include "experiments/columns.hpp"
#include "reports/findings.hpp"
#include "reports/results.hpp"

namespace polhode {
namespace {

constexpr double levels[] = {1e-4, 1e-8, 1e-12};
constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"quantity", ColumnType::text, "which error, a column of work_precision.csv"},
    {"error", ColumnType::number, "to be reached"},
    {"below_floor", ColumnType::boolean, "1: rounding decides there, nobody is ranked"},
    {"solver", ColumnType::text, "who reaches it in the least time; empty: nobody"},
    {"time_s", ColumnType::number, "CPU time of one run, s"},
};

}  // namespace

Table summary_table(const std::filesystem::path& folder) {
  const report::Results results = report::read_results(folder);
  Table table{"summary.csv", columns, {}, 3};
  for (const auto& scene : results.scenes) {
    if (report::Results::rows_of(results.work_precision, scene.id).empty()) continue;
    const auto quantity = results.quantity_of(results.work_precision, scene.id);
    for (const double level : levels) {
      const bool below = report::below_floor(scene, quantity, level);
      const auto ranked =
          below ? std::vector<report::Cost>() : report::ranking(results, scene, "time_min_s", level);
      table.add({scene.id, quantity.column, level, std::int64_t{below},
                 ranked.empty() ? Cell() : Cell(ranked.front().solver),
                 ranked.empty() ? Cell() : Cell(ranked.front().cost)});
    }
  }
  return table;
}

std::string result_summary(const std::filesystem::path& folder, const std::string& place) {
  const report::Results results = report::read_results(folder);
  std::string out;
  if (results.work_precision.rows() > 0) {
    std::vector<std::vector<std::string>> lines{{"scene"}};
    for (const double level : levels) lines[0].push_back(fmt::format("{:.0e}", level));
    for (const auto& scene : results.scenes) {
      if (report::Results::rows_of(results.work_precision, scene.id).empty()) continue;
      const auto quantity = results.quantity_of(results.work_precision, scene.id);
      lines.push_back({scene.id});
      for (const double level : levels) {
        if (report::below_floor(scene, quantity, level)) {
          lines.back().emplace_back("below the rounding floor");
          continue;
        }
        const auto ranked = report::ranking(results, scene, "time_min_s", level);
        lines.back().push_back(report::lacks_truth(results.work_precision, scene.id) ? "no truth"
                               : ranked.empty()                                      ? "none"
                                                : fmt::format("{}  {}", ranked.front().solver,
                                                              duration_text(ranked.front().cost)));
      }
    }
    out += "Cheapest solver to reach an error (CPU time of one run)\n\n" + in_columns(lines) + '\n';
  }
  const auto say = [&out](const std::string& sentence) {
    if (!sentence.empty()) out += sentence + '\n';
  };
  for (const auto& scene : results.scenes) {
    if (!report::Results::rows_of(results.orders, scene.id).empty())
      say(scene.id + ": " + report::orders_sentence(results, scene));
    if (!report::Results::rows_of(results.stability, scene.id).empty())
      say(scene.id + ": " + report::stability_sentence(results, scene));
  }
  out += fmt::format("\nResults: {}/index.html (page), {}/*.csv (tables)\n", place, place);
  return out;
}

}  // namespace polhode
