// Fills the page: tables, sentences and looks become one packed text that the scripts of the page read.
#include "reports/page.hpp"

#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "reports/findings.hpp"
#include "reports/pack.hpp"
#include "reports/stability_map.hpp"

namespace polhode::report {
namespace {

// More digits than a chart shows or an error means; the files of the folder have all.
constexpr int digits = 5;

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) throw std::runtime_error("cannot read " + path.string());
  return text.str();
}

void flatten(const nlohmann::ordered_json& value, const std::string& name, Provenance& out) {
  const auto below = [&](const std::string& key) { return name.empty() ? key : name + " " + key; };
  if (value.is_object()) {
    for (const auto& [key, item] : value.items()) flatten(item, below(key), out);
  } else if (value.is_array() && !value.empty() && value.front().is_structured()) {
    // A list of things with ids reads better under those ids than under numbers.
    for (const auto& item : value) {
      const char* key_of_item = item.contains("id") ? "id" : "scene";
      if (!item.is_object() || !item.contains(key_of_item) || !item[key_of_item].is_string()) {
        out.emplace_back(name, item.dump());
        continue;
      }
      std::string text;
      for (const auto& [key, part] : item.items())
        if (key != key_of_item && !part.is_null())
          text += (text.empty() ? "" : ", ") + key + " " +
                  (part.is_string() ? part.get<std::string>() : part.dump());
      out.emplace_back(below(item[key_of_item].get<std::string>()), text);
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

nlohmann::ordered_json sentences_of(const Results& r, const SceneCard& scene) {
  nlohmann::ordered_json out = nlohmann::ordered_json::object();
  const auto say = [&](const char* about, const CsvTable& table, const std::string& sentence) {
    if (!Results::rows_of(table, scene.id).empty()) out[about] = sentence;
  };
  say("time_min_s", r.work_precision, work_sentence(r, scene));
  say("rhs_evals", r.work_precision, evaluations_sentence(r, scene));
  say("orders", r.orders, orders_sentence(r, scene));
  say("rotational_energy", r.drift,
      drift_sentence(r, scene, "rotational_energy_drift_rel", "rotational energy"));
  say("total_energy", r.drift, drift_sentence(r, scene, "total_energy_drift_rel", "energy"));
  say("momentum", r.drift, drift_sentence(r, scene, "momentum_drift_rel", "angular momentum"));
  say("stability", r.stability, stability_sentence(r, scene));
  return out;
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

std::string page_data(const Results& r, const std::filesystem::path& folder,
                      const std::vector<std::pair<Figure, std::string>>& drawn, const Provenance& provenance,
                      const std::vector<std::string>& notes) {
  nlohmann::ordered_json data;
  data["summary"] = summary_sentence(r);
  data["notes"] = notes;
  data["missing_packages"] = page_missing_packages;
  for (const SceneCard& scene : r.scenes)
    data["scenes"].push_back({{"id", scene.id}, {"title", scene.title}, {"says", sentences_of(r, scene)}});
  for (const auto& [solver, map] : stability_maps(r.stability_map))
    data["map_says"][solver] = map_sentence(map);
  for (const auto& [solver, mark] : r.marks) data["looks"][solver] = {mark.colour, mark.filled, mark.dash};
  for (const auto& [name, value] : provenance) data["provenance"].push_back({name, value});
  for (const auto& [figure, svg] : drawn)
    data["figures"].push_back(
        {{"kind", figure.kind}, {"scene", figure.scene}, {"title", figure.title}, {"svg", svg}});
  for (const std::string& file : r.files) data["tables"][file] = rounded_csv(text_of(folder / file), digits);
  return data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::string page(std::string_view data) {
  constexpr std::string_view mark = "{{data}}";
  const auto place = page_template.find(mark);
  std::string out(page_template.substr(0, place));
  out += packed(data);
  out += page_template.substr(place + mark.size());
  return out;
}

}  // namespace polhode::report
