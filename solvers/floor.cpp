#include "solvers/floor.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/sensitivity.hpp"

namespace polhode {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double double_epsilon = std::numeric_limits<double>::epsilon();

}  // namespace

Floor floor_of(const Scene& scene, std::span<const double> times, const Truth&, const Allowance&) {
  Floor t;
  if (!scene.rotation) return t;
  // From at most 17 times on.
  std::vector<double> marks;
  const std::size_t every = (times.size() + 15) / 16;
  for (std::size_t i = 0; i < times.size(); i += every) marks.push_back(times[i]);
  if (marks.back() < times.back()) marks.push_back(times.back());
  const Sensitivity s = sensitivity(scene, marks);
  if (!s.known) {
    t.conditioning = t.attitude_growth = t.rate_growth = none;
    t.attitude = 4e-16;  // the least that it can be
    t.rate = double_epsilon;
    return t;
  }
  const int a = s.attitude;
  const auto worst = [](const auto& block) {
    return block.size() == 0 ? 0.0 : block.colwise().norm().maxCoeff();
  };
  // Of any disturbance on the way. The resolution of an attitude, and an ulp of the rates, are least.
  double attitude_later = 1, rate_later = 1;
  const double w0 = scene.rotation->w0.norm(), unit = w0 > 0 ? w0 / s.rates.front() : 1;
  for (const auto& from : s.maps)
    for (const Eigen::MatrixXd& map : from) {
      attitude_later = std::max(attitude_later, worst(map.topRows(a)));
      rate_later = std::max(rate_later, worst(map.bottomRows(3)));
      if (&from != &s.maps.front()) continue;
      t.attitude_growth = std::max(t.attitude_growth, unit * worst(map.topRightCorner(a, 3)));
      t.rate_growth = std::max(t.rate_growth, unit * worst(map.bottomRightCorner(3, 3)));
    }
  t.conditioning = std::max(t.attitude_growth, t.rate_growth);
  t.attitude = std::max(double_epsilon * std::max(t.attitude_growth, attitude_later), 4e-16);
  t.rate = double_epsilon * std::max(t.rate_growth, rate_later);
  return t;
}

}  // namespace polhode
