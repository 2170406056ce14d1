// Truths by content, their floors, and error norms.
#include "experiments/truth.hpp"

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <type_traits>

#include <fmt/format.h>

#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"
#include "experiments/truth_store.hpp"
#include "models/errors.hpp"
#include "models/scene_content.hpp"
#include "solvers/thread_time.hpp"

namespace polhode {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double double_epsilon = std::numeric_limits<double>::epsilon();
constexpr double worth_keeping = 0.05;  // s of a floor

std::vector<double> with_zero(std::span<const double> times) {
  std::vector<double> all;
  if (times.empty() || times.front() > 0) all.push_back(0);
  all.insert(all.end(), times.begin(), times.end());
  return all;
}

/// The budget of the options from now on; an interrupt ends it, and the line of progress tells how long it
/// has taken. Lives no longer than the options.
Allowance allowance_of(const Options& options, const std::string& what) {
  using Clock = std::chrono::steady_clock;
  return {options.truth_budget_s,
          [&options, what, began = thread_seconds(), looked = Clock::now(), told = 0L]() mutable {
            if (interrupted()) return true;
            if (const auto now = Clock::now(); now - looked > std::chrono::milliseconds(200)) {
              looked = now;
              if (const long seconds = std::lround(thread_seconds() - began); seconds > told)
                progress(options, fmt::format("{}, {} s", what, told = seconds));
            }
            return false;
          }};
}

/// Takes the line of progress away, so that what is said next does not stand behind it.
struct ClearedLine {
  const Options& options;
  ~ClearedLine() { progress(options, ""); }
};

bool is_spent(const Allowance& allowance) {
  try {
    allowance.spend();
  } catch (const Refused&) {
    return true;
  }
  return false;
}

/// What is known of the scenes of one content.
struct Entry {
  struct Refusal {
    double seconds;  // were not enough
    std::string why;
    bool more_time_helps;
  };
  std::mutex guard;  // held while the motion is found: who asks for the same waits, others do not
  std::optional<Motion> motion;
  std::map<double, Refusal> refused;  // by the end that the motion was to reach
  std::map<std::vector<double>, std::shared_ptr<const SceneTruth>> at;
};

Entry& entry_of(const std::string& content) {
  static std::mutex guard;
  static std::map<std::string, Entry> known;
  const std::lock_guard lock(guard);
  return known[content];
}

/// How far to find the motion: as long as the scene lasts, so that whoever asks for more times finds it
/// there; not so far where that is refused, or where to find it again later costs no more than a tenth.
std::vector<double> ends_to_try(const Scene& scene, double asked) {
  if (asked >= scene.duration) return {asked};
  if (asked < scene.duration / 10) return {asked};
  return {scene.duration, asked};
}

/// Fills in the motion, at least to `end`, from the disk or by finding it until `until`.
void find_motion(Entry& entry, const std::string& content, const Scene& scene, double end, double until,
                 const Allowance& allowance) {
  if (entry.motion && entry.motion->until() >= end) return;
  const TruthStore store = TruthStore::of_user();
  const std::string key = "motion\n" + content;
  if (const auto bytes = store.read(key))
    if (auto motion = Motion::restored(scene, *bytes); motion && motion->until() >= end) {
      entry.motion.emplace(std::move(*motion));
      return;
    }
  entry.motion.emplace(Motion(scene, until, allowance));
  if (const std::string bytes = entry.motion->saved(); !bytes.empty()) store.write(key, bytes);
}

Floor unknown_floor() {
  Floor f;
  f.attitude_growth = f.rate_growth = f.conditioning = none;
  f.attitude = 4e-16;  // the least that it can be
  f.rate = double_epsilon;
  return f;
}

std::string bytes_of(const Floor& floor) {
  static_assert(std::is_trivially_copyable_v<Floor>);
  std::string bytes(sizeof floor, '\0');
  std::memcpy(bytes.data(), &floor, sizeof floor);
  return bytes;
}

}  // namespace

std::shared_ptr<const SceneTruth> truth_of(const Scene& scene, std::span<const double> times,
                                           const Options& options) {
  const std::vector<double> all = with_zero(times);
  const std::string content = content_of(scene);
  Entry& entry = entry_of(content);
  const std::lock_guard lock(entry.guard);
  auto& known = entry.at[all];
  // A refusal stands until somebody allows more.
  const double seconds = options.truth_budget_s;
  if (known && (known->is_known() || !known->more_time_helps || known->budget_s() >= seconds)) return known;
  const ClearedLine line{options};
  auto found = std::make_shared<SceneTruth>(scene, all, options);
  for (const double until : ends_to_try(scene, all.back())) {
    const bool is_there = entry.motion && entry.motion->until() >= all.back();
    const auto before = entry.refused.begin();
    if (!is_there && before != entry.refused.end() && before->first <= until &&
        (before->second.seconds >= seconds || !before->second.more_time_helps)) {
      found->truth.refusal = before->second.why;
      found->more_time_helps = before->second.more_time_helps;
      continue;
    }
    const Allowance allowance = allowance_of(options, "truth of " + scene.id);
    try {
      find_motion(entry, content, scene, all.back(), until, allowance);
      found->truth = entry.motion->at(all, allowance);
      found->more_time_helps = false;
      break;
    } catch (const Refused& e) {
      found->truth.refusal = e.what();
      found->more_time_helps = is_spent(allowance);
      if (!entry.motion || entry.motion->until() < all.back())
        entry.refused[until] = {seconds, e.what(), found->more_time_helps};
    }
  }
  return known = found;
}

std::shared_ptr<const SceneTruth> needed_truth_of(const Scene& scene, std::span<const double> times,
                                                  const Options& options) {
  auto truth = truth_of(scene, times, options);
  if (!truth->is_known()) throw Error(1, refusal_text(scene, *truth));
  return truth;
}

std::string refusal_text(const Scene& scene, const SceneTruth& truth) {
  return "no truth of '" + scene.id + (scene.variant.empty() ? "" : " with " + scene.variant) +
         "': " + truth.truth.refusal + (truth.more_time_helps ? "; --truth-budget S allows more" : "");
}

const Floor& SceneTruth::floor() const {
  const std::lock_guard lock(guard_);
  if (floor_) return *floor_;
  if (!is_known()) return floor_.emplace(unknown_floor());
  std::string key = "floor\n" + content_of(scene_);
  for (const double t : times_) key += fmt::format("{:a} ", t);
  const TruthStore store = TruthStore::of_user();
  if (const auto bytes = store.read(key); bytes && bytes->size() == sizeof(Floor)) {
    Floor kept;
    std::memcpy(&kept, bytes->data(), sizeof kept);
    return floor_.emplace(kept);
  }
  const ClearedLine line{options_};
  const double began = thread_seconds();
  try {
    floor_ = floor_of(scene_, times_, truth, allowance_of(options_, "rounding floor of " + scene_.id));
  } catch (const Refused&) {
    return floor_.emplace(unknown_floor());
  }
  if (thread_seconds() - began > worth_keeping) store.write(key, bytes_of(*floor_));
  return *floor_;
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
    e.above_floor = resolved(e.attitude_max, truth.floor().attitude, truth.truth.attitude_uncertainty);
  else if (rotates)
    e.above_floor = resolved(e.rate_max, truth.floor().rate, truth.truth.rate_uncertainty);
  else
    e.above_floor = resolved(e.position_max, double_epsilon * position_scale, 0);
  return e;
}

}  // namespace polhode
