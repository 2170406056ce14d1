// Does the error of a solver that chooses its steps follow the tolerance that it was given?
//
// A ladder of tolerances by powers of ten, on scenes that are not stiff and, where they have a dial, at the
// largest value at which the truth is known. The error is the largest of attitude (rad) and rates (relative)
// over the samples. A run is called deceived where its error exceeds ten (a hundred) times the tolerance
// times the conditioning of the scene: what an error of one tolerance, made once, has become by the end.
#include <algorithm>
#include <cmath>

#include "experiments/fit.hpp"
#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/stability.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"parameter_value", ColumnType::number, "where its dial stands; empty: as the file says"},
    {"rtol", ColumnType::number, "relative tolerance; the absolute one is equal"},
    {"outcome", ColumnType::text,
     "ok, or why the run failed; timeout also, unrun, where the two looser tolerances before ran out of "
     "time"},
    {"error", ColumnType::number, "the larger of attitude error, rad, and relative rate error"},
    {"error_over_tolerance", ColumnType::number, "error over rtol"},
    {"slope", ColumnType::number, "of the error to the row before, in decades per decade"},
    {"deceived", ColumnType::integer,
     "0; 10 or 100 where the error exceeds that many times rtol times the conditioning, and the floor"},
    {"rhs_evals", ColumnType::integer, "evaluations of the right-hand side"},
};
constexpr std::size_t key_columns = 4;
constexpr Column verdict_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"solver", ColumnType::text, "solver id"},
    {"parameter_value", ColumnType::number, "where its dial stands; empty: as the file says"},
    {"slope", ColumnType::number, "of the error against rtol, fitted above the floor; 1: the error follows"},
    {"slope_error", ColumnType::number, "its standard error"},
    {"deceived_10", ColumnType::number, "share of the runs above the floor that are deceived by 10"},
    {"deceived_100", ColumnType::number, "share that are deceived by 100"},
    {"least_error", ColumnType::number, "least error of all tolerances"},
    {"below_floor", ColumnType::text,
     "what tolerances below the rounding floor do: keeps (the error stays within ten times the least), "
     "worse, "
     "fails (the run does not end); empty: none was tried"},
};

/// The scene at its largest dial value that has a truth; or as it is.
struct Subject {
  Scene scene;
  Cell value;
  std::shared_ptr<const SceneTruth> truth;
  std::vector<double> times;
};

}  // namespace

std::vector<Table> tolerances(const Plan& plan) {
  Table rows{"tolerance.csv", columns, {}, key_columns};
  Table verdicts{"tolerance_verdict.csv", verdict_columns, {}, 3};  // scene, solver, value of the dial
  std::vector<Subject> subjects;
  for (const Scene& scene : plan.scenes) {
    if (interrupted() || !scene.rotation) continue;
    const auto subject = [&](const Scene& s, const Cell& value) {
      Subject x{s, value, nullptr, uniform_times(s.duration, 8)};
      x.truth = truth_for(plan, x.scene, x.times, "tolerances", true);
      return x;
    };
    subjects.push_back(subject(scene, {}));
    if (!scene.dial || plan.options.quick) continue;
    for (std::size_t k = scene.dial->values.size(); k-- > 0 && !interrupted();) {
      const double v = scene.dial->values[k];
      Subject x = subject(scene.with_dial(v), v);
      if (!x.truth->is_known()) continue;  // too stiff even for the truth: a smaller value
      subjects.push_back(std::move(x));
      break;
    }
  }
  std::vector<double> ladder;
  for (int k = 2; k <= 16; k += plan.options.quick ? 2 : 1) ladder.push_back(std::pow(10.0, -k));
  std::vector<const Method*> methods;
  for (const Method* m : plan.methods)
    if (m->by_tolerance && m->family != "truth") methods.push_back(m);
  struct Run {
    std::vector<Cell> row;
    double error = std::numeric_limits<double>::quiet_NaN();
    Outcome outcome = Outcome::ok;
  };
  std::vector<Run> runs(subjects.size() * methods.size() * ladder.size());
  const auto run_one = [&](std::size_t i) {
    const Subject& s = subjects[i / (methods.size() * ladder.size())];
    const Method& method = *methods[i / ladder.size() % methods.size()];
    Setting setting = setting_of(plan.options, Knob::tolerance);
    setting.rtol = ladder[i % ladder.size()];
    setting.timeout_s = std::min(setting.timeout_s, plan.options.quick ? 0.3 : 2.0);
    std::vector<Cell> row = {text(s.scene.id), text(method.id), s.value, setting.rtol};
    if (auto known = plan.earlier.find(rows, row)) {
      row = std::move(*known);
      for (int o = 0; o <= static_cast<int>(last_outcome); ++o)
        if (std::get<std::string>(row[4]) == name_of(static_cast<Outcome>(o)))
          runs[i].outcome = static_cast<Outcome>(o);
      if (const auto* e = std::get_if<double>(&row[5])) runs[i].error = *e;
      runs[i].row = std::move(row);
      return;
    }
    row.resize(std::size(columns));
    // A tighter tolerance takes longer: what ran out of time twice will again.
    const std::size_t k = i % ladder.size();
    if (k >= 2 && runs[i - 1].outcome == Outcome::timeout && runs[i - 2].outcome == Outcome::timeout) {
      runs[i].outcome = Outcome::timeout;
      row[4] = text(name_of(Outcome::timeout));
      runs[i].row = std::move(row);
      return;
    }
    if (!s.truth->is_known()) {  // one row says it
      if (k > 0) return;
      runs[i].outcome = run_without_truth(method, s.scene, setting, *s.truth).outcome;
      row[3] = Cell();
      row[4] = text(name_of(runs[i].outcome));
      if (!interrupted()) runs[i].row = std::move(row);
      return;
    }
    const Trajectory run = run_once(method, s.scene, setting, grid_of_times(s.times));
    row[4] = text(name_of(run.outcome));
    if (run.outcome != Outcome::unsupported) row[9] = run.work.rhs_evals;
    runs[i].outcome = run.outcome;
    if (run.outcome == Outcome::ok) {
      const Errors e = errors_of(s.scene, *s.truth, run.samples, 1, method.epsilon);
      runs[i].error = e.attitude_max > e.rate_max ? e.attitude_max : e.rate_max;
      row[5] = runs[i].error;
      row[6] = runs[i].error / setting.rtol;
    }
    if (!interrupted()) runs[i].row = std::move(row);
  };
  for_each_run(plan.options, runs.size() / ladder.size(), [&](std::size_t ladder_at) {
    const std::size_t first = ladder_at * ladder.size();
    progress(plan.options, "tolerances: " + subjects[ladder_at / methods.size()].scene.id + ", " +
                               std::string(methods[ladder_at % methods.size()]->id));
    for (std::size_t i = first; i < first + ladder.size() && !interrupted(); ++i) run_one(i);
  });
  for (std::size_t first = 0; first < runs.size(); first += ladder.size()) {
    const Subject& s = subjects[first / (methods.size() * ladder.size())];
    if (!s.truth->is_known()) continue;
    const Floor& reach = s.truth->floor();
    const double conditioning = reach.conditioning >= 1 ? reach.conditioning : 1;
    const double floor = 10 * std::max(reach.attitude, reach.rate);
    std::vector<double> x, y;
    double above = 0, by_10 = 0, by_100 = 0, least = std::numeric_limits<double>::infinity(), below = 0;
    bool complete = true, failed_below = false;
    for (std::size_t k = 0; k < ladder.size(); ++k) {
      Run& r = runs[first + k];
      complete = complete && !r.row.empty();
      if (r.row.empty()) continue;
      const bool small = ladder[k] * conditioning < floor / 10;
      if (r.outcome == Outcome::ok) {
        const bool resolved = r.error > floor;
        const double ratio = r.error / (ladder[k] * conditioning);
        const int deceived = !resolved ? 0 : ratio > 100 ? 100 : ratio > 10 ? 10 : 0;
        r.row[8] = std::int64_t{deceived};
        if (k > 0 && r.error > 0 && runs[first + k - 1].error > 0)
          r.row[7] =
              number(std::log(r.error / runs[first + k - 1].error) / std::log(ladder[k] / ladder[k - 1]));
        least = std::min(least, r.error);
        if (resolved && !small) {
          ++above;
          by_10 += deceived >= 10;
          by_100 += deceived >= 100;
          if (r.error < 0.1) {
            x.push_back(std::log10(ladder[k]));
            y.push_back(std::log10(r.error));
          }
        }
        if (small) below = std::max(below, r.error);
      } else if (small && r.outcome != Outcome::unsupported) {
        failed_below = true;
      }
    }
    if (complete && runs[first].outcome != Outcome::unsupported) {
      std::vector<Cell> row(std::begin(runs[first].row), std::begin(runs[first].row) + 3);
      row.resize(std::size(verdict_columns));
      if (x.size() >= 3) {
        const Line line = fit_line(x, y);
        row[3] = line.slope;
        row[4] = line.slope_error;
      }
      if (above > 0) {
        row[5] = by_10 / above;
        row[6] = by_100 / above;
      }
      if (std::isfinite(least)) row[7] = least;
      row[8] = text(failed_below ? "fails" : below > 10 * least ? "worse" : below > 0 ? "keeps" : "");
      verdicts.add(std::move(row));
    }
  }
  for (Run& r : runs)
    if (!r.row.empty()) rows.add(std::move(r.row));
  std::vector<Table> tables;
  tables.push_back(std::move(rows));
  tables.push_back(std::move(verdicts));
  return tables;
}

}  // namespace polhode
