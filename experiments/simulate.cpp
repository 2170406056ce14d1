// `simulate`: one trajectory as CSV, in the user's body frame.
#include <fmt/format.h>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"

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
std::vector<S> row_of(const Scene& scene, const SampleT& s) {
  std::vector<S> row{s.t};
  const auto add = [&row](const auto& v) {
    for (int i = 0; i < 3; ++i) row.push_back(v[i]);
  };
  if (scene.translation) {
    add(s.p);
    add(s.v);
  }
  if (scene.rotation) {
    const QuaternionT<S> to_user = scene.rotation->principal_to_user.template cast<S>();
    const bool turned = to_user.vec().norm() > S(0);
    if (scene.rotation->attitude) {
      const QuaternionT<S> q = turned ? QuaternionT<S>(s.q * to_user.conjugate()) : s.q;
      for (const S& x : {q.w(), q.x(), q.y(), q.z()}) row.push_back(x);
    }
    add(turned ? to_space<S>(to_user, s.w_B) : s.w_B);
  }
  row.push_back(s.total_energy);
  if (scene.rotation) {
    // Without an attitude the momentum is known in the body frame alone.
    const QuaternionT<S> to_user = scene.rotation->principal_to_user.template cast<S>();
    add(scene.rotation->attitude || !(to_user.vec().norm() > S(0)) ? s.L : to_space<S>(to_user, s.L));
  }
  return row;
}

std::string header(const Scene& scene) {
  std::string line;
  for (std::size_t i = 0; i < std::size(columns); ++i) {
    const bool translation = i >= 1 && i <= 6, attitude = i >= 7 && i <= 10,
               rotation = (i >= 11 && i <= 13) || i >= 15;
    if ((translation && !scene.translation) || (rotation && !scene.rotation) ||
        (attitude && !(scene.rotation && scene.rotation->attitude)))
      continue;
    line += (line.empty() ? "" : ",") + std::string(columns[i].name);
  }
  return line + '\n';
}

void put(const Options& options, const std::string& text) {
  if (!options.output || *options.output == "-")
    write_stdout(text);
  else
    write_file(*options.output, text);
}

std::string wide_trajectory(const Scene& scene, const AskedTimes& asked, const Options& options) {
  std::vector<double> times = asked.times;
  if (asked.from_start) times.insert(times.begin(), 0.0);
  const Truth truth = reference_solution(scene, times);
  const double worst = std::max(truth.attitude_uncertainty, truth.rate_uncertainty);
  if (worst > std::pow(10.0, -options.digits))
    fmt::print(stderr,
               "polhode: note: {} digits asked for, but the truth of '{}' is only certain to {:.1e}\n",
               options.digits, scene.id, worst);
  std::string text = header(scene);
  for (std::size_t i = 0; i < truth.samples.size(); ++i) {
    const std::vector<Wide> row = row_of<Wide>(scene, truth.samples[i]);
    text += shortest(times[i]);
    for (std::size_t k = 1; k < row.size(); ++k)
      text += ',' + (options.digits <= 17 ? shortest(row[k].convert_to<double>())
                                          : row[k].str(options.digits, std::ios_base::scientific));
    text += '\n';
  }
  return text;
}

}  // namespace

int simulate_verb(const Options& options) {
  if (options.scenes.size() != 1)
    throw UsageError("simulate needs one scene; 'polhode list scenes' shows all");
  if (options.solvers.size() > 1) throw UsageError("simulate takes one --solver");
  const Scene scene = asked_scene(options, options.scenes.front());
  const Method& method = find_method(options.solvers.empty() ? "reference" : options.solvers.front());
  const AskedTimes asked = asked_times(scene, options);
  if (method.family == "truth") {
    put(options, wide_trajectory(scene, asked, options));
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
  std::string text = header(scene);
  for (const Sample& s : run.samples) {
    const std::vector<double> row = row_of<double>(scene, s);
    for (std::size_t k = 0; k < row.size(); ++k) text += (k ? "," : "") + shortest(row[k]);
    text += '\n';
  }
  put(options, text);
  if (run.outcome != Outcome::ok) {
    fmt::print(stderr, "polhode: '{}' ended with {}: {}\n", method.id, name_of(run.outcome), run.reason);
    return 1;
  }
  return 0;
}

}  // namespace polhode
