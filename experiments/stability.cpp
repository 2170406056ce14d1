// Question: how large a step does each solver survive on a stiff scene?
//
// The scene's stiff parameter is set to each of its values; the step size is bisected (in its logarithm)
// between a step that keeps the energy and one that does not. A step is stable if after 1000 steps (more
// where those are short of three periods) the kinetic energy of the rotation and the potential of its loads
// have not grown: these scenes lose energy or keep it, none gains.
//
// Theory beside it: the largest h for which the stability polynomial of the solver stays within one in
// modulus at h lambda, for every fast eigenvalue lambda of the Jacobian at rest (2/lambda for Euler
// and 2.785/lambda for RK4 where it is real). Where no limit is found within the range searched, the field is
// empty.
#include <cmath>
#include <complex>

#include <Eigen/Eigenvalues>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"
#include "solvers/erased_model.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"parameter", ColumnType::text, "the stiff parameter, load.key"},
    {"parameter_value", ColumnType::number, "its value, in the unit of the scene file"},
    {"h_s", ColumnType::number, "the smallest step tried that failed, s; empty: none did"},
    {"outcome", ColumnType::text, "how the run at h_s ended (ok: it ended, but had gained energy)"},
    {"largest_stable_h_s", ColumnType::number, "largest stable step, s; empty: none found"},
    {"theory_h_s", ColumnType::number, "linear theory, s; empty: the solver has no stability polynomial"},
    {"energy_growth_per_step", ColumnType::number, "(E_end/E_start)^(1/steps) at h_s"},
};

struct Trial {
  bool stable = false;
  Outcome outcome = Outcome::ok;
  double growth = std::numeric_limits<double>::quiet_NaN();
};

/// fastest  modulus of the fastest eigenvalue, 1/s
Trial try_step(const Integration& run, double h, double fastest, double rounding) {
  // Three periods of the fastest motion at least: over less, damping has not had its share yet.
  const auto steps = static_cast<std::int64_t>(std::clamp(20 / (h * fastest), 1000.0, 1e6));
  Grid grid;
  grid.from_start = true;
  for (const std::int64_t n : {std::int64_t{1}, std::int64_t{10}, std::int64_t{100}, steps}) {
    const std::int64_t before = grid.steps();
    grid.stretches.push_back({h * double(n), n - before, h});
  }
  Trajectory out;
  run(grid, out);
  Trial t;
  t.outcome = out.outcome;
  if (out.samples.size() < 2) return t;
  const Sample &start = out.samples.front(), &end = out.samples.back();
  const double n = std::max(1.0, std::round(end.t / h));
  if (start.total_energy > 0 && end.total_energy > 0)
    t.growth = std::pow(end.total_energy / start.total_energy, 1 / n);
  t.stable = out.outcome == Outcome::ok && end.total_energy <= start.total_energy * (1 + rounding);
  return t;
}

/// Of the Jacobian at rest in the attitude of the space frame: where springs and drags lead to.
std::vector<std::complex<double>> eigenvalues(const Scene& scene) {
  const auto model = erased_model(scene);
  std::vector<double> rest(model->initial().begin(), model->initial().end());
  if (scene.rotation) std::fill_n(rest.begin(), model->has_attitude() ? 7 : 3, 0.0);
  if (model->has_attitude()) {
    const Quaternion q = normalised(scene.rotation->principal_to_user);
    const double components[] = {q.w(), q.x(), q.y(), q.z()};
    std::ranges::copy(components, rest.begin());
  }
  Eigen::MatrixXd J(model->size(), model->size());
  model->jacobian(0.0, rest.data(), J.data());
  const Eigen::VectorXcd values = J.eigenvalues();
  return {values.begin(), values.end()};
}

/// Largest h with |R(h lambda)| <= 1 for every lambda but the slow ones, which do not limit the step.
double theory(std::span<const double> polynomial, const std::vector<std::complex<double>>& lambda, double low,
              double high) {
  double fastest = 0;
  for (const auto& l : lambda) fastest = std::max(fastest, std::abs(l));
  const auto stable = [&](double h) {
    for (const auto& l : lambda) {
      if (std::abs(l) < 0.1 * fastest) continue;  // the slow motions do not limit the step
      std::complex<double> r = 0;
      for (std::size_t k = polynomial.size(); k-- > 0;) r = r * (h * l) + polynomial[k];
      if (std::abs(r) > 1 + 1e-12) return false;
    }
    return true;
  };
  if (!stable(low) || stable(high)) return std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 60; ++i) {
    const double middle = std::sqrt(low * high);
    (stable(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

std::vector<Table> stability(const Plan& plan) {
  Table table{"stability.csv", columns, {}};
  refuse_options(plan.options, "stability searches the step size itself", true, true, true);
  struct Case {
    const Scene* scene;
    double value;
    const Method* method;
    std::vector<Cell> row;
  };
  std::vector<Case> cases;
  for (const Scene& scene : plan.scenes) {
    if (!scene.dial) continue;
    for (const Method* m : plan.methods)
      if (m->by_steps)
        for (const double v : scene.dial->values) cases.push_back({&scene, v, m, {}});
  }
  for_each_run(plan.options, cases.size(), [&](std::size_t i) {
    Case& c = cases[i];
    progress(plan.options, "stability: " + c.scene->id + ", " + std::string(c.method->id));
    const Scene scene = c.scene->with_dial(c.value);
    c.row = {text(scene.id), text(c.method->id), text(scene.dial->place), c.value};
    c.row.resize(std::size(columns));
    const auto lambda = eigenvalues(scene);
    double fastest = 0;
    for (const auto& l : lambda) fastest = std::max(fastest, std::abs(l));
    const Prepared run = c.method->prepare(scene, setting_of(plan.options, Knob::steps));
    if (!run.integrate) {
      c.row[5] = text(name_of(Outcome::unsupported));
      return;
    }
    double low = 1e-4 / fastest, high = 1e3 / fastest;
    c.row[7] = number(theory(c.method->stability_polynomial, lambda, low, high));
    if (c.method->stability_polynomial.empty()) c.row[7] = Cell();
    // Two thousand rounded operations a run: an energy that grows by less than this has not grown.
    constexpr double rounding = 1e-12;
    Trial worst = try_step(run.integrate, low, fastest, rounding);
    double failed = low;
    if (worst.stable) {
      failed = high;
      worst = try_step(run.integrate, high, fastest, rounding);
      if (!worst.stable) {
        while (high / low > 1 + 1e-4 && !interrupted()) {
          const double middle = std::sqrt(low * high);
          const Trial t = try_step(run.integrate, middle, fastest, rounding);
          if (t.stable) {
            low = middle;
          } else {
            high = failed = middle;
            worst = t;
          }
        }
      } else {
        low = high;
      }
      c.row[6] = low;
    }
    c.row[5] = text(name_of(worst.outcome));
    if (!worst.stable) {
      c.row[4] = failed;
      c.row[8] = number(worst.growth);
    }
  });
  for (Case& c : cases)
    if (!c.row.empty()) table.add(std::move(c.row));
  std::vector<Table> tables;
  tables.push_back(std::move(table));
  return tables;
}

}  // namespace polhode
