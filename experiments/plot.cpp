// The plot: axes in decades, the rounding floor as a line.
#include "experiments/plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <vector>

#include <fmt/format.h>
#include <unistd.h>

#include "experiments/columns.hpp"
#include "reports/results.hpp"

namespace polhode {
namespace {

constexpr int margin = 8, width = 70, height = 21;  // of the labels; of the field
constexpr std::size_t letters = 9;

struct Point {
  double error, seconds;
  std::string solver;
};

/// Decades that hold all values.
struct Axis {
  int low = 0, high = 1;  // powers of ten
  int cells;

  Axis(const std::vector<double>& values, int n) : cells(n) {
    const auto [least, largest] = std::ranges::minmax(values);
    low = static_cast<int>(std::floor(std::log10(least)));
    high = std::max(low + 1, static_cast<int>(std::ceil(std::log10(largest))));
  }
  int cell(double x) const {
    const double part = (std::log10(x) - low) / (high - low);
    return std::clamp(static_cast<int>(std::lround(part * (cells - 1))), 0, cells - 1);
  }
};

/// Who reaches some decade of error in the least time, from coarse to fine.
std::vector<std::string> fastest(const std::vector<Point>& points, const Axis& errors) {
  std::vector<std::string> ids;
  for (int k = errors.high; k >= errors.low; --k) {
    const Point* best = nullptr;
    for (const Point& p : points)
      if (p.error <= std::pow(10, k) && (!best || p.seconds < best->seconds)) best = &p;
    if (best && std::ranges::find(ids, best->solver) == ids.end() && ids.size() < letters)
      ids.push_back(best->solver);
  }
  // Closed forms win everywhere: those who come next tell more. One more per round, until the letters are
  // used up.
  for (std::size_t before = 0; before != ids.size() && ids.size() < letters;) {
    before = ids.size();
    for (int k = errors.high; k >= errors.low; k -= 3) {
      const Point* best = nullptr;
      for (const Point& p : points)
        if (p.error <= std::pow(10, k) && std::ranges::find(ids, p.solver) == ids.end() &&
            (!best || p.seconds < best->seconds))
          best = &p;
      if (best && ids.size() < letters) ids.push_back(best->solver);
    }
  }
  return ids;
}

std::string painted(char letter, std::size_t index, bool coloured) {
  if (!coloured) return std::string(1, letter);
  constexpr int colours[] = {31, 32, 33, 34, 35, 36, 91, 92, 94};
  return fmt::format("\033[1;{}m{}\033[0m", colours[index % std::size(colours)], letter);
}

std::string plot_of(const report::Results& results, const report::SceneCard& scene, bool coloured) {
  const report::CsvTable& table = results.work_precision;
  const report::Quantity quantity = results.quantity_of(table, scene.id);
  std::vector<Point> points;
  for (const std::size_t i : report::Results::rows_of(table, scene.id)) {
    if (table.text(i, "outcome") != "ok") continue;
    const double error = table.number(i, quantity.column), seconds = table.number(i, "time_min_s");
    if (error >= 0 && std::isfinite(error) && seconds > 0)
      points.push_back({std::max(error, 1e-17), seconds, table.text(i, "solver")});
  }
  if (points.empty()) return "";
  std::vector<double> e, t;
  for (const Point& p : points) {
    e.push_back(p.error);
    t.push_back(p.seconds);
  }
  const Axis errors(e, height), times(t, width);
  const std::vector<std::string> ids = fastest(points, errors);

  std::vector<std::string> field(height, std::string(width, ' '));
  if (scene.floor >= std::pow(10, errors.low) && scene.floor <= std::pow(10, errors.high))
    field[static_cast<std::size_t>(errors.cell(scene.floor))].assign(width, '-');
  const auto at = [&](const Point& p) -> char& {
    return field[static_cast<std::size_t>(errors.cell(p.error))]
                [static_cast<std::size_t>(times.cell(p.seconds))];
  };
  for (const Point& p : points) at(p) = '.';
  for (std::size_t k = ids.size(); k-- > 0;)  // the first on top
    for (const Point& p : points)
      if (p.solver == ids[k]) at(p) = static_cast<char>('a' + k);

  std::string out = fmt::format("{}: largest {}{} against CPU time of a run\n\n", scene.id, quantity.name,
                                quantity.unit.empty() ? "" : ", " + quantity.unit + ",");
  for (int row = height - 1; row >= 0; --row) {
    const double decade = errors.low + double(errors.high - errors.low) * row / (height - 1);
    // A label where a whole decade lies in the row.
    std::string label;
    const double whole = std::round(decade);
    if (errors.cell(std::pow(10, whole)) == row) label = fmt::format("{:.0e}", std::pow(10, whole));
    out += fmt::format("{:>{}} |", label, margin - 2);
    for (const char c : field[static_cast<std::size_t>(row)])
      out +=
          c >= 'a' && c <= 'z' ? painted(c, static_cast<std::size_t>(c - 'a'), coloured) : std::string(1, c);
    while (out.back() == ' ') out.pop_back();
    out += '\n';
  }
  out += fmt::format("{:>{}}+{}\n", "", margin - 1, std::string(width, '-'));
  std::string axis(margin + width, ' ');
  for (int k = times.low; k <= times.high; ++k) {
    const std::string label = duration_text(std::pow(10, k));
    const auto from = static_cast<std::size_t>(
        std::clamp(margin + times.cell(std::pow(10, k)) - static_cast<int>(label.size()) / 2, 0,
                   margin + width - static_cast<int>(label.size())));
    if (axis.find_last_not_of(' ') == std::string::npos || axis.find_last_not_of(' ') + 2 < from || from == 0)
      axis.replace(from, label.size(), label);
  }
  axis.erase(axis.find_last_not_of(' ') + 1);
  out += axis + "\n\n";
  std::size_t column = 0;
  for (std::size_t k = 0; k < ids.size(); ++k) {
    constexpr std::size_t cell = 39;
    const std::string name = ids[k].substr(0, cell - 3);
    out += ' ' + painted(static_cast<char>('a' + k), k, coloured) + ' ' + name;
    column = (column + 1) % 2;
    out += column == 0 || k + 1 == ids.size() ? "\n" : std::string(cell - 3 - name.size(), ' ');
  }
  return out + " .  other runs" + (std::isfinite(scene.floor) ? ", --- rounding floor" : "") + '\n';
}

}  // namespace

std::string work_precision_plot(const std::filesystem::path& folder, bool coloured) {
  const report::Results results = report::read_results(folder);
  std::string out;
  for (const report::SceneCard& scene : results.scenes) {
    const std::string plot = plot_of(results, scene, coloured);
    if (!plot.empty()) out += (out.empty() ? "" : "\n") + plot;
  }
  return out;
}

bool stdout_is_terminal() { return isatty(STDOUT_FILENO) == 1; }

bool stdout_is_coloured() {
  const char* forbidden = std::getenv("NO_COLOR");
  return stdout_is_terminal() && !(forbidden && *forbidden);
}

}  // namespace polhode
