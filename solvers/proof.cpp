#include "solvers/proof.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "models/errors.hpp"
#include "solvers/second_method.hpp"

namespace polhode {
namespace {

using V = Vec3T<Checked>;
using Kind = StatedLoad::Kind;

/// A stretch this long, in units of the state's pace, and so many rows: 5e-42 and 4e-45 of the state are left
/// of the second method's error.
struct Effort {
  double stretch;
  int rows;
};
constexpr Effort brief{1.0 / 16384, 4}, thorough{1.0 / 16, 10};

double size_of(const V& v) { return v.norm().convert_to<double>(); }

/// What thousands of roundings in 50 digits may leave, beside what is stated.
constexpr double rounding = 1e-45;

/// What differences of rates are measured by: |w|, but no less than this part of the fastest. A body may come
/// to rest, and what is left of its rates is as exact as those were that it had.
constexpr double least_rate = 1e-3;

std::string digits(const Checked& x) { return x.str(24, std::ios_base::scientific); }
template <class Vector>
std::string digits(const Vector& v) {
  std::string text;
  for (Eigen::Index i = 0; i < v.size(); ++i) text += (i ? ", " : "") + digits(Checked(v[i]));
  return "(" + text + ")";
}
std::string digits(const QuaternionT<Checked>& q) {
  return digits(Eigen::Matrix<Checked, 4, 1>(q.w(), q.x(), q.y(), q.z()));
}

class Prover {
 public:
  Prover(const std::string& scene, const ExactScene& exact, const ExactMotion& motion, double until,
         std::span<const WideSample> samples, const ExactMotion::Uncertainty& uncertainty,
         const Allowance& allowance)
      : scene_(scene),
        exact_(exact),
        motion_(motion),
        until_(until),
        samples_(samples),
        allowance_(allowance),
        second_(exact),
        attitude_(4 * uncertainty.attitude + rounding),
        rate_(4 * uncertainty.rate + rounding) {
    for (const WideSample& s : samples)
      fastest_ = std::max(fastest_, Wide(s.w_B.norm()).convert_to<double>());
    fastest_ = std::max(fastest_, natural_rate(exact));
  }

  void prove() {
    const StatedState start = second_.start();
    const WideSample first = samples_.front().t == 0 ? samples_.front() : sample_at(Wide(0));
    compare("the start that the file gives", first, start, {});
    conserve(start);
    // What costs much is proven thoroughly; a closed form of few times, where it costs least.
    const bool costly = motion_.steps() > 0 || samples_.size() >= 64;
    follow(Wide(0), start, costly ? thorough : brief);
    const std::size_t n = samples_.size(), more = n == 1 ? 1 : costly ? 3 : 1;
    for (std::size_t k = 0; k < more; ++k) {
      // The last, and two that no pattern in the times can avoid for ever.
      const std::size_t i = k == 0 ? n - 1 : (n * (k == 1 ? 3819 : 6180)) / 10007;
      if (samples_[i].t > 0) follow(samples_[i].t, second_.stated(samples_[i]), brief);
    }
  }

 private:
  WideSample sample_at(const Wide& t) const { return motion_.at(std::span(&t, 1), allowance_).front(); }

  [[noreturn]] void contradict(const std::string& what, const Wide& t, const std::string& truth,
                               const std::string& other, double gap, double allowed) const {
    throw Error(
        70, "the truth of '" + scene_ + "' contradicts " + what +
                " at t = " + number_text(t.convert_to<double>()) + " s: got " + truth + " (" +
                motion_.kind() + "), need " + other + "; they differ by " + number_text(gap) +
                ", where at most " + number_text(allowed) +
                " was to be. No number of it is used. This is a mistake of polhode: please report the scene");
  }

  void compare(const std::string& what, const WideSample& sample, const StatedState& other,
               const SecondMethod::Reached& errors) const {
    const StatedState own = second_.stated(sample);
    if (exact_.rotation) {
      if (exact_.rotation->attitude) {
        const double gap = attitude_error<Checked>(own.q(), other.q()).convert_to<double>(),
                     allowed = attitude_ + errors.attitude_error;
        if (!(gap <= allowed))
          contradict(what, sample.t, "attitude " + digits(own.q()), digits(other.q()), gap, allowed);
      }
      const V w = second_.rates_U(own), w_other = second_.rates_U(other);
      const double size = std::max(size_of(w_other), least_rate * fastest_), gap = size_of(V(w - w_other)),
                   allowed = size * (rate_ + errors.rate_error);
      if (!(gap <= allowed)) contradict(what, sample.t, "rates " + digits(w), digits(w_other), gap, allowed);
    }
    if (exact_.translation) {
      const double way = size_of(other.p()) + size_of(other.v()) * (1 + until_) +
                         std::numeric_limits<double>::min(),
                   gap = size_of(V(own.p() - other.p())) + size_of(V(own.v() - other.v())),
                   allowed = way * (1e-36 + errors.way_error);
      if (!(gap <= allowed))
        contradict(what, sample.t, "position " + digits(own.p()), digits(other.p()), gap, allowed);
    }
  }

  /// The second method from a state of time t over a stretch within the motion, beside the truth there.
  void follow(const Wide& t, const StatedState& from, Effort effort) const {
    const double pace = second_.pace(from);
    if (!(pace > 0) || !(until_ > 0)) return;
    Wide h = std::min(effort.stretch / pace, until_);
    for (int tries = 0; tries < 8; ++tries, h /= 16) {
      allowance_.spend();
      const Wide end = t + h <= Wide(until_) ? Wide(t + h) : t - h;
      if (end < 0 || end == t) continue;
      const auto there = second_.reached(Checked(t), from, Checked(end) - Checked(t), effort.rows);
      // A spring that changes its side within the stretch is no smooth equation; nor does a method say much
      // whose own error is large.
      const bool crossed = second_.side(from, end < t) != second_.side(there.state, false);
      if (crossed || !(there.attitude_error < 1e-25) || !(there.rate_error < 1e-25)) continue;
      compare("a second method from t = " + number_text(t.convert_to<double>()) + " s on", sample_at(end),
              there.state, there);
      return;
    }
  }

  /// Energy and angular momentum, where the loads leave them or change them in a known way.
  void conserve(const StatedState& start) const {
    if (!exact_.rotation) return;
    bool potential = true, free = true, only_space = true, only_weight = true;
    const StatedLoad* gradient = nullptr;
    V torque(0, 0, 0), up(0, 0, 0);
    double potential_size = 0;
    const double inertia = exact_.stated->inertia_U.norm().convert_to<double>();
    for (const StatedLoad& load : exact_.stated->loads) {
      free = false;
      potential =
          potential && (load.kind == Kind::gravity_about_pivot || load.kind == Kind::gravity_gradient ||
                        (load.kind == Kind::spring && load.damping == 0));
      only_space = only_space && load.kind == Kind::space_torque;
      only_weight = only_weight && load.kind == Kind::gravity_about_pivot;
      if (load.kind == Kind::space_torque) torque += load.vector.cast<Checked>();
      const double number = load.number.convert_to<double>(), vector = size_of(load.vector.cast<Checked>());
      if (load.kind == Kind::gravity_about_pivot) {
        // About parallel weights alone; others turn L about every axis.
        const V here = load.vector.cast<Checked>();
        if (!up.isZero(0) && !here.cross(up).isZero(0)) only_weight = false;
        up = here;
        potential_size += number * vector * size_of(load.center.cast<Checked>());
      }
      if (load.kind == Kind::spring) potential_size += 4 * number;
      if (load.kind == Kind::gravity_gradient) {
        if (gradient) potential = false;
        gradient = &load;
        potential_size += 3 * number * number * inertia;
      }
    }
    if (gradient && exact_.stated->loads.size() > 1) potential = false;  // Jacobi's integral is that of one
    const bool oriented = exact_.rotation->attitude;
    const auto energy = [&](const Checked& t, const StatedState& s) {
      Checked e = second_.rotational_energy(s) + second_.potential_energy(t, s);
      if (gradient) e -= Checked(gradient->number) * s.L()[2];
      return e;
    };
    const Checked at_start = energy(0, start);
    for (const WideSample& sample : samples_) {
      allowance_.spend();
      const StatedState s = second_.stated(sample);
      const double w = std::max(size_of(second_.rates_U(s)), least_rate * fastest_), momentum = inertia * w;
      const double off_L = momentum * (attitude_ + rate_) * 2;
      if (oriented && (free || only_space)) {
        const V must = start.L() + torque * Checked(sample.t);
        const double gap = size_of(V(s.L() - must));
        if (!(gap <= off_L + 1e-48 * size_of(must)))
          contradict("the angular momentum", sample.t, digits(s.L()), digits(must), gap, off_L);
      }
      if (oriented && !free && only_weight) {
        const Checked along = s.L().dot(up), must = start.L().dot(up);
        const double gap = abs(Checked(along - must)).convert_to<double>() / size_of(up);
        if (!(gap <= off_L + 1e-48 * size_of(start.L())))
          contradict("the angular momentum about the vertical", sample.t, digits(along), digits(must), gap,
                     off_L);
      }
      if (potential) {
        const Checked e = energy(Checked(sample.t), s);
        const double gap = abs(Checked(e - at_start)).convert_to<double>();
        double allowed = 2 * momentum * w * rate_ + 2 * potential_size * attitude_ + 1e-47 * potential_size;
        if (gradient) allowed += gradient->number.convert_to<double>() * off_L;
        if (!(gap <= allowed))
          contradict(gradient ? "Jacobi's integral" : "the energy", sample.t, digits(e), digits(at_start),
                     gap, allowed);
      }
    }
  }

  const std::string& scene_;
  const ExactScene& exact_;
  const ExactMotion& motion_;
  double until_;
  std::span<const WideSample> samples_;
  const Allowance& allowance_;
  SecondMethod second_;
  double attitude_, rate_;  // what two of its values may differ by, rad and relative
  double fastest_ = 0;      // rad/s
};

}  // namespace

void prove(const std::string& scene, const ExactScene& exact, const ExactMotion& motion, double until,
           std::span<const WideSample> samples, const ExactMotion::Uncertainty& uncertainty,
           const Allowance& allowance) {
  if (samples.empty()) return;
  Prover(scene, exact, motion, until, samples, uncertainty, allowance).prove();
}

double least_uncertainty(const ExactScene& exact, std::span<const WideSample> samples) {
  if (!exact.rotation || samples.empty()) return 0;
  Wide fastest(0);
  for (const WideSample& s : samples) fastest = std::max(fastest, Wide(s.w_B.norm()));
  // Some hundred roundings of the state, and one of the angle that it has turned by.
  const Wide left = std::numeric_limits<Wide>::epsilon() * (256 + 4 * fastest * samples.back().t);
  return std::min(left.convert_to<double>(), std::numbers::pi);
}

}  // namespace polhode
