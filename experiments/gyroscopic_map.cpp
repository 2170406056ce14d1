// Where does the gyroscopic term make a method gain energy?
//
// A free body spins at |w| = 1 near each of its principal axes in turn (a hundredth of the rate lies along
// the others), for shapes from rod over sphere to disc and steps from a thousandth of a radian to ten.
// Nothing but h|w| and the shape matters to the exact equations, so that one map serves every size and speed;
// what a solver adds that is not free of scale (a clamp, a sleep) shows as an outcome. The rates of its
// growth are the map.
//
// Beside it the limit of linear theory: of the Jacobian of the rates about the spin, whose eigenvalues are
// imaginary about the axes of least and greatest moment.
#include <algorithm>
#include <cmath>

#include "experiments/energy_growth.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/linear_theory.hpp"
#include "experiments/stability.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"solver", ColumnType::text, "solver id"},
    {"axis", ColumnType::text,
     "principal axis near which the body spins: that of the least, middle, greatest moment"},
    {"inertia_ratio", ColumnType::number, "polar over transverse moment: 0 rod, 1 sphere, 2 disc"},
    {"h_w", ColumnType::number, "step size times |w|, rad"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"energy_growth_per_step", ColumnType::number, "(E_end/E_start)^(1/steps) - 1; below 0: dissipates"},
    {"grows", ColumnType::boolean, "1: the energy has a trend upwards; 0: it swings, stays or falls"},
    {"theory_h_w", ColumnType::number,
     "h|w| up to which linear theory finds no growth; empty: no limit, or no theory"},
};
constexpr std::size_t key_columns = 4;
constexpr const char* axis_names[] = {"least", "middle", "greatest"};
constexpr std::int64_t steps = 512;

/// Moments of a body with a polar moment of `ratio` times the transverse one, and transverse moments that
/// differ a little where the shape allows it (|I1 - I2| <= I3 <= I1 + I2), so that it has three axes. Sorted.
Vec3 moments_of(double ratio) {
  const double difference = 0.5 * std::abs(1 - ratio) * std::min(ratio, 2 - ratio);
  Vec3 I(ratio, 1 - difference, 1);
  std::sort(I.data(), I.data() + 3);
  return I;
}

Scene spinning_body(double ratio, int axis) {
  Scene scene;
  scene.id = "gyroscopic-map";
  scene.unknowns = 7;
  scene.duration = 1;
  RotationData r;
  r.moments = moments_of(ratio);
  r.w0 = Vec3::Constant(0.01);
  r.w0[axis] = 1;
  r.w0.normalize();
  scene.rotation = r;
  return scene;
}

/// Of the rates alone, which know nothing of the attitude.
Linearised rates_about_spin(const Scene& scene) {
  Scene rates = scene;
  rates.rotation->attitude = false;
  rates.unknowns = 3;
  return linearised(rates);
}

}  // namespace

Table gyroscopic_map(const Plan& plan) {
  Table table{"stability_map.csv", columns, {}, key_columns};
  const bool quick = plan.options.quick;
  std::vector<double> ratios, sizes;
  if (quick)
    ratios = {0.01, 0.5, 1.6};
  else
    ratios = {0.01, 0.03, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9,
              1,    1.1,  1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 1.99};
  const int per_decade = quick ? 2 : 8, decades = quick ? 2 : 4;
  for (int k = 0; k <= decades * per_decade; ++k)
    sizes.push_back(std::pow(10.0, 1 - decades + double(k) / per_decade));
  struct Body {
    Scene scene;
    int axis;
    double ratio;
    Linearised linear;
  };
  std::vector<Body> bodies;
  for (int axis = 0; axis < 3; ++axis)
    for (const double ratio : ratios) {
      const Scene scene = spinning_body(ratio, axis);
      bodies.push_back({scene, axis, ratio, rates_about_spin(scene)});
    }
  std::vector<const Method*> methods;
  for (const Method* m : plan.methods)
    if (m->by_steps) methods.push_back(m);
  std::vector<std::vector<std::vector<Cell>>> rows(methods.size() * bodies.size());
  for_each_run(plan.options, rows.size(), [&](std::size_t i) {
    const Method& method = *methods[i / bodies.size()];
    const Body& body = bodies[i % bodies.size()];
    progress(plan.options, "gyroscopic map: " + std::string(method.id));
    Setting setting = setting_of(plan.options, Knob::steps);
    setting.timeout_s = std::min(setting.timeout_s, 1.0);
    Cell theory;
    // Beside an eigenvalue that grows by itself, or none at all, no step is a limit.
    const bool swings = body.linear.fastest > 1e-6 &&
                        std::ranges::all_of(body.linear.eigenvalues, [&](const std::complex<double>& l) {
                          return l.real() <= 1e-9 * body.linear.fastest;
                        });
    if (swings && !method.stability_polynomial.empty())
      if (const auto h = theoretical_limit(method, body.linear, sizes.front(), sizes.back())) theory = *h;
    Integration run;
    for (const double h : sizes) {
      if (interrupted()) return;
      std::vector<Cell> row = {text(method.id), text(axis_names[body.axis]), body.ratio, h};
      if (auto known = plan.earlier.find(table, row)) {
        rows[i].push_back(std::move(*known));
        continue;
      }
      if (!run) {
        Prepared prepared = method.prepare(body.scene, setting);
        if (!prepared.integrate) return;  // it serves no free body: no map
        run = guarded(std::move(prepared.integrate));
      }
      const EnergyGrowth g = energy_growth(run, h, steps);
      row.resize(std::size(columns));
      row[4] = text(name_of(g.outcome));
      row[5] = number(g.per_step);
      if (g.outcome == Outcome::ok) row[6] = std::int64_t{!g.stable};
      row[7] = theory;
      rows[i].push_back(std::move(row));
    }
  });
  for (auto& of_body : rows)
    for (auto& row : of_body) table.add(std::move(row));
  return table;
}

}  // namespace polhode
