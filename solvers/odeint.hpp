// Boost.Odeint in the terms of this program: its steppers on the flat state of a model, at fixed step or
// controlled.
//
// The arithmetic of a step is the library's, on std::array through its array_algebra: loops of known length,
// which the compiler unrolls. Steps of fixed size run in the one loop of solvers/fixed_step.hpp, controlled
// ones in that of solvers/adaptive_step.hpp, which shortens the last step to hit the end as the library's
// integrate_adaptive does.
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
#include <limits>
#include <memory>
#include <type_traits>

#include <boost/numeric/odeint/algebra/algebra_dispatcher.hpp>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/algebra/operations_dispatcher.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/controlled_step_result.hpp>
#include <boost/version.hpp>

#include "solvers/adaptive_step.hpp"
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
[[gnu::always_inline]] inline void derivative(const M& m, double t, const typename M::State& y,
                                              typename M::State& d) {
  typename M::State f;
  m.rhs(t, y.data(), f.data());
  d = f;
}

/// The right-hand side of a model as Odeint calls it: f(y, dy/dt, t). Always inlined: it is called at a dozen
/// places of a step, and the compiler left to itself makes a function of a dozen operations.
template <AnyModel M>
struct OdeintRhs {
  const M* model;
  std::int64_t* calls;
  [[gnu::always_inline]] void operator()(const typename M::State& y, typename M::State& d, double t) const {
    ++*calls;
    derivative(*model, t, y, d);
  }
};

/// The same without a counter, for steps of a known number of calls.
template <AnyModel M>
struct OdeintRhsUncounted {
  const M& model;
  [[gnu::always_inline]] void operator()(const typename M::State& y, typename M::State& d, double t) const {
    derivative(model, t, y, d);
  }
};

/// An explicit Odeint stepper for the fixed-step loop; `stages` right-hand sides a step.
template <class OdeintStepper, int stages>
struct OdeintFixed : QuaternionForm {
  static constexpr int rhs_per_step = stages;

  template <AnyModel M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) const {
    typename M::State next;
    const OdeintRhsUncounted<M> rhs{m};
    stepper.do_step(rhs, y, t, next, h);
    return next;
  }

  /// The same in place, as the library does it with one copy of the state less.
  template <AnyModel M>
  void advance(const M& m, double t, double h, typename M::State& y) const {
    const OdeintRhsUncounted<M> rhs{m};
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
    const OdeintRhsUncounted<M> rhs{m};
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

/// A run of one of the library's controlled steppers.
///
/// one_function   all of a step in the function of the loop: a tenth faster for the pairs of few stages,
/// slower
///                for many, whose trial step is best a function of its own
template <class Controlled, bool one_function, AnyModel M>
class OdeintControlled final : public AdaptiveSteps {
 public:
  template <class Make>
  OdeintControlled(M model, const Setting& setting, const Make& make)
      : model_(std::move(model)), run_{make(), {}}, branch_{make(), {}} {
    typename M::State d;
    model_.rhs(0.0, model_.initial.data(), d.data());
    first_ = first_step(model_.initial, d, setting);
    run_.restart(model_.initial);
  }

  void restart(double t_end, Progress& p) override {
    run_.restart(model_.initial);
    p.rhs_evals = 1;  // of the first step
    p.h = first_ > 0 ? std::min(first_, t_end) : 1e-6 * t_end;
  }

  void cruise(double t_stop, std::int64_t limit, Progress& p) override { go(run_, t_stop, limit, p); }

  bool attempt(Progress& p) override {
    before_ = run_.y;
    const std::int64_t accepted = p.accepted;
    go(run_, std::numeric_limits<double>::infinity(), p.attempts + 1, p);
    return p.accepted > accepted;
  }

  /// By the branch; its first trial is the whole way, which the run has just shown to be possible.
  bool sample_within(double t_start, double t, Sample& out) override {
    branch_.restart(before_);
    Progress uncounted{.t = t_start, .h = t - t_start};
    while (uncounted.attempts < 1000 && !uncounted.stuck) {
      const bool last = uncounted.t + uncounted.h >= t;
      if (last) uncounted.h = t - uncounted.t;
      const std::int64_t accepted = uncounted.accepted;
      go(branch_, std::numeric_limits<double>::infinity(), uncounted.attempts + 1, uncounted);
      if (!last || uncounted.accepted == accepted) continue;
      out = observe(model_, t, branch_.y.data());
      return true;
    }
    return false;
  }

  Sample sample(double t) const override { return observe(model_, t, run_.y.data()); }
  bool is_finite() const override { return all_finite(run_.y); }

 private:
  struct alignas(64) Line {
    Controlled stepper;
    typename M::State y{};

    void restart(const typename M::State& start) {
      if constexpr (requires { stepper.reset(); }) stepper.reset();
      y = start;
    }
  };

  void go(Line& line, double t_stop, std::int64_t limit, Progress& p) {
    if constexpr (requires { model_.rotation.load.loads; })
      go_on(model_, line, t_stop, limit, p);  // a list of loads walks through memory anyway
    else if constexpr (one_function)
      go_flattened(line, t_stop, limit, p);
    else
      go_step_by_step(line, t_stop, limit, p);
  }
  /// A trial step as a function of its own: what a pair of many stages fills a function with.
  [[gnu::noinline, gnu::flatten]] static bool try_step(Controlled& stepper, const OdeintRhs<M>& rhs,
                                                       typename M::State& y, double& t, double& h) {
    return stepper.try_step(rhs, y, t, h) == boost::numeric::odeint::success;
  }
  void go_step_by_step(Line& line, double t_stop, std::int64_t limit, Progress& p) {
    const OdeintRhs<M> rhs{&model_, &p.rhs_evals};
    while (p.t + p.h < t_stop && p.attempts < limit) {
      const double before = p.t, trial = p.h;
      if (!p.tell(before, trial, try_step(line.stepper, rhs, line.y, p.t, p.h))) break;
    }
  }
  [[gnu::noinline, gnu::flatten]] void go_flattened(Line& line, double t_stop, std::int64_t limit,
                                                    Progress& p) {
    const M model = model_;
    go_on(model, line, t_stop, limit, p);
  }
  static void go_on(const M& model, Line& line, double t_stop, std::int64_t limit, Progress& progress) {
    Progress p = progress;
    std::int64_t calls = 0;
    typename M::State y = line.y;
    const OdeintRhs<M> rhs{&model, &calls};
    while (p.t + p.h < t_stop && p.attempts < limit) {
      const double before = p.t, trial = p.h;
      if (!p.tell(before, trial, line.stepper.try_step(rhs, y, p.t, p.h) == boost::numeric::odeint::success))
        break;
    }
    line.y = y;
    p.rhs_evals += calls;
    progress = p;
  }

  M model_;
  double first_ = 0;
  Line run_, branch_;
  typename M::State before_{};
};

/// `prepare` of a solver file. A Family names the library's types for a state:
///   fixed<State>                 a stepper of solvers/fixed_step.hpp, if it has the knob `steps`
///   controlled<State>(setting)   returns a controlled stepper, if it has the knob `tolerance`
///   one_function                 see OdeintControlled
template <class Family>
Prepared run_odeint(const Scene& scene, const Setting& setting) {
  return with_model(scene, [&](auto model) -> Prepared {
    using M = decltype(model);
    using State = typename M::State;
    if constexpr (requires { Family::template controlled<State>(setting); })
      if (setting.knob == Knob::tolerance) {
        const auto make = [&setting] { return Family::template controlled<State>(setting); };
        using Run = OdeintControlled<decltype(make()), Family::one_function, M>;
        return run_adaptive_steps(std::shared_ptr<AdaptiveSteps>(new Run(std::move(model), setting, make)),
                                  setting);
      }
    if constexpr (requires { typename Family::template fixed<State>; })
      if (setting.knob == Knob::steps) {
        using Stepper = typename Family::template fixed<State>;
        return run_fixed_steps(std::make_shared<FixedStepsOf<Stepper, M>>(std::move(model)), setting);
      }
    return {{},
            setting.knob == Knob::steps ? "has no fixed step size, only a tolerance"
                                        : "has no tolerance, only a fixed step size"};
  });
}

}  // namespace polhode
