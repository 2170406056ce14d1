// Two recursions along the marks of solvers/sensitivity.hpp, whose maps M take disturbances from one to the
// next: P <- M P, from the start, tells the growth of initial disturbances and of the first rounding; S with
// S S^T <- M (S S^T + N^2) M^T adds up the squares of all roundings N on the way. Divided by their number
// that is what one rounding does in the mean. (The sum itself would grow with the number of marks; a solver
// of high order takes fewer steps than that.) A free body goes round and round its polhode: from the second
// period on its maps are those of the first, and many periods are one power of a map.
#include "solvers/floor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/QR>

#include "models/exact_scene.hpp"
#include "models/free_rotation.hpp"
#include "solvers/sensitivity.hpp"

namespace polhode {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr double least_attitude = 4e-16;            // that a quaternion of doubles resolves, rad
constexpr double most_attitude = std::numbers::pi;  // of two motions that know nothing of each other
constexpr double most_rate = 2;
constexpr double most_growth = 1e300;
constexpr double most_entry = 1e150;  // of a map: a product of two does not overflow
// Rates are measured by |w|, but by no less than this part of the fastest: a body may come to rest.
constexpr double least_rate = 1e-3;
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr int stretch_limit = 10'000;  // 5000 radians, half a second
constexpr int blocks_an_octave = 8;    // an octave: from a number of periods to twice that

/// NaN counts as the bound: what has overflowed.
double bounded(double x, double bound) { return x < bound ? x : bound; }

double largest_column(const auto& block) { return block.colwise().norm().maxCoeff(); }

/// x 2^exponent, up to most_growth. An x that may have been cut off counts as that.
double scaled(double x, int exponent) {
  if (x >= most_entry / 10) return most_growth;
  return x > 0 ? std::min(std::ldexp(x, exponent), most_growth) : x;
}

/// later earlier, cut off at most_entry, so that zeros beside what grows without bounds stay zeros.
DisturbanceMap product(const DisturbanceMap& later, const DisturbanceMap& earlier) {
  return (later * earlier).cwiseMin(most_entry).cwiseMax(-most_entry);
}

/// In units of epsilon: what rounds off an attitude, and each component of the rates by itself. (A component
/// that is small stays as exact as the others: a body that spins about an unstable axis keeps what little it
/// has across it.)
DisturbanceMap rounding(const Vec3& w, bool attitude) {
  Eigen::Matrix<double, 6, 1> n;
  n << Vec3::Constant(attitude ? 1 : 0), w.cwiseAbs();
  return n.asDiagonal();
}

/// What the roundings at many marks have become: the root of the sum of their squares.
struct Noise {
  DisturbanceMap root = DisturbanceMap::Zero();  // root root^T is the sum
  double marks = 0;

  /// The same after `map`, with the roundings at later marks.
  Noise then(const DisturbanceMap& map, const Noise& later) const {
    // [map root, later root] = L Q.
    Eigen::Matrix<double, 12, 6> both;
    both << (map * root).transpose(), later.root.transpose();
    const Eigen::HouseholderQR<Eigen::Matrix<double, 12, 6>> qr(both);
    Noise n;
    n.root = DisturbanceMap(qr.matrixQR().topRows<6>().triangularView<Eigen::Upper>()).transpose();
    n.marks = marks + later.marks;
    return n;
  }
};

/// From the start to a mark.
struct Standing {
  DisturbanceMap map = DisturbanceMap::Identity();  // times 2^exponent
  int exponent = 0;
  Noise noise;
};

/// The map over one period of a free body, freed from what its roundings would become when it is repeated.
///
/// The rates return: after a period they have only slid along their own path, by as much as the period of the
/// disturbed motion is another. Their map is 1 + f g^T with f = w' and g.f = 0, and (w, f), the disturbance
/// of who is late, returns as it was. No f: a steady turn, whose map is left as it is.
DisturbanceMap returned(DisturbanceMap map, const Vec3& w, const Vec3& f) {
  const double f2 = f.squaredNorm();
  if (!(f2 > 0)) return map;
  Vec3 g = (map.bottomRightCorner<3, 3>() - Mat3::Identity()).transpose() * f / f2;
  g -= f * (f.dot(g) / f2);
  map.bottomRightCorner<3, 3>() = Mat3::Identity() + f * g.transpose();
  const Vec3 missing = w - map.topLeftCorner<3, 3>() * w - map.topRightCorner<3, 3>() * f;
  map.topRightCorner<3, 3>() += missing * f.transpose() / f2;
  return map;
}

Vec3 free_acceleration(const Vec3& moments, const Vec3& w) {
  return moments.cwiseProduct(w).cross(w).cwiseQuotient(moments);
}

class Follower {
 public:
  Follower(const Scene& scene, std::span<const double> times, const Allowance& allowance)
      : scene_(scene), times_(times), allowance_(allowance), motion_(scene), end_(times.back()) {}

  Floor run();

 private:
  bool attitude() const { return scene_.rotation->attitude; }
  /// Nothing is left of the motion.
  bool settled() const {
    return floor_.rate >= most_rate && (!attitude() || floor_.attitude >= most_attitude);
  }

  void pass(const Stretch& s, Standing& x);
  void look(const Standing& x, const Vec3& w);
  void answer(const DisturbanceMap& map, int exponent, const Vec3& w);
  bool follow(double until, Standing& x, std::vector<Stretch>* kept);
  bool repeat(double period, const Standing& once, const std::vector<Stretch>& lap);
  void compare();

  struct Growth {
    double attitude, rate, w;
  };

  const Scene& scene_;
  std::span<const double> times_;
  const Allowance& allowance_;
  Sensitivity motion_;
  double end_;
  Floor floor_{.attitude = least_attitude, .rate = epsilon};
  double mark_ = 0;              // s, how far it was followed
  double fastest_ = 0;           // rad/s, so far
  std::vector<Growth> growths_;  // at the asked times
};

/// Goes on by a stretch, with the roundings at its begin.
void Follower::pass(const Stretch& s, Standing& x) {
  allowance_.spend();
  if (!settled()) x.noise = x.noise.then(s.across(), {s.across() * rounding(s.rates.front(), attitude()), 1});
  x.map = s.across() * x.map;
  if (x.map.cwiseAbs().maxCoeff() > 1e100) {
    x.map *= std::ldexp(1.0, -300);
    x.exponent += 300;
  }
  look(x, s.rates.back());
}

/// The floor at a mark.
void Follower::look(const Standing& x, const Vec3& w) {
  fastest_ = std::max(fastest_, w.norm());
  if (settled() || !(fastest_ > 0)) return;
  const DisturbanceMap start = x.map * rounding(scene_.rotation->w0, attitude());
  const auto larger = [&](const auto& first, const auto& later) {
    return epsilon * std::max(scaled(first.norm(), x.exponent),
                              bounded(later.norm() / std::sqrt(x.noise.marks), most_growth));
  };
  const double turned = larger(start.topRows<3>(), x.noise.root.topRows<3>());
  const double changed = larger(start.bottomRows<3>(), x.noise.root.bottomRows<3>());
  floor_.attitude = std::max(floor_.attitude, bounded(turned, most_attitude));
  floor_.rate =
      std::max(floor_.rate, bounded(changed / std::max(w.norm(), least_rate * fastest_), most_rate));
}

/// The growth at the next asked time.
void Follower::answer(const DisturbanceMap& map, int exponent, const Vec3& w) {
  growths_.push_back({scaled(largest_column(map.topRightCorner<3, 3>()), exponent),
                      scaled(largest_column(map.bottomRightCorner<3, 3>()), exponent), w.norm()});
}

/// Stretch by stretch to the first mark at `until` or beyond the last asked time. False: it cannot be
/// followed so far.
bool Follower::follow(double until, Standing& x, std::vector<Stretch>* kept) {
  for (int n = 0; mark_ < std::min(until, end_); ++n) {
    if (n == stretch_limit) return false;
    const std::optional<Stretch> s = motion_.next(until);
    if (!s) return false;
    for (; growths_.size() < times_.size() && times_[growths_.size()] <= s->end;) {
      const double t = times_[growths_.size()];
      answer(s->map_to(t) * x.map, x.exponent, s->rates_at(t));
    }
    pass(*s, x);
    mark_ = s->end;
    if (kept) kept->push_back(*s);
    if (x.exponent > 1000 && (settled() || n + 1 == stretch_limit)) {  // what comes is not less
      growths_.resize(times_.size(), {most_growth, most_growth, s->rates.back().norm()});
      return true;
    }
  }
  return true;
}

/// From the end of the first period on: its stretches over again. All of them in the first periods, then in
/// every second, fourth, ... period, with those between jumped over at once: an eighth of the time at most.
bool Follower::repeat(double period, const Standing& once, const std::vector<Stretch>& lap) {
  const Vec3 w = scene_.rotation->w0, f = free_acceleration(scene_.rotation->moments, w);
  std::vector<DisturbanceMap> to{DisturbanceMap::Identity()};  // each stretch of the lap
  for (const Stretch& s : lap) to.push_back(product(s.across(), to.back()));
  std::vector<DisturbanceMap> doubled{returned(to.back(), w, f)};  // over 1, 2, 4, ... periods
  const auto over = [&](double periods) {
    DisturbanceMap map = DisturbanceMap::Identity();
    std::size_t k = 0;
    while (periods >= 1) {
      if (k == doubled.size()) doubled.push_back(returned(product(doubled.back(), doubled.back()), w, f));
      if (std::fmod(periods, 2) == 1) map = product(doubled[k], map);
      periods = std::floor(periods / 2);
      ++k;
    }
    return map;
  };
  while (growths_.size() < times_.size()) {
    const double t = times_[growths_.size()], periods = std::floor(t / period);
    const double rest = std::clamp(t - periods * period, 0.0, period);
    std::size_t k = 0;
    while (lap[k].end < rest) ++k;
    answer(lap[k].map_to(rest) * to[k] * over(periods), 0, lap[k].rates_at(rest));
  }
  Noise noise = once.noise, block = once.noise;
  double size = 1, done = 1;  // periods
  for (int n = 1;; ++n) {
    Standing x{over(done), 0, noise};
    for (const Stretch& s : lap) {
      if (settled() || s.begin + done * period >= end_) return true;
      pass(s, x);
    }
    noise = noise.then(over(size), block);
    done += size;
    if (n % blocks_an_octave == 0) {
      block = block.then(over(size), block);
      size *= 2;
    }
  }
}

/// A body so nearly round that its period cannot be followed: its growth, which is slow, from closed forms of
/// motions that start 1e-9 apart. What is rounded later grows less than what is rounded first.
void Follower::compare() {
  using Real = long double;
  const RotationData& r = *scene_.rotation;
  const Real distance = Real(1e-9) * r.w0.norm();
  std::vector<FreeRotation<Real>> motions;
  for (int i = -1; i < 3; ++i) {
    Vec3T<Real> w = r.w0.cast<Real>();
    if (i >= 0) w[i] += distance;
    motions.emplace_back(r.moments, r.q0.cast<Real>(), w);
  }
  Vec3 w = r.w0;
  const auto map_to = [&](double t) {
    DisturbanceMap map = DisturbanceMap::Identity();  // a rotation at first stays one of the same angle
    const auto base = motions[0].at(t);
    for (int i = 0; i < 3; ++i) {
      const auto other = motions[std::size_t(i + 1)].at(t);
      const Vec3T<Real> turn = log_rotation<Real>(base.q.conjugate() * other.q) / distance;
      const Vec3T<Real> change = (other.w_B - base.w_B) / distance;
      map.col(3 + i) << turn.cast<double>(), change.cast<double>();
    }
    w = base.w_B.cast<double>();
    return map;
  };
  for (double t = mark_; t < end_;) {
    allowance_.spend();
    t *= std::exp2(1.0 / blocks_an_octave);
    const DisturbanceMap map = map_to(t);
    look({map, 0, {DisturbanceMap::Zero(), 1}}, w);
  }
  while (growths_.size() < times_.size()) {
    const DisturbanceMap map = map_to(times_[growths_.size()]);
    answer(map, 0, w);
  }
}

Floor Follower::run() {
  const RotationData& r = *scene_.rotation;
  double period = std::numeric_limits<double>::infinity();
  if (r.loads.empty()) {
    period = FreeRotation<double>(r.moments, r.q0, r.w0).period();
    if (free_acceleration(r.moments, r.w0).squaredNorm() == 0 && r.w0.norm() > 0)
      period = 2 * std::numbers::pi / r.w0.norm();
  }
  Standing x;
  std::vector<Stretch> lap;
  const bool periodic = std::isfinite(period);
  bool known = follow(period, x, periodic ? &lap : nullptr) && (period >= end_ || repeat(period, x, lap));
  if (!known && periodic && lap.size() == stretch_limit) {
    compare();
    known = true;
  }
  if (!known) {
    floor_.conditioning = floor_.attitude_growth = floor_.rate_growth = none;
    return floor_;
  }
  double fastest = 0;
  for (const Growth& g : growths_) fastest = std::max(fastest, g.w);
  if (fastest == 0) fastest = 1;
  // Where a body comes to rest for a moment, or for good, its own rate would measure nothing.
  const auto scale = [&](double w) { return std::max(w, least_rate * fastest); };
  const double unit = scale(r.w0.norm());
  const auto widen = [](double& largest, double growth, double factor) {
    largest = std::max(largest, growth < most_growth ? bounded(factor * growth, most_growth) : most_growth);
  };
  for (const Growth& g : growths_) {
    if (attitude()) widen(floor_.attitude_growth, g.attitude, unit);
    widen(floor_.rate_growth, g.rate, unit / scale(g.w));
  }
  floor_.conditioning = std::max(floor_.attitude_growth, floor_.rate_growth);
  return floor_;
}

/// The truth may start from other numbers than solvers do: what the file says, not the doubles nearest to it.
bool starts_elsewhere(const Scene& scene, const Truth& truth) {
  if (truth.samples.empty()) return false;
  const RotationData& r = *scene.rotation;
  const WideSample& s = truth.samples.front();
  const Wide rounding(1e-30);
  return (r.attitude && attitude_error<Wide>(s.q, r.q0.cast<Wide>()) > rounding) ||
         (s.w_B - r.w0.cast<Wide>()).norm() > rounding * s.w_B.norm();
}

/// The floor is at least what starting from the scene's doubles makes of the truth.
void include_start(const Scene& scene, std::span<const double> times, const Truth& truth, Floor& floor) {
  const std::optional<std::vector<Turning>> rounded = motion_of_doubles(scene, times);
  if (!rounded || truth.samples.size() != times.size()) return;
  double fastest = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const WideSample& s = truth.samples[i];
    const Turning& x = (*rounded)[i];
    const auto w = s.w_B.norm().convert_to<double>();
    fastest = std::max(fastest, w);
    const double scale = std::max(w, least_rate * fastest);
    const Vec3T<Wide> gap = s.w_B - x.w_B.cast<Wide>();
    if (scene.rotation->attitude)
      floor.attitude =
          std::max(floor.attitude, attitude_error<Wide>(s.q, x.q.cast<Wide>()).convert_to<double>());
    if (scale > 0)
      floor.rate = std::max(floor.rate, bounded(gap.norm().convert_to<double>() / scale, most_rate));
  }
}

}  // namespace

Floor floor_of(const Scene& scene, std::span<const double> times, const Truth& truth,
               const Allowance& allowance) {
  if (!scene.rotation) return {};
  Floor floor = Follower(scene, times, allowance).run();
  // The one place where the reduction of the file to doubles comes in.
  if (starts_rounded(scene) || starts_elsewhere(scene, truth)) include_start(scene, times, truth, floor);
  return floor;
}

}  // namespace polhode
