// What the modules share: from a scene to an engine's body, from its state to a sample, and the loop.
//
// An engine of fixed step is a class E, made from (const EngineBody&, const E::Choice&), with
//   void restart()               back to the start
//   Met set_step(double h)       the size of the steps to come; what it meets if it will not take such
//   Met step(double t)           one step from t; what it met on the way
//   std::int64_t rhs_evals(std::int64_t steps)   accelerations it computed in so many steps, the last taken
//   EngineState state() const
#pragma once

#include <mutex>

#include "solvers/engines/engine_body.hpp"
#include "solvers/engines/engines.hpp"
#include "solvers/fixed_step.hpp"

namespace polhode {

/// A limit of the engine's own that a step has run into: it ends the run, and the reason says what the engine
/// did behind the user's back.
struct Met {
  Outcome outcome = Outcome::ok;
  const char* reason = nullptr;
};

/// Velocity [rad/s or m/s] at which engines that end the program on a number that is not finite are stopped.
constexpr double fastest_for_assertions = 1e10;

/// The body of a scene; it must have an attitude, or no rotation at all (`is_served`).
bool is_served(const Scene& scene);
EngineBody engine_body(const Scene& scene);

/// The sample of an engine's state, by the equations of the scene.
using Observe = std::function<Sample(double t, const EngineState& state)>;
Observe observe_engine(const Scene& scene);

constexpr const char* engines_need_an_attitude =
    "an engine always integrates the attitude, and the scene asks for the rates alone";

template <class E>
class EngineSteps final : public FixedSteps {
 public:
  EngineSteps(const Scene& scene, const typename E::Choice& choice)
      : body_(engine_body(scene)), observe_(observe_engine(scene)), engine_(body_, choice) {
    engine_.restart();
  }
  void restart() override { engine_.restart(); }
  Advance advance(double t_start, double h, std::int64_t i, std::int64_t until) override {
    [[maybe_unused]] const auto alone = [] {
      if constexpr (requires { E::one_thread; })
        return std::unique_lock(E::one_thread);  // an engine that steps in one thread at a time
      else
        return 0;
    }();
    const std::int64_t from = i;
    Met met = engine_.set_step(h);
    for (; i < until && met.reason == nullptr; ++i) met = engine_.step(t_start + static_cast<double>(i) * h);
    Advance done{i, met.outcome, met.reason, engine_.rhs_evals(i - from)};
    if (met.reason == nullptr && !is_finite(engine_.state())) {
      done.outcome = Outcome::not_finite;
      done.reason = "a state that is not finite";
    }
    return done;
  }
  Sample sample(double t) const override { return observe_(t, engine_.state()); }

 private:
  static bool is_finite(const EngineState& s) {
    return s.q.coeffs().allFinite() && s.w_B.allFinite() && s.p_S.allFinite() && s.v_S.allFinite();
  }
  const EngineBody body_;
  Observe observe_;
  E engine_;
};

/// Set up once, run often.
template <class E>
Prepared run_engine(const Scene& scene, const Setting& setting, const typename E::Choice& choice) {
  if (!is_served(scene)) return {{}, engines_need_an_attitude};
  return run_fixed_steps(std::make_shared<EngineSteps<E>>(scene, choice), setting);
}

}  // namespace polhode

// Every module defines these two: its rows, and what it was compiled against.
extern "C" {
const polhode::MethodRows* polhode_engine_rows();
extern const std::size_t polhode_engine_stamp;
}
