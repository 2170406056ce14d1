// Reads a result folder and gives every solver its look.
//
// Hue tells the family, shade, mark and dash tell the member. All follow the order of solvers.csv, so that no
// list of solvers is needed here and looks agree between figures and pages.
#include "reports/results.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "reports/words.hpp"

namespace polhode::report {
namespace {

// Hues that stay apart under the common colour-vision deficiencies, dark enough for thin lines on white.
// Source: Okabe & Ito, Color Universal Design (2008), darkened where needed; Tol, SRON/EPS/TN/09-002.
constexpr std::array<unsigned, 9> palette = {0xD55E00, 0xC28A00, 0x0072B2, 0x009E73, 0x8E4EA6,
                                             0xA3224D, 0x2FA4CF, 0x7C7A1C, 0x555555};
constexpr std::array<int, 6> filled_marks = {7, 5, 9, 11, 13, 15};

std::string shaded(unsigned rgb, int variant) {
  const double amount = std::array{0.0, -0.32, 0.34}[static_cast<std::size_t>(variant % 3)];
  const auto channel = [&](int shift) {
    const double c = (rgb >> shift) & 0xFF;
    return static_cast<int>(std::lround(amount < 0 ? c * (1 + amount) : c + (255 - c) * amount));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", channel(16), channel(8), channel(0));
}

/// solvers  with their families, in the order of the registry
std::map<std::string, Mark> marks_of(const std::vector<std::pair<std::string, std::string>>& solvers) {
  std::map<std::string, Mark> marks;
  std::vector<std::pair<std::string, std::size_t>> families;  // with the number of members so far
  for (const auto& solver : solvers) {
    auto found = std::find_if(families.begin(), families.end(),
                              [&](const auto& f) { return f.first == solver.second; });
    if (found == families.end()) found = families.insert(families.end(), {solver.second, 0});
    const auto n = static_cast<std::size_t>(found - families.begin());
    const std::size_t member = found->second++;
    Mark mark;
    mark.colour = shaded(palette[n % palette.size()], static_cast<int>(member));
    // Two families of one hue never share a mark.
    constexpr std::size_t half = filled_marks.size() / 2;
    mark.filled = filled_marks[n / palette.size() % 2 * half + (member + member / half + n) % half];
    mark.dash = member / 9 % 2 == 0 ? 1 : 2;
    marks.emplace(solver.first, mark);
  }
  return marks;
}

void append_new(std::vector<std::string>& list, std::set<std::string>& seen, const std::string& value) {
  if (!value.empty() && seen.insert(value).second) list.push_back(value);
}

}  // namespace

std::string Quantity::with_unit(std::string_view value) const {
  return unit.empty() ? std::string(value) : fmt::format("{} {}", value, unit);
}

std::vector<std::size_t> Results::rows_of(const CsvTable& table, std::string_view scene) {
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < table.rows(); ++i)
    if (table.text(i, "scene") == scene) rows.push_back(i);
  return rows;
}

std::vector<std::string> Results::solvers_in(const CsvTable& table, std::string_view scene) const {
  std::set<std::string> there;
  for (const std::size_t i : rows_of(table, scene)) there.insert(table.text(i, "solver"));
  std::vector<std::string> out;
  for (const std::string& id : solvers)
    if (there.count(id)) out.push_back(id);
  return out;
}

std::string Results::family_of(const std::string& solver) const {
  const auto found = families.find(solver);
  return found == families.end() ? std::string() : found->second;
}

Quantity Results::quantity_of(const CsvTable& table, std::string_view scene) const {
  static const std::array<Quantity, 5> candidates = {
      {{"attitude_error_max_rad", "attitude error", "rad"},
       {"rate_error_max_rel", "relative rate error", ""},
       {"position_error_max_m", "position error", "m"},
       {"energy_error_max_rel", "relative energy error", ""},
       {"momentum_error_max_rel", "relative momentum error", ""}}};
  const auto rows = rows_of(table, scene);
  for (const Quantity& q : candidates)
    for (const std::size_t i : rows)
      if (std::isfinite(table.number(i, q.column))) return q;
  return candidates.front();
}

bool Results::drift_quantity_is_total(std::string_view scene) const {
  for (const std::size_t i : rows_of(drift, scene))
    if (std::isfinite(drift.number(i, "rotational_energy_drift_rel"))) return false;
  return true;
}

Results read_results(const std::filesystem::path& folder) {
  Results r;
  const auto read = [&](const char* name) { return read_csv(folder / name); };
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
    if (entry.path().extension() == ".csv") r.files.push_back(entry.path().filename().string());
  std::sort(r.files.begin(), r.files.end());
  r.work_precision = read("work_precision.csv");
  r.convergence = read("convergence.csv");
  r.orders = read("orders.csv");
  r.drift = read("drift.csv");
  r.drift_verdict = read("drift_verdict.csv");
  r.stability = read("stability.csv");
  r.stability_map = read("stability_map.csv");
  r.solver_table = read("solvers.csv");
  const CsvTable scene_table = read("scenes.csv"), engines = read("engines.csv"),
                 extremes = read("extremes.csv"), tolerance = read("tolerance.csv");

  std::vector<std::string> scene_ids, all;
  std::set<std::string> seen_scenes, seen_solvers, used;
  for (std::size_t i = 0; i < scene_table.rows(); ++i)
    append_new(scene_ids, seen_scenes, scene_table.text(i, "scene"));
  for (std::size_t i = 0; i < r.solver_table.rows(); ++i)
    append_new(all, seen_solvers, r.solver_table.text(i, "solver"));
  const CsvTable* const with_solvers[] = {&r.work_precision, &r.convergence, &r.orders,        &r.drift,
                                          &r.drift_verdict,  &r.stability,   &r.stability_map, &engines,
                                          &extremes,         &tolerance};
  for (const CsvTable* t : with_solvers)
    for (std::size_t i = 0; i < t->rows(); ++i) {
      if (t->has("scene")) append_new(scene_ids, seen_scenes, t->text(i, "scene"));
      append_new(all, seen_solvers, t->text(i, "solver"));
      used.insert(t->text(i, "solver"));
    }
  for (std::size_t i = 0; i < r.solver_table.rows(); ++i)
    r.families[r.solver_table.text(i, "solver")] = r.solver_table.text(i, "family");
  std::vector<std::pair<std::string, std::string>> members;
  for (const std::string& id : all) members.emplace_back(id, r.family_of(id));
  r.marks = marks_of(members);
  for (const std::string& id : all)
    if (used.count(id)) r.solvers.push_back(id);

  std::set<std::string> names;
  for (const std::string& id : scene_ids) {
    SceneCard card;
    card.id = id;
    for (const std::size_t i : Results::rows_of(scene_table, id)) {
      card.title = scene_table.text(i, "title");
      card.left_out = scene_table.text(i, "left_out");
      card.truth = scene_table.text(i, "truth");
      card.unknowns = scene_table.text(i, "unknowns");
      card.duration = scene_table.number(i, "duration_s");
      card.truth_uncertainty = scene_table.number(i, "truth_uncertainty_rad");
      card.floor = scene_table.number(i, "floor_attitude_rad");
    }
    card.file = file_name_of(id);
    for (int n = 2; !names.insert(card.file).second; ++n)
      card.file = fmt::format("{}-{}", file_name_of(id), n);
    r.scenes.push_back(card);
  }
  return r;
}

}  // namespace polhode::report
