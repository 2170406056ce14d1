#include "solvers/sensitivity.hpp"

#include <memory>
#include <optional>

#include "models/free_rotation.hpp"
#include "models/wide.hpp"
#include "solvers/radau_run.hpp"
#include "solvers/reference.hpp"
#include "solvers/taylor_run.hpp"

namespace polhode {
namespace {

constexpr int order = 20;
constexpr double log2_tolerance = -62;
constexpr int implicit_stages = 11;  // where it is stiff
constexpr double implicit_tolerance = 1e-17;
constexpr std::int64_t step_limit = 20'000;  // half a second

/// Attitude and rate a time later where nothing turns the body: by its closed form, in a type wide enough for
/// a million turns.
FreeRotation<Wide>::State free_state(const RotationData& r, const QuaternionT<Wide>& q, const Vec3T<Wide>& w,
                                     const Wide& later) {
  return FreeRotation<Wide>(r.moments, q, w).at(later);
}

/// The same for the state of a model; the rest of the state is left as it is.
template <class M>
typename M::State state_later(const RotationData& r, typename M::State y, const Wide& later) {
  using S = typename M::Scalar;
  QuaternionT<Wide> q(Wide(1), Wide(0), Wide(0), Wide(0));
  if constexpr (M::has_attitude) q = M::Rotating::attitude_of(y.data()).template cast<Wide>();
  const auto x = free_state(r, q, Vec3T<Wide>(M::Rotating::w_of(y.data()).template cast<Wide>()), later);
  if constexpr (M::has_attitude) {
    const Wide numbers[] = {x.q.w(), x.q.x(), x.q.y(), x.q.z()};
    for (std::size_t i = 0; i < 4; ++i) y[i] = static_cast<S>(numbers[i]);
  }
  for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(M::Rotating::w_at + i)] = static_cast<S>(x.w_B[i]);
  return y;
}

template <class M>
Sensitivity follow(const M& m, const Scene& scene, std::span<const double> times) {
  using S = typename M::Scalar;
  using State = typename M::State;
  constexpr S distance = S(1e-12);
  Sensitivity result;
  result.attitude = M::has_attitude ? 3 : 0;
  const int size = result.attitude + 3;
  TaylorSeries<M> series(m, order);
  std::unique_ptr<ErasedModel> doubles;
  std::optional<RadauRun<S>> implicit;
  if (is_stiff(scene, times)) {
    doubles = erased_model(scene);
    implicit.emplace(m, *doubles, implicit_stages);
  }
  // From times[from] through all later times; shorter if it took too long.
  const auto flow = [&](State y, std::size_t from) {
    std::vector<State> reached;
    if (scene.rotation->loads.empty()) {
      for (const double t : times.subspan(from + 1))
        reached.push_back(state_later<M>(*scene.rotation, y, Wide(t) - Wide(times[from])));
      return reached;
    }
    S t(times[from]);
    const auto later = times.subspan(from + 1);
    const auto keep = [&](const S&, std::span<const S> there) {
      std::copy(there.begin(), there.end(), reached.emplace_back().begin());
    };
    const std::int64_t steps = implicit ? implicit->run(t, y, later, implicit_tolerance, step_limit, keep)
                                        : taylor_run(series, t, y, later, log2_tolerance, step_limit, keep);
    if (steps < 0) result.known = false;
    return reached;
  };
  const auto rate = [](const State& y) { return M::Rotating::w_of(y.data()).norm(); };

  std::vector<State> states{m.initial};
  if (times.size() > 1)
    for (const State& y : flow(m.initial, 0)) states.push_back(y);
  S fastest(0);
  for (const State& y : states) fastest = std::max(fastest, rate(y));
  if (fastest == S(0)) fastest = S(1);
  // Where a body comes to rest for a moment, or for good, its own rate would measure nothing.
  const auto scale = [&](const State& y) { return std::max(rate(y), S(1e-3) * fastest); };
  for (const State& y : states) result.rates.push_back(static_cast<double>(scale(y)));

  for (std::size_t from = 0; from + 1 < states.size() && result.known; ++from) {
    std::vector<Eigen::MatrixXd> maps(states.size() - 1 - from, Eigen::MatrixXd(size, size));
    for (int column = 0; column < size && result.known; ++column) {
      State y = states[from];
      if constexpr (M::has_attitude)
        if (column < 3) {
          Vec3T<S> turn(S(0), S(0), S(0));
          turn[column] = distance;
          const QuaternionT<S> q = M::Rotating::attitude_of(y.data()) * exp_rotation<S>(turn);
          const S numbers[] = {q.w(), q.x(), q.y(), q.z()};
          std::copy(numbers, numbers + 4, y.begin());
        }
      if (column >= result.attitude)
        y[static_cast<std::size_t>(M::Rotating::w_at + column - result.attitude)] +=
            distance * scale(states[from]);
      const std::vector<State> moved = flow(y, from);
      for (std::size_t k = 0; k < moved.size(); ++k) {
        const State &base = states[from + 1 + k], &other = moved[k];
        if constexpr (M::has_attitude) {
          const QuaternionT<S> turn = normalised<S>(M::Rotating::attitude_of(base.data())).conjugate() *
                                      normalised<S>(M::Rotating::attitude_of(other.data()));
          const S side(turn.w() < S(0) ? -2 : 2);
          for (int i = 0; i < 3; ++i)
            maps[k](i, column) = static_cast<double>(side * turn.vec()[i] / distance);
        }
        const Vec3T<S> change = M::Rotating::w_of(other.data()) - M::Rotating::w_of(base.data());
        for (int i = 0; i < 3; ++i)
          maps[k](result.attitude + i, column) = static_cast<double>(change[i] / (scale(base) * distance));
      }
    }
    result.maps.push_back(std::move(maps));
  }
  return result;
}

}  // namespace

Sensitivity sensitivity(const Scene& scene, std::span<const double> times) {
  return with_general_model<long double>(scene, [&](const auto& m) -> Sensitivity {
    if constexpr (std::remove_cvref_t<decltype(m)>::has_rotation)
      return follow(m, scene, times);
    else
      return {};
  });
}

}  // namespace polhode
