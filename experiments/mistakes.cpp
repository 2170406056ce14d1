// Recognising mistakes: each hypothesis is a way to read the file (or, for the missing term, another equation
// to compare it with); it is believed if the median error falls tenfold. The median, because a run may be
// right for most of its time and lost at the end.
#include "experiments/mistakes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "experiments/stopwatch.hpp"
#include "models/model.hpp"
#include "solvers/observe.hpp"

namespace polhode {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double tenfold = 10;
constexpr double nothing_to_explain = 1e-6;  // errors below are no mistakes of writing down

/// The truth, or what stands in its place, in double: mistakes are large.
struct State {
  Quaternion q;
  Vec3 w;
};

std::vector<State> states_of(std::span<const WideSample> truth) {
  std::vector<State> out;
  for (const WideSample& s : truth)
    out.push_back({Quaternion(s.q.w().convert_to<double>(), s.q.x().convert_to<double>(),
                              s.q.y().convert_to<double>(), s.q.z().convert_to<double>()),
                   Vec3(s.w_B.x().convert_to<double>(), s.w_B.y().convert_to<double>(),
                        s.w_B.z().convert_to<double>())});
  return out;
}

/// I w' = tau_B without (I w) x w, by RK4 with steps far smaller than a turn.
std::optional<std::vector<State>> without_gyroscopic_term(const Scene& scene, std::span<const double> times) {
  return with_general_model<double>(scene, [&](const auto& m) -> std::optional<std::vector<State>> {
    using M = std::decay_t<decltype(m)>;
    if constexpr (!M::has_rotation) {
      return std::nullopt;
    } else {
      const auto& body = m.rotation;
      if (!body.has_gyroscopic_term()) return std::nullopt;
      constexpr int size = std::decay_t<decltype(body)>::size, w_at = std::decay_t<decltype(body)>::w_at;
      using Vector = Eigen::Matrix<double, size, 1>;
      const auto slope = [&](double t, const Vector& y) {
        Vector d;
        body.template rhs<double>(t, y.data(), d.data());
        const Vec3 w = y.template segment<3>(w_at);
        d.template segment<3>(w_at) -=
            body.gyroscopic_constants().cwiseProduct(Vec3(w.y() * w.z(), w.z() * w.x(), w.x() * w.y()));
        return d;
      };
      Vector y;
      for (int i = 0; i < size; ++i) y[i] = m.initial[static_cast<std::size_t>(i)];
      // 1/50 of a radian a step: a local error of 1e-10 where the attitude turns evenly.
      const double fastest = std::max(scene.rotation->w0.norm(), 1e-3);
      const double ideal = 0.02 / fastest;
      if (times.back() / ideal > 1e6) return std::nullopt;
      std::vector<State> out;
      double t = 0;
      for (const double end : times) {
        const int n = end > t ? static_cast<int>(std::ceil((end - t) / ideal)) : 0;
        const double h = (end - t) / std::max(n, 1);
        for (int i = 0; i < n; ++i) {
          const Vector a = slope(t, y), b = slope(t + h / 2, y + h / 2 * a),
                       c = slope(t + h / 2, y + h / 2 * b), d = slope(t + h, y + h * c);
          y += h / 6 * (a + 2 * b + 2 * c + d);
          t += h;
        }
        t = end;
        State s{Quaternion::Identity(), y.template segment<3>(w_at)};
        if constexpr (M::has_attitude) s.q = body.attitude_of(y.data());
        out.push_back(s);
      }
      return out;
    }
  });
}

struct Misfit {
  double attitude = none, rate = none;
  double worst() const {
    const double w = std::isnan(attitude) ? rate : std::isnan(rate) ? attitude : std::max(attitude, rate);
    return std::isnan(w) ? std::numeric_limits<double>::infinity() : w;
  }
};

Misfit misfit_of(const Scene& scene, const TrajectoryFile& file, const Reading& reading,
                 std::span<const State> truth) {
  const std::vector<Sample> samples = samples_of(scene, file, reading);
  std::vector<double> attitude, rate;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const std::ptrdiff_t k = static_cast<std::ptrdiff_t>(i) - reading.late;
    if (k < 0 || k >= static_cast<std::ptrdiff_t>(truth.size())) continue;
    const State& exact = truth[static_cast<std::size_t>(k)];
    if (!file.q.empty() && scene.rotation->attitude)
      attitude.push_back(attitude_error<double>(exact.q, samples[i].q));
    if (!file.w.empty()) {
      const double n = exact.w.norm();
      rate.push_back((samples[i].w_B - exact.w).norm() / (n > 0 ? n : 1));
    }
  }
  return {median(std::move(attitude)), median(std::move(rate))};
}

bool even(std::span<const double> t) {
  if (t.size() < 8) return false;
  const double h = t[1] - t[0];
  for (std::size_t i = 2; i < t.size(); ++i)
    if (std::abs(t[i] - t[i - 1] - h) > 1e-6 * h) return false;
  return true;
}

bool falls(double before, double after) { return before > nothing_to_explain && after < before / tenfold; }

}  // namespace

std::vector<Sample> samples_of(const Scene& scene, const TrajectoryFile& file, const Reading& reading) {
  std::vector<Sample> out;
  if (!scene.rotation) {
    return with_general_model<double>(scene, [&](const auto& m) {
      using M = std::decay_t<decltype(m)>;
      for (std::size_t i = 0; i < file.t.size(); ++i) {
        typename M::State y = m.initial;
        if constexpr (M::has_translation && !M::has_rotation)
          for (int k = 0; k < 3; ++k) {
            if (!file.p.empty()) y[static_cast<std::size_t>(k)] = file.p[i][k];
            if (!file.v.empty()) y[static_cast<std::size_t>(k + 3)] = file.v[i][k];
          }
        out.push_back(observe(m, file.t[i], y.data()));
      }
      return out;
    });
  }
  const RotationData& r = *scene.rotation;
  return with_general_model<double>(scene, [&](const auto& m) {
    using M = std::decay_t<decltype(m)>;
    if constexpr (M::has_rotation) {
      constexpr auto rotation = static_cast<std::size_t>(std::decay_t<decltype(m.rotation)>::size);
      constexpr auto w_at = static_cast<std::size_t>(std::decay_t<decltype(m.rotation)>::w_at);
      for (std::size_t i = 0; i < file.t.size(); ++i) {
        typename M::State y = m.initial;
        Quaternion q_user = Quaternion::Identity();
        if (!file.q.empty()) {
          const auto& c = file.q[i];
          q_user =
              reading.scalar_last ? Quaternion(c[3], c[0], c[1], c[2]) : Quaternion(c[0], c[1], c[2], c[3]);
          if (reading.inverse) q_user = q_user.conjugate();
        }
        if constexpr (M::has_attitude) {
          const Quaternion q = q_user * r.principal_to_user;
          y[0] = q.w();
          y[1] = q.x();
          y[2] = q.y();
          y[3] = q.z();
        }
        if (!file.w.empty()) {
          Vec3 w = file.w[i];
          if (reading.degrees) w *= std::numbers::pi / 180;
          if (reading.space_rates) w = to_body<double>(q_user, w);
          w = to_body<double>(r.principal_to_user, w);
          for (std::size_t k = 0; k < 3; ++k) y[w_at + k] = w[static_cast<int>(k)];
        }
        if constexpr (M::has_translation)
          for (std::size_t k = 0; k < 3; ++k) {
            if (!file.p.empty()) y[rotation + k] = file.p[i][static_cast<int>(k)];
            if (!file.v.empty()) y[rotation + 3 + k] = file.v[i][static_cast<int>(k)];
          }
        Sample s = observe(m, file.t[i], y.data());
        if ((file.w.empty() || (file.q.empty() && M::has_attitude)) && !file.L.empty()) s.L = file.L[i];
        if (file.w.empty() && !file.energy.empty()) s.total_energy = file.energy[i];
        out.push_back(s);
      }
    }
    return out;
  });
}

std::vector<Mistake> likely_mistakes(const Scene& scene, const TrajectoryFile& file, const Reading& reading,
                                     std::span<const WideSample> truth) {
  std::vector<Mistake> found;
  if (!scene.rotation || (file.q.empty() && file.w.empty())) return found;
  struct Explained {
    Reading reading;
    Misfit misfit;
  };
  /// The reading that lies nearest, beginning with the attitude, which turns the rates.
  const auto best_reading = [&](std::span<const State> exact, int late) {
    Explained best{reading, {}};
    best.reading.late = late;
    best.misfit = misfit_of(scene, file, best.reading, exact);
    const Reading as_said = best.reading;
    for (const int k : {1, 2, 3}) {
      if (file.q.empty()) break;
      Reading other = as_said;
      other.scalar_last ^= (k & 1) != 0;
      other.inverse ^= (k & 2) != 0;
      const Misfit m = misfit_of(scene, file, other, exact);
      if (falls(best.misfit.attitude, m.attitude)) best = {other, m};
    }
    const Reading attitude_found = best.reading;
    for (const int k : {1, 2, 3}) {
      if (file.w.empty() || ((k & 1) != 0 && file.q.empty())) continue;
      Reading other = attitude_found;
      other.space_rates ^= (k & 1) != 0;
      other.degrees ^= (k & 2) != 0;
      const Misfit m = misfit_of(scene, file, other, exact);
      if (falls(best.misfit.rate, m.rate)) best = {other, m};
    }
    return best;
  };
  const std::vector<State> exact = states_of(truth);
  const Misfit said = misfit_of(scene, file, reading, exact);
  Explained best = best_reading(exact, 0);
  bool no_gyroscopic_term = false;
  if (even(file.t))
    for (const int late : {1, -1})
      if (const Explained other = best_reading(exact, late); falls(best.misfit.worst(), other.misfit.worst()))
        best = other;
  if (best.misfit.worst() > nothing_to_explain)
    if (const auto mistaken = without_gyroscopic_term(scene, file.t))
      if (const Explained other = best_reading(*mistaken, 0);
          falls(best.misfit.worst(), other.misfit.worst())) {
        best = other;
        no_gyroscopic_term = true;
      }

  const auto told = [&](bool yes, std::string_view id, std::string_view what, bool of_rates) {
    if (yes)
      found.push_back({id, what, of_rates ? "rate" : "attitude", of_rates ? said.rate : said.attitude,
                       of_rates ? best.misfit.rate : best.misfit.attitude});
  };
  const Reading& r = best.reading;
  const bool rates_alone = file.q.empty();
  told(r.scalar_last && !reading.scalar_last, "scalar-last",
       "the quaternion has its scalar last: qw, qx, qy, qz hold x, y, z, w (say --quaternion xyzw)", false);
  told(!r.scalar_last && reading.scalar_last, "scalar-first",
       "the quaternion has its scalar first (say --quaternion wxyz)", false);
  told(r.inverse != reading.inverse, "inverse-attitude",
       "the quaternion is the inverse (conjugate): it turns space into body; needs body into space", false);
  told(r.space_rates && !reading.space_rates, "space-rates",
       "the angular velocity is in the space frame, not in the body frame (say --frame space)", true);
  told(!r.space_rates && reading.space_rates, "body-rates",
       "the angular velocity is in the body frame, not in the space frame (say --frame body)", true);
  told(r.degrees, "degrees", "the angular velocity is in degrees per second; needs rad/s", true);
  told(r.late > 0, "one-row-late", "each row holds the state of the row before: the file is one sample late",
       rates_alone);
  told(r.late < 0, "one-row-early", "each row holds the state of the row after: the file is one sample early",
       rates_alone);
  told(no_gyroscopic_term, "no-gyroscopic-term",
       "the gyroscopic term is missing: the motion follows I w' = tau, without (I w) x w", rates_alone);
  return found;
}

}  // namespace polhode
