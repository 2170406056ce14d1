// Explicit Runge-Kutta methods: their coefficients against the theory, and what compensated summation is
// worth.
#include <cmath>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "models/model.hpp"
#include "solvers/dop853_table.hpp"
#include "solvers/registry.hpp"
#include "solvers/stability_function.hpp"
#include "solvers/verner98_table.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

// ---- order conditions, one for each rooted tree

/// A rooted tree: the subtrees that hang at its root, by their places in a list of all trees.
struct Tree {
  int nodes = 1;
  std::vector<std::size_t> subtrees;
  double density = 1;  // gamma of the tree: its weight has to be 1/gamma
};

/// All rooted trees of up to so many nodes.
std::vector<Tree> trees_up_to(int most) {
  std::vector<Tree> all;
  std::vector<std::size_t> chosen;
  const auto grow = [&](const auto& self, int nodes, int left, std::size_t largest) -> void {
    if (left == 0) {
      Tree tree{nodes, chosen, double(nodes)};
      for (const std::size_t s : chosen) tree.density *= all[s].density;
      all.push_back(tree);
      return;
    }
    for (std::size_t s = 0; s <= largest && s < all.size(); ++s) {
      if (all[s].nodes > left) continue;
      chosen.push_back(s);
      self(self, nodes, left - all[s].nodes, s);
      chosen.pop_back();
    }
  };
  for (int n = 1; n <= most; ++n) grow(grow, n, n - 1, all.size());
  return all;
}

TEST(OrderConditions, TreesAreAllThere) {
  // Rooted trees of 1, 2, ... nodes: OEIS A000081.
  std::map<int, int> count;
  for (const Tree& t : trees_up_to(9)) ++count[t.nodes];
  EXPECT_EQ(count, (std::map<int, int>{
                       {1, 1}, {2, 1}, {3, 2}, {4, 4}, {5, 9}, {6, 20}, {7, 48}, {8, 115}, {9, 286}}));
}

/// Largest |b phi(tree) - theta^nodes/gamma| over the trees of so many nodes: for the result at theta h.
template <int stages>
long double residual(const std::vector<Tree>& trees, int least, int most, const double (&a)[stages][stages],
                     const std::vector<double>& b, long double theta = 1) {
  std::vector<std::array<long double, std::size_t(stages)>> phi;
  long double largest = 0;
  for (const Tree& tree : trees) {
    if (tree.nodes > most) break;
    auto& p = phi.emplace_back();
    p.fill(1);
    for (const std::size_t subtree : tree.subtrees)
      for (std::size_t i = 0; i < p.size(); ++i) {
        long double sum = 0;
        for (std::size_t j = 0; j < i; ++j)
          if (a[i][j] != 0) sum += a[i][j] * phi[subtree][j];
        p[i] *= sum;
      }
    long double weight = 0;
    for (std::size_t i = 0; i < p.size(); ++i) weight += b[i] * p[i];
    if (tree.nodes >= least)
      largest = std::max(largest, std::abs(weight - std::pow(theta, tree.nodes) / tree.density));
  }
  return largest;
}

/// Every condition up to this order holds, and one of the next order does not. Where the coefficients are
/// rounded to doubles the weights are off by some 1e-16 times derivatives of up to a few hundred; and a
/// coefficient that is wrong in its tenth digit shows.
template <int stages>
void expect_order(int order, const double (&a)[stages][stages], const std::vector<double>& b) {
  static const auto trees = trees_up_to(10);
  constexpr long double tolerance = 1e-13L;
  EXPECT_LT(residual<stages>(trees, 1, order, a, b), tolerance);
  EXPECT_GT(residual<stages>(trees, order + 1, order + 1, a, b), 1e-7);
  for (int i = 0; i < stages; ++i) {
    std::vector<double> wrong_b = b;
    wrong_b[std::size_t(i)] *= 1 + 1e-10;
    if (b[std::size_t(i)] != 0) {
      EXPECT_GT(residual<stages>(trees, 1, order, a, wrong_b), tolerance) << "b " << i;
    }
  }
}

template <int stages>
void expect_row_sums(const double (&a)[stages][stages], const double (&c)[stages]) {
  for (int i = 0; i < stages; ++i) {
    long double sum = 0, absolute = 0;
    for (int j = 0; j < i; ++j) {
      sum += a[i][j];
      absolute += std::abs(a[i][j]);
    }
    EXPECT_LE(std::abs(sum - c[i]), std::ldexp(1.0L, -53) * (absolute + c[i])) << "row " << i;
    for (int j = i; j < stages; ++j) EXPECT_EQ(a[i][j], 0) << "not explicit: " << i << ", " << j;
  }
}

template <std::size_t n>
std::vector<double> weights(const double (&b)[n], const double (&difference)[n], double sign) {
  std::vector<double> w(b, b + n);
  for (std::size_t i = 0; i < n; ++i) w[i] += sign * difference[i];
  return w;
}

TEST(OrderConditions, Dop853) {
  using T = Dop853Table;
  expect_row_sums(T::a, T::c);
  expect_order(8, T::a, {std::begin(T::b), std::end(T::b)});
  expect_order(3, T::a, {std::begin(T::b_order_3), std::end(T::b_order_3)});
  expect_order(5, T::a, weights(T::b, T::b_minus_order_5, -1));
}

TEST(OrderConditions, DenseOutputOfDop853) {
  // y(t + x h) = y + h sum b_i(x) k_i: the weights that belong to the terms of the interpolation, with the
  // stages of the step, the slope at its end and three more. Order 7 within the step, that of the step at its
  // end. The coefficients reach 500: 1e-12 for their rounding.
  using T = Dop853Table;
  constexpr int n = T::dense_stages;
  double a[n][n] = {};
  for (int i = 0; i < T::stages; ++i) std::copy(T::a[i], T::a[i] + T::stages, a[i]);
  std::copy(T::b, T::b + T::stages, a[T::stages]);
  for (int i = 0; i < 3; ++i) std::copy(T::a_dense[i], T::a_dense[i] + n, a[T::stages + 1 + i]);
  double c[n];
  std::copy(T::c, T::c + T::stages, c);
  c[T::stages] = 1;
  std::copy(T::c_dense, T::c_dense + 3, c + T::stages + 1);
  expect_row_sums(a, c);
  const auto trees = trees_up_to(8);
  for (const double x : {0.1, 0.5, 0.8, 1.0}) {
    std::vector<double> weight(n);
    for (int i = 0; i < n; ++i) {
      const double way = i < T::stages ? T::b[i] : 0, start = i == 0, end = i == T::stages;
      const double high =
          T::dense[0][i] + x * (T::dense[1][i] + (1 - x) * (T::dense[2][i] + x * T::dense[3][i]));
      weight[std::size_t(i)] =
          x * (way + (1 - x) * (start - way + x * (2 * way - start - end + (1 - x) * high)));
    }
    EXPECT_LT(residual<n>(trees, 1, 7, a, weight, x), 1e-12) << x;
    if (x < 1) {
      EXPECT_GT(residual<n>(trees, 8, 8, a, weight, x), 1e-10) << x;
    } else {
      EXPECT_LT(residual<n>(trees, 8, 8, a, weight, x), 1e-12) << x;
    }
  }
}

TEST(OrderConditions, Verner98) {
  using T = Verner98Table;
  expect_row_sums(T::a, T::c);
  expect_order(9, T::a, {std::begin(T::b), std::end(T::b)});
  expect_order(8, T::a, weights(T::b, T::order_8_minus_b, 1));
}

/// Changes each coefficient in its ninth digit and asks whether a condition of one of the formulas notices.
template <int stages>
void expect_that_a_wrong_digit_shows(int order, const double (&a)[stages][stages],
                                     const std::vector<std::vector<double>>& formulas) {
  const auto trees = trees_up_to(order);
  double wrong[stages][stages];
  for (int i = 3; i < stages; ++i)
    for (int j = 0; j < i; ++j) {
      if (a[i][j] == 0) continue;
      std::copy(&a[0][0], &a[0][0] + stages * stages, &wrong[0][0]);
      wrong[i][j] *= 1 + 1e-9;
      long double largest = 0;
      for (const auto& b : formulas) largest = std::max(largest, residual<stages>(trees, 1, order, wrong, b));
      EXPECT_GT(largest, 1e-13L) << i << ", " << j;
    }
}

TEST(OrderConditions, AWrongDigitShows) {
  // Stages 2 and 3 hardly show in the conditions, which is how such formulas are made: they have their row
  // sums. Stage 16 of Verner's pair is seen by the estimate alone, stages 14 and 15 by the formula alone.
  expect_that_a_wrong_digit_shows(8, Dop853Table::a,
                                  {{std::begin(Dop853Table::b), std::end(Dop853Table::b)}});
  expect_that_a_wrong_digit_shows(9, Verner98Table::a,
                                  {{std::begin(Verner98Table::b), std::end(Verner98Table::b)},
                                   weights(Verner98Table::b, Verner98Table::order_8_minus_b, 1)});
}

// ---- runs

Scene hairer_vilmart() {
  Scene scene;
  scene.duration = 10;
  RotationData rotation;
  rotation.moments = Vec3(0.6, 0.8, 1);
  rotation.w0 = Vec3(3, 0.5, -0.9);
  scene.rotation = rotation;
  return scene;
}

Trajectory run(const Method& method, const Scene& scene, const Setting& setting, const Grid& grid) {
  const Prepared prepared = method.prepare(scene, setting);
  EXPECT_TRUE(prepared.integrate) << method.id << ": " << prepared.unsupported;
  Trajectory trajectory;
  if (prepared.integrate) prepared.integrate(grid, trajectory);
  return trajectory;
}

TEST(StabilityPolynomial, IsWhatAStepDoesToLinearDrag) {
  // v' = -k v: one step of size h multiplies v by R(-k h). Products of some twenty rounded numbers, some of
  // them tens of times the result: 1e-13 of it.
  Scene scene;
  scene.duration = 1;
  TranslationData translation;
  translation.mass = 1;
  translation.v0 = Vec3(1, -2, 0.5);
  translation.drag = 1;
  translation.has_force = true;
  scene.translation = translation;
  Setting setting;
  setting.knob = Knob::steps;
  int checked = 0;
  for (const Method* m : all_methods()) {
    if (m->stability_polynomial.empty() || !m->by_steps) continue;
    const Prepared prepared = m->prepare(scene, setting);
    if (!prepared.integrate) continue;
    for (const double h : {0.125, 1.0, 2.5}) {
      Grid grid;
      grid.stretches.push_back({h, 1, h});
      Trajectory t;
      prepared.integrate(grid, t);
      ASSERT_EQ(t.samples.size(), 1u) << m->id;
      double R = 0, size = 0;
      R = amplification(*m, -h);
      for (std::size_t i = m->stability_polynomial.size(); i-- > 0;)
        size = size * h + std::abs(m->stability_polynomial[i]);
      EXPECT_LT((t.samples[0].v - R * translation.v0).norm(), 1e-13 * size) << m->id << " at h = " << h;
    }
    ++checked;
  }
  EXPECT_GE(checked, 10);
}

TEST(StabilityPolynomial, BeginsAsTheExponential) {
  for (const Method* m : all_methods()) {
    // R = P/Q: its series by long division.
    const auto coefficient = [](std::span<const double> c, std::size_t i) {
      return i < c.size() ? c[i] : i == 0 ? 1.0 : 0.0;
    };
    std::vector<double> R;
    double factorial = 1;
    for (std::size_t i = 0; !m->stability_polynomial.empty() && double(i) <= m->claims.attitude_order; ++i) {
      if (i > 0) factorial *= double(i);
      double r = coefficient(m->stability_polynomial, i);
      for (std::size_t k = 1; k <= i; ++k) r -= coefficient(m->stability_denominator, k) * R[i - k];
      R.push_back(r);
      EXPECT_NEAR(r * factorial, 1, 1e-9) << m->id << ", z^" << i;
    }
  }
}

TEST(ExplicitRungeKutta, SamplesWithinStepsAreAsAccurateAsTheRun) {
  // Tight tolerances take steps of 0.2 to 0.9 s; 1000 samples lie mostly inside. Between steps the dense
  // output of order 7 has an error of its own, of the tolerance's size; the branches of the others have none.
  // Truth: the closed form.
  Grid grid;
  for (int i = 1; i <= 1000; ++i) grid.stretches.push_back({i * 0.01, 1, 0.01});
  const Trajectory truth = run(find_method("exact"), hairer_vilmart(), {}, grid);
  for (const char* id : {"dop853", "verner98", "gbs"})
    for (const double rtol : {1e-6, 1e-8, 1e-10}) {
      Setting setting;
      setting.knob = Knob::tolerance;
      setting.rtol = rtol;
      const Trajectory t = run(find_method(id), hairer_vilmart(), setting, grid);
      ASSERT_EQ(t.outcome, Outcome::ok) << id << ": " << t.reason;
      EXPECT_LT(t.work.steps, 200) << id;
      double largest = 0;
      for (std::size_t i = 0; i < t.samples.size(); ++i)
        largest = std::max(largest, attitude_error(truth.samples[i].q, t.samples[i].q));
      const double end = attitude_error(truth.samples.back().q, t.samples.back().q);
      EXPECT_LT(largest, 3 * (end + rtol)) << id << " at " << rtol;
    }
}

TEST(ExplicitRungeKutta, FixedStepsThereAndBackCountWhatTheySay) {
  for (const auto& [id, stages] : {std::pair{"dop853", 12}, {"verner98", 15}, {"gbs", 17}}) {
    Grid grid;
    grid.stretches.push_back({10, 100, 0.1});
    Setting setting;
    setting.knob = Knob::steps;
    const Trajectory t = run(find_method(id), hairer_vilmart(), setting, grid);
    EXPECT_EQ(t.work.steps, 100) << id;
    EXPECT_EQ(t.work.rhs_evals, 100 * stages) << id;
  }
}

// ---- compensated summation

TEST(Compensated, RoundingNoLongerGrowsWithTheSteps) {
  // Steps so small that truncation is below rounding: of order 4, 1e-11 (h/1e-3)^4 or so at h = 1e-5. What is
  // left of the attitude error of a plain run is the rounding of its sums, N^(1/2) to N^(3/2) units
  // of 1.1e-16. The compensated run is left with what the right-hand sides round (h times smaller) and with
  // the rounded constants of the body, the same for both.
  constexpr std::int64_t steps = sanitized ? 100'000 : 1'000'000;
  Scene scene = hairer_vilmart();
  Grid grid;
  grid.stretches.push_back({10, steps, 10.0 / double(steps)});
  Setting setting;
  setting.knob = Knob::steps;
  const Sample truth = run(find_method("exact"), scene, {}, grid).samples.back();
  for (const auto& [plain, compensated] :
       {std::pair{"rk4", "rk4-compensated"}, {"dop853", "dop853-compensated"}}) {
    const Trajectory without = run(find_method(plain), scene, setting, grid),
                     with = run(find_method(compensated), scene, setting, grid);
    const double error = attitude_error(truth.q, without.samples.back().q),
                 compensated_error = attitude_error(truth.q, with.samples.back().q);
    EXPECT_GT(error, 20 * compensated_error) << plain;  // 1.3e-12 against 2e-15 rad measured
    EXPECT_LT(compensated_error, 2e-14) << plain;
  }
}

}  // namespace
}  // namespace polhode
