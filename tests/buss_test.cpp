// Derivatives of torques: the arithmetic of truncated series, and the orders that rest on it where a torque
// depends on time, on a square root and on drag.
#include <cmath>

#include <gtest/gtest.h>

#include "experiments/question.hpp"
#include "solvers/truncated_series.hpp"

namespace polhode {

std::vector<Table> convergence(const Plan& plan);

namespace {

TruncatedSeries series(double a, double b, double c, double d) {
  TruncatedSeries x(a);
  x[1] = b;
  x[2] = c;
  x[3] = d;
  return x;
}

void expect_equal(const TruncatedSeries& got, const TruncatedSeries& want) {
  for (int k = 0; k < TruncatedSeries::terms; ++k)
    EXPECT_NEAR(got[k], want[k], 1e-14) << "coefficient " << k;  // a dozen operations on numbers near one
}

TEST(TruncatedSeries, InversesUndo) {
  const TruncatedSeries x = series(1.3, -0.7, 0.4, 1.1), y = series(-0.8, 0.5, 1.2, -0.3);
  expect_equal(x * y / y, x);
  expect_equal(sqrt(x) * sqrt(x), x);
  expect_equal(x - y + y, x);
  expect_equal(-(x * y), (-x) * y);
}

TEST(TruncatedSeries, CircularFunctionsOfTime) {
  // sin(0.6 + 2 s): derivatives 2 cos, -4 sin, -8 cos at 0.6
  const TruncatedSeries x = series(0.6, 2, 0, 0);
  const double s = std::sin(0.6), c = std::cos(0.6);
  expect_equal(sin(x), series(s, 2 * c, -2 * s, -8 * c / 6));
  expect_equal(cos(x), series(c, -2 * s, -2 * c, 8 * s / 6));
  const TruncatedSeries y = series(0.6, 2, -0.5, 0.9);
  expect_equal(sin(y) * sin(y) + cos(y) * cos(y), 1.0);
  expect_equal(sign_of(y), 1.0);
  expect_equal(sign_of(-y), -1.0);
}

TEST(Buss, OrdersWhereTheTorqueDependsOnTimeOrOnARoot) {
  for (const char* scene : {"gravity-gradient-satellite", "attitude-spring"}) {
    Plan plan;
    plan.scenes = {find_scene(scene)};
    plan.methods = select_methods({"buss*"});
    plan.options.quiet = plan.options.quick = true;
    const Table orders = convergence(plan)[1];
    int fitted = 0;
    for (const auto& row : orders.rows) {
      if (!std::holds_alternative<double>(row[3]) || !std::holds_alternative<double>(row[4])) continue;
      EXPECT_NEAR(std::get<double>(row[4]), std::get<double>(row[3]), 0.15)
          << scene << ", " << std::get<std::string>(row[1]) << ", " << std::get<std::string>(row[2]);
      ++fitted;
    }
    EXPECT_EQ(fitted, 16) << scene;
  }
}

}  // namespace
}  // namespace polhode
