// What the tables say, in words.
#include "reports/findings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <fmt/format.h>

#include "reports/words.hpp"

namespace polhode::report {
namespace {

/// The level that tells most about a scene: the smallest of a few that somebody reaches above the floor.
std::optional<double> telling_level(const Results& results, const SceneCard& scene,
                                    std::string_view cost_column) {
  const Quantity quantity = results.quantity_of(results.work_precision, scene.id);
  for (const double level : {1e-8, 1e-6, 1e-4, 1e-2})
    if (!below_floor(scene, quantity, level) && !ranking(results, scene, cost_column, level).empty())
      return level;
  return std::nullopt;
}

std::string cost_text(double cost, bool is_time) {
  if (is_time) return pretty_time(cost);
  return fmt::format("{:.0f} right-hand-side evaluations", cost);
}

constexpr const char* no_truth = "There is no truth of this scene to measure errors against.";

/// Solvers that a scene could be asked of: with at least one row that is not `unsupported`.
std::size_t count_supported(const CsvTable& table, std::string_view scene) {
  std::set<std::string> solvers;
  for (const std::size_t i : Results::rows_of(table, scene))
    if (table.text(i, "outcome") != "unsupported") solvers.insert(table.text(i, "solver"));
  return solvers.size();
}

std::string ranking_sentence(const Results& results, const SceneCard& scene, double level,
                             const std::vector<Cost>& order, bool is_time) {
  const Quantity quantity = results.quantity_of(results.work_precision, scene.id);
  const std::size_t all = count_supported(results.work_precision, scene.id);
  const std::string where = quantity.with_unit(pretty_number(level));
  const Cost& best = order.front();
  if (all == 1)
    return fmt::format("{} alone was run here: it reaches {} for {}.", best.solver, where,
                       cost_text(best.cost, is_time));
  std::string text = fmt::format("At {}, {} is the cheapest of {}: {}", where, best.solver,
                                 pretty_count(all, "solver"), cost_text(best.cost, is_time));
  const auto factor = [&](const Cost& c) { return pretty_factor(c.cost / best.cost); };
  if (order.size() > 1) text += fmt::format("; {} needs {} times that", order[1].solver, factor(order[1]));
  if (order.size() > 2) text += fmt::format(", {} {} times", order.back().solver, factor(order.back()));
  text += ".";
  if (const std::size_t missed = all - order.size(); missed > 0)
    text += fmt::format(" {} of {} did not get there.", missed, all);
  return text;
}

}  // namespace

bool lacks_truth(const CsvTable& table, std::string_view scene) {
  const auto rows = Results::rows_of(table, scene);
  return std::any_of(rows.begin(), rows.end(),
                     [&](std::size_t i) { return table.text(i, "outcome") == "no_truth"; });
}

std::vector<Cost> ranking(const Results& results, const SceneCard& scene, std::string_view cost_column,
                          double level) {
  const CsvTable& table = results.work_precision;
  const Quantity quantity = results.quantity_of(table, scene.id);
  std::map<std::string, double> least;
  for (const std::size_t i : Results::rows_of(table, scene.id)) {
    const double error = table.number(i, quantity.column), cost = table.number(i, cost_column);
    if (table.text(i, "outcome") != "ok" || !(error <= level) || !(cost > 0)) continue;
    const auto [found, is_new] = least.emplace(table.text(i, "solver"), cost);
    if (!is_new) found->second = std::min(found->second, cost);
  }
  std::vector<Cost> out;
  for (const auto& [solver, cost] : least) out.push_back({solver, cost});
  std::stable_sort(out.begin(), out.end(), [](const Cost& a, const Cost& b) { return a.cost < b.cost; });
  return out;
}

bool below_floor(const SceneCard& scene, const Quantity& quantity, double level) {
  return quantity.unit == "rad" && level < scene.floor;
}

std::string work_sentence(const Results& results, const SceneCard& scene) {
  if (lacks_truth(results.work_precision, scene.id)) return no_truth;
  const auto level = telling_level(results, scene, "time_min_s");
  if (!level) return "No run reached an error of 0.01 or less here with its time measured.";
  return ranking_sentence(results, scene, *level, ranking(results, scene, "time_min_s", *level), true);
}

std::string evaluations_sentence(const Results& results, const SceneCard& scene) {
  if (lacks_truth(results.work_precision, scene.id)) return no_truth;
  const auto level = telling_level(results, scene, "rhs_evals");
  if (!level) return "No run that counts right-hand sides reached an error of 0.01 or less here.";
  const auto order = ranking(results, scene, "rhs_evals", *level);
  const auto clock = ranking(results, scene, "time_min_s", *level);
  std::string text = ranking_sentence(results, scene, *level, order, false);
  if (!clock.empty() && order.size() > 1)
    text += clock.front().solver == order.front().solver
                ? " It also wins by the clock."
                : fmt::format(
                      " By the clock {} wins: the difference is what a solver spends around the equations.",
                      clock.front().solver);
  return text;
}

bool order_met(double claimed, double order, double order_error) {
  const double band = std::max(0.15, std::isfinite(order_error) ? 2 * order_error : 0.0);
  return std::abs(order - claimed) <= band;
}

std::string orders_sentence(const Results& results, const SceneCard& scene) {
  const CsvTable& t = results.orders;
  std::size_t with_claim = 0, met = 0, above = 0, worst = 0;
  double shortest = 0;  // by how much an order falls short of its claim
  for (const std::size_t i : Results::rows_of(t, scene.id)) {
    const double claimed = t.number(i, "claimed"), order = t.number(i, "order");
    if (!std::isfinite(claimed) || !std::isfinite(order)) continue;
    ++with_claim;
    const bool is_met = order_met(claimed, order, t.number(i, "order_error"));
    met += is_met;
    above += !is_met && order > claimed;
    if (!is_met && claimed - order > shortest) shortest = claimed - order, worst = i;
  }
  if (with_claim == 0) return "No order was claimed and fitted on this scene.";
  if (met == with_claim)
    return fmt::format("{} with a claim {} it.", pretty_count(with_claim, "fitted order"),
                       with_claim == 1 ? "meets" : "all meet");
  std::string text = fmt::format("{} of {} with a claim {} it", met, pretty_count(with_claim, "fitted order"),
                                 met == 1 ? "meets" : "meet");
  // A claim holds for every scene, also under a torque and where the body is least symmetric.
  if (above > 0) text += fmt::format(", {} {} above it", above, above == 1 ? "is" : "are");
  if (met + above == with_claim) return text + ".";
  return text + fmt::format(", {} below. Farthest below is {} in {}: {:.2f} where {} is claimed.",
                            with_claim - met - above, t.text(worst, "solver"), t.text(worst, "quantity"),
                            t.number(worst, "order"), t.text(worst, "claimed"));
}

std::string drift_sentence(const Results& results, const SceneCard& scene, std::string_view column,
                           std::string_view what) {
  const CsvTable& t = results.drift;
  struct End {
    double time = -1, value = 0;
  };
  // One end for each run; a solver that ran at several settings is named with the setting.
  std::map<std::string, std::set<std::string>> settings;
  for (const std::size_t i : Results::rows_of(t, scene.id))
    settings[t.text(i, "solver")].insert(t.text(i, "knob_value"));
  std::map<std::string, End> ends;
  double longest = 0;
  for (const std::size_t i : Results::rows_of(t, scene.id)) {
    const double time = t.number(i, "t_s"), value = std::abs(t.number(i, column));
    if (!std::isfinite(time) || !std::isfinite(value)) continue;
    std::string run = t.text(i, "solver");
    if (settings[run].size() > 1) run += " (" + t.text(i, "knob") + " " + t.text(i, "knob_value") + ")";
    End& end = ends[run];
    if (time > end.time) end.time = time;
    end.value = std::max(end.value, value);
    longest = std::max(longest, time);
  }
  if (ends.empty()) return fmt::format("No drift of the {} was measured here.", what);
  std::string best, worst;
  std::size_t early = 0;
  for (const auto& [solver, end] : ends) {
    // A run that ended early has drifted for less time: it is counted, never ranked.
    if (end.time < 0.999 * longest) {
      ++early;
      continue;
    }
    if (best.empty() || end.value < ends[best].value) best = solver;
    if (worst.empty() || end.value > ends[worst].value) worst = solver;
  }
  std::string text = fmt::format("Over {} s, {} keeps the {} best, within {}", pretty_number(longest), best,
                                 what, pretty_number(ends[best].value));
  if (worst != best)
    text += fmt::format("; {} misses it by up to {}", worst, pretty_number(ends[worst].value));
  text += ".";
  if (early > 0) text += fmt::format(" {} ended before that time.", pretty_count(early, "run"));
  return text;
}

std::vector<StabilityLimit> stability_limits(const CsvTable& t, const SceneCard& scene) {
  std::vector<StabilityLimit> out;
  std::map<std::string, std::size_t> seen;
  for (const std::size_t i : Results::rows_of(t, scene.id)) {
    const std::string key =
        t.text(i, "solver") + '\n' + t.text(i, "parameter") + '\n' + t.text(i, "parameter_value");
    const StabilityLimit limit{t.text(i, "solver"),
                               t.text(i, "parameter"),
                               t.text(i, "parameter_value"),
                               t.number(i, "largest_stable_h_s"),
                               t.number(i, "largest_stable_near_rest_h_s"),
                               t.number(i, "theory_h_s")};
    if (const auto [found, is_new] = seen.emplace(key, out.size()); is_new) {
      out.push_back(limit);
    } else {
      StabilityLimit& kept = out[found->second];
      if (!std::isfinite(kept.largest)) kept.largest = limit.largest;
      if (!std::isfinite(kept.near_rest)) kept.near_rest = limit.near_rest;
      if (!std::isfinite(kept.theory)) kept.theory = limit.theory;
    }
  }
  return out;
}

std::string stability_sentence(const Results& results, const SceneCard& scene) {
  std::size_t with_theory = 0, agree = 0;
  double farthest = 0;
  std::string worst;
  for (const StabilityLimit& l : stability_limits(results.stability, scene)) {
    if (!std::isfinite(l.beside_theory()) || !std::isfinite(l.theory) || l.theory <= 0) continue;
    ++with_theory;
    const double off = std::abs(l.beside_theory() / l.theory - 1);
    if (off <= 0.02) ++agree;
    if (off >= farthest) farthest = off, worst = l.solver;
  }
  if (with_theory == 0) return "No solver here has both a measured limit and one from theory.";
  return fmt::format("{} of {} {} with linear theory within 2 %; farthest off is {}, by {} %.", agree,
                     pretty_count(with_theory, "measured limit"), agree == 1 ? "agrees" : "agree", worst,
                     pretty_number(100 * farthest));
}

CsvTable telling_rows(const Results& results, const SceneCard& scene, const CsvTable& table,
                      std::size_t most_solvers) {
  std::vector<std::size_t> rows = Results::rows_of(table, scene.id);
  const std::vector<std::string> solvers = results.solvers_in(table, scene.id);
  if (solvers.size() <= most_solvers) return table.selection(rows);
  const Quantity quantity = results.quantity_of(results.work_precision, scene.id);
  std::map<std::string, double> least;  // error
  for (const std::size_t i : Results::rows_of(results.work_precision, scene.id)) {
    const double error = results.work_precision.number(i, quantity.column);
    if (!std::isfinite(error)) continue;
    const auto [found, is_new] = least.emplace(results.work_precision.text(i, "solver"), error);
    if (!is_new) found->second = std::min(found->second, error);
  }
  // Best first: by cost where the level is reached, then by least error, then in the order of the registry.
  std::vector<std::string> order;
  if (const auto level = telling_level(results, scene, "time_min_s"))
    for (const Cost& c : ranking(results, scene, "time_min_s", *level)) order.push_back(c.solver);
  std::vector<std::pair<double, std::string>> by_error;
  for (const auto& [solver, error] : least) by_error.emplace_back(error, solver);
  std::stable_sort(by_error.begin(), by_error.end());
  for (const auto& [error, solver] : by_error) order.push_back(solver);
  order.insert(order.end(), solvers.begin(), solvers.end());
  std::set<std::string> here(solvers.begin(), solvers.end()), families, chosen;
  for (const std::string& solver : order)
    if (here.count(solver) && families.insert(results.family_of(solver)).second) chosen.insert(solver);
  std::erase_if(rows, [&](std::size_t i) { return !chosen.count(table.text(i, "solver")); });
  return table.selection(rows);
}

std::string summary_sentence(const Results& results) {
  if (results.solvers.empty()) return "This folder holds no runs.";
  std::string text = fmt::format("{} on {}: how wrong, how stable, how expensive?",
                                 pretty_count(results.solvers.size(), "solver"),
                                 pretty_count(results.scenes.size(), "scene"));
  std::map<std::string, int> wins;
  int scenes = 0;
  for (const SceneCard& scene : results.scenes) {
    const Quantity q = results.quantity_of(results.work_precision, scene.id);
    if (below_floor(scene, q, 1e-8)) continue;
    const auto order = ranking(results, scene, "time_min_s", 1e-8);
    if (order.empty()) continue;
    ++scenes;
    ++wins[order.front().solver];
  }
  if (scenes == 0) return text;
  const auto best = std::max_element(wins.begin(), wins.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  return text + fmt::format(" At an error of 10⁻⁸, {} is cheapest on {} of {}.", best->first, best->second,
                            pretty_count(static_cast<std::size_t>(scenes), "scene"));
}

}  // namespace polhode::report
