// `show`: a scene as it is understood.
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

std::string numbers(const Vec3& v) { return fmt::format("({}, {}, {})", v.x(), v.y(), v.z()); }
std::string numbers(const Quaternion& q) {
  return fmt::format("({}, {}, {}, {})", q.w(), q.x(), q.y(), q.z());
}
nlohmann::ordered_json array(const Vec3& v) { return {v.x(), v.y(), v.z()}; }
nlohmann::ordered_json array(const Quaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

std::vector<std::string> load_names(const Scene& scene) {
  std::vector<std::string> names;
  if (scene.translation && scene.translation->acceleration.norm() > 0) names.emplace_back("gravity");
  if (scene.translation && scene.translation->drag > 0) names.emplace_back("linear_drag");
  if (scene.rotation)
    for (const auto& l : scene.rotation->loads)
      names.emplace_back(std::visit([](const auto& x) { return x.type; }, l));
  return names;
}

}  // namespace

int show_verb(const Options& options) {
  if (options.scenes.size() != 1) throw UsageError("show needs one scene; 'polhode list scenes' shows all");
  const Scene s = asked_scene(options, options.scenes.front());
  const auto truth = truth_of(s, uniform_times(s.duration, 16), options);
  const Floor& floor = truth->floor();
  progress(options, "");
  const auto loads = load_names(s);
  if (options.json) {
    nlohmann::ordered_json j{{"id", s.id},
                             {"title", s.title},
                             {"source", s.source},
                             {"file", s.file.string()},
                             {"duration_s", s.duration},
                             {"unknowns", s.unknowns},
                             {"left_out", s.left_out},
                             {"notes", s.notes},
                             {"loads", loads}};
    if (s.rotation)
      j["rotation"] = {{"principal_moments_kg_m2", array(s.rotation->moments)},
                       {"principal_to_user", array(s.rotation->principal_to_user)},
                       {"about_pivot", s.rotation->about_pivot},
                       {"attitude", s.rotation->attitude},
                       {"q0_principal", array(s.rotation->q0)},
                       {"w0_principal_rad_per_s", array(s.rotation->w0)}};
    if (s.translation)
      j["translation"] = {{"mass_kg", s.translation->mass},
                          {"p0_m", array(s.translation->p0)},
                          {"v0_m_per_s", array(s.translation->v0)},
                          {"acceleration_m_per_s2", array(s.translation->acceleration)},
                          {"drag_kg_per_s", s.translation->drag}};
    const auto known = [&truth](const nlohmann::ordered_json& value) {
      return truth->is_known() ? value : nlohmann::ordered_json();
    };
    j["truth"] = {{"kind", known(truth->truth.kind)},
                  {"refusal", truth->is_known() ? nlohmann::ordered_json()
                                                : nlohmann::ordered_json(truth->truth.refusal)},
                  {"attitude_uncertainty_rad", known(truth->truth.attitude_uncertainty)},
                  {"rate_uncertainty_rel", known(truth->truth.rate_uncertainty)},
                  {"cost_s", known(truth->truth.cost_s)},
                  {"conditioning", floor.conditioning},
                  {"attitude_floor_rad", known(floor.attitude)},
                  {"rate_floor_rel", known(floor.rate)}};
    write_stdout(j.dump(2) + "\n");
    return 0;
  }
  std::string out = fmt::format("{}: {}\n", s.id, s.title);
  const auto line = [&out](std::string_view name, const std::string& value) {
    out += fmt::format("  {:<22} {}\n", name, value);
  };
  if (!s.source.empty()) line("source", s.source);
  line("file", s.file.string());
  line("duration", fmt::format("{} s", s.duration));
  if (s.rotation) {
    const RotationData& r = *s.rotation;
    line(r.about_pivot ? "moments about pivot" : "principal moments", numbers(r.moments) + " kg m^2");
    if (r.principal_to_user.vec().norm() > 0)
      line("principal axes", "turned by q = " + numbers(r.principal_to_user) + " from the body axes given");
    if (r.attitude) line("attitude at start", numbers(r.q0) + " (w, x, y, z), principal axes");
    line("angular velocity", numbers(r.w0) + " rad/s, principal axes");
    const Vec3 L = r.moments.cwiseProduct(r.w0);
    line("energy of rotation", fmt::format("{} J", 0.5 * L.dot(r.w0)));
    line("angular momentum", fmt::format("{} kg m^2/s", L.norm()));
  }
  if (s.translation) {
    line("mass", fmt::format("{} kg", s.translation->mass));
    line("position, velocity", numbers(s.translation->p0) + " m, " + numbers(s.translation->v0) + " m/s");
  }
  std::string all;
  for (const std::string& l : loads) all += (all.empty() ? "" : ", ") + l;
  line("loads", all.empty() ? "none" : all);
  line("unknowns", std::to_string(s.unknowns));
  for (std::size_t i = 0; i < s.left_out.size(); ++i) line(i ? "" : "left out", s.left_out[i]);
  for (const std::string& note : s.notes) line("note", note);
  line("truth", truth->is_known() ? truth->truth.kind : "none: " + truth->truth.refusal);
  if (s.rotation && truth->is_known()) {
    line("  certain to", s.rotation->attitude
                             ? fmt::format("{:.1e} rad, rates {:.1e}", truth->truth.attitude_uncertainty,
                                           truth->truth.rate_uncertainty)
                             : fmt::format("rates {:.1e}", truth->truth.rate_uncertainty));
    line("  cost", fmt::format("{:.3g} s for 17 times", truth->truth.cost_s));
    line("conditioning",
         std::isfinite(floor.conditioning)
             ? fmt::format("{:.3g} times a relative change of the initial rates", floor.conditioning)
             : "not known: too long or too stiff to follow disturbances");
    line("rounding floor", s.rotation->attitude
                               ? fmt::format("{:.1e} rad, rates {:.1e}", floor.attitude, floor.rate)
                               : fmt::format("rates {:.1e}", floor.rate));
  }
  write_stdout(out);
  return 0;
}

}  // namespace polhode
