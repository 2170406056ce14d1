// The tables of the page.
#include "reports/page_tables.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "reports/findings.hpp"
#include "reports/words.hpp"

namespace polhode::report {
namespace {

std::string id_html(std::string_view solver) {
  return fmt::format("<span class=\"id\">{}</span>", escape_html(solver));
}

std::string badge(std::string_view look, std::string_view text) {
  return fmt::format("<span class=\"badge {}\">{}</span>", look, escape_html(text));
}

std::string table_html(const std::string& head, const std::string& body) {
  if (body.empty()) return {};
  return fmt::format(
      "<div class=\"wrap\"><table><thead><tr>{}</tr></thead>\n<tbody>\n{}</tbody></table></div>\n", head,
      body);
}

std::string cells(const std::vector<std::string>& texts, std::string_view look) {
  std::string out;
  for (const std::string& t : texts) out += fmt::format("<td{}>{}</td>", look, t.empty() ? "–" : t);
  return out;
}

/// `random_walk` reads as `random walk`.
std::string spaced(std::string text) {
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

std::string_view look_of_class(std::string_view drift_class) {
  if (drift_class == "bounded") return "good";
  if (drift_class == "random_walk") return "fair";
  if (drift_class == "linear") return "poor";
  if (drift_class == "unsupported") return "";
  return "bad";
}

bool failed(const std::string& outcome) { return !outcome.empty() && outcome != "ok"; }

/// Settings of one failed kind, `steps 50, 100, …, 51200`: all if they are few, the name of the knob once.
std::string listed(const std::vector<std::string>& settings) {
  std::string out, last_name;
  for (std::size_t i = 0; i < settings.size(); ++i) {
    if (settings.size() > 8 && i == 3) {
      out += ", …";
      i = settings.size() - 1;
    }
    const auto space = settings[i].find(' ');
    const std::string name = settings[i].substr(0, space);
    out += (i ? ", " : "") +
           (name == last_name && space != std::string::npos ? settings[i].substr(space + 1) : settings[i]);
    last_name = name;
  }
  return out;
}

std::string pretty_setting(const CsvTable& t, std::size_t row, std::string_view column) {
  const double value = t.number(row, column);
  return std::isfinite(value) ? pretty_number(value) : t.text(row, column);
}

}  // namespace

std::string verdict_table(const Results& r) {
  std::string body;
  for (const SceneCard& scene : r.scenes) {
    const auto rows = Results::rows_of(r.work_precision, scene.id);
    if (rows.empty()) continue;
    const Quantity quantity = r.quantity_of(r.work_precision, scene.id);
    body += fmt::format("<tr><th scope=\"row\"><a href=\"#{}\">{}</a><small>{}</small></th>", scene.file,
                        escape_html(scene.name()), quantity.name);
    for (const double level : {1e-4, 1e-8}) {
      const auto order = ranking(r, scene, "time_min_s", level);
      if (below_floor(scene, quantity, level)) {
        body += "<td>–<small>below the rounding floor</small></td>";
      } else if (order.empty()) {
        body += "<td>–<small>reached by none</small></td>";
      } else {
        std::string then = "alone";
        if (order.size() > 1)
          then = fmt::format("then {}, {} × that", escape_html(order[1].solver),
                             pretty_factor(order[1].cost / order[0].cost));
        body += fmt::format("<td>{} <strong>{}</strong><small>{}</small></td>", id_html(order[0].solver),
                            pretty_time(order[0].cost), then);
      }
    }
    std::size_t bad = 0;
    for (const std::size_t i : rows) bad += failed(r.work_precision.text(i, "outcome"));
    body += fmt::format("<td class=\"n\">{} of {}</td></tr>\n", bad, rows.size());
  }
  return table_html(
      "<th>Scene</th><th>Cheapest at 10⁻⁴</th><th>Cheapest at 10⁻⁸</th><th class=\"n\">Runs not ok</th>",
      body);
}

std::string cost_table(const Results& r, const SceneCard& scene) {
  const CsvTable& t = r.work_precision;
  const Quantity quantity = r.quantity_of(t, scene.id);
  constexpr std::array levels = {1e-2, 1e-4, 1e-8};
  std::map<std::string, std::array<double, 3>> times;
  for (const std::string& s : r.solvers) times[s].fill(std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < levels.size(); ++k)
    for (const Cost& c : ranking(r, scene, "time_min_s", levels[k])) times[c.solver][k] = c.cost;
  std::map<std::string, double> least;
  for (const std::size_t i : Results::rows_of(t, scene.id)) {
    const double error = t.number(i, quantity.column);
    if (!std::isfinite(error)) continue;
    const auto [found, is_new] = least.emplace(t.text(i, "solver"), error);
    if (!is_new) found->second = std::min(found->second, error);
  }
  std::vector<std::string> order = r.solvers_in(t, scene.id);
  // Whoever reaches the smallest level first, then by the least error.
  std::stable_sort(order.begin(), order.end(), [&](const std::string& a, const std::string& b) {
    for (std::size_t k = levels.size(); k-- > 0;) {
      const double x = times[a][k], y = times[b][k];
      if (std::isfinite(x) != std::isfinite(y)) return std::isfinite(x);
      if (std::isfinite(x) && x != y) return x < y;
    }
    return least.count(a) && (!least.count(b) || least[a] < least[b]);
  });
  std::string body;
  for (const std::string& s : order) {
    std::vector<std::string> texts;
    for (std::size_t k = 0; k < levels.size(); ++k)
      texts.push_back(below_floor(scene, quantity, levels[k]) ? "below floor" : pretty_time(times[s][k]));
    texts.push_back(least.count(s) ? quantity.with_unit(pretty_number(least[s])) : "no run was ok");
    body += fmt::format("<tr><th scope=\"row\">{}</th>{}</tr>\n", id_html(s), cells(texts, " class=\"n\""));
  }
  return table_html(
      "<th>Solver</th><th class=\"n\">Time to 10⁻²</th><th class=\"n\">to 10⁻⁴</th><th class=\"n\">to "
      "10⁻⁸</th>"
      "<th class=\"n\">Least error</th>",
      body);
}

namespace {

/// A table whose rows are solvers and whose columns are the quantities in order of appearance.
template <typename KeyOf, typename CellOf>
std::string pivot(const CsvTable& t, const std::vector<std::size_t>& rows, KeyOf key_of, CellOf cell_of) {
  std::vector<std::string> keys, quantities;
  std::map<std::pair<std::string, std::string>, std::string> values;
  const auto note = [](std::vector<std::string>& list, const std::string& value) {
    if (std::find(list.begin(), list.end(), value) == list.end()) list.push_back(value);
  };
  for (const std::size_t i : rows) {
    const std::string key = key_of(i);
    note(keys, key);
    note(quantities, t.text(i, "quantity"));
    values[{key, t.text(i, "quantity")}] = cell_of(i);
  }
  std::string head = "<th>Solver</th>", body;
  for (const std::string& q : quantities) head += fmt::format("<th>{}</th>", escape_html(spaced(q)));
  for (const std::string& key : keys) {
    body += fmt::format("<tr><th scope=\"row\">{}</th>", key);
    for (const std::string& q : quantities) {
      const auto found = values.find({key, q});
      body +=
          fmt::format("<td>{}</td>", found == values.end() || found->second.empty() ? "–" : found->second);
    }
    body += "</tr>\n";
  }
  return table_html(head, body);
}

}  // namespace

std::string orders_table(const Results& r, const SceneCard& scene) {
  const CsvTable& t = r.orders;
  return pivot(
      t, Results::rows_of(t, scene.id), [&](std::size_t i) { return id_html(t.text(i, "solver")); },
      [&](std::size_t i) {
        const double claimed = t.number(i, "claimed"), order = t.number(i, "order"),
                     error = t.number(i, "order_error");
        const std::string claim = std::isfinite(claimed)
                                      ? "<small>claimed " + pretty_number(claimed) + "</small>"
                                      : "<small>no claim</small>";
        if (!std::isfinite(order)) return "–" + claim;
        std::string text = fmt::format("{:.2f}", order);
        if (std::isfinite(error)) text += fmt::format(" ± {:.2g}", error);
        // An order above the claim is a surprise, one below it a failure.
        std::string_view look;
        if (std::isfinite(claimed))
          look = order_met(claimed, order, error) ? "good" : order > claimed ? "fair" : "bad";
        return badge(look, text) + claim;
      });
}

std::string drift_table(const Results& r, const SceneCard& scene) {
  const CsvTable& t = r.drift_verdict;
  return pivot(
      t, Results::rows_of(t, scene.id),
      [&](std::size_t i) {
        std::string key = id_html(t.text(i, "solver"));
        if (!t.text(i, "knob_value").empty())
          key += fmt::format(" <small>{} {}</small>", escape_html(t.text(i, "knob")),
                             escape_html(pretty_setting(t, i, "knob_value")));
        return key;
      },
      [&](std::size_t i) {
        const std::string& drift_class = t.text(i, "class");
        std::string text = badge(look_of_class(drift_class), spaced(drift_class));
        std::string more;
        if (const double e = t.number(i, "exponent"); std::isfinite(e))
          more = drift_class == "exponential" ? "rate " + pretty_number(e) + "/s"
                                              : "exponent " + pretty_number(e);
        if (const double m = t.number(i, "max_abs"); std::isfinite(m))
          more += (more.empty() ? "up to " : ", up to ") + pretty_number(m);
        if (!more.empty()) text += "<small>" + more + "</small>";
        return text;
      });
}

std::string stability_table(const Results& r, const SceneCard& scene) {
  std::string body;
  for (const StabilityLimit& l : stability_limits(r, scene)) {
    const bool both = std::isfinite(l.largest) && l.theory > 0;
    body += fmt::format("<tr><th scope=\"row\">{}</th><td>{} = {}</td>", id_html(l.solver),
                        escape_html(l.parameter), escape_html(l.value));
    body += cells({std::isfinite(l.largest) ? pretty_time(l.largest) : "none found", pretty_time(l.theory),
                   both ? fmt::format("{:.3f}", l.largest / l.theory) : "–"},
                  " class=\"n\"");
    body += "</tr>\n";
  }
  return table_html(
      "<th>Solver</th><th>Parameter</th><th class=\"n\">Largest stable step</th><th class=\"n\">Linear "
      "theory</th>"
      "<th class=\"n\">Ratio</th>",
      body);
}

std::string failures_table(const Results& r) {
  using Key =
      std::tuple<std::string, std::string, std::string, std::string>;  // scene, solver, experiment, outcome
  std::vector<Key> order;
  std::map<Key, std::vector<std::string>> settings;
  const auto note = [&](const CsvTable& t, std::size_t i, const char* experiment, const std::string& outcome,
                        const std::string& setting) {
    const Key key(t.text(i, "scene"), t.text(i, "solver"), experiment, outcome);
    const auto [found, is_new] = settings.try_emplace(key);
    if (is_new) order.push_back(key);
    if (!setting.empty() &&
        std::find(found->second.begin(), found->second.end(), setting) == found->second.end())
      found->second.push_back(setting);
  };
  const auto knob = [](const CsvTable& t, std::size_t i) {
    const std::string value = pretty_setting(t, i, "knob_value");
    return value == "–" || value.empty() ? std::string() : t.text(i, "knob") + " " + value;
  };
  for (std::size_t i = 0; i < r.work_precision.rows(); ++i)
    if (const std::string& o = r.work_precision.text(i, "outcome"); failed(o))
      note(r.work_precision, i, "work-precision", o, knob(r.work_precision, i));
  for (std::size_t i = 0; i < r.convergence.rows(); ++i)
    if (const std::string& o = r.convergence.text(i, "outcome"); failed(o))
      note(
          r.convergence, i, "convergence", o,
          r.convergence.text(i, "steps").empty() ? std::string() : "steps " + r.convergence.text(i, "steps"));
  for (std::size_t i = 0; i < r.drift_verdict.rows(); ++i) {
    const std::string& c = r.drift_verdict.text(i, "class");
    static const std::array<std::string_view, 5> drifts = {"bounded", "random_walk", "linear", "quadratic",
                                                           "exponential"};
    if (!c.empty() && std::find(drifts.begin(), drifts.end(), c) == drifts.end())
      note(r.drift_verdict, i, "drift", c, knob(r.drift_verdict, i));
  }
  // In the search for a limit, steps fail on purpose: only a search that found none is a failure.
  for (std::size_t i = 0; i < r.stability.rows(); ++i)
    if (const std::string& o = r.stability.text(i, "outcome");
        failed(o) && !std::isfinite(r.stability.number(i, "largest_stable_h_s")))
      note(r.stability, i, "stability", o,
           r.stability.text(i, "parameter") + " " + r.stability.text(i, "parameter_value"));
  std::string body;
  for (const Key& key : order) {
    const auto& [scene, solver, experiment, outcome] = key;
    body += fmt::format(
        "<tr><td class=\"id\">{}</td><td>{}</td><td class=\"id\">{}</td><td>{}</td><td>{}</td></tr>\n",
        escape_html(scene), id_html(solver), experiment,
        badge(outcome == "unsupported" ? "" : "bad", spaced(outcome)), escape_html(listed(settings[key])));
  }
  return table_html("<th>Scene</th><th>Solver</th><th>Experiment</th><th>Outcome</th><th>Settings</th>",
                    body);
}

std::string solvers_table(const Results& r) {
  const CsvTable& t = r.solver_table;
  std::string body;
  for (std::size_t i = 0; i < t.rows(); ++i)
    body += fmt::format(
        "<tr><th scope=\"row\">{}</th>{}</tr>\n", id_html(t.text(i, "solver")),
        cells({escape_html(t.text(i, "family")), escape_html(t.text(i, "order")),
               escape_html(t.text(i, "version")),
               escape_html(t.text(i, "summary")) +
                   (t.text(i, "source").empty() ? std::string()
                                                : "<small>" + escape_html(t.text(i, "source")) + "</small>")},
              ""));
  return table_html("<th>Solver</th><th>Family</th><th>Order</th><th>Version</th><th>What it is</th>", body);
}

}  // namespace polhode::report
