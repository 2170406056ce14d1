// The truth of a scene in 50 digits: its closed form, or the same equations by Taylor series, run twice.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "models/allowance.hpp"
#include "models/scene.hpp"
#include "models/wide.hpp"
#include "solvers/method.hpp"

namespace polhode {

/// The exact state at one time, in the principal frame.
struct WideSample {
  Wide t{};
  QuaternionT<Wide> q{Wide(1), Wide(0), Wide(0), Wide(0)};
  Vec3T<Wide> w_B = Vec3T<Wide>::Zero(), p = Vec3T<Wide>::Zero(), v = Vec3T<Wide>::Zero(),
              L = Vec3T<Wide>::Zero();
  Wide rotational_energy{}, total_energy{};
};

class ExactMotion;

/// The exact solution at asked times, and how certain it is.
struct Truth {
  std::vector<WideSample> samples;
  std::string kind;                 // how it was found, in words
  double attitude_uncertainty = 0;  // rad, largest over the samples: difference of two runs of other accuracy
  double rate_uncertainty = 0;      // relative, likewise
  std::int64_t steps = 0;           // of the more accurate run
  double cost_s = 0;                // thread time of finding the motion, its samples and the proof
  std::string refusal;  // why there is none: what an allowance or 50 digits do not reach. No samples then.
};

/// The motion of a scene, found once and then known at any time from 0 to its end.
///
/// By its closed form where it has one (models/closed_form.hpp); else by Radau IIA of 23 stages if it is
/// stiff and that succeeds; else by Taylor series of order 48. Each is found twice, with other accuracies,
/// and the largest difference is the stated uncertainty: that of 50 digits to 40, of local terms of 1e-43 to
/// 1e-36, of 1e-33 to 1e-28.
class Motion {
 public:
  /// Throws Refused and Stopped as the allowance says, Refused also where the steps are too many.
  Motion(const Scene& scene, double until, const Allowance& allowance);
  double until() const { return until_; }

  /// The truth at times (increasing, from 0 to until()), proven before it is returned (solvers/proof.hpp).
  /// Throws as above, Refused also where 50 digits do not reach, and Error with exit code 70 if the truth
  /// contradicts the scene or itself.
  Truth at(std::span<const double> times, const Allowance& allowance) const;

  /// What another process can go on with; "" where finding it again costs next to nothing.
  std::string saved() const;
  /// From what `saved` gave for a scene of the same content; nothing if the bytes are not that.
  static std::optional<Motion> restored(const Scene& scene, std::string_view bytes);

 private:
  Motion(const Scene& scene, double until, std::shared_ptr<const ExactMotion> motion);

  Scene scene_;
  double until_;
  double cost_s_ = 0;  // of finding it, thread time
  std::shared_ptr<const ExactMotion> motion_;
};

/// The truth at the given times (increasing, >= 0), once: Motion and its `at`.
Truth reference_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance = {});

/// Solves any scene by Taylor series, and so is a second truth for those with a closed form.
Truth series_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance = {});

/// Solves a scene with fast decays by Radau IIA in 50 digits (solvers/radau_run.hpp).
/// throws   Error with exit code 70 if a run finds no step size (a torque that jumps)
Truth implicit_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance = {});

/// Would an explicit series need thousands of steps for a motion that has died out? Judged by the Jacobian at
/// the start: a decay as fast as its own oscillation or faster.
bool is_stiff(const Scene& scene, double until);
inline bool is_stiff(const Scene& scene, std::span<const double> times) {
  return !times.empty() && is_stiff(scene, times.back());
}

}  // namespace polhode
