// The truth of a scene in 50 digits: its closed form, or the same equations by Taylor series, run twice.
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
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

/// The exact solution at asked times, and how certain it is.
struct Truth {
  std::vector<WideSample> samples;
  std::string kind;                 // how it was found, in words
  double attitude_uncertainty = 0;  // rad, largest over the samples: difference of two runs of other accuracy
  double rate_uncertainty = 0;      // relative, likewise
  std::int64_t steps = 0;           // of the more accurate run
  double cost_s = 0;                // thread time of both runs
  std::string refusal;              // why there is none: what an allowance or 50 digits do not reach. No samples then.
};

/// The motion of a scene, found once and then known at any time from 0 to its end.
class Motion {
 public:
  /// Throws Refused and Stopped as the allowance says, Refused also where 50 digits do not reach.
  Motion(const Scene& scene, double until, const Allowance& allowance);
  double until() const { return until_; }

  /// The truth at times (increasing, from 0 to until()), proven before it is returned. Throws as above, and
  /// Error with exit code 70 if the truth contradicts the scene or itself.
  Truth at(std::span<const double> times, const Allowance& allowance) const;

  /// What another process can go on with; "" where finding it again costs next to nothing.
  std::string saved() const;
  /// From what `saved` gave for a scene of the same content; nothing if the bytes are not that.
  static std::optional<Motion> restored(const Scene& scene, std::string_view bytes);

 private:
  Scene scene_;
  double until_;
};

/// Solves the scene at the given times (increasing, >= 0): by its closed form where it has one
/// (models/closed_form.hpp), whose uncertainty is the largest difference to the same in 40 digits; else as
/// implicit_solution if it is stiff and that succeeds, else as series_solution. `kind` says which.
Truth reference_solution(const Scene& scene, std::span<const double> times);

/// Solves any scene by Taylor series, and so is a second truth for those with a closed form.
///
/// The more accurate of two runs is returned: order 48 with local terms below 1e-43 of the state, against
/// order 40 and 1e-36; the largest difference between them is the stated uncertainty.
/// throws   Error with exit code 70 if a run does not end (a rate so stiff that an explicit series cannot
///          follow)
Truth series_solution(const Scene& scene, std::span<const double> times);

/// Solves a scene with fast decays by Radau IIA in 50 digits (solvers/radau_run.hpp): 23 stages with steps
/// that miss 1e-33 of the state, against 19 and 1e-28; the largest difference is the stated uncertainty.
/// throws   Error with exit code 70 if a run finds no step size (a torque that jumps) or does not end
Truth implicit_solution(const Scene& scene, std::span<const double> times);

/// Would an explicit series need thousands of steps for a motion that has died out? Judged by the Jacobian at
/// the start: a decay as fast as its own oscillation or faster.
bool is_stiff(const Scene& scene, std::span<const double> times);

}  // namespace polhode
