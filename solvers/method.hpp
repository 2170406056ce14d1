// What a solver is: one row with its identity, its claims and a function that prepares a run.
//
// Type erasure happens once per run: `prepare` builds the model of the scene and the stepper, and what it
// returns can be run many times (for the clock) without setting up again. Inside, the loop is monomorphic.
#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "models/attitude.hpp"
#include "models/scene.hpp"

namespace polhode {

/// How a run ended. A numerical failure is a value, and its row stays.
enum class Outcome {
  ok,
  not_finite,
  diverged,
  solver_failed,
  step_limit,
  timeout,
  clamped,
  asleep,
  unsupported,
  no_truth  // the run had nothing to be measured against, and was not made
};
inline constexpr Outcome last_outcome = Outcome::no_truth;
std::string_view name_of(Outcome outcome);

/// The state at one asked time, in the principal frame. Parts that the scene lacks keep their defaults.
struct Sample {
  double t = 0;              // s
  Quaternion q{1, 0, 0, 0};  // principal -> space, of the length that the solver left it
  Vec3 w_B = Vec3::Zero();   // rad/s
  Vec3 p = Vec3::Zero(), v = Vec3::Zero();
  Vec3 L = Vec3::Zero();         // kg m^2/s; space frame, or body frame where the scene has no attitude
  double rotational_energy = 0;  // J
  double total_energy = 0;       // J
  double unit_defect = 0;        // abs(|q| - 1), or |R^T R - 1|_F of a matrix state
};

/// Counters of one run.
struct Work {
  std::int64_t steps = 0, rejected_steps = 0, rhs_evals = 0, jacobian_evals = 0;
};

/// Result of one run. Samples up to a failure are kept.
struct Trajectory {
  std::vector<Sample> samples;
  Work work;
  Outcome outcome = Outcome::ok;
  std::string reason;  // of a failure, in words
};

/// The asked times and, for solvers of fixed step, how each stretch between two of them is divided.
/// Times are integers of steps: t = t_start + i h, never a running sum.
struct Grid {
  struct Stretch {
    double t_end;            // s, the asked time at its end
    std::int64_t steps = 0;  // fixed steps in it
    double h = 0;            // s, their size
  };
  bool from_start = false;         // a sample at t = 0 as well
  std::vector<Stretch> stretches;  // in increasing order

  double end() const { return stretches.empty() ? 0 : stretches.back().t_end; }
  std::int64_t steps() const {
    std::int64_t n = 0;
    for (const auto& s : stretches) n += s.steps;
    return n;
  }
};

/// none: there is nothing to set (closed forms, the truth).
enum class Knob { steps, tolerance, none };
std::string_view name_of(Knob knob);

/// What a user sets, and what bounds a run.
struct Setting {
  Knob knob = Knob::steps;
  double rtol = 1e-6, atol = 0;  // atol 0: the solver takes its default, equal to rtol
  std::int64_t step_limit = 100'000'000;
  double timeout_s = std::numeric_limits<double>::infinity();

  double absolute_tolerance() const { return atol > 0 ? atol : rtol; }
};

/// A claim that a test measures. `unknown` is an honest value.
enum class Claim { unknown, yes, no };

/// What the row promises on a nonlinear free or forced scene; every value here is measured by a test.
/// Orders are those of the global error in h; `none` where the error has no order (variable step, or exact).
struct Claims {
  static constexpr double none = -1;
  double attitude_order = none, rate_order = none, energy_order = none, momentum_order = none;
  // The order of all four where a load depends on time, if it is less than that.
  double timed_order = std::numeric_limits<double>::infinity();
  Claim unit_attitude = Claim::unknown;       // |q| or R^T R stays at one to rounding
  Claim momentum_magnitude = Claim::unknown;  // |L| of the free body stays to rounding
  Claim space_momentum = Claim::unknown;      // L in the space frame stays, magnitude and direction
  Claim energy_bounded = Claim::unknown;      // the energy error of the free body has no secular part
  Claim reversible = Claim::unknown;          // a run forward and one back return to the start

  /// These claims for a scene whose loads depend on time, or not.
  Claims with_time(bool timed) const {
    Claims c = *this;
    if (timed)
      for (double* order : {&c.attitude_order, &c.rate_order, &c.energy_order, &c.momentum_order})
        if (*order > timed_order) *order = timed_order;
    return c;
  }
};

/// A run, set up: call it as often as wanted, but not from two threads at a time, copies included: they share
/// the state. The trajectory's memory is reused.
using Integration = std::function<void(const Grid&, Trajectory&)>;

struct Prepared {
  Integration integrate;    // empty if the solver does not serve the scene
  std::string unsupported;  // then: why
};

struct Method {
  std::string_view id = {}, family = {}, summary = {}, source = {}, version = {};
  std::string_view settings = {};  // of a library: what is set on it beyond the knob, in words
  bool by_steps = false,
       by_tolerance = false;  // the knobs it has; a tolerance is the default where there is one
  double epsilon = std::numeric_limits<double>::epsilon();  // of the arithmetic that it steps in
  bool in_studies = true;  // false: only where it is asked for by name (it repeats another row's results)
  Claims claims = {};
  // On y' = lambda y a step multiplies by R(h lambda), here by its coefficients in ascending powers: a
  // polynomial, or that over the denominator. Both empty: not a function of z alone, or not known.
  std::span<const double> stability_polynomial = {}, stability_denominator = {};
  Prepared (*prepare)(const Scene&, const Setting&) = nullptr;

  Knob default_knob() const { return by_tolerance ? Knob::tolerance : by_steps ? Knob::steps : Knob::none; }
  bool has(Knob knob) const {
    return knob == Knob::steps ? by_steps : knob == Knob::tolerance ? by_tolerance : default_knob() == knob;
  }
};

/// The rows of one solver file (variants of one method are rows of one file).
using MethodRows = std::span<const Method>;

}  // namespace polhode
