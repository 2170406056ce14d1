// The page of a result folder: what was asked, the verdict, the evidence scene by scene, what failed, where
// it is from.
#include "reports/page.hpp"

#include <cmath>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/findings.hpp"
#include "reports/page_tables.hpp"
#include "reports/words.hpp"

namespace polhode::report {
namespace {

void flatten(const nlohmann::ordered_json& value, const std::string& name, Provenance& out) {
  const auto below = [&](const std::string& key) { return name.empty() ? key : name + " " + key; };
  if (value.is_object()) {
    for (const auto& [key, item] : value.items()) flatten(item, below(key), out);
  } else if (value.is_array() && !value.empty() && value.front().is_structured()) {
    for (const auto& item : value) {
      // A list of things with ids reads better under those ids than under numbers.
      if (item.is_object() && item.contains("id") && item["id"].is_string()) {
        std::string text;
        for (const auto& [key, part] : item.items())
          if (key != "id" && !part.is_null())
            text += (text.empty() ? "" : ", ") + key + " " +
                    (part.is_string() ? part.get<std::string>() : part.dump());
        out.emplace_back(below(item["id"].get<std::string>()), text);
      } else {
        out.emplace_back(name, item.dump());
      }
    }
  } else if (value.is_array()) {
    std::string text;
    for (const auto& item : value)
      text += (text.empty() ? "" : ", ") + (item.is_string() ? item.get<std::string>() : item.dump());
    out.emplace_back(name, text);
  } else if (!value.is_null()) {
    out.emplace_back(name, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

std::string sentence_of(const Results& r, const SceneCard& scene, const Figure& f) {
  switch (f.kind) {
    case Figure::Kind::work:
      return work_sentence(r, scene);
    case Figure::Kind::evaluations:
      return evaluations_sentence(r, scene);
    case Figure::Kind::convergence:
      return orders_sentence(r, scene);
    case Figure::Kind::energy_drift:
      return r.drift_quantity_is_total(scene.id)
                 ? drift_sentence(r, scene, "total_energy_drift_rel", "energy")
                 : drift_sentence(r, scene, "rotational_energy_drift_rel", "rotational energy");
    case Figure::Kind::momentum_drift:
      return drift_sentence(r, scene, "momentum_drift_rel", "angular momentum");
    case Figure::Kind::stability:
      return stability_sentence(r, scene);
  }
  return {};
}

std::string_view how_to_read(Figure::Kind kind) {
  switch (kind) {
    case Figure::Kind::work:
    case Figure::Kind::evaluations:
      return "Lower left is better. Hollow marks: rounding decides the error, so nobody is ranked there.";
    case Figure::Kind::convergence:
      return "The slope of a line is the order of the solver. Dotted: slopes 1, 2 and 4.";
    case Figure::Kind::energy_drift:
    case Figure::Kind::momentum_drift:
      return "Flat is bounded, slope ½ a random walk, slope 1 a secular drift.";
    case Figure::Kind::stability:
      return "Marks: measured. Dashed: linear theory.";
  }
  return {};
}

std::string figure_html(const Results& r, const SceneCard& scene, const Figure& f, bool drawn) {
  const std::string sentence = escape_html(sentence_of(r, scene, f));
  const std::string caption = fmt::format("<figcaption>{}<small>{} ", sentence, how_to_read(f.kind));
  if (!drawn)
    return fmt::format(
        "<figure>{}Not drawn: <code>gnuplot figures/{}.gp</code> in this folder draws it.</small>"
        "</figcaption></figure>\n",
        caption, f.name);
  return fmt::format(
      "<figure><div class=\"scroll\"><img src=\"figures/{0}.svg\" width=\"{1}\" height=\"{2}\" "
      "loading=\"lazy\" alt=\"{3}. "
      "{4}\"></div>{5}<a href=\"figures/{0}.svg\">SVG</a> · <a href=\"figures/{0}.pdf\">PDF</a> · "
      "<a href=\"figures/{0}.gp\">script</a></small></figcaption></figure>\n",
      f.name, f.width, f.height, escape_html(f.title), sentence, caption);
}

std::string fact(std::string_view name, const std::string& value) {
  if (value.empty()) return {};
  return fmt::format("<div><dt>{}</dt><dd>{}</dd></div>", name, escape_html(value));
}

std::string scene_html(const Results& r, const SceneCard& scene, const std::vector<Figure>& figures,
                       const std::set<std::string>& drawn) {
  std::string out = fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n", scene.file, escape_html(scene.name()));
  const auto with_unit = [](double x, const char* unit) {
    return std::isfinite(x) ? fmt::format("{} {}", pretty_number(x), unit) : std::string();
  };
  out += "<dl class=\"facts\">" + fact("scene", scene.id) + fact("duration", with_unit(scene.duration, "s")) +
         fact("unknowns", scene.unknowns) + fact("left out", scene.left_out) + fact("truth", scene.truth) +
         fact("truth known to", with_unit(scene.truth_uncertainty, "rad")) +
         fact("rounding floor", with_unit(scene.floor, "rad")) + "</dl>\n";
  using Kind = Figure::Kind;
  const auto draw = [&](std::initializer_list<Kind> kinds) {
    std::string html;
    for (const Figure& f : figures)
      for (const Kind k : kinds)
        if (f.kind == k && f.scene == scene.id) html += figure_html(r, scene, f, drawn.count(f.name) > 0);
    return html;
  };
  const auto block = [&](std::string_view title, const std::string& figure, std::string_view table_title,
                         const std::string& table, bool open) {
    if (figure.empty() && table.empty()) return;
    out += fmt::format("<h3>{}</h3>\n{}", title, figure);
    if (!table.empty())
      out += fmt::format("<details{}><summary>{}</summary>\n{}</details>\n", open ? " open" : "", table_title,
                         table);
  };
  block("Accuracy and cost", draw({Kind::work, Kind::evaluations}), "Every solver: time to an error",
        cost_table(r, scene), false);
  block("Convergence", draw({Kind::convergence}), "Observed and claimed orders", orders_table(r, scene),
        false);
  block("Drift", draw({Kind::energy_drift, Kind::momentum_drift}), "Classes of drift", drift_table(r, scene),
        false);
  block("Stability", draw({Kind::stability}), "Largest stable steps", stability_table(r, scene), false);
  return out + "</section>\n";
}

}  // namespace

Provenance read_provenance(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "run.json";
  if (!std::filesystem::exists(path)) return {};
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot read " + path.string());
  const auto json = nlohmann::ordered_json::parse(file, nullptr, false);
  if (json.is_discarded()) return {{"run.json", "is not JSON"}};
  Provenance out;
  flatten(json, "", out);
  return out;
}

std::string page(const Results& r, const std::vector<Figure>& figures, const std::set<std::string>& drawn,
                 const Provenance& provenance, const std::vector<std::string>& notes) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"generator\" content=\"polhode\">\n<title>polhode: how wrong, how stable, how "
      "expensive?</title>\n";
  out += fmt::format("<style>{}</style>\n</head>\n<body>\n<header>\n", style_sheet());
  out += fmt::format("<h1>Integrators on spinning bodies</h1>\n<p class=\"lead\">{}</p>\n",
                     escape_html(summary_sentence(r)));
  std::string where;
  for (const char* key : {"cpu", "date", "version"})
    for (const auto& [name, value] : provenance)
      if (name == key)
        where += (where.empty() ? "" : " · ") + (name == "version" ? "polhode " + value : value);
  if (!where.empty()) out += fmt::format("<p class=\"soft\">{}</p>\n", escape_html(where));

  out += "<nav>";
  for (const SceneCard& scene : r.scenes)
    out += fmt::format("<a href=\"#{}\">{}</a>", scene.file, escape_html(scene.name()));
  out += "</nav>\n</header>\n<main>\n";
  for (const std::string& note : notes) out += fmt::format("<p class=\"note\">{}</p>\n", escape_html(note));

  const std::string verdict = verdict_table(r);
  if (!verdict.empty())
    out +=
        "<section>\n<h2>Verdict</h2>\n<p>Which solver reaches an error with the least run time. The error is "
        "the "
        "largest over the sample times; between two measured runs the time is interpolated in "
        "logarithms.</p>\n" +
        verdict + "</section>\n";
  for (const SceneCard& scene : r.scenes) out += scene_html(r, scene, figures, drawn);
  if (r.solvers.empty())
    out +=
        "<section><h2>No results</h2><p>The tables of this folder are empty or missing: no run has been "
        "kept.</p>"
        "</section>\n";
  const std::string failures = failures_table(r);
  if (!failures.empty())
    out +=
        "<section id=\"outcomes-not-ok\">\n<h2>Runs that did not end well</h2>\n<p>They are part of the "
        "result. A solver that does "
        "not apply to a scene is unsupported there.</p>\n<details open><summary>Outcomes</summary>\n" +
        failures + "</details>\n</section>\n";
  else if (!r.solvers.empty())
    out += "<p>No run failed.</p>\n";
  if (const std::string solvers = solvers_table(r); !solvers.empty())
    out += "<section id=\"all-solvers\">\n<h2>Solvers</h2>\n<details><summary>All " +
           std::to_string(r.solver_table.rows()) + " of them, with their precision and mode</summary>\n" +
           solvers + "</details>\n</section>\n";
  out += "</main>\n<footer>\n<h2>Where this comes from</h2>\n";
  if (!r.files.empty()) {
    out += "<p>Data: ";
    for (std::size_t i = 0; i < r.files.size(); ++i)
      out += fmt::format("{}<a href=\"{}\">{}</a>", i ? " · " : "", r.files[i], r.files[i]);
    out += "</p>\n";
  }
  if (provenance.empty()) {
    out += "<p>This folder has no run.json, so nothing is known about the machine and the versions.</p>\n";
  } else {
    out += "<dl>";
    for (const auto& [name, value] : provenance)
      out += fmt::format("<dt>{}</dt><dd>{}</dd>", escape_html(name), escape_html(value));
    out += "</dl>\n";
  }
  return out + "</footer>\n</body>\n</html>\n";
}

}  // namespace polhode::report
