// Question: at which order do the errors of each solver fall with the step size?
//
// A ladder of N = 2^k fixed steps over the whole duration; the error of a rung is its largest over 16 common
// sample times. Orders are fitted for attitude, rate, energy and momentum apart, above the rounding floor
// only.
#include <cmath>
#include <limits>

#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"

namespace polhode {
namespace {

constexpr Column convergence_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"steps", ColumnType::integer, "fixed steps over the duration"},
    {"h_s", ColumnType::number, "step size, s"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"attitude_error_max_rad", ColumnType::number, "largest attitude error over the sample times, rad"},
    {"rate_error_max_rel", ColumnType::number, "largest |w - w_exact|/|w_exact|"},
    {"energy_error_max_rel", ColumnType::number,
     "largest |E - E_exact|/|E(0)|; of the rotation where there is one"},
    {"momentum_error_max_rel", ColumnType::number, "largest |L - L_exact|/|L(0)|"},
    {"attitude_error_end_rad", ColumnType::number, "attitude error at the end, rad"},
    {"attitude_order", ColumnType::number, "slope to the row before"},
    {"rate_order", ColumnType::number, "slope to the row before"},
    {"energy_order", ColumnType::number, "slope to the row before"},
    {"momentum_order", ColumnType::number, "slope to the row before"},
    {"above_floor", ColumnType::boolean,
     "1: the error is above ten times what double precision and truth resolve"},
    {"position_error_max_m", ColumnType::number, "largest position error, m"},
};
constexpr Column order_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"quantity", ColumnType::text, "attitude, rate, energy or momentum"},
    {"claimed", ColumnType::number, "order that the solver claims; empty: none"},
    {"order", ColumnType::number, "fitted order; empty: no three points between coarse steps and the floor"},
    {"order_error", ColumnType::number, "its standard error"},
    {"points", ColumnType::integer, "points in the fit"},
};

constexpr int sample_count = 16;

struct Rung {
  std::int64_t steps = 0;
  Outcome outcome = Outcome::unsupported;
  Errors errors{};
};

double slope(double before, double now) { return std::log2(before / now); }

}  // namespace

std::vector<Table> convergence(const Plan& plan) {
  Table rows{"convergence.csv", convergence_columns, {}, 3}, orders{"orders.csv", order_columns, {}, 3};
  refuse_options(plan.options, "convergence makes its own ladder of steps and sample times", true, true,
                 true);
  // 2^4 ... 2^17 steps; a quick look stops at 2^13.
  const int first = 4, last = plan.options.quick ? 13 : 17;
  for (const Scene& scene : plan.scenes) {
    if (interrupted()) break;
    const auto times = uniform_times(scene.duration, sample_count);
    const auto truth = truth_for(plan, scene, times, "convergence", true);
    if (interrupted()) break;
    std::vector<const Method*> methods;
    for (const Method* m : plan.methods)
      if (m->by_steps) methods.push_back(m);
    const std::size_t rungs = static_cast<std::size_t>(last - first + 1);
    std::vector<Rung> all(methods.size() * rungs);
    for_each_run(plan.options, all.size(), [&](std::size_t i) {
      const Method& method = *methods[i / rungs];
      Rung& rung = all[i];
      rung.steps = std::int64_t{1} << (first + static_cast<int>(i % rungs));
      progress(plan.options, "convergence: " + scene.id + ", " + std::string(method.id));
      const Setting setting = setting_of(plan.options, Knob::steps);
      const Trajectory run = truth->is_known()
                                 ? run_once(method, scene, setting, grid_of_steps(times, rung.steps))
                                 : run_without_truth(method, scene, setting, *truth);
      rung.outcome = run.outcome;
      tell_failure(plan.options, scene, method, run);
      if (run.outcome == Outcome::ok) rung.errors = errors_of(scene, *truth, run.samples, 1, method.epsilon);
    });
    if (interrupted()) break;  // a scene is reported whole or not at all
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const std::span ladder(&all[m * rungs], rungs);
      const Outcome outcome = ladder.front().outcome;
      if (outcome == Outcome::unsupported || outcome == Outcome::no_truth) {  // one row says it
        std::vector<Cell> row(std::size(convergence_columns));
        row[0] = text(scene.id);
        row[1] = text(methods[m]->id);
        row[4] = text(name_of(outcome));
        rows.add(std::move(row));
        continue;
      }
      const Rung* before = nullptr;
      for (const Rung& r : ladder) {
        std::vector<Cell> row{text(scene.id), text(methods[m]->id), r.steps, scene.duration / double(r.steps),
                              text(name_of(r.outcome))};
        row.resize(std::size(convergence_columns));
        if (r.outcome == Outcome::ok) {
          const Errors& e = r.errors;
          row[5] = number(e.attitude_max);
          row[6] = number(e.rate_max);
          row[7] = number(e.energy_max);
          row[8] = number(e.momentum_max);
          row[9] = number(e.attitude_end);
          if (before) {
            row[10] = number(slope(before->errors.attitude_max, e.attitude_max));
            row[11] = number(slope(before->errors.rate_max, e.rate_max));
            row[12] = number(slope(before->errors.energy_max, e.energy_max));
            row[13] = number(slope(before->errors.momentum_max, e.momentum_max));
          }
          row[14] = std::int64_t{e.above_floor};
          row[15] = number(e.position_max);
          before = &r;
        } else {
          before = nullptr;
        }
        rows.add(std::move(row));
      }
      if (!scene.rotation) continue;
      const auto fit = [&](const char* quantity, double claimed, double Errors::*error, double floor) {
        // A solver that claims order 0 converges to another motion: its errors stay large, and are no less
        // certain.
        const double coarse = claimed == 0 ? std::numeric_limits<double>::infinity() : 0.1;
        std::vector<double> h, e;
        for (const Rung& r : ladder) {
          h.push_back(scene.duration / double(r.steps));
          e.push_back(r.outcome == Outcome::ok ? r.errors.*error : std::numeric_limits<double>::quiet_NaN());
        }
        const auto line = observed_order(h, e, floor, coarse);
        orders.add({text(scene.id), text(methods[m]->id), text(quantity),
                    claimed >= 0 ? Cell(claimed) : Cell(), line ? Cell(line->slope) : Cell(),
                    line ? Cell(line->slope_error) : Cell(), std::int64_t{line ? line->points : 0}});
      };
      const Claims c = methods[m]->claims.with_time(depends_on_time(scene));
      // A hundred times the floor: a point at ten times it may be off by a tenth, which bends a slope by
      // 0.15.
      const double margin = 100 * methods[m]->epsilon / std::numeric_limits<double>::epsilon();
      const double attitude_floor =
          margin * std::max(truth->floor().attitude, truth->truth.attitude_uncertainty);
      const double rate_floor = margin * std::max(truth->floor().rate, truth->truth.rate_uncertainty);
      // Energy and momentum of a run are sums of thousands of rounded numbers.
      const double sum_floor = margin * 1e-15;
      if (scene.rotation->attitude) fit("attitude", c.attitude_order, &Errors::attitude_max, attitude_floor);
      fit("rate", c.rate_order, &Errors::rate_max, rate_floor);
      fit("energy", c.energy_order, &Errors::energy_max, sum_floor);
      fit("momentum", c.momentum_order, &Errors::momentum_max, std::max(sum_floor, rate_floor));
    }
  }
  std::vector<Table> tables;
  tables.push_back(std::move(rows));
  tables.push_back(std::move(orders));
  return tables;
}

}  // namespace polhode
