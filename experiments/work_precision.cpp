// Question: what does an accuracy cost, in time and in evaluations of the right-hand side?
//
// Every solver runs over a ladder of its knob. First the error pass, against the truth at 16 sample times;
// then the timing pass, with the end alone asked for and no errors computed, all candidates interleaved in
// rounds on one thread. A run whose error pass failed is not timed and keeps its row.
#include <cmath>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/measured_run.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"knob", ColumnType::text, "steps, rtol (absolute tolerance equal to it), or none"},
    {"knob_value", ColumnType::number, "its value; empty: nothing to set"},
    {"outcome", ColumnType::text, "ok, or why the run failed"},
    {"steps", ColumnType::integer, "accepted steps"},
    {"rejected_steps", ColumnType::integer, "rejected steps"},
    {"rhs_evals", ColumnType::integer, "evaluations of the right-hand side"},
    {"jacobian_evals", ColumnType::integer, "evaluations of the Jacobian"},
    {"attitude_error_max_rad", ColumnType::number, "largest attitude error over the sample times, rad"},
    {"rate_error_max_rel", ColumnType::number, "largest |w - w_exact|/|w_exact|"},
    {"energy_error_max_rel", ColumnType::number,
     "largest |E - E_exact|/|E(0)|; of the rotation where there is one"},
    {"momentum_error_max_rel", ColumnType::number, "largest |L - L_exact|/|L(0)|"},
    {"unit_defect_max", ColumnType::number, "largest | |q| - 1 |, or |R^T R - 1| of a matrix state"},
    {"time_min_s", ColumnType::number, "CPU time of a run, least of the repeats, s"},
    {"time_median_s", ColumnType::number, "median, s"},
    {"time_mad_s", ColumnType::number, "median absolute deviation, s"},
    {"repeats", ColumnType::integer, "repeats of the measurement"},
    {"above_floor", ColumnType::boolean,
     "1: the error is above ten times what double precision and truth resolve"},
    {"position_error_max_m", ColumnType::number, "largest position error, m"},
};

}  // namespace

std::vector<Table> work_precision(const Plan& plan) {
  Table table{"work_precision.csv", columns, {}, 4};
  refuse_options(plan.options, "work-precision samples at 16 times of its own", false, false, true);
  if (plan.options.h) throw UsageError("--h: work-precision counts in steps; needs --steps");
  const bool quick = plan.options.quick;
  const TimingPlan timing = quick ? TimingPlan{3, 50e-6, 5e-3} : TimingPlan{7, 500e-6, 25e-3};
  for (const Scene& scene : plan.scenes) {
    if (interrupted()) break;
    const auto times = uniform_times(scene.duration, 16);
    const auto truth = truth_for(plan, scene, times, "work-precision", true);
    if (interrupted()) break;
    std::vector<MeasuredRun> all;
    for (const Method* m : plan.methods) {
      if (m->family == "truth") continue;  // it is what the others are measured against
      // One value where the options give one, else the whole ladder.
      const Knob knob = plan.options.chooses_steps() && m->by_steps ? Knob::steps : m->default_knob();
      const auto add = [&](double value) { all.push_back({m, knob, value}); };
      if (knob == Knob::none)
        add(0);
      else if (knob == Knob::steps && plan.options.steps)
        add(double(*plan.options.steps));
      else if (knob == Knob::steps)
        for (int k = 5; k <= (quick ? 12 : 16); ++k) add(std::ldexp(1.0, k));
      else if (plan.options.rtol)
        add(*plan.options.rtol);
      else
        for (int k = 2; k <= 13; k += quick ? 2 : 1) add(std::pow(10.0, -k));
    }
    for_each_run(plan.options, all.size(), [&](std::size_t i) {
      MeasuredRun& c = all[i];
      progress(plan.options, "work-precision: " + scene.id + ", " + std::string(c.method->id));
      find_errors(plan.options, scene, *truth, times, c);
    });
    if (interrupted()) break;

    std::vector<std::function<void()>> timed;
    std::vector<MeasuredRun*> of;
    for (MeasuredRun& c : all) {
      if (c.run.outcome != Outcome::ok) continue;
      timed.push_back(timed_run(plan.options, scene, c));
      of.push_back(&c);
    }
    const auto measured = time_interleaved(timed, timing, [&](std::size_t done, std::size_t total) {
      count_progress(done, total);
      progress(plan.options, "work-precision: " + scene.id + ", clock");
    });
    count_progress(0, 0);
    for (std::size_t i = 0; i < of.size(); ++i) of[i]->timing = measured[i];

    const Method* told = nullptr;
    for (const MeasuredRun& c : all) {
      const bool ok = c.run.outcome == Outcome::ok;
      const bool was_run = c.run.outcome != Outcome::unsupported && c.run.outcome != Outcome::no_truth;
      if (!was_run) {
        if (c.method == told) continue;  // one row says it
        told = c.method;
      }
      std::vector<Cell> row{text(scene.id), text(c.method->id), text(name_of(c.knob))};
      row.resize(std::size(columns));
      row[4] = text(name_of(c.run.outcome));
      if (was_run) {
        if (c.knob != Knob::none) row[3] = c.value;
        const Work& w = c.run.work;
        row[5] = w.steps;
        row[6] = w.rejected_steps;
        row[7] = w.rhs_evals;
        row[8] = w.jacobian_evals;
      }
      if (ok) {
        row[9] = number(c.errors.attitude_max);
        row[10] = number(c.errors.rate_max);
        row[11] = number(c.errors.energy_max);
        row[12] = number(c.errors.momentum_max);
        row[13] = number(c.errors.unit_defect_max);
        row[14] = number(c.timing.min);
        row[15] = number(c.timing.median);
        row[16] = number(c.timing.mad);
        row[17] = std::int64_t{c.timing.repeats};
        row[18] = std::int64_t{c.errors.above_floor};
        row[19] = number(c.errors.position_max);
      }
      table.add(std::move(row));
    }
  }
  std::vector<Table> tables;
  tables.push_back(std::move(table));
  return tables;
}

}  // namespace polhode
