// Slopes.
#include "experiments/fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace polhode {

Line fit_line(std::span<const double> x, std::span<const double> y) {
  const auto n = static_cast<double>(x.size());
  double mx = 0, my = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mx += x[i] / n;
    my += y[i] / n;
  }
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mx) * (x[i] - mx);
    xy += (x[i] - mx) * (y[i] - my);
    yy += (y[i] - my) * (y[i] - my);
  }
  const double slope = xx > 0 ? xy / xx : 0;
  const double rest = std::max(0.0, yy - slope * xy);
  const double error = x.size() > 2 && xx > 0 ? std::sqrt(rest / (n - 2) / xx) : 0;
  return {slope, error, static_cast<int>(x.size())};
}

std::optional<Line> observed_order(std::span<const double> h, std::span<const double> error, double floor,
                                   double coarse) {
  constexpr double straight = 0.03;
  // Where the errors turn and grow again with finer steps, rounding has taken over: what lies at or beyond
  // the turn, or within ten times its error, is not truncation.
  std::size_t turn = 0;
  for (std::size_t i = 0; i < error.size(); ++i)
    if (std::isfinite(error[i]) && !(error[i] >= error[turn])) turn = i;
  const bool turned = turn + 1 < error.size() && std::isfinite(coarse);
  const auto usable = [&](std::size_t i) {
    const bool converging = !turned || (i < turn && error[i] > 10 * error[turn]);
    return std::isfinite(error[i]) && error[i] > floor && error[i] < coarse && converging;
  };
  for (const std::size_t width : {std::size_t{4}, std::size_t{3}}) {
    std::optional<Line> best;
    for (std::size_t i = h.size() + 1 - std::min(width, h.size() + 1); i-- > 0;) {
      std::vector<double> x, y;
      for (std::size_t k = i; k < i + width && usable(k); ++k) {
        x.push_back(std::log(h[k]));
        y.push_back(std::log(error[k]));
      }
      if (x.size() < width) continue;
      const Line line = fit_line(x, y);
      if (line.slope_error < straight) return line;
      if (!best || line.slope_error < best->slope_error) best = line;
    }
    if (best) return best;
  }
  return std::nullopt;
}

Drift classify_drift(std::span<const double> t, std::span<const double> d, double resolution) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> log_t, lin_t, log_d;
  double largest = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (!std::isfinite(d[i])) return {"not_finite", none, none};
    largest = std::max(largest, d[i]);
    if (t[i] > 0 && largest > resolution) {
      log_t.push_back(std::log(t[i]));
      lin_t.push_back(t[i]);
      log_d.push_back(std::log(largest));
    }
  }
  if (log_t.size() < 4) return {"bounded", 0, 0};  // nothing above what a double resolves
  // The later half of the decades: transients of the start are not drift.
  const double from = 0.5 * (log_t.front() + log_t.back());
  const auto begin =
      static_cast<std::size_t>(std::lower_bound(log_t.begin(), log_t.end(), from) - log_t.begin());
  const std::size_t n = log_t.size() - begin;
  if (n < 4) return {"bounded", 0, 0};
  const std::span x(log_t.data() + begin, n), s(lin_t.data() + begin, n), y(log_d.data() + begin, n);
  const Line power = fit_line(x, y), growth = fit_line(s, y);
  const double gained = y.back() - y.front();
  const auto relative = [](const Line& l) { return l.slope > 0 ? l.slope_error / l.slope : 1e300; };
  if (gained > std::log(1e3) && relative(growth) < relative(power) && power.slope > 2.5)
    return {"exponential", growth.slope, growth.slope_error};
  const double e = power.slope;
  return {e < 0.25   ? "bounded"
          : e < 0.75 ? "random_walk"
          : e < 1.5  ? "linear"
                     : "quadratic",
          e, power.slope_error};
}

}  // namespace polhode
