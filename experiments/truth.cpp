// Truth cache, conditioning and error norms.
#include "experiments/truth.hpp"

#include <cmath>
#include <limits>
#include <map>
#include <mutex>

#include "experiments/table.hpp"
#include "solvers/floor.hpp"

namespace polhode {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double double_epsilon = std::numeric_limits<double>::epsilon();

std::vector<double> with_zero(std::span<const double> times) {
  std::vector<double> all;
  if (times.empty() || times.front() > 0) all.push_back(0);
  all.insert(all.end(), times.begin(), times.end());
  return all;
}

}  // namespace

std::shared_ptr<const SceneTruth> truth_of(const Scene& scene, std::span<const double> times) {
  static std::mutex guard;
  static std::map<std::string, std::shared_ptr<const SceneTruth>> known;
  const std::vector<double> all = with_zero(times);
  // A scene that was varied (a stiff parameter) differs in its loads, a file in its path.
  std::string key = scene.id + '\n' + scene.file.string() + '\n' + scene.variant + '\n';
  for (const double t : all) key += shortest(t) + ' ';
  const std::lock_guard lock(guard);
  auto& entry = known[key];
  if (!entry) {
    auto t = std::make_shared<SceneTruth>();
    t->truth = reference_solution(scene, all);
    const Floor floor = floor_of(scene, all, t->truth, {});
    t->attitude_growth = floor.attitude_growth;
    t->rate_growth = floor.rate_growth;
    t->conditioning = floor.conditioning;
    t->attitude_floor = floor.attitude;
    t->rate_floor = floor.rate;
    entry = t;
  }
  return entry;
}

double energy_scale(const SceneTruth& truth, bool rotational) {
  const auto of = [&](const WideSample& s) {
    return std::abs((rotational ? s.rotational_energy : s.total_energy).convert_to<double>());
  };
  double scale = of(truth.truth.samples.front());
  if (scale > 0) return scale;
  for (const auto& s : truth.truth.samples) scale = std::max(scale, of(s));
  return scale > 0 ? scale : 1;
}

SampleErrors errors_at(const Scene& scene, const SceneTruth& truth, const Sample& s,
                       const WideSample& exact) {
  SampleErrors e{none, none, none, none, none, none, none, none};
  const auto gap = [](const Vec3& a, const Vec3T<Wide>& b) {
    return Vec3T<Wide>(a.template cast<Wide>() - b).norm().template convert_to<double>();
  };
  const auto relative = [&](double value, const Wide& of_truth, bool rotational) {
    return Wide(Wide(value) - of_truth).convert_to<double>() / energy_scale(truth, rotational);
  };
  e.total_energy = relative(s.total_energy, exact.total_energy, false);
  if (scene.translation) e.position = gap(s.p, exact.p);
  if (!scene.rotation) return e;
  if (scene.rotation->attitude) {
    e.attitude = attitude_error<Wide>(exact.q, s.q.cast<Wide>()).convert_to<double>();
    e.unit_defect = s.unit_defect;
  }
  const double n = exact.w_B.norm().convert_to<double>(), g = gap(s.w_B, exact.w_B);
  e.rate = n > 0 ? g / n : g;
  e.rotational_energy = relative(s.rotational_energy, exact.rotational_energy, true);
  const Vec3 L(exact.L.x().convert_to<double>(), exact.L.y().convert_to<double>(),
               exact.L.z().convert_to<double>());
  double L0 = truth.truth.samples.front().L.norm().convert_to<double>();
  if (!(L0 > 0))
    for (const auto& x : truth.truth.samples) L0 = std::max(L0, x.L.norm().convert_to<double>());
  const double missed = gap(s.L, exact.L);
  e.momentum = L0 > 0 ? missed / L0 : missed;
  e.momentum_direction = std::atan2(s.L.cross(L).norm(), s.L.dot(L));
  return e;
}

Errors errors_of(const Scene& scene, const SceneTruth& truth, std::span<const Sample> samples,
                 std::size_t first, double epsilon) {
  const bool rotates = scene.rotation.has_value(), moves = scene.translation.has_value();
  const bool attitude = rotates && scene.rotation->attitude;
  const bool rotational = rotates && moves;  // free fall must not hide the rotation
  Errors e{attitude ? 0 : none, attitude ? 0 : none, rotates ? 0 : none, 0,
           rotates ? 0 : none,  moves ? 0 : none,    attitude ? 0 : none};
  double position_scale = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const WideSample& exact = truth.truth.samples[first + i];
    const SampleErrors s = errors_at(scene, truth, samples[i], exact);
    if (attitude) {
      e.attitude_end = s.attitude;
      e.attitude_max = std::max(e.attitude_max, s.attitude);
      e.unit_defect_max = std::max(e.unit_defect_max, s.unit_defect);
    }
    if (rotates) {
      e.rate_max = std::max(e.rate_max, s.rate);
      e.momentum_max = std::max(e.momentum_max, s.momentum);
    }
    if (moves) {
      e.position_max = std::max(e.position_max, s.position);
      position_scale = std::max(position_scale, exact.p.norm().convert_to<double>());
    }
    e.energy_max = std::max(e.energy_max, std::abs(rotational ? s.rotational_energy : s.total_energy));
  }
  const double coarser = epsilon / double_epsilon;
  const auto resolved = [coarser](double error, double floor, double uncertainty) {
    return error > 10 * std::max(coarser * floor, uncertainty);
  };
  if (attitude)
    e.above_floor = resolved(e.attitude_max, truth.attitude_floor, truth.truth.attitude_uncertainty);
  else if (rotates)
    e.above_floor = resolved(e.rate_max, truth.rate_floor, truth.truth.rate_uncertainty);
  else
    e.above_floor = resolved(e.position_max, double_epsilon * position_scale, 0);
  return e;
}

}  // namespace polhode
