// The reference: the closed form of the scene in 50 digits where it has one, else a Taylor series of
// order 48.
// The latter (solvers/taylor_run.hpp) is run twice, at two orders and tolerances; the difference is the
// stated uncertainty, as is that of a closed form to the same in 40 digits.
#include "solvers/reference.hpp"

#include "models/closed_form.hpp"
#include "models/errors.hpp"
#include "solvers/taylor_run.hpp"
#include "solvers/thread_time.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {
namespace {

template <class M>
std::vector<WideSample> run(const M& m, std::span<const double> times, int order, double log2_tolerance,
                            std::int64_t& steps) {
  constexpr std::int64_t step_limit = 300'000;
  TaylorSeries<M> series(m, order);
  std::vector<WideSample> samples;
  samples.reserve(times.size());
  Wide t(0);
  typename M::State y = m.initial;
  steps = taylor_run(series, t, y, times, log2_tolerance, step_limit, [&](const Wide& at, const auto& state) {
    samples.push_back(wide_sample(m, at, state));
  });
  if (steps < 0)
    throw Error(70, "the reference solution took " + std::to_string(step_limit) +
                        " steps to reach t = " + std::to_string(t.convert_to<double>()) +
                        " s: the scene is too stiff for an explicit series");
  return samples;
}

}  // namespace

namespace {

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
    widen_uncertainty(truth, i, attitude ? QuaternionT<Wide>(x.q.cast<Wide>()) : truth.samples[i].q,
                      x.w_B.cast<Wide>());
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
  if (is_stiff(scene, times)) try {
      return implicit_solution(scene, times);
    } catch (const Error&) {
      // A torque that jumps has no smooth step across; the series holds its sign and stops at the jump.
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
      widen_uncertainty(truth, i, coarse[i].q, coarse[i].w_B);
  });
  truth.cost_s = thread_seconds() - began;
  return truth;
}

Motion::Motion(const Scene& scene, double until, const Allowance& allowance) : scene_(scene), until_(until) {
  allowance.spend();
}
Truth Motion::at(std::span<const double> times, const Allowance& allowance) const {
  allowance.spend();
  return reference_solution(scene_, times);
}
std::string Motion::saved() const { return ""; }
std::optional<Motion> Motion::restored(const Scene&, std::string_view) { return {}; }

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
