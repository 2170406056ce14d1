// The verdict table on the terminal.
#include "experiments/summary.hpp"

#include <map>

#include <fmt/format.h>

#include "reports/findings.hpp"
#include "reports/results.hpp"

namespace polhode {
namespace {

std::string duration_text(double s) {
  if (s < 1e-6) return fmt::format("{:.3g} ns", s * 1e9);
  if (s < 1e-3) return fmt::format("{:.3g} us", s * 1e6);
  if (s < 1) return fmt::format("{:.3g} ms", s * 1e3);
  return fmt::format("{:.3g} s", s);
}

}  // namespace

std::string result_summary(const std::filesystem::path& folder, const std::string& place) {
  const report::Results results = report::read_results(folder);
  std::string out;
  constexpr double levels[] = {1e-4, 1e-8, 1e-12};
  if (results.work_precision.rows() > 0) {
    std::size_t width = 5;
    for (const auto& s : results.scenes) width = std::max(width, s.id.size());
    out += fmt::format("Cheapest solver to reach an error (CPU time of one run)\n\n{:{}}", "scene", width);
    for (const double level : levels) out += fmt::format("  {:<34}", fmt::format("{:.0e}", level));
    out += '\n';
    for (const auto& scene : results.scenes) {
      if (report::Results::rows_of(results.work_precision, scene.id).empty()) continue;
      const auto quantity = results.quantity_of(results.work_precision, scene.id);
      out += fmt::format("{:{}}", scene.id, width);
      for (const double level : levels) {
        std::string cell;
        if (report::below_floor(scene, quantity, level)) {
          cell = "below the rounding floor";
        } else {
          const auto ranked = report::ranking(results, scene, "time_min_s", level);
          cell = ranked.empty()
                     ? "none"
                     : fmt::format("{}  {}", ranked.front().solver, duration_text(ranked.front().cost));
        }
        out += fmt::format("  {:<34}", cell);
      }
      out += '\n';
    }
    out += '\n';
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
