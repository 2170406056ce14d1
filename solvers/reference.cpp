// The reference: the closed form of the scene in 50 digits where it has one, else a Taylor series of
// order 48.
//   y(t + h) = sum y_k h^k, coefficients by recurrence from the recorded equations (models/jet.hpp)
// The step is the largest for which the last two terms stay below a tolerance, for attitude, rates and
// translation apart; asked times are read off the series inside a step, so that they cost no step. Run twice,
// at two orders and tolerances; the difference is the stated uncertainty. Explicit: a decay of rate r costs
// about r/2.4 steps a second. Scenes that are too stiff for it are refused. Source: Jorba & Zou, Exp. Math.
// 14 (2005).
#include "solvers/reference.hpp"

#include "models/closed_form.hpp"
#include "models/errors.hpp"
#include "models/model.hpp"
#include "models/taylor_series.hpp"
#include "solvers/thread_time.hpp"

namespace polhode {
namespace {

/// log2 |x| of a number whose exponent a double may not hold; -inf for 0.
double log2_of(const Wide& x) {
  if (x == 0) return -std::numeric_limits<double>::infinity();
  int e = 0;
  const Wide m = frexp(Wide(abs(x)), &e);
  return e + std::log2(m.convert_to<double>());
}

/// Largest h for which terms p - 1 and p stay below 2^log2_tolerance of the state, over groups of
/// coordinates.
template <class M>
double step_size(const TaylorSeries<M>& series, double log2_tolerance) {
  struct Group {
    int begin, end;
  };
  std::vector<Group> groups;
  if constexpr (M::has_attitude) groups.push_back({0, 4});
  if constexpr (M::has_rotation) groups.push_back({M::Rotating::w_at, M::Rotating::size});
  if constexpr (M::has_translation) {
    groups.push_back({M::rotation_size, M::rotation_size + 3});
    groups.push_back({M::rotation_size + 3, M::rotation_size + 6});
  }
  double log2_h = 200;
  for (const Group& g : groups) {
    const auto norm = [&](int k) {
      double largest = -std::numeric_limits<double>::infinity();
      for (int i = g.begin; i < g.end; ++i) largest = std::max(largest, log2_of(series.coefficients(i)[k]));
      return largest;
    };
    double scale = norm(0);
    if (std::isinf(scale)) scale = norm(1);  // from rest: the first slope, per second
    const int p = series.order();
    for (const int k : {p - 1, p}) {
      const double term = norm(k);
      if (std::isinf(term) || std::isinf(scale)) continue;
      log2_h = std::min(log2_h, (log2_tolerance + scale - term) / k);
    }
  }
  return std::exp2(log2_h);
}

template <class M>
WideSample wide_sample(const M& m, const Wide& t, const typename M::State& y) {
  WideSample s;
  s.t = t;
  if constexpr (M::has_attitude) s.q = normalised<Wide>(m.rotation.attitude_of(y.data()));
  if constexpr (M::has_rotation) {
    s.w_B = m.rotation.w_of(y.data());
    s.L = m.angular_momentum(y.data());
  }
  if constexpr (M::has_translation) {
    s.p = m.position(y.data());
    s.v = m.velocity(y.data());
  }
  s.rotational_energy = m.rotational_energy(y.data());
  s.total_energy = m.total_energy(t, y.data());
  return s;
}

template <class M>
std::vector<WideSample> run(const M& m, std::span<const double> times, int order, double log2_tolerance,
                            std::int64_t& steps) {
  constexpr std::int64_t step_limit = 300'000;
  TaylorSeries<M> series(m, order);
  std::vector<WideSample> samples;
  samples.reserve(times.size());
  Wide t(0);
  typename M::State y = m.initial;
  series.settle_signs(t, y);
  std::size_t next = 0;
  while (next < times.size() && times[next] <= 0) {
    samples.push_back(wide_sample(m, t, y));
    ++next;
  }
  const Wide end = times.empty() ? Wide(0) : Wide(times.back());
  for (steps = 0; next < times.size(); ++steps) {
    if (steps == step_limit)
      throw Error(70, "the reference solution took " + std::to_string(step_limit) +
                          " steps to reach t = " + std::to_string(t.convert_to<double>()) +
                          " s: the scene is too stiff for an explicit series");
    series.expand(t, y);
    Wide h = step_size(series, log2_tolerance);
    if (h > end - t) h = end - t;
    int crossed = -1;
    h = series.first_sign_change(h, crossed);
    for (; next < times.size() && Wide(times[next]) <= t + h; ++next)
      samples.push_back(wide_sample(m, Wide(times[next]), series.at(Wide(times[next]) - t)));
    y = series.at(h);
    t += h;
    if (crossed >= 0) series.flip_sign(crossed);
  }
  return samples;
}

}  // namespace

namespace {

/// The larger of the stated uncertainty and the difference of two states.
void widen_uncertainty(Truth& truth, const QuaternionT<Wide>& q, const Vec3T<Wide>& w_B,
                       const WideSample& s) {
  truth.attitude_uncertainty =
      std::max(truth.attitude_uncertainty, attitude_error<Wide>(s.q, q).convert_to<double>());
  const Wide w = s.w_B.norm();
  if (w > 0)
    truth.rate_uncertainty =
        std::max(truth.rate_uncertainty, Wide((s.w_B - w_B).norm() / w).convert_to<double>());
}

/// The closed form of the scene; in 40 digits as well at up to 17 of the times.
Truth written_solution(const Scene& scene, std::span<const double> times, const ClosedForm<Wide>& form) {
  Truth truth;
  truth.kind = "closed form: " + closed_form_kind(scene) + ", in 50 digits against 40";
  with_general_model<Wide>(scene, [&](const auto& m) {
    using M = std::remove_cvref_t<decltype(m)>;
    for (const double t : times) {
      const ExactState<Wide> x = form.at(Wide(t));
      typename M::State y = m.initial;
      if constexpr (M::has_attitude) {
        const Wide q[] = {x.q.w(), x.q.x(), x.q.y(), x.q.z()};
        std::copy(q, q + 4, y.begin());
      }
      for (std::size_t i = 0; i < 3; ++i) {
        const auto k = static_cast<int>(i);
        if constexpr (M::has_rotation) y[std::size_t(M::Rotating::w_at) + i] = x.w_B[k];
        if constexpr (M::has_translation) {
          y[std::size_t(M::rotation_size) + i] = x.p[k];
          y[std::size_t(M::rotation_size) + 3 + i] = x.v[k];
        }
      }
      truth.samples.push_back(wide_sample(m, Wide(t), y));
    }
  });
  const auto narrower = closed_form<Narrower>(scene);
  const std::size_t every = std::max<std::size_t>(1, times.size() / 16);
  for (std::size_t i = (times.size() - 1) % every; i < times.size(); i += every) {
    const ExactState<Narrower> x = narrower->at(Narrower(times[i]));
    const bool attitude = scene.rotation && scene.rotation->attitude;
    widen_uncertainty(truth, attitude ? QuaternionT<Wide>(x.q.cast<Wide>()) : truth.samples[i].q,
                      x.w_B.cast<Wide>(), truth.samples[i]);
  }
  return truth;
}

}  // namespace

Truth reference_solution(const Scene& scene, std::span<const double> times) {
  const double began = thread_seconds();
  if (const auto form = closed_form<Wide>(scene); form && !times.empty()) {
    Truth truth = written_solution(scene, times, *form);
    truth.cost_s = thread_seconds() - began;
    return truth;
  }
  return series_solution(scene, times);
}

Truth series_solution(const Scene& scene, std::span<const double> times) {
  const double began = thread_seconds();
  Truth truth;
  truth.kind = "Taylor series of order 48 in 50 digits, against order 40";
  with_general_model<Wide>(scene, [&](const auto& m) {
    truth.samples = run(m, times, 48, -143, truth.steps);  // 2^-143 = 1e-43
    std::int64_t steps = 0;
    const auto coarse = run(m, times, 40, -120, steps);  // 2^-120 = 1e-36
    for (std::size_t i = 0; i < truth.samples.size(); ++i)
      widen_uncertainty(truth, coarse[i].q, coarse[i].w_B, truth.samples[i]);
  });
  truth.cost_s = thread_seconds() - began;
  return truth;
}

std::vector<WideSample> perturbed_solution(const Scene& scene, std::span<const double> times) {
  return with_general_model<Wide>(scene, [&](const auto& m) {
    std::int64_t steps = 0;
    return run(m, times, 28, -80, steps);
  });
}

namespace {

Vec3 narrow(const Vec3T<Wide>& v) {
  return Vec3(v.x().convert_to<double>(), v.y().convert_to<double>(), v.z().convert_to<double>());
}

Prepared prepare_reference(const Scene& scene, const Setting&) {
  return {[scene](const Grid& grid, Trajectory& out) {
            std::vector<double> times;
            if (grid.from_start) times.push_back(0);
            for (const auto& s : grid.stretches) times.push_back(s.t_end);
            out = {};
            Truth truth;
            try {
              truth = reference_solution(scene, times);
            } catch (const Error& e) {
              out.outcome = Outcome::step_limit;
              out.reason = e.what();
              return;
            }
            for (const WideSample& w : truth.samples) {
              Sample s;
              s.t = w.t.convert_to<double>();
              s.q = Quaternion(w.q.w().convert_to<double>(), w.q.x().convert_to<double>(),
                               w.q.y().convert_to<double>(), w.q.z().convert_to<double>());
              s.w_B = narrow(w.w_B);
              s.p = narrow(w.p);
              s.v = narrow(w.v);
              s.L = narrow(w.L);
              s.rotational_energy = w.rotational_energy.convert_to<double>();
              s.total_energy = w.total_energy.convert_to<double>();
              out.samples.push_back(s);
            }
            out.work.steps = truth.steps;
          },
          {}};
}

constinit const Method rows[] = {
    {.id = "reference",
     .family = "truth",
     .summary = "the truth of the scene in 50 digits: its closed form, or a Taylor series run twice",
     .source = "models/closed_form.hpp; Jorba & Zou, Experimental Mathematics 14 (2005)",
     .claims = {.unit_attitude = Claim::yes,
                .momentum_magnitude = Claim::yes,
                .space_momentum = Claim::yes,
                .energy_bounded = Claim::yes,
                .reversible = Claim::yes},
     .prepare = prepare_reference},
};

}  // namespace
extern const MethodRows reference;
const MethodRows reference = rows;
}  // namespace polhode
