// `simulate`: one trajectory as CSV, in the user's body frame.
#include <fmt/format.h>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"
#include "models/exact_scene.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"t_s", ColumnType::number, "time, s"},
    {"px_m", ColumnType::number, "position of the centre of mass, space frame, m"},
    {"py_m", ColumnType::number, ""},
    {"pz_m", ColumnType::number, ""},
    {"vx_m_per_s", ColumnType::number, "its velocity, m/s"},
    {"vy_m_per_s", ColumnType::number, ""},
    {"vz_m_per_s", ColumnType::number, ""},
    {"qw", ColumnType::number, "attitude, body to space, scalar first"},
    {"qx", ColumnType::number, ""},
    {"qy", ColumnType::number, ""},
    {"qz", ColumnType::number, ""},
    {"wx_rad_per_s", ColumnType::number, "angular velocity, body frame, rad/s"},
    {"wy_rad_per_s", ColumnType::number, ""},
    {"wz_rad_per_s", ColumnType::number, ""},
    {"energy_J", ColumnType::number, "total energy, J"},
    {"Lx_kg_m2_per_s", ColumnType::number, "angular momentum, space frame, kg m^2/s"},
    {"Ly_kg_m2_per_s", ColumnType::number, ""},
    {"Lz_kg_m2_per_s", ColumnType::number, ""},
};

/// Numbers of a row in the user's body frame, in the order of the columns; the parts that the scene lacks are
/// out.
template <class S, class SampleT>
std::vector<S> row_of(const Scene& scene, const QuaternionT<S>& to_user, const SampleT& s) {
  std::vector<S> row{s.t};
  const auto add = [&row](const auto& v) {
    for (int i = 0; i < 3; ++i) row.push_back(v[i]);
  };
  if (scene.translation) {
    add(s.p);
    add(s.v);
  }
  if (scene.rotation) {
    const bool turned = to_user.vec().norm() > S(0);
    if (scene.rotation->attitude) {
      const QuaternionT<S> q = turned ? QuaternionT<S>(s.q * to_user.conjugate()) : s.q;
      for (const S& x : {q.w(), q.x(), q.y(), q.z()}) row.push_back(x);
    }
    add(turned ? to_space<S>(to_user, s.w_B) : s.w_B);
  }
  row.push_back(s.total_energy);
  if (scene.rotation && scene.rotation->attitude) add(s.L);
  return row;
}

std::vector<Column> columns_of(const Scene& scene) {
  std::vector<Column> of_scene;
  for (std::size_t i = 0; i < std::size(columns); ++i) {
    const bool translation = i >= 1 && i <= 6, attitude = i >= 7 && i <= 10, rotation = i >= 11 && i <= 13,
               momentum = i >= 15;
    if ((translation && !scene.translation) || (rotation && !scene.rotation) ||
        // L is that of the space frame, which bare rates do not know.
        ((attitude || momentum) && !(scene.rotation && scene.rotation->attitude)))
      continue;
    of_scene.push_back(columns[i]);
  }
  return of_scene;
}

void put(const Options& options, const Table& table) {
  const std::string text = options.json ? json(table) : csv(table);
  if (!options.output || *options.output == "-")
    write_stdout(text);
  else
    write_file(*options.output, text);
}

void add_wide_rows(Table& table, const Scene& scene, const AskedTimes& asked, const Options& options) {
  std::vector<double> times = asked.times;
  if (asked.from_start) times.insert(times.begin(), 0.0);
  const auto known = needed_truth_of(scene, times, options);
  const Truth& truth = known->truth;
  const double worst = std::max(truth.attitude_uncertainty, truth.rate_uncertainty);
  if (worst > std::pow(10.0, -options.digits))
    fmt::print(stderr,
               "polhode: note: {} digits asked for, but the truth of '{}' is only certain to {:.1e}\n",
               options.digits, scene.id, worst);
  const std::size_t before = truth.samples.size() - times.size();  // the start, where it was not asked for
  const ExactScene exact = exact_scene(scene);
  QuaternionT<Wide> to_user(Wide(1), Wide(0), Wide(0), Wide(0));
  if (exact.rotation) to_user = exact.rotation->principal_to_user;
  for (std::size_t i = 0; i < times.size(); ++i) {
    std::vector<Cell> row{times[i]};
    const std::vector<Wide> numbers = row_of<Wide>(scene, to_user, truth.samples[before + i]);
    for (std::size_t k = 1; k < numbers.size(); ++k)
      row.push_back(options.digits <= 17 ? Cell(numbers[k].convert_to<double>())
                                         : Cell(numbers[k].str(options.digits, std::ios_base::scientific)));
    table.add(std::move(row));
  }
}

}  // namespace

int simulate_verb(const Options& options) {
  if (options.scenes.size() != 1)
    throw UsageError("simulate needs one scene; 'polhode list scenes' shows all");
  if (options.solvers.size() > 1) throw UsageError("simulate takes one --solver");
  const Scene scene = asked_scene(options, options.scenes.front());
  const Method& method = find_method(options.solvers.empty() ? "reference" : options.solvers.front());
  const AskedTimes asked = asked_times(scene, options);
  const std::vector<Column> of_scene = columns_of(scene);
  Table table{"trajectory.csv", of_scene, {}, 1};
  if (method.family == "truth") {
    add_wide_rows(table, scene, asked, options);
    put(options, table);
    return 0;
  }
  if (options.digits > 17)
    throw UsageError(
        fmt::format("--digits {}: '{}' computes in double precision, which has 17; needs --solver reference",
                    options.digits, method.id));
  const Knob knob = options.chooses_steps() ? Knob::steps
                    : options.rtol          ? Knob::tolerance
                                            : method.default_knob();
  if (!method.has(knob))
    throw UsageError(fmt::format("solver '{}' {}", method.id,
                                 method.by_steps ? "takes fixed steps; it needs --steps or --h, not --rtol"
                                 : method.by_tolerance
                                     ? "chooses its steps; it needs --rtol, not --steps or --h"
                                     : "has neither steps nor a tolerance: leave out --steps, --h, --rtol"));
  if (knob == Knob::steps && !options.chooses_steps())
    throw UsageError(fmt::format("solver '{}' takes fixed steps: it needs --steps N or --h H", method.id));
  Grid grid;
  if (asked.times.empty())
    ;  // the start alone
  else if (knob != Knob::steps)
    grid = grid_of_times(asked.times);
  else
    grid = options.h ? grid_of_size(asked.times, *options.h) : grid_of_steps(asked.times, *options.steps);
  grid.from_start = asked.from_start;
  const Trajectory run = run_once(method, scene, setting_of(options, knob), grid);
  if (run.outcome == Outcome::unsupported)
    throw UsageError(
        fmt::format("solver '{}' does not serve scene '{}': {}", method.id, scene.id, run.reason));
  for (const Sample& s : run.samples) {
    const std::vector<double> row =
        row_of<double>(scene, scene.rotation ? scene.rotation->principal_to_user : Quaternion(1, 0, 0, 0), s);
    table.add({row.begin(), row.end()});
  }
  put(options, table);
  if (run.outcome != Outcome::ok) {
    fmt::print(stderr, "polhode: '{}' ended with {}: {}\n", method.id, name_of(run.outcome), run.reason);
    return 1;
  }
  return 0;
}

}  // namespace polhode
