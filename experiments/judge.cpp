// `judge`: the trajectory of any other program against the exact motion of a scene.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "experiments/columns.hpp"
#include "experiments/fit.hpp"
#include "experiments/mistakes.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "models/errors.hpp"

namespace polhode {
namespace {

constexpr Column columns[] = {
    {"quantity", ColumnType::text, "what is compared with the exact motion"},
    {"unit", ColumnType::text, "rad, m, or 1 for a ratio"},
    {"max", ColumnType::number, "largest error over the rows"},
    {"end", ColumnType::number, "error of the last row"},
    {"first_above_s", ColumnType::number, "first time with an error above --error, s; empty: never"},
    {"drift", ColumnType::text, "bounded, random_walk, linear, quadratic, exponential"},
    {"exponent", ColumnType::number, "of t (of exp(t), 1/s, if exponential)"},
    {"exponent_error", ColumnType::number, "its standard error"},
};
constexpr Column row_columns[] = {
    {"t_s", ColumnType::number, "time, s"},
    {"attitude_error_rad", ColumnType::number, "attitude error, rad"},
    {"rate_error_rel", ColumnType::number, "|w - w_exact|/|w_exact|"},
    {"position_error_m", ColumnType::number, "position error, m"},
    {"energy_error_rel", ColumnType::number,
     "(E - E_exact)/|E(0)|, signed; of the rotation where there is one"},
    {"momentum_error_rel", ColumnType::number, "|L - L_exact|/|L(0)|"},
    {"unit_defect", ColumnType::number, "| |q| - 1 |"},
};
struct Quantity {
  const char *name, *unit;
};
constexpr std::array<Quantity, 6> quantities = {{{"attitude", "rad"},
                                                 {"rate", "1"},
                                                 {"position", "m"},
                                                 {"energy", "1"},
                                                 {"momentum", "1"},
                                                 {"unit defect", "1"}}};
constexpr std::size_t compared = 5;      // the last is no error against the truth
constexpr std::size_t most_rows = 2000;  // the truth is computed for each, in 50 digits
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Every k-th row and the last, where there are too many.
void thin(TrajectoryFile& file) {
  const std::size_t n = file.t.size(), every = (n + most_rows - 1) / most_rows;
  if (every == 1) return;
  const auto keep = [n, every](auto& part) {
    if (part.empty()) return;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i)
      if (i % every == 0 || i + 1 == n) part[kept++] = part[i];
    part.resize(kept);
  };
  keep(file.t);
  keep(file.q);
  keep(file.w);
  keep(file.p);
  keep(file.v);
  keep(file.L);
  keep(file.energy);
}

/// Which quantities the file tells something about.
std::array<bool, 6> told_by(const Scene& scene, const TrajectoryFile& file) {
  const bool moves = scene.translation.has_value(), rotates = scene.rotation.has_value();
  const bool attitude = rotates && scene.rotation->attitude && !file.q.empty();
  const bool rates = rotates && !file.w.empty();
  const bool oriented = attitude || (rotates && !scene.rotation->attitude);
  const bool moving = !file.p.empty() && !file.v.empty();
  const bool computed = rotates ? rates && (moves || oriented || scene.rotation->loads.empty()) : moving;
  return {attitude, rates, moves && !file.p.empty(),
          computed || (!(rotates && moves) && !file.energy.empty()),
          // L in a file is that of the space frame, which bare rates do not know.
          rotates && ((rates && oriented) || (scene.rotation->attitude && !file.L.empty())), attitude};
}

std::array<double, 6> errors_in(const SampleErrors& e, const std::array<bool, 6>& told, bool rotational) {
  std::array<double, 6> all = {e.attitude, e.rate,
                               e.position, rotational ? e.rotational_energy : e.total_energy,
                               e.momentum, e.unit_defect};
  for (std::size_t k = 0; k < all.size(); ++k)
    if (!told[k]) all[k] = none;
  return all;
}

std::string read_as(const TrajectoryFile& file, const Reading& reading) {
  std::string parts;
  const auto add = [&parts](bool there, const std::string& what) {
    if (there) parts += (parts.empty() ? "" : ", ") + what;
  };
  add(!file.q.empty(),
      file.tum ? "attitude (TUM: scalar last)"
               : fmt::format("attitude ({})", reading.scalar_last ? "scalar last" : "scalar first"));
  add(!file.w.empty(), fmt::format("angular velocity ({} frame{})", reading.space_rates ? "space" : "body",
                                   file.degrees ? ", from degrees" : ""));
  add(!file.p.empty(), "position");
  add(!file.v.empty(), "velocity");
  add(!file.L.empty(), "angular momentum");
  add(!file.energy.empty(), "energy");
  return parts;
}

}  // namespace

int judge_verb(const Options& options) {
  if (options.scenes.size() != 2)
    throw UsageError("judge needs a scene and a trajectory: polhode judge SCENE TRAJECTORY.csv");
  const Scene scene = asked_scene(options, options.scenes[0]);
  const std::string& name = options.scenes[1];
  TrajectoryFile file = read_trajectory(name);
  if (file.t.back() > scene.duration * (1 + 1e-12))
    throw InputError(
        fmt::format("{}: the last row has t = {} s, but '{}' lasts {} s; needs times from 0 to there, "
                    "or --duration",
                    name, file.t.back(), scene.id, scene.duration));
  const std::size_t rows = file.t.size();
  thin(file);
  Reading reading;
  // TUM's columns are named here, so its order is true unless the options say otherwise.
  reading.scalar_last = file.tum ? false : options.quaternion == "xyzw";
  if (file.tum && options.quaternion == "wxyz") {
    for (auto& q : file.q) q = {q[1], q[2], q[3], q[0]};  // the four numbers as they stand in the line
  }
  reading.space_rates = options.frame.empty() ? file.space_rates : options.frame == "space";
  if (reading.space_rates && !file.w.empty() && file.q.empty())
    throw InputError(name + ": rates in the space frame need the attitude beside them: qw, qx, qy, qz");

  const auto told = told_by(scene, file);
  if (std::none_of(told.begin(), told.end(), [](bool t) { return t; }))
    throw InputError(
        fmt::format("{}: nothing in it belongs to '{}': got {}", name, scene.id, read_as(file, reading)));
  std::size_t norm = 0;
  while (norm < compared && (options.norm.empty() ? !told[norm] : options.norm != quantities[norm].name))
    ++norm;
  if (norm == compared || !told[norm])
    throw InputError(fmt::format("{}: no {} can be had from {}", name,
                                 options.norm.empty() ? "error" : options.norm, read_as(file, reading)));

  progress(options, "judge: truth");
  const auto truth = needed_truth_of(scene, file.t, options);
  const std::size_t first = file.t.front() > 0 ? 1 : 0;
  const std::vector<Sample> samples = samples_of(scene, file, reading);
  Table series{"judged_rows.csv", row_columns, {}, 1};
  std::array<std::vector<double>, 6> errors;
  const bool rotational = scene.rotation && scene.translation;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const auto e =
        errors_in(errors_at(scene, *truth, samples[i], truth->truth.samples[first + i]), told, rotational);
    std::vector<Cell> row{file.t[i]};
    for (std::size_t k = 0; k < e.size(); ++k) {
      row.push_back(number(e[k]));
      errors[k].push_back(std::abs(e[k]));
    }
    series.add(std::move(row));
  }
  const double threshold = options.error.value_or(options.max_error.value_or(1e-3));
  Table table{"judge.csv", columns, {}, 1};
  double judged = 0;
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    if (!told[k]) continue;
    const auto& e = errors[k];
    const double largest = *std::max_element(e.begin(), e.end());
    if (k == norm) judged = largest;
    const auto above = std::find_if(e.begin(), e.end(), [threshold](double x) { return x > threshold; });
    const Drift d = classify_drift(file.t, e, 1e-15);
    table.add({text(quantities[k].name), text(quantities[k].unit), largest, e.back(),
               above == e.end() ? Cell() : Cell(file.t[static_cast<std::size_t>(above - e.begin())]),
               text(d.kind), number(d.exponent), number(d.exponent_error)});
  }
  const std::span exact(truth->truth.samples.data() + first, samples.size());
  const std::vector<Mistake> mistakes = likely_mistakes(scene, file, reading, exact);
  progress(options, "");
  const bool passed = !options.max_error || judged <= *options.max_error;
  if (options.output) {
    if (*options.output == "-")
      write_stdout(csv(series));
    else
      write_file(*options.output, csv(series));
    if (*options.output == "-") return passed ? 0 : 1;
  }

  if (options.json) {
    nlohmann::ordered_json found = nlohmann::ordered_json::array();
    for (const Mistake& m : mistakes)
      found.push_back({{"id", m.id},
                       {"what", m.what},
                       {"quantity", m.quantity},
                       {"median_error_as_it_stands", m.before},
                       {"median_error_without", m.after}});
    const nlohmann::ordered_json j = {
        {"scene", scene.id},
        {"file", name},
        {"rows", rows},
        {"rows_judged", samples.size()},
        {"from_s", file.t.front()},
        {"to_s", file.t.back()},
        {"read_as", read_as(file, reading)},
        {"ignored_columns", file.ignored},
        {"threshold", threshold},
        {"errors", nlohmann::ordered_json::parse(json(table))},
        {"mistakes", found},
        {"attitude_floor_rad", truth->floor().attitude},
        {"norm", quantities[norm].name},
        {"max_error",
         options.max_error ? nlohmann::ordered_json(*options.max_error) : nlohmann::ordered_json()},
        {"passed", passed}};
    write_stdout(j.dump(2) + "\n");
    return passed ? 0 : 1;
  }
  std::string out = fmt::format("{} against the exact motion of {}\n", name, scene.id);
  out += fmt::format("  {} rows from t = {} to {} s", rows, file.t.front(), file.t.back());
  if (samples.size() < rows) out += fmt::format("; {} of them judged, evenly", samples.size());
  out += fmt::format("\n  read as: {}\n", read_as(file, reading));
  if (!file.ignored.empty()) out += fmt::format("  not looked at: {}\n", name_list(file.ignored));
  std::vector<std::vector<std::string>> lines{
      {"error of", "largest", "at the end", fmt::format("above {}", shortest(threshold)), "drift"}};
  for (const auto& row : table.rows) {
    const auto value = [&row](std::size_t i) { return std::get<double>(row[i]); };
    const std::string unit = std::get<std::string>(row[1]) == "1" ? "" : " " + std::get<std::string>(row[1]);
    const std::string kind = std::get<std::string>(row[5]);
    lines.push_back({std::get<std::string>(row[0]), fmt::format("{:.3g}{}", value(2), unit),
                     fmt::format("{:.3g}{}", value(3), unit),
                     row[4].index() == 0 ? "never" : fmt::format("from t = {:.6g} s", value(4)),
                     kind == "bounded"
                         ? kind
                         : fmt::format("{}, {}^{:.2f}", kind, kind == "exponential" ? "e" : "t", value(6))});
  }
  out += '\n' + in_columns(lines);
  if (told[0] && norm == 0 && judged <= 10 * truth->floor().attitude)
    out += fmt::format("\nThat is what double precision can resolve on this scene ({:.1e} rad).\n",
                       truth->floor().attitude);
  if (mistakes.empty()) {
    out += "\nNo known mistake explains these errors.\n";
  } else {
    out += "\nLikely mistakes (undone, the median error falls):\n";
    for (const Mistake& m : mistakes)
      out += fmt::format("  - {}: {} error {:.2g} -> {:.2g}\n", m.what, m.quantity, m.before, m.after);
  }
  if (options.max_error)
    out += fmt::format("\n{}: largest {} error {:.3g}, allowed {}\n", passed ? "passed" : "FAILED",
                       quantities[norm].name, judged, shortest(*options.max_error));
  write_stdout(out);
  return passed ? 0 : 1;
}

}  // namespace polhode
