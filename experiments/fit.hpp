// Least squares on a line, and the classes and orders that are read off slopes.
#pragma once
#include <optional>
#include <span>
#include <string_view>

namespace polhode {

struct Line {
  double slope, slope_error;  // standard error; 0 for two points
  int points;
};

/// Least-squares line through (x, y); needs two points.
Line fit_line(std::span<const double> x, std::span<const double> y);

/// Observed order of a ladder of errors, coarse to fine: slope of log error against log h.
///
/// Points at or below `floor`, above `coarse` (pre-asymptotic), not finite, or near and beyond the point
/// where the errors grow again (rounding) are left out. Windows of four neighbouring points (three if there
/// are no more) are tried from the fine end; the first that lies on a straight line (standard error of the
/// slope below 0.03) is taken, else the straightest: steps that are too coarse bend the ladder at one end,
/// rounding at the other. With an infinite `coarse` (a solver that claims no convergence) nothing but the
/// floor is left out.
///
/// returns  nothing if three usable neighbours do not exist
std::optional<Line> observed_order(std::span<const double> h, std::span<const double> error, double floor,
                                   double coarse);

/// Class of a drift d(t) >= 0 sampled at increasing t > 0: "bounded", "random_walk", "linear", "quadratic",
/// "exponential" or "not_finite", by the slope of its running maximum in log-log, over the later half of the
/// decades sampled; an exponential is a straighter line in log-linear that has grown a thousandfold.
struct Drift {
  std::string_view kind;
  double exponent, exponent_error;  // of t; of exp(t) per second if exponential
};
Drift classify_drift(std::span<const double> t, std::span<const double> d, double resolution);

}  // namespace polhode
