// The reference: the motion of a scene in 50 digits, by its closed form, by Radau IIA or by Taylor series,
// found once, proven each time that it is used.
#include "solvers/reference.hpp"

#include "models/errors.hpp"
#include "solvers/exact_motion.hpp"
#include "solvers/proof.hpp"
#include "solvers/thread_time.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {
namespace {

/// Beyond it a truth is none.
constexpr double worst_uncertainty = 1e-6;

std::shared_ptr<const ExactMotion> found(const Scene& scene, double until, const Allowance& allowance) {
  give_back_wide_constants();
  if (auto closed = closed_motion(scene)) return closed;
  if (is_stiff(scene, until)) try {
      return implicit_motion(scene, until, allowance);
    } catch (const Error&) {
      // A torque that jumps has no smooth step across; the series holds its sign and stops at the jump.
    }
  return series_motion(exact_scene(scene), until, allowance);
}

/// The truth of a motion that has been found: its samples, how certain they are, and the proof of both.
Truth truth_of_motion(const Scene& scene, const ExactMotion& motion, double until,
                      std::span<const double> times, const Allowance& allowance) {
  give_back_wide_constants();
  const double began = thread_seconds();
  Truth truth;
  truth.kind = motion.kind();
  truth.steps = motion.steps();
  if (times.empty()) return truth;
  const std::vector<Wide> wide_times(times.begin(), times.end());
  truth.samples = motion.at(wide_times, allowance);
  ExactMotion::Uncertainty u = motion.uncertainty(truth.samples, allowance);
  const ExactScene exact = exact_scene(scene);
  const double least = least_uncertainty(exact, truth.samples);
  // Not std::max: what is not a number is to be refused.
  if (u.attitude < least) u.attitude = least;
  if (u.rate < least) u.rate = least;
  if (!(u.attitude <= worst_uncertainty) || !(u.rate <= worst_uncertainty))
    throw Refused("50 digits do not reach: the attitude is certain to " + number_text(u.attitude) +
                  " rad, the rates to " + number_text(u.rate));
  prove(scene.id, exact, motion, until, truth.samples, u, allowance);
  // Proven, and known without any rounding.
  for (WideSample& s : truth.samples)
    if (s.t == 0)
      s = with_general_model<Wide>(exact, [](const auto& m) { return wide_sample(m, Wide(0), m.initial); });
  if (!scene.rotation || scene.rotation->attitude) truth.attitude_uncertainty = u.attitude;
  truth.rate_uncertainty = u.rate;
  truth.cost_s = thread_seconds() - began;
  return truth;
}

Truth truth_by(std::shared_ptr<const ExactMotion> motion, double began, const Scene& scene,
               std::span<const double> times, const Allowance& allowance) {
  Truth truth = truth_of_motion(scene, *motion, times.empty() ? 0 : times.back(), times, allowance);
  truth.cost_s = thread_seconds() - began;
  return truth;
}

}  // namespace

Motion::Motion(const Scene& scene, double until, const Allowance& allowance) : Motion(scene, until, nullptr) {
  const double began = thread_seconds();
  motion_ = found(scene, until, allowance);
  cost_s_ = thread_seconds() - began;
}
Motion::Motion(const Scene& scene, double until, std::shared_ptr<const ExactMotion> motion)
    : scene_(scene), until_(until), motion_(std::move(motion)) {}

Truth Motion::at(std::span<const double> times, const Allowance& allowance) const {
  Truth truth = truth_of_motion(scene_, *motion_, until_, times, allowance);
  truth.cost_s += cost_s_;
  return truth;
}

std::string Motion::saved() const {
  const std::string bytes = motion_->saved();
  if (bytes.empty()) return bytes;
  return std::to_string(cost_s_) + ' ' + Wide(until_).str(0, std::ios_base::scientific) + ' ' + bytes;
}

std::optional<Motion> Motion::restored(const Scene& scene, std::string_view bytes) try {
  const std::size_t first = bytes.find(' '), second = bytes.find(' ', first + 1);
  if (first == bytes.npos || second == bytes.npos) return {};
  const double cost = std::stod(std::string(bytes.substr(0, first)));
  const auto until = Wide(std::string(bytes.substr(first + 1, second - first - 1))).convert_to<double>();
  bytes.remove_prefix(second + 1);
  std::shared_ptr<const ExactMotion> motion = bytes.starts_with("series")
                                                  ? restored_series(exact_scene(scene), bytes)
                                                  : restored_implicit(scene, bytes);
  if (!motion) return {};
  Motion restored(scene, until, std::move(motion));
  restored.cost_s_ = cost;
  return restored;
} catch (const std::exception&) {
  return {};  // a number that is none, an end before the end: not what `saved` gave
}

Truth reference_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance) {
  const double began = thread_seconds();
  return truth_by(found(scene, times.empty() ? 0 : times.back(), allowance), began, scene, times, allowance);
}
Truth series_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance) {
  const double began = thread_seconds();
  return truth_by(series_motion(exact_scene(scene), times.empty() ? 0 : times.back(), allowance), began,
                  scene, times, allowance);
}
Truth implicit_solution(const Scene& scene, std::span<const double> times, const Allowance& allowance) {
  const double began = thread_seconds();
  return truth_by(implicit_motion(scene, times.empty() ? 0 : times.back(), allowance), began, scene, times,
                  allowance);
}

namespace {

Vec3 narrow(const Vec3T<Wide>& v) {
  return Vec3(v.x().convert_to<double>(), v.y().convert_to<double>(), v.z().convert_to<double>());
}

Prepared prepare_reference(const Scene& scene, const Setting& setting) {
  return {[scene, timeout = setting.timeout_s](const Grid& grid, Trajectory& out) {
            const Allowance allowance(timeout, {});
            std::vector<double> times;
            if (grid.from_start) times.push_back(0);
            for (const auto& s : grid.stretches) times.push_back(s.t_end);
            out = {};
            Truth truth;
            try {
              truth = reference_solution(scene, times, allowance);
            } catch (const Refused& e) {
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
