// Question: what is lost over time?
//
// One run per solver, sampled at log-spaced steps (or at every time that --samples or --times asks for);
// energy, momentum as a vector, its direction and the unit length, each against the exact motion, so that a
// torque's own work is not taken for an error. The running maximum of each is classified by its growth.
#include <cmath>

#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/question.hpp"

namespace polhode {
namespace {

constexpr Column drift_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"knob", ColumnType::text, "steps, rtol or none"},
    {"knob_value", ColumnType::number, "its value"},
    {"t_s", ColumnType::number, "time, s"},
    {"attitude_error_rad", ColumnType::number, "attitude error, rad"},
    {"rotational_energy_drift_rel", ColumnType::number, "(E_rot - exact)/|E_rot(0)|, signed"},
    {"total_energy_drift_rel", ColumnType::number, "(E - exact)/|E(0)|, signed"},
    {"momentum_drift_rel", ColumnType::number, "|L - L_exact|/|L(0)|"},
    {"momentum_direction_drift_rad", ColumnType::number, "angle between L and L_exact, rad"},
    {"unit_defect", ColumnType::number, "| |q| - 1 |, or |R^T R - 1| of a matrix state"},
    {"outcome", ColumnType::text, "of the run: ok, or why it failed; t_s is empty where it has no samples"},
};
constexpr Column verdict_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"knob", ColumnType::text, "steps, rtol or none"},
    {"knob_value", ColumnType::number, "its value"},
    {"quantity", ColumnType::text, "the column of drift.csv that is classified"},
    {"class", ColumnType::text,
     "bounded, random_walk, linear, quadratic, exponential, not_finite; or the outcome"},
    {"exponent", ColumnType::number, "of t (of exp(t), 1/s, if exponential)"},
    {"exponent_error", ColumnType::number, "its standard error"},
    {"max_abs", ColumnType::number, "largest absolute value over the samples"},
};

constexpr int quantity_count = 6;
constexpr const char* quantities[quantity_count] = {"attitude_error", "rotational_energy",  "total_energy",
                                                    "momentum",       "momentum_direction", "unit_defect"};

using Drifts = std::array<double, quantity_count>;

Drifts drifts_at(const Scene& scene, const SceneTruth& truth, const Sample& s, const WideSample& exact) {
  const SampleErrors e = errors_at(scene, truth, s, exact);
  return {e.attitude, e.rotational_energy, e.total_energy, e.momentum, e.momentum_direction, e.unit_defect};
}

}  // namespace

std::vector<Table> drift(const Plan& plan) {
  Table samples{"drift.csv", drift_columns, {}, 5}, verdicts{"drift_verdict.csv", verdict_columns, {}, 5};
  const Options& options = plan.options;
  for (const Scene& scene : plan.scenes) {
    if (interrupted()) break;
    const std::int64_t steps = options.steps.value_or(options.quick ? 4096 : 16384);
    std::vector<double> times;
    if (!options.times.empty() || options.samples) {
      times = asked_times(scene, options).times;
    } else {
      for (const std::int64_t n : log_spaced(steps, 48))
        times.push_back(n == steps ? scene.duration : scene.duration * double(n) / double(steps));
    }
    const auto truth = truth_for(plan, scene, times, "drift", false);
    if (interrupted()) break;
    std::vector<const Method*> methods;
    for (const Method* m : plan.methods)
      if (m->family != "truth") methods.push_back(m);
    std::vector<Trajectory> runs(methods.size());
    std::vector<double> values(methods.size());
    std::vector<Knob> knobs(methods.size());
    for_each_run(options, methods.size(), [&](std::size_t i) {
      const Method& m = *methods[i];
      progress(options, "drift: " + scene.id + ", " + std::string(m.id));
      knobs[i] = options.chooses_steps() && m.by_steps ? Knob::steps : m.default_knob();
      Setting setting = setting_of(options, knobs[i]);
      Grid grid;
      if (knobs[i] == Knob::steps) {
        grid = options.h ? grid_of_size(times, *options.h) : grid_of_steps(times, steps);
        values[i] = double(grid.steps());
      } else {
        setting.rtol = options.rtol.value_or(1e-8);
        values[i] = setting.rtol;
        grid = grid_of_times(times);
      }
      runs[i] = truth->is_known() ? run_once(m, scene, setting, grid)
                                  : run_without_truth(m, scene, setting, *truth);
      tell_failure(options, scene, m, runs[i]);
    });
    if (interrupted()) break;
    for (std::size_t i = 0; i < methods.size(); ++i) {
      const Trajectory& run = runs[i];
      std::vector<double> t;
      std::array<std::vector<double>, quantity_count> series;
      const std::vector<Cell> head{
          text(scene.id), text(methods[i]->id), text(name_of(knobs[i])),
          run.outcome == Outcome::unsupported || run.outcome == Outcome::no_truth || knobs[i] == Knob::none
              ? Cell()
              : Cell(values[i])};
      for (std::size_t k = 0; k < run.samples.size(); ++k) {
        const Drifts d = drifts_at(scene, *truth, run.samples[k], truth->truth.samples[k + 1]);
        std::vector<Cell> row = head;
        row.emplace_back(run.samples[k].t);
        for (const double x : d) row.push_back(number(x));
        row.push_back(text(name_of(run.outcome)));
        samples.add(std::move(row));
        t.push_back(run.samples[k].t);
        for (int j = 0; j < quantity_count; ++j) series[j].push_back(std::abs(d[j]));
      }
      if (run.samples.empty()) {
        std::vector<Cell> row = head;
        row.resize(std::size(drift_columns));
        row.back() = text(name_of(run.outcome));
        samples.add(std::move(row));
      }
      for (int j = 0; j < quantity_count; ++j) {
        const bool applies =
            scene.rotation ? (j != 0 && j != 4 && j != 5) || scene.rotation->attitude : j == 2;
        if (!applies) continue;
        std::vector<Cell> row = head;
        row.push_back(text(quantities[j]));
        double largest = 0;
        for (const double x : series[j]) largest = std::max(largest, x);
        if (run.outcome != Outcome::ok) {
          row.push_back(text(run.outcome == Outcome::diverged ? "not_finite" : name_of(run.outcome)));
          row.insert(row.end(), {Cell(), Cell(), run.samples.empty() ? Cell() : Cell(largest)});
        } else {
          // 1e-15: what the sum of a few rounded terms cannot resolve.
          const Drift c = classify_drift(t, series[j], 1e-15);
          row.push_back(text(c.kind));
          row.insert(row.end(), {number(c.exponent), number(c.exponent_error), Cell(largest)});
        }
        verdicts.add(std::move(row));
      }
    }
  }
  std::vector<Table> tables;
  tables.push_back(std::move(samples));
  tables.push_back(std::move(verdicts));
  return tables;
}

}  // namespace polhode
