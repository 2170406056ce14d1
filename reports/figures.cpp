// Figures for papers, as gnuplot scripts with their data beside them. Each is drawn four times: as SVG and as
// PDF, one column wide and two. Which clauses a script needs is decided here, from the same table, because
// gnuplot complains about clauses without points.
#include "reports/figures.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "reports/findings.hpp"
#include "reports/stability_map.hpp"

namespace polhode::report {

std::string gnuplot_text(std::string_view text) {
  std::string out = "'";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) continue;
    if (c == '\'') out += c;
    out += c;
  }
  return out + "'";
}

std::string gnuplot_field(std::string_view text) {
  return gnuplot_text(text.substr(0, text.find_first_of(",\"")));
}

namespace {

/// Limits of a logarithmic axis: whole decades around what it must show.
class LogRange {
 public:
  explicit LogRange(double least) : least_(least) {}

  /// Zeros, negatives and what is smaller than `least` do not stretch the axis: they are drawn on its lower
  /// end.
  void include(double value) {
    if (!std::isfinite(value) || value < least_) return;
    low_ = std::min(low_, value);
    high_ = std::max(high_, value);
  }
  bool empty() const { return !(low_ <= high_); }
  double low() const { return std::pow(10.0, std::floor(std::log10(low_) + 1e-9)); }
  double high() const {
    const double up = std::pow(10.0, std::ceil(std::log10(high_) - 1e-9));
    return up > low() ? up : 10 * low();
  }
  double largest() const { return high_; }
  int decades() const { return static_cast<int>(std::lround(std::log10(high() / low()))); }

  void cap(double highest) { high_ = std::clamp(high_, low_, std::max(low_, highest)); }

 private:
  double least_, low_ = std::numeric_limits<double>::infinity(), high_ = 0;
};

constexpr double least_shown_error = 1e-17;  // smaller relative errors mean nothing in double precision
constexpr double highest_shown_drift = 1e3;  // an exponential escape leaves at the top
constexpr std::size_t most_lines = 20;  // in one figure; of more solvers the best of each family are drawn

struct Axes {
  std::string title, x_label, y_label;
  LogRange x, y;
};

std::string log_axis(char axis, const LogRange& range, const std::string& label) {
  // A label every decade up to eight of them, then every second, third, ... one; minor ticks only where there
  // is room.
  const int every = (range.decades() + 7) / 8;
  std::string out =
      fmt::format("set logscale {0}\nset {0}range [{1:.10g}:{2:.10g}]\n", axis, range.low(), range.high());
  out += fmt::format(
      "set format {0} '10^{{%T}}'\nset {0}tics {1:.10g}\nset {0}label {2} noenhanced textcolor rgb "
      "'#333333'\n",
      axis, std::pow(10.0, every), gnuplot_text(label));
  if (every == 1) out += fmt::format("set m{}tics 10\n", axis);
  return out;
}

std::string head(const Figure& f, const Axes& axes) {
  std::string out = fmt::format("# Run in this folder: gnuplot {0}.gp. Reads {0}.csv.\n", f.name);
  out +=
      "set encoding utf8\nset datafile separator comma\nset datafile columnheaders\nset datafile missing "
      "NaN\n";
  out += "set border 3 linecolor rgb '#555555' linewidth 0.8\nset tics nomirror out scale 0.6,0.3\n";
  out += "set grid xtics ytics linetype 1 linecolor rgb '#e4e4e4' linewidth 0.7\n";
  out += fmt::format("set title {} noenhanced textcolor rgb '#222222'\n", gnuplot_text(axes.title));
  out += log_axis('x', axes.x, axes.x_label) + log_axis('y', axes.y, axes.y_label);
  return out;
}

/// Draws what was plotted once for every width and format: 7 pt letters, 84 mm for one column of a page and
/// 174 mm for two, the legend below or beside.
std::string drawing(const Figure& f, std::size_t legend) {
  const auto rows = static_cast<double>(legend);
  const double below = 62 + 3.4 * std::ceil(rows / 2), beside = std::max(100.0, 18 + 3.6 * rows);
  return fmt::format(
      "do for [mm in '84 174'] {{\n"
      "  name = '{0}-'.mm.'mm'\n"
      "  tall = mm eq '84' ? {1:.0f} : {2:.0f}  # mm\n"
      "  set key default Left reverse noenhanced textcolor rgb '#333333'\n"
      "  if (mm eq '84') {{ set key below height 1.5 maxcols 2 samplen 1.6 spacing 0.9 }}\n"
      "  if (mm ne '84') {{ set key outside right top maxcols 1 samplen 2.2 spacing 1.0 }}\n"
      "  px = 96 / 25.4  # of an SVG\n"
      "  set terminal svg size mm*px, tall*px font 'Helvetica,9.3' linewidth 0.75 background rgb '#ffffff'\n"
      "  set output name.'.svg'\n  replot\n"
      "  if (strstrt(GPVAL_TERMINALS, 'pdfcairo') > 0) {{\n"
      "    set terminal pdfcairo color size mm/10.0 cm, tall/10.0 cm font 'sans,14' fontscale 0.5 linewidth "
      "0.75\n"
      "    set output name.'.pdf'\n    replot\n  }}\n"
      "  unset output\n}}\n",
      f.name, below, beside);
}

/// The clauses of one plot command.
class Clauses {
 public:
  explicit Clauses(std::string file) : file_(std::move(file)) {}

  void add(std::string_view x, std::string_view y, std::string_view look, std::string_view title) {
    text_ += text_.empty() ? fmt::format("plot {} ", gnuplot_text(file_)) : std::string(", \\\n  '' ");
    text_ += fmt::format("using ({}):({}) {} {}", x, y, look,
                         title.empty() ? "notitle" : fmt::format("title {}", gnuplot_text(title)));
  }
  /// A line of the legend alone.
  void add_key(std::string_view look, std::string_view title) {
    text_ += fmt::format(", \\\n  NaN {} title {}", look, gnuplot_text(title));
  }
  bool empty() const { return text_.empty(); }
  std::string text() const { return text_ + "\n"; }

 private:
  std::string file_, text_;
};

std::string line_look(const Mark& m) {
  return fmt::format(
      "with linespoints linecolor rgb '{0}' linewidth 1.6 dashtype {1} pointtype {2} pointsize 0.45",
      m.colour, m.dash, m.filled);
}

std::string hollow_look(const Mark& m) {
  return fmt::format("with points linecolor rgb '{}' linewidth 1.2 pointtype {} pointsize 0.45", m.colour,
                     m.hollow());
}

void finish(Figure& f, const CsvTable& table, const Axes& axes, std::size_t legend,
            const std::string& between, const Clauses& clauses) {
  f.title = axes.title;
  f.data = table.csv();
  f.script = head(f, axes) + between + "set terminal unknown\n" + clauses.text() + drawing(f, legend);
}

/// Grey band from the lower end of the axis up to the rounding floor.
std::string floor_band(const SceneCard& scene, const Quantity& quantity, const LogRange& y) {
  if (quantity.unit != "rad" || !(scene.floor > y.low())) return {};
  const double top = std::min(scene.floor, y.high());
  return fmt::format(
      "set object 1 rectangle from graph 0, first {0:.10g} to graph 1, first {1:.10g} behind "
      "fillcolor rgb '#eeeeee' fillstyle solid noborder\n"
      "set label 2 'rounding floor' at graph 0.99, first {1:.10g} right offset 0, character 0.6 "
      "textcolor rgb '#777777'\n",
      y.low(), top);
}

/// Dotted lines of slope 1, 2 and 4 from one corner, to be compared with the curves by eye.
std::string slope_guides(const LogRange& x, const LogRange& y) {
  std::string out;
  if (y.decades() < 2 || x.decades() < 1 || std::min(y.largest(), 1.0) < 30 * y.low()) return out;
  int tag = 10;
  for (const int p : {1, 2, 4}) {
    const double x0 = x.largest(), y0 = std::min(y.largest(), 1.0);
    const double x1 = std::max(x.low(), x0 * std::pow(y.low() / y0, 1.0 / p));
    const double y1 = y0 * std::pow(x1 / x0, p);
    out += fmt::format(
        "set arrow {} from {:.10g}, {:.10g} to {:.10g}, {:.10g} nohead back dashtype 3 linewidth 1.2 "
        "linecolor rgb '#999999'\n",
        tag, x0, y0, x1, y1);
    // The label sits on the guide where it leaves the axes, on the side that is free there.
    const bool leaves_below = x1 > x.low() * 1.001;
    out += fmt::format(
        "set label {} 'slope {}' at {:.10g}, {:.10g} left offset character {} textcolor rgb "
        "'#777777'\n",
        tag, p, x1, y1, leaves_below ? "0.9, 0.6" : "1.6, -0.3");
    ++tag;
  }
  return out;
}

struct Ladder {
  std::size_t joined = 0, loose = 0, low = 0;
};

/// Error against something, one line a solver: three figures share it.
bool ladder_figure(Figure& f, const Results& r, const SceneCard& scene, const CsvTable& table,
                   const std::string& x_column, Axes axes, bool guides) {
  const Quantity quantity = r.quantity_of(table, scene.id);
  axes.y_label = quantity.unit.empty() ? "largest " + quantity.name
                                       : fmt::format("largest {} / {}", quantity.name, quantity.unit);
  std::map<std::string, Ladder> ladders;
  const auto rows = Results::rows_of(table, scene.id);
  for (const std::size_t i : rows) {
    const double x = table.number(i, x_column), error = table.number(i, quantity.column);
    if (!(x > 0) || !std::isfinite(x) || !std::isfinite(error) || error < 0) continue;
    axes.x.include(x);
    axes.y.include(error);
  }
  if (axes.x.empty()) return false;
  if (axes.y.empty()) axes.y.include(least_shown_error);
  const double low = axes.y.low();
  for (const std::size_t i : rows) {
    const double x = table.number(i, x_column), error = table.number(i, quantity.column);
    if (!(x > 0) || !std::isfinite(x) || !std::isfinite(error) || error < 0) continue;
    Ladder& ladder = ladders[table.text(i, "solver")];
    ++(table.flag(i, "above_floor") ? ladder.joined : ladder.loose);
    if (error < low) ++ladder.low;
  }

  Clauses clauses(f.name + ".csv");
  std::size_t legend = 0;
  for (const std::string& solver : r.solvers_in(table, scene.id)) {
    const Ladder& ladder = ladders[solver];
    const Mark& mark = r.marks.at(solver);
    const std::string mine = fmt::format("mine({})", gnuplot_field(solver));
    const std::string y = fmt::format("shown(column('{}'))", quantity.column);
    const std::string x = fmt::format("column('{}')", x_column);
    if (ladder.joined + ladder.loose > 0) ++legend;
    if (ladder.joined > 0)
      clauses.add(fmt::format("{} && !loose('above_floor') ? {} : NaN", mine, x), y, line_look(mark), solver);
    if (ladder.loose > 0)
      clauses.add(fmt::format("{} && loose('above_floor') ? {} : NaN", mine, x), y, hollow_look(mark),
                  ladder.joined > 0 ? "" : solver);
    if (ladder.low > 0)
      clauses.add(fmt::format("{} && column('{}') < {:.10g} ? {} : NaN", mine, quantity.column, low, x),
                  fmt::format("{:.10g}", low),
                  fmt::format("with points linecolor rgb '{}' pointtype 11 pointsize 0.8", mark.colour), "");
  }
  if (clauses.empty()) return false;
  std::string between = fmt::format(
      "mine(s) = stringcolumn('solver') eq s\n"
      "# An error of zero, or one too small to show, sits on the lower end and carries a downward mark.\n"
      "shown(y) = y < {:.10g} ? {:.10g} : y\n",
      low, low);
  between += table.has("above_floor") ? "# Points that rounding decides stay unconnected and "
                                        "hollow.\nloose(c) = stringcolumn(c) eq '0' || "
                                        "stringcolumn(c) eq 'false'\n"
                                      : "loose(c) = 0\n";
  between += floor_band(scene, quantity, axes.y);
  if (guides) between += slope_guides(axes.x, axes.y);
  finish(f, table, axes, legend, between, clauses);
  return true;
}

bool drift_figure(Figure& f, const Results& r, const SceneCard& scene, const CsvTable& table,
                  const std::string& column, Axes axes) {
  // A solver may have been run at several settings: each is a line of its own, told apart by the label.
  std::vector<std::pair<std::string, std::string>> runs;
  std::map<std::string, int> settings;
  for (const std::size_t i : Results::rows_of(table, scene.id)) {
    const double t = table.number(i, "t_s"), drift = std::abs(table.number(i, column));
    if (!(t > 0) || !std::isfinite(drift) || drift == 0) continue;
    axes.x.include(t);
    axes.y.include(drift);
    const std::pair run(table.text(i, "solver"), table.text(i, "knob_value"));
    if (std::find(runs.begin(), runs.end(), run) == runs.end()) {
      runs.push_back(run);
      ++settings[run.first];
    }
  }
  if (axes.x.empty() || axes.y.empty()) return false;
  axes.y.cap(highest_shown_drift);
  const auto place = [&](const std::string& s) { return std::find(r.solvers.begin(), r.solvers.end(), s); };
  std::stable_sort(runs.begin(), runs.end(),
                   [&](const auto& a, const auto& b) { return place(a.first) < place(b.first); });

  Clauses clauses(f.name + ".csv");
  std::map<std::string, int> nth;
  for (const auto& [solver, value] : runs) {
    const Mark& m = r.marks.at(solver);
    const int dash = (m.dash - 1 + nth[solver]++) % 4 + 1;
    clauses.add(
        fmt::format("mine({}, {}) ? column('t_s') : NaN", gnuplot_field(solver), gnuplot_field(value)),
        fmt::format("size(column('{}'))", column),
        fmt::format(
            "with linespoints linecolor rgb '{}' linewidth 1.5 dashtype {} pointtype {} pointsize 0.45 "
            "pointnumber 7",
            m.colour, dash, m.filled),
        settings[solver] > 1 ? fmt::format("{} @ {}", solver, value) : solver);
  }
  const std::string between =
      "mine(s, v) = stringcolumn('solver') eq s && stringcolumn('knob_value') eq v\n"
      "# A drift of exactly zero has no logarithm and is passed over.\nsize(y) = abs(y) > 0 ? abs(y) : NaN\n";
  finish(f, table, axes, runs.size(), between, clauses);
  return true;
}

bool stability_figure(Figure& f, const Results& r, const SceneCard& scene, const CsvTable& table,
                      const std::string& parameter, Axes axes) {
  std::map<std::string, std::pair<int, int>> lines;  // measured, theory
  for (const StabilityLimit& l : stability_limits(table, scene)) {
    if (l.parameter != parameter) continue;
    const double value = std::strtod(l.value.c_str(), nullptr);
    if (!(value > 0)) continue;
    if (l.largest > 0) axes.x.include(value), axes.y.include(l.largest), ++lines[l.solver].first;
    if (l.theory > 0) axes.x.include(value), axes.y.include(l.theory), ++lines[l.solver].second;
  }
  if (axes.x.empty() || axes.y.empty()) return false;
  Clauses clauses(f.name + ".csv");
  std::size_t legend = 0;
  bool with_theory = false;
  for (const std::string& solver : r.solvers_in(table, scene.id)) {
    const auto [measured, theory] = lines[solver];
    const Mark& m = r.marks.at(solver);
    const std::string x = fmt::format("mine({}) ? column('parameter_value') : NaN", gnuplot_field(solver));
    // `smooth unique` sorts by the parameter, and makes one point of several rows with one value of it.
    if (theory > 0) {
      clauses.add(
          x, "column('theory_h_s')",
          fmt::format("smooth unique with lines linecolor rgb '{}' linewidth 1.4 dashtype 2", m.colour), "");
      with_theory = true;
    }
    if (measured > 0) {
      clauses.add(
          x, "column('largest_stable_h_s')",
          fmt::format("smooth unique with {} linecolor rgb '{}' linewidth 1.6 pointtype {} pointsize 0.55",
                      theory > 0 ? "points" : "linespoints", m.colour, m.filled),
          solver);
      ++legend;
    }
  }
  if (with_theory) {
    clauses.add_key("with lines linecolor rgb '#555555' linewidth 1.4 dashtype 2", "linear theory");
    ++legend;
  }
  if (clauses.empty()) return false;
  finish(f, table, axes, legend,
         fmt::format("mine(s) = stringcolumn('solver') eq s && stringcolumn('parameter') eq {}\n",
                     gnuplot_field(parameter)),
         clauses);
  return true;
}

/// `stiffness_N_m` reads as `stiffness N m` on an axis; nothing more is known about a parameter here.
std::string spaced(std::string text) {
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

}  // namespace

std::vector<Figure> figures_of(const Results& r) {
  std::vector<Figure> out;
  const LogRange errors(least_shown_error), costs(std::numeric_limits<double>::min());
  for (const SceneCard& scene : r.scenes) {
    const auto keep = [&](const std::string& kind, const std::string& stem, auto draw) {
      Figure f;
      f.kind = kind;
      f.scene = scene.id;
      f.name = stem + "-" + scene.file;
      if (draw(f)) out.push_back(std::move(f));
    };
    const CsvTable work = telling_rows(r, scene, r.work_precision, most_lines),
                   ladder = telling_rows(r, scene, r.convergence, most_lines),
                   drift = telling_rows(r, scene, r.drift, most_lines),
                   limits = telling_rows(r, scene, r.stability, most_lines);
    const auto titled = [&](const std::string& what, std::string x_label, std::string y_label) {
      return Axes{scene.name() + ": " + what, std::move(x_label), std::move(y_label), costs, errors};
    };
    keep("work-precision", "work-precision", [&](Figure& f) {
      return ladder_figure(f, r, scene, work, "time_min_s",
                           titled("error against run time", "run time, least of the repeats / s", ""), false);
    });
    keep("evaluations", "evaluations", [&](Figure& f) {
      return ladder_figure(f, r, scene, work, "rhs_evals",
                           titled("error against work", "right-hand-side evaluations", ""), false);
    });
    keep("convergence", "convergence", [&](Figure& f) {
      return ladder_figure(f, r, scene, ladder, "h_s", titled("error against step", "step h / s", ""), true);
    });
    keep("energy-drift", "energy-drift", [&](Figure& f) {
      for (const auto& [column, what] : {std::pair("rotational_energy_drift_rel", "rotational energy"),
                                         std::pair("total_energy_drift_rel", "energy")})
        if (drift_figure(f, r, scene, drift, column,
                         titled(fmt::format("drift of the {}", what), "time / s",
                                fmt::format("|relative drift| of the {}", what))))
          return true;
      return false;
    });
    keep("momentum-drift", "momentum-drift", [&](Figure& f) {
      return drift_figure(
          f, r, scene, drift, "momentum_drift_rel",
          titled("drift of the angular momentum", "time / s", "relative drift of the angular momentum"));
    });
    std::vector<std::string> parameters;
    for (const std::size_t i : Results::rows_of(limits, scene.id))
      if (std::find(parameters.begin(), parameters.end(), limits.text(i, "parameter")) == parameters.end())
        parameters.push_back(limits.text(i, "parameter"));
    for (std::size_t n = 0; n < parameters.size(); ++n)
      keep("stability", n == 0 ? "stability" : fmt::format("stability-{}", n + 1), [&](Figure& f) {
        return stability_figure(
            f, r, scene, limits, parameters[n],
            titled("largest stable step", spaced(parameters[n]), "largest stable step h / s"));
      });
  }
  for (Figure& f : map_figures(r)) out.push_back(std::move(f));
  return out;
}

}  // namespace polhode::report
