// Boost.Odeint in the terms of this program: its steppers on the flat state of a model, at fixed step or
// controlled.
//
// The arithmetic of a step is the library's, on std::array through its array_algebra: loops of known length,
// which the compiler unrolls. Steps of fixed size run in the one loop of solvers/fixed_step.hpp. The loop
// around a controlled stepper is that of the library's integrate_adaptive (shorten the last step to hit the
// end) with counters, limits and samples added.
//
// Asked times inside a step are reached by a branch: a second stepper of the same method and tolerance goes
// from the start of that step to the asked time, and the run goes on as if nobody had looked. So neither
// errors nor counters depend on how many samples are asked. Measured with dopri5 on a tumbling body (200
// samples in 10 s), the largest attitude error at rtol 1e-8 and 1e-10 is 1.8e-8 and 5.0e-11 rad this way,
// 3.0e-8 and 1.5e-10 with the library's dense output of order 4; to stop at each asked time would take up to
// three times the evaluations, for an accuracy that the tolerance did not ask for. Right-hand sides of
// branches are not counted; where only the end is asked, as for the clock, there are none.
//
// Source: Ahnert & Mulansky, Odeint: solving ordinary differential equations in C++, AIP Conf. Proc. 1389
// (2011).
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <type_traits>

#include <boost/numeric/odeint/algebra/algebra_dispatcher.hpp>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/algebra/operations_dispatcher.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/controlled_step_result.hpp>
#include <boost/version.hpp>

#include "solvers/fixed_step.hpp"

namespace polhode {

static_assert(std::is_same_v<boost::numeric::odeint::algebra_dispatcher<std::array<double, 7>>::algebra_type,
                             boost::numeric::odeint::array_algebra>,
              "Odeint must take std::array through its array algebra");

/// "Boost 1.74", from the header's own text "1_74".
inline constexpr auto boost_version_text = [] {
  constexpr std::string_view name = "Boost ", number = BOOST_LIB_VERSION;
  std::array<char, name.size() + number.size()> text{};
  std::size_t n = 0;
  for (const char c : name) text[n++] = c;
  for (const char c : number) text[n++] = c == '_' ? '.' : c;
  return text;
}();
inline constexpr std::string_view boost_version{boost_version_text.data(), boost_version_text.size()};

/// dy/dt of a model. By way of a local array, because `d` might share memory with the model's constants for
/// all the compiler knows, and it would read them anew after each store.
template <AnyModel M>
void derivative(const M& m, double t, const typename M::State& y, typename M::State& d) {
  typename M::State f;
  m.rhs(t, y.data(), f.data());
  d = f;
}

/// The right-hand side of a model as Odeint calls it: f(y, dy/dt, t); counts its calls.
template <AnyModel M>
struct OdeintRhs {
  const M* model;
  std::int64_t* calls;
  void operator()(const typename M::State& y, typename M::State& d, double t) const {
    ++*calls;
    derivative(*model, t, y, d);
  }
};

/// An explicit Odeint stepper for the fixed-step loop; `stages` right-hand sides a step.
template <class OdeintStepper, int stages>
struct OdeintFixed : QuaternionForm {
  static constexpr int rhs_per_step = stages;

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State next;
    const auto rhs = [&m](const auto& x, auto& d, double s) { derivative(m, s, x, d); };
    stepper.do_step(rhs, y, t, next, h);
    return next;
  }

  /// The same in place, as the library does it with one copy of the state less.
  template <AnyModel M>
  void advance(const M& m, double t, double h, typename M::State& y) const {
    const auto rhs = [&m](const auto& x, auto& d, double s) { derivative(m, s, x, d); };
    stepper.do_step(rhs, y, t, h);
  }

  mutable OdeintStepper stepper;  // holds stage derivatives: scratch, nothing that outlives a step
};

/// The same for a stepper whose last stage is the first of the next step: its state carries the derivative
/// along.
template <class OdeintStepper, int stages>
struct OdeintFixedFsal {
  static constexpr int rhs_per_step = stages;  // one more at the start of a run

  template <class S>
  struct WithDerivative {
    S y, d;
    auto begin() const { return y.begin(); }
    auto end() const { return y.end(); }
  };

  template <AnyModel M>
  static WithDerivative<typename M::State> start(const M& m) {
    WithDerivative<typename M::State> x{m.initial, {}};
    m.rhs(0.0, x.y.data(), x.d.data());
    return x;
  }
  template <AnyModel M>
  WithDerivative<typename M::State> step(const M& m, double t, double h,
                                         const WithDerivative<typename M::State>& x) const {
    WithDerivative<typename M::State> next;
    const auto rhs = [&m](const auto& y, auto& d, double s) { derivative(m, s, y, d); };
    stepper.do_step(rhs, x.y, x.d, t, next.y, next.d, h);
    return next;
  }
  template <AnyModel M>
  static Sample sample(const M& m, double t, const WithDerivative<typename M::State>& x) {
    return observe(m, t, x.y.data());
  }

  mutable OdeintStepper stepper;
};

/// The library's error control around one of its Runge-Kutta pairs, at the tolerances of a setting.
template <class Pair>
boost::numeric::odeint::controlled_runge_kutta<Pair> controlled_pair(const Setting& setting) {
  using Controlled = boost::numeric::odeint::controlled_runge_kutta<Pair>;
  static const Pair
      blank;  // static: the constructor copies all of it, scratch included, which must have a value
  return Controlled(typename Controlled::error_checker_type(setting.absolute_tolerance(), setting.rtol),
                    typename Controlled::step_adjuster_type(), blank);
}

/// First trial step of a controlled run [s]: 0.01 |y|/|y'| in the norm of the tolerances, the first guess of
/// Hairer, Norsett & Wanner, Solving ODEs I (1993), II.4. A poor guess costs a rejected step or two, no
/// accuracy.
template <class State>
double first_step(const State& y, const State& d, const Setting& setting, double t_end) {
  double size = 0, rate = 0;
  for (std::size_t i = 0; i < y.size(); ++i) {
    const double scale = setting.absolute_tolerance() + setting.rtol * std::abs(y[i]);
    size = std::max(size, std::abs(y[i]) / scale);
    rate = std::max(rate, std::abs(d[i]) / scale);
  }
  // Where the state or its rate is zero the quotient says nothing: begin carefully.
  const double h = size < 1e-5 || rate < 1e-5 ? 1e-6 * t_end : 0.01 * size / rate;
  return std::min(h, t_end);
}

/// One trial step of a controlled stepper; true if it was accepted. Flattened: the right-hand side of a free
/// body is a dozen operations, called at a dozen places of a step, and the compiler left to itself makes a
/// function of it.
template <class Controlled, class Rhs, class State>
[[gnu::flatten]] bool try_step_inlined(Controlled& stepper, const Rhs& rhs, State& y, double& t, double& h) {
  return stepper.try_step(rhs, y, t, h) == boost::numeric::odeint::success;
}

/// The same for any model: a list of loads is not worth inlining, it walks through memory anyway.
template <class Controlled, class Rhs, class State>
bool try_step(Controlled& stepper, const Rhs& rhs, State& y, double& t, double& h) {
  if constexpr (requires { rhs.model->rotation.load.loads; })
    return stepper.try_step(rhs, y, t, h) == boost::numeric::odeint::success;
  else
    return try_step_inlined(stepper, rhs, y, t, h);
}

/// Goes from (t, y) to t_to with a fresh controlled stepper; the first trial is the whole way, which the run
/// has just shown to be possible. Returns false if it cannot be done.
template <class Controlled, AnyModel M>
bool branch_to(Controlled stepper, const M& m, double t, double t_to, typename M::State& y) {
  std::int64_t uncounted = 0;
  const OdeintRhs<M> rhs{&m, &uncounted};
  double h = t_to - t;
  for (int attempts = 0; attempts < 1000; ++attempts) {
    const bool last = t + h >= t_to;
    if (last) h = t_to - t;
    if (!try_step(stepper, rhs, y, t, h)) continue;
    if (last) return true;
  }
  return false;
}

/// One run of a controlled stepper.
///
/// stepper  of the library, fresh or used: it is reset
/// fresh    returns a stepper of the same kind, for the branches to asked times
/// out      samples at the asked times; steps are accepted ones
template <class Controlled, class Fresh, AnyModel M>
void integrate_controlled(Controlled& stepper, const Fresh& fresh, const M& m, const Setting& setting,
                          const Grid& grid, Trajectory& out) {
  using clock = std::chrono::steady_clock;
  const bool timed = setting.timeout_s < 1e9;
  const auto began = timed ? clock::now() : clock::time_point{};
  out.samples.clear();
  out.samples.reserve(grid.stretches.size() + 1);
  out.work = {};
  out.outcome = Outcome::ok;
  out.reason.clear();
  const auto fail = [&](Outcome outcome, double t, const std::string& what) {
    out.outcome = outcome;
    out.reason = what + " at t = " + std::to_string(t) + " s";
  };

  typename M::State y = m.initial, before;
  const Sample first = observe(m, 0.0, y.data());
  if (grid.from_start) out.samples.push_back(first);
  if (grid.stretches.empty()) return;
  if constexpr (requires { stepper.reset(); }) stepper.reset();
  std::int64_t calls = 0, accepted = 0, attempts = 0;
  const OdeintRhs<M> rhs{&m, &calls};
  const auto count = [&] { out.work = {accepted, attempts - accepted, calls, 0}; };
  rhs(y, before, 0.0);
  const double t_end = grid.end();
  double t = 0, h = first_step(y, before, setting, t_end);
  auto asked = grid.stretches.begin();
  int rejected_in_a_row = 0;
  for (bool ended = false; !ended;) {
    if (attempts == setting.step_limit) {
      count();
      return fail(Outcome::step_limit, t, "gave up after " + std::to_string(attempts) + " steps");
    }
    if (attempts % 1024 == 1023) {
      if (timed && std::chrono::duration<double>(clock::now() - began).count() > setting.timeout_s) {
        count();
        return fail(Outcome::timeout, t, "still running after " + std::to_string(setting.timeout_s) + " s");
      }
      if (!all_finite(y)) {  // the library accepts a step whose error is not a number, and keeps its size
        count();
        return fail(Outcome::not_finite, t, "a state that is not finite");
      }
    }
    const bool last = t + h >= t_end;
    if (last) h = t_end - t;
    const double t_before = t, trial = h;
    const bool looked_into = asked->t_end < t + h;
    if (looked_into) before = y;
    ++attempts;
    if (!try_step(stepper, rhs, y, t, h)) {
      // The library grows a step after an error that is not a number, or shrinks it for ever: neither may
      // hang.
      if (++rejected_in_a_row == 500 || !(t_before + trial > t_before)) {
        count();
        return fail(Outcome::solver_failed, t,
                    "no acceptable step size: last tried " + std::to_string(trial) + " s");
      }
      continue;
    }
    rejected_in_a_row = 0;
    ++accepted;
    if (last) t = t_end;
    ended = last;
    if (!looked_into && !last) continue;
    if (!all_finite(y)) {
      count();
      return fail(Outcome::not_finite, t, "a state that is not finite");
    }
    for (; asked != grid.stretches.end() && asked->t_end <= t; ++asked) {
      Sample s;
      if (asked->t_end == t) {
        s = observe(m, t, y.data());
      } else {
        typename M::State between = before;
        if (!branch_to(fresh(), m, t_before, asked->t_end, between)) {
          count();
          return fail(Outcome::solver_failed, asked->t_end, "no acceptable step to the asked time");
        }
        s = observe(m, asked->t_end, between.data());
      }
      if (has_diverged(first, s)) {
        count();
        return fail(Outcome::diverged, s.t, "kinetic energy beyond 1e12 times its start");
      }
      out.samples.push_back(s);
    }
  }
  count();
}

/// `prepare` of a solver file. A Family names the library's types for a state:
///   fixed<State>                 a stepper of solvers/fixed_step.hpp, if it has the knob `steps`
///   controlled<State>(setting)   returns a controlled stepper, if it has the knob `tolerance`
template <class Family>
Prepared run_odeint(const Scene& scene, const Setting& setting) {
  return with_model(scene, [&](auto model) -> Prepared {
    using State = typename decltype(model)::State;
    if constexpr (requires { Family::template controlled<State>(setting); })
      if (setting.knob == Knob::tolerance) {
        const auto fresh = [setting] { return Family::template controlled<State>(setting); };
        // Made once: bulirsch_stoer fills a dozen vectors in its constructor. Copies of the run share it, so
        // that they must not run at the same time.
        using Controlled = decltype(fresh());
        const std::shared_ptr<Controlled> stepper(new Controlled(fresh()));
        return {[=](const Grid& grid, Trajectory& out) {
                  integrate_controlled(*stepper, fresh, model, setting, grid, out);
                },
                {}};
      }
    if constexpr (requires { typename Family::template fixed<State>; })
      if (setting.knob == Knob::steps)
        return {[=](const Grid& grid, Trajectory& out) {
                  typename Family::template fixed<State> stepper;
                  integrate_fixed(stepper, model, setting, grid, out);
                },
                {}};
    return {{},
            setting.knob == Knob::steps ? "has no fixed step size, only a tolerance"
                                        : "has no tolerance, only a fixed step size"};
  });
}

}  // namespace polhode
