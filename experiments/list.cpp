// `list`: what there is, from the registries.
#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

const char* claim_text(Claim c) { return c == Claim::yes ? "yes" : c == Claim::no ? "no" : "unknown"; }
std::string order_text(double order) { return order >= 0 ? shortest(order) : "-"; }

nlohmann::ordered_json method_json(const Method& m) {
  const Claims& c = m.claims;
  const auto order = [](double o) {
    return o >= 0 ? nlohmann::ordered_json(o) : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json knobs = nlohmann::ordered_json::array();
  if (m.by_steps) knobs.push_back("steps");
  if (m.by_tolerance) knobs.push_back("rtol");
  return {{"id", m.id},
          {"family", m.family},
          {"knob", name_of(m.default_knob())},
          {"knobs", knobs},
          {"order", order(c.attitude_order)},
          {"summary", m.summary},
          {"source", m.source},
          {"version", m.version},
          {"settings", m.settings},
          {"precision", precision_of(m)},
          {"claims",
           {{"attitude_order", order(c.attitude_order)},
            {"rate_order", order(c.rate_order)},
            {"energy_order", order(c.energy_order)},
            {"momentum_order", order(c.momentum_order)},
            {"attitude_order_timed", order(c.with_time(true).attitude_order)},
            {"unit_attitude", claim_text(c.unit_attitude)},
            {"momentum_magnitude", claim_text(c.momentum_magnitude)},
            {"space_momentum", claim_text(c.space_momentum)},
            {"energy_bounded", claim_text(c.energy_bounded)},
            {"reversible", claim_text(c.reversible)}}},
          {"available", true},
          {"missing", nullptr}};
}

std::string list_solvers(const Options& options) {
  std::vector<const Method*> methods =
      options.solvers.empty() ? all_methods() : select_methods(options.solvers);
  if (options.json) {
    nlohmann::ordered_json j = nlohmann::ordered_json::array();
    for (const Method* m : methods) j.push_back(method_json(*m));
    for (const EngineStatus& e : all_engines())
      if (!e.available)
        j.push_back({{"id", e.id},
                     {"family", "engine"},
                     {"knob", "steps"},
                     {"order", nullptr},
                     {"summary", e.summary},
                     {"source", e.package},
                     {"claims", nullptr},
                     {"available", false},
                     {"missing", e.missing}});
    return j.dump(2) + "\n";
  }
  std::size_t id_width = 0, family_width = 0;
  for (const Method* m : methods) {
    id_width = std::max(id_width, m->id.size());
    family_width = std::max(family_width, m->family.size());
  }
  const auto line = [&](auto id, auto family, auto knob, auto orders, auto unit, auto summary) {
    return fmt::format("{:<{}}  {:<{}}  {:<11}  {:<7}  {:<8}  {}\n", id, id_width, family, family_width, knob,
                       orders, unit, summary);
  };
  // The other claims are in --json.
  std::string out = line("solver", "family", "knob", "order", "unit |q|", "what it does");
  for (const Method* m : methods) {
    const Claims& c = m->claims;
    out += line(m->id, m->family, m->by_steps && m->by_tolerance ? "rtol, steps" : name_of(m->default_knob()),
                fmt::format("{} {} {} {}", order_text(c.attitude_order), order_text(c.rate_order),
                            order_text(c.energy_order), order_text(c.momentum_order)),
                claim_text(c.unit_attitude), m->summary);
  }
  for (const EngineStatus& e : all_engines())
    if (!e.available) out += fmt::format("{:<{}}  {}\n", e.id + "-*", id_width, e.missing);
  out +=
      "\norder: of attitude, rates, energy and momentum in the step size; - : none is claimed; where a load\n"
      "depends on time: the same, unless the last column says otherwise\n";
  return out;
}

std::string list_scenes(const Options& options) {
  nlohmann::ordered_json j = nlohmann::ordered_json::array();
  std::string out = fmt::format("{:<28} {:>8} {:>9}  {}\n", "scene", "unknowns", "duration", "title");
  for (const std::string& id : builtin_scene_ids()) {
    const Scene s = find_scene(id);
    out += fmt::format("{:<28} {:>8} {:>9}  {}\n", id, s.unknowns, shortest(s.duration) + " s", s.title);
    j.push_back({{"id", id},
                 {"title", s.title},
                 {"source", s.source},
                 {"duration_s", s.duration},
                 {"unknowns", s.unknowns},
                 {"file", s.file.string()}});
  }
  return options.json ? j.dump(2) + "\n" : out;
}

/// "  ids" and, below, the settings that these rows share; rows in the order of the registry.
std::string settings_text(const std::vector<const Method*>& methods) {
  std::string out;
  for (std::size_t i = 0; i < methods.size();) {
    const std::string_view settings = methods[i]->settings;
    std::string ids;
    for (; i < methods.size() && methods[i]->settings == settings; ++i)
      ids += (ids.empty() ? "" : ", ") + std::string(methods[i]->id);
    out += fmt::format("  {}\n    {}\n", ids, settings);
  }
  return out;
}

std::string list_engines(const Options& options) {
  nlohmann::ordered_json j = nlohmann::ordered_json::array();
  std::string out =
      fmt::format("{:<11} {:<10} {:<14} {}\n", "engine", "available", "version", "what, and what is set");
  for (const EngineStatus& e : all_engines()) {
    const std::string version(e.available && !e.methods.empty() ? e.methods.front()->version : "");
    out += fmt::format("{:<11} {:<10} {:<14} {}\n", e.id, e.available ? "yes" : "no", version,
                       e.available ? e.summary : e.missing);
    nlohmann::ordered_json solvers = nlohmann::ordered_json::array(), settings;
    for (const Method* m : e.methods) {
      solvers.push_back(m->id);
      settings[std::string(m->id)] = m->settings;
    }
    out += settings_text(e.methods);
    j.push_back(
        {{"id", e.id},
         {"summary", e.summary},
         {"package", e.package},
         {"version", version},
         {"available", e.available},
         {"missing", e.available ? nlohmann::ordered_json(nullptr) : nlohmann::ordered_json(e.missing)},
         {"solvers", solvers},
         {"settings", settings}});
  }
  return options.json ? j.dump(2) + "\n" : out;
}

}  // namespace

int list_verb(const Options& options) {
  if (options.scenes.size() != 1) throw UsageError("list needs one of: scenes, solvers, engines");
  const std::string& what = options.scenes.front();
  if (what == "solvers")
    write_stdout(list_solvers(options));
  else if (what == "scenes")
    write_stdout(list_scenes(options));
  else if (what == "engines")
    write_stdout(list_engines(options));
  else
    throw UsageError("list: got '" + what + "', needs one of: scenes, solvers, engines");
  return 0;
}

}  // namespace polhode
