// Asking questions and writing the answers: `study` asks all of them, the other question verbs one each.
//
// Everything goes into one result folder: the tables, solvers.csv and scenes.csv, run.json, datapackage.json,
// the figures and the page. It is filled beside its final place and moved there whole.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "experiments/grid.hpp"
#include "experiments/interrupt.hpp"
#include "experiments/plot.hpp"
#include "experiments/provenance.hpp"
#include "experiments/question.hpp"
#include "experiments/result_folder.hpp"
#include "experiments/summary.hpp"
#include "experiments/verbs.hpp"
#include "models/errors.hpp"
#include "reports/report.hpp"

namespace polhode {

#define VERB(function, verb, operands, summary) int function##_verb(const Options& options);
#include "experiments/verbs.def"
#undef VERB

namespace {

// One scene for each thing that a study should show: a near-separatrix body in free fall, a well-conditioned
// free body with published digits, torque with fast spin, several loads at once, and two with a stiff
// parameter.
constexpr const char* study_scenes[] = {"hairer-vilmart",      "tumbling-box",    "heavy-top",
                                        "spinning-projectile", "attitude-spring", "angular-drag"};
constexpr const char* quick_scenes[] = {"hairer-vilmart", "heavy-top", "angular-drag"};

constexpr Column solver_columns[] = {
    {"solver", ColumnType::text, "solver id"},
    {"family", ColumnType::text, "family"},
    {"order", ColumnType::number, "claimed order of the attitude; empty: none"},
    {"source", ColumnType::text, "where the method is from"},
    {"version", ColumnType::text, "of the library that it wraps"},
    {"summary", ColumnType::text, "what it does"},
    {"rate_order", ColumnType::number, "claimed order of the rates"},
    {"energy_order", ColumnType::number, "claimed order of the energy"},
    {"momentum_order", ColumnType::number, "claimed order of the momentum"},
    {"unit_attitude", ColumnType::text, "yes, no or unknown: the attitude stays of unit length to rounding"},
    {"momentum_magnitude", ColumnType::text, "|L| of the free body stays to rounding"},
    {"space_momentum", ColumnType::text, "L of the free body stays to rounding, direction too"},
    {"energy_bounded", ColumnType::text, "the energy error of the free body has no secular part"},
    {"reversible", ColumnType::text, "forward and back returns to the start"},
    {"precision", ColumnType::text, "of its arithmetic: double, single or wide"},
    {"settings", ColumnType::text, "what is set on the library beyond the knob"},
};
constexpr Column scene_columns[] = {
    {"scene", ColumnType::text, "scene id"},
    {"title", ColumnType::text, "title"},
    {"duration_s", ColumnType::number, "duration, s"},
    {"unknowns", ColumnType::integer, "length of the state"},
    {"left_out", ColumnType::text, "what the equations do without"},
    {"truth_uncertainty_rad", ColumnType::number,
     "largest difference to a second solution of less accuracy, rad"},
    {"floor_attitude_rad", ColumnType::number,
     "what double precision can resolve: rounding times the largest growth of a disturbance, rad"},
    {"truth", ColumnType::text, "kind of the truth; none, and why, where it could not be had"},
    {"conditioning", ColumnType::number,
     "growth of a relative disturbance of the initial rates; empty: not known"},
    {"truth_uncertainty_rate_rel", ColumnType::number, "the same for the rates, relative"},
    {"floor_rate_rel", ColumnType::number, "what double precision can resolve of the rates, relative"},
    {"moment_1_kg_m2", ColumnType::number, "principal moments, about the pivot where there is one, kg m^2"},
    {"moment_2_kg_m2", ColumnType::number, ""},
    {"moment_3_kg_m2", ColumnType::number, ""},
};

Cell order_cell(double order) { return order >= 0 ? Cell(order) : Cell(); }
Cell claim_cell(Claim c) { return text(c == Claim::yes ? "yes" : c == Claim::no ? "no" : "unknown"); }

/// All solvers, not the chosen ones: their order decides the colours of every figure.
Table solver_table() {
  Table t{"solvers.csv", solver_columns, {}, 1};
  for (const Method* m : all_methods()) {
    const Claims& c = m->claims;
    t.add({text(m->id), text(m->family), order_cell(c.attitude_order), text(m->source), text(m->version),
           text(m->summary), order_cell(c.rate_order), order_cell(c.energy_order),
           order_cell(c.momentum_order), claim_cell(c.unit_attitude), claim_cell(c.momentum_magnitude),
           claim_cell(c.space_momentum), claim_cell(c.energy_bounded), claim_cell(c.reversible),
           text(precision_of(*m)), text(m->settings)});
  }
  return t;
}

Cell moment(const Scene& s, int i) { return s.rotation ? Cell(s.rotation->moments[i]) : Cell(); }

std::string kind_of(const SceneTruth& truth) {
  return truth.is_known() ? truth.truth.kind : "none: " + truth.truth.refusal;
}

Table scene_table(const Plan& plan) {
  Table t{"scenes.csv", scene_columns, {}, 1};
  for (const Scene& s : plan.scenes) {
    std::string left_out;
    for (const std::string& part : s.left_out) left_out += (left_out.empty() ? "" : "; ") + part;
    const auto truth = truth_for(plan, s, uniform_times(s.duration, 16), "scenes", true);
    if (interrupted()) break;
    const bool rotation = s.rotation && truth->is_known(), attitude = rotation && s.rotation->attitude;
    const Floor& floor = truth->floor();
    t.add({text(s.id), text(s.title), s.duration, std::int64_t{s.unknowns}, left_out,
           attitude ? Cell(truth->truth.attitude_uncertainty) : Cell(),
           attitude ? Cell(floor.attitude) : Cell(), kind_of(*truth), number(floor.conditioning),
           rotation ? Cell(truth->truth.rate_uncertainty) : Cell(), rotation ? Cell(floor.rate) : Cell(),
           moment(s, 0), moment(s, 1), moment(s, 2)});
  }
  return t;
}

/// What the truths cost belongs to the machine, and so to run.json.
std::vector<TruthCost> truths_of(const Plan& plan) {
  std::vector<TruthCost> costs;
  if (interrupted()) return costs;
  for (const Scene& s : plan.scenes) {
    const auto truth = truth_for(plan, s, uniform_times(s.duration, 16), "scenes", false);
    if (interrupted()) break;
    costs.push_back({s.id, kind_of(*truth), truth->truth.cost_s});
  }
  return costs;
}

/// Every built-in scene that has a dial.
std::vector<std::string> dial_scenes() {
  std::vector<std::string> ids = builtin_scene_ids();
  std::erase_if(ids, [](const std::string& id) { return !find_scene(id).dial; });
  return ids;
}

Plan plan_of(const Options& options, const std::vector<Question>& questions) {
  Plan plan;
  plan.options = options;
  std::vector<std::string> ids = options.scenes;
  if (ids.empty()) {
    if (questions.size() == 1 && std::string_view(questions.front().id) == "stability" && !options.quick)
      ids = dial_scenes();
    else if (options.quick)
      ids.assign(std::begin(quick_scenes), std::end(quick_scenes));
    else
      ids.assign(std::begin(study_scenes), std::end(study_scenes));
  }
  for (const std::string& id : ids) {
    Scene scene = asked_scene(options, id);
    for (const Scene& other : plan.scenes)
      if (other.id == scene.id) throw UsageError("scene '" + scene.id + "' is asked for twice");
    plan.scenes.push_back(std::move(scene));
  }
  if (options.solvers.empty()) {
    for (const Method* m : all_methods())
      if (m->family != "truth" && m->in_studies) plan.methods.push_back(m);
  } else {
    plan.methods = select_methods(options.solvers);
  }
  return plan;
}

/// Answers questions and puts the answers where the options say.
int answer(const Options& options, const std::vector<Question>& questions) {
  Plan plan = plan_of(options, questions);
  const std::string place = options.output.value_or("polhode-results");
  const bool to_folder =
      place != "-" && !place.ends_with(".csv") && !(options.json && place.ends_with(".json"));
  if (!to_folder && questions.size() > 1)
    throw UsageError("-o " + place + ": a study has many tables and needs a folder");
  if (!to_folder && options.plot) throw UsageError("--plot: -o " + place + " takes the table alone");
  // Asked before the work: a place that cannot be written should not cost a minute first.
  std::optional<ResultFolder> folder;
  if (to_folder) folder.emplace(place, options.force);
  const std::string mark = fingerprint(options.command_line, plan.scenes);
  if (to_folder) plan.earlier = Earlier(place, mark);
  std::vector<Table> tables;
  for (const Question& q : questions) {
    if (interrupted()) break;
    for (Table& t : q.answer(plan)) tables.push_back(std::move(t));
  }
  progress(options, "");
  const auto has_rows = [](const Table& t) { return !t.rows.empty(); };
  // Interrupted before there was anything: what lies in that place from earlier stays.
  if (tables.empty() || (interrupted() && std::ranges::none_of(tables, has_rows))) throw Stopped();
  if (questions.size() == 1 && tables.front().rows.empty() && !interrupted())
    throw UsageError(
        std::string(questions.front().id) +
        ": none of these scenes and solvers can answer it (stability needs a scene with a [stiff] table "
        "and a solver of fixed step, convergence a solver of fixed step, engines a body that turns freely)");
  if (!to_folder) {
    const std::string text = options.json ? json(tables.front()) : csv(tables.front());
    if (place == "-")
      write_stdout(text);
    else
      write_file(place, text);
    return interrupted() ? 130 : 0;
  }
  tables.push_back(solver_table());
  if (!interrupted()) {
    Table scenes = scene_table(plan);
    if (!interrupted()) tables.push_back(std::move(scenes));
  }
  for (const Table& t : tables) folder->write(std::string(t.file), csv(t));
  folder->write("run.json", run_json(options.command_line, truths_of(plan), mark, interrupted()));
  folder->write("datapackage.json", datapackage_json(tables));
  progress(options, "drawing");
  const ReportOutcome report = write_report(folder->draft());
  progress(options, "");
  const std::string summary =
      options.json ? json(questions.size() == 1 ? tables.front() : summary_table(folder->draft()))
                   : result_summary(folder->draft(), place);
  const bool one_plot = questions.size() == 1 && stdout_is_terminal();
  const std::string plot = !options.json && (options.plot || one_plot)
                               ? work_precision_plot(folder->draft(), stdout_is_coloured())
                               : "";
  folder->commit();
  for (const std::string& note : report.notes) fmt::print(stderr, "polhode: note: {}\n", note);
  if (options.json || !options.quiet) write_stdout(summary + (plot.empty() ? "" : "\n" + plot));
  return interrupted() ? 130 : 0;
}

}  // namespace

int study_verb(const Options& options) {
  refuse_options(options, "a study chooses its own; ask one question alone for that", true, true, true);
  return answer(options, all_questions());
}

const std::vector<Verb>& all_verbs() {
  static const std::vector<Verb> verbs = [] {
    std::vector<Verb> v;
#define VERB(function, verb, operands, summary) v.push_back({verb, operands, summary, function##_verb});
#include "experiments/verbs.def"
#undef VERB
    std::vector<Verb> questions;
#define QUESTION(function, verb, summary)                                                                \
  questions.push_back({verb, "[SCENE...]", summary, [](const Options& o) {                               \
                         return answer(o, {*std::find_if(all_questions().begin(), all_questions().end(), \
                                                         [](const Question& q) {                         \
                                                           return std::string_view(q.id) == verb;        \
                                                         })});                                           \
                       }});
#include "experiments/questions.def"
#undef QUESTION
    v.insert(v.begin() + 1, questions.begin(), questions.end());
    return v;
  }();
  return verbs;
}

}  // namespace polhode
