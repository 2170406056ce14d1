// Cells read once; edges, colours and sentences from them.
#include "reports/stability_map.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "reports/words.hpp"

namespace polhode::report {
namespace {

constexpr const char* axes[] = {"least", "middle", "greatest"};

std::string about(std::string_view axis) {
  return axis == "middle" ? "about the middle axis" : fmt::format("about the axis of {} moment", axis);
}

constexpr double quiet = 1e-12, loud = 1e-1;  // growth per step: below and above, colours do not change
constexpr double noticed = 1e-6;              // loss per step that a sentence speaks of

/// Position of a growth on the palette: -1 loses all, 0 keeps, +1 gains most; logarithmic between.
double shade(double growth) {
  const double size = std::abs(growth);
  if (size < quiet) return 0;
  return std::copysign(std::min(1.0, 0.12 + 0.88 * std::log(size / quiet) / std::log(loud / quiet)), growth);
}

/// Lightness falls and chroma rises in even steps on both sides of no change (OKLCH, hues 250 and 48
/// degrees), as on the page.
constexpr const char* palette =
    "-1 '#0065b1', -0.75 '#4f8ac4', -0.5 '#87add6', -0.25 '#bdd1e6', 0 '#f5f5f5', "
    "0.25 '#e4c8bb', 0.5 '#d09c82', 0.75 '#ba7048', 1 '#a24200'";

double percent(std::size_t part, std::size_t all) {
  return 100 * static_cast<double>(part) / static_cast<double>(all);
}

/// "12 %"; what is there is never "0 %".
std::string share(std::size_t part, std::size_t all) {
  return part > 0 && percent(part, all) < 1 ? "less than 1 %" : fmt::format("{:.0f} %", percent(part, all));
}

/// `Its clamp acts on 4 % of it, from h·|ω| = 0.8 on.`
std::string held_sentence(const std::vector<MapCell>& map, std::string_view outcome, std::string_view what) {
  std::size_t n = 0;
  double least = 0, most = 0;
  for (const MapCell& c : map)
    if (c.outcome == outcome) {
      least = n == 0 ? c.h_w : std::min(least, c.h_w);
      most = std::max(most, c.h_w);
      ++n;
    }
  if (n == 0) return {};
  if (least == most)
    return fmt::format(" {} on {} of it, at h·|ω| = {}.", what, share(n, map.size()), pretty_number(least));
  return fmt::format(" {} on {} of it, between h·|ω| = {} and {}.", what, share(n, map.size()),
                     pretty_number(least), pretty_number(most));
}

/// Borders between neighbours, and beyond the first and the last.
std::vector<double> borders_of(const std::set<double>& values, double (*between)(double, double)) {
  const std::vector<double> v(values.begin(), values.end());
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < v.size(); ++i) out.push_back(between(v[i], v[i + 1]));
  return out;
}

struct Lattice {
  std::vector<double> x, y;                        // borders: one more than there are cells
  std::vector<std::vector<const MapCell*>> cells;  // by shape, then by step; null where there is none
};

Lattice lattice_of(const std::vector<MapCell>& map, std::string_view axis) {
  std::set<double> ratios, sizes;
  for (const MapCell& c : map) ratios.insert(c.ratio), sizes.insert(c.h_w);
  Lattice l;
  l.x = borders_of(ratios, [](double a, double b) { return (a + b) / 2; });
  l.x.insert(l.x.begin(), 0);
  l.x.push_back(2);
  l.y = borders_of(sizes, [](double a, double b) { return std::sqrt(a * b); });
  const double step = l.y.size() > 1 ? std::sqrt(l.y[1] / l.y[0]) : 1.2;
  l.y.insert(l.y.begin(), *sizes.begin() / step);
  l.y.push_back(*sizes.rbegin() * step);
  l.cells.assign(ratios.size(), std::vector<const MapCell*>(sizes.size()));
  const auto place = [](const std::set<double>& s, double v) {
    return static_cast<std::size_t>(std::distance(s.begin(), s.find(v)));
  };
  for (const MapCell& c : map)
    if (c.axis == axis) l.cells[place(ratios, c.ratio)][place(sizes, c.h_w)] = &c;
  return l;
}

/// Rows of a figure's data: rectangles, and lines from one corner to the other.
class Drawing {
 public:
  void add(std::string_view kind, std::string_view axis, double x1, double x2, double y1, double y2,
           std::string_view shade = {}) {
    kinds_.insert({std::string(axis), std::string(kind)});
    data_ += fmt::format("{},{},{:.6g},{:.6g},{:.6g},{:.6g},{}\n", kind, axis, x1, x2, y1, y2, shade);
  }
  bool has(const std::string& axis, const std::string& kind) const { return kinds_.contains({axis, kind}); }
  std::string csv() const { return "kind,axis,x1,x2,y1,y2,shade\n" + data_; }

 private:
  std::set<std::pair<std::string, std::string>> kinds_;
  std::string data_;
};

/// "0.4237"; "" where the solver ended without a number.
std::string shade_text(const MapCell& c) {
  return std::isfinite(c.growth) ? fmt::format("{:.4f}", shade(c.growth)) : "";
}

void draw(Drawing& out, const Lattice& l, std::string_view axis) {
  const auto grows = [&](std::size_t x, std::size_t y) { return l.cells[x][y] && l.cells[x][y]->grows; };
  for (std::size_t x = 0; x < l.cells.size(); ++x) {
    const double x1 = l.x[x], x2 = l.x[x + 1];
    const auto& column = l.cells[x];
    // Cells of one colour above each other are one rectangle: half of a picture's size otherwise.
    for (std::size_t y = 0, top; y < column.size(); y = top) {
      top = y + 1;
      if (!column[y]) continue;
      const std::string colour = shade_text(*column[y]);
      while (top < column.size() && column[top] && shade_text(*column[top]) == colour) ++top;
      out.add(colour.empty() ? "failed" : "cell", axis, x1, x2, l.y[y], l.y[top], colour);
    }
    for (std::size_t y = 0; y < column.size(); ++y) {
      const MapCell* c = column[y];
      if (!c) continue;
      const double y1 = l.y[y], y2 = l.y[y + 1];
      if (c->outcome == "clamped" || c->outcome == "asleep") out.add(c->outcome, axis, x1, x2, y1, y2);
      if (x + 1 < l.cells.size() && grows(x, y) != grows(x + 1, y)) out.add("edge", axis, x2, x2, y1, y2);
      if (y + 1 < column.size() && grows(x, y) != grows(x, y + 1)) out.add("edge", axis, x1, x2, y2, y2);
      if (c->theory > y1 && c->theory <= y2) out.add("theory", axis, x1, x2, c->theory, c->theory);
    }
  }
}

/// The plot of one axis: what its data have rows of, as gnuplot complains about clauses without points.
std::string panel(const Drawing& drawing, const std::string& file, const std::string& axis) {
  const auto of = [&](const char* kind, const std::string& column) {
    return fmt::format("(is('{}','{}')?{}:NaN)", kind, axis, column);
  };
  const char *x1 = "column('x1')", *x2 = "column('x2')", *y1 = "column('y1')", *y2 = "column('y2')";
  const std::string x = fmt::format("({}+{})/2", x1, x2), y = fmt::format("(sqrt({}*{}))", y1, y2);
  const auto box = [&](const char* kind, const char* shade, const char* colour) {
    return fmt::format(
        "{}:{}:({}):({}):({}):({}){} with boxxyerror fillstyle solid 1.0 noborder linecolor {}", of(kind, x),
        y, x1, x2, y1, y2, shade, colour);
  };
  const auto mark = [&](const char* kind, const char* sign) {
    return fmt::format("{}:{} with points pointtype '{}' linecolor rgb '#444444'", of(kind, x), y, sign);
  };
  const auto line = [&](const char* kind, int dash) {
    return fmt::format(
        "{}:({}):({}-{}):({}-{}) with vectors nohead linewidth 1.6 dashtype {} linecolor rgb '#111111'",
        of(kind, x1), y1, x2, x1, y2, y1, dash);
  };
  const std::pair<const char*, std::string> clauses[] = {
      {"cell", box("cell", ":(column('shade'))", "palette")},
      {"failed", box("failed", "", "rgb '#bdbdbd'")},
      {"clamped", mark("clamped", "/")},
      {"asleep", mark("asleep", "\\")},
      {"edge", line("edge", 1)},
      {"theory", line("theory", 3)},
  };
  std::string out;
  for (const auto& [kind, look] : clauses)
    if (drawing.has(axis, kind))
      out += fmt::format("{} using {} notitle", out.empty() ? "plot " + gnuplot_text(file) : ", \\\n      ''",
                         look);
  if (out.empty()) return {};
  return fmt::format("    set title {}\n    {}\n", gnuplot_text(about(axis)), out);
}

Figure map_figure(const std::string& solver, const std::vector<MapCell>& map) {
  Figure f;
  f.kind = "stability-map";
  f.name = "stability-map-" + file_name_of(solver);
  f.title = solver + ": energy gained or lost per step";
  Drawing drawing;
  std::string panels;
  double low = 1, high = 1;
  for (const char* axis : axes) {
    const Lattice l = lattice_of(map, axis);
    low = l.y.front(), high = l.y.back();
    draw(drawing, l, axis);
    panels += panel(drawing, f.name + ".csv", axis);
  }
  f.data = drawing.csv();
  f.script = fmt::format(
      R"(# Run in this folder: gnuplot {0}.gp. Reads {0}.csv.
set encoding utf8
set datafile separator comma
set datafile columnheaders
set datafile missing NaN
is(k, a) = stringcolumn('kind') eq k && stringcolumn('axis') eq a
set border 3 linecolor rgb '#555555' linewidth 0.8
set tics nomirror out scale 0.6,0.3
set xrange [0:2]
set xtics ('rod' 0, 'sphere' 1, 'disc' 2)
set xlabel 'axial / transverse moment' textcolor rgb '#333333'
set logscale y
set yrange [{1:.6g}:{2:.6g}]
set ytics 10
set format y '10^{{%T}}'
set ylabel 'h |ω| / rad' textcolor rgb '#333333'
set palette defined ({3})
set cbrange [-1:1]
set cbtics ('−10 %%' -1, '−10^{{-6}}' -0.604, '0' 0, '10^{{-6}}' 0.604, '10 %%' 1)
do for [mm in '84 174'] {{
  wide = mm eq '174'
  px = 96 / 25.4  # of an SVG
  tall = wide ? 78 : 170  # mm
  do for [form in 'svg pdf'] {{
    if (form eq 'pdf' && strstrt(GPVAL_TERMINALS, 'pdfcairo') == 0) {{ continue }}
    if (form eq 'svg') {{
      set terminal svg size mm*px, tall*px font 'Helvetica,9.3' linewidth 0.75 background rgb '#ffffff'
    }} else {{
      set terminal pdfcairo color size mm/10.0 cm, tall/10.0 cm font 'sans,14' fontscale 0.5 linewidth 0.75
    }}
    set output '{0}-'.mm.'mm.'.form
    set multiplot layout (wide ? 1 : 3), (wide ? 3 : 1) title {4}."\n"\
      .'line: growth begins; dashed: by linear theory; / clamped, \ asleep, grey: failed' noenhanced
{5}    unset multiplot
    unset output
  }}
}}
)",
      f.name, low, high, palette, gnuplot_text(f.title), panels);
  return f;
}

}  // namespace

std::map<std::string, std::vector<MapCell>> stability_maps(const CsvTable& t) {
  std::map<std::string, std::vector<MapCell>> out;
  for (std::size_t i = 0; i < t.rows(); ++i) {
    MapCell c;
    c.axis = t.text(i, "axis");
    c.outcome = t.text(i, "outcome");
    c.ratio = t.number(i, "inertia_ratio");
    c.h_w = t.number(i, "h_w");
    c.growth = t.number(i, "energy_growth_per_step");
    c.theory = t.number(i, "theory_h_w");
    c.grows = t.text(i, "grows") == "1" || c.outcome == "diverged" || c.outcome == "not_finite";
    if (c.ratio >= 0 && c.ratio <= 2 && c.h_w > 0) out[t.text(i, "solver")].push_back(std::move(c));
  }
  return out;
}

std::string map_sentence(const std::vector<MapCell>& map) {
  std::size_t grow = 0, lose = 0, fail = 0;
  const MapCell *first = nullptr, *fastest = nullptr, *slowest = nullptr;
  std::map<std::string, std::pair<std::size_t, std::size_t>> by_axis;  // grow, all
  for (const MapCell& c : map) {
    auto& [grow_here, all_here] = by_axis[c.axis];
    ++all_here;
    if (c.grows) {
      ++grow, ++grow_here;
      if (!first || c.h_w < first->h_w) first = &c;
      if (std::isfinite(c.growth) && (!fastest || c.growth > fastest->growth)) fastest = &c;
    } else if (c.outcome == "clamped" || c.outcome == "asleep") {
      continue;  // held: said apart
    } else if (c.growth < -noticed) {
      ++lose;
      if (!slowest || c.growth < slowest->growth) slowest = &c;
    } else if (!std::isfinite(c.growth)) {
      ++fail;
    }
  }
  std::string text;
  if (!first) {
    text = "Gains energy nowhere on this map.";
  } else {
    text = fmt::format("Gains energy on {} of this map (", share(grow, map.size()));
    const char* comma = "";
    for (const char* axis : axes) {
      const auto& [grow_here, all_here] = by_axis[axis];
      if (all_here > 0)
        text += fmt::format("{}{} {}", std::exchange(comma, ", "), share(grow_here, all_here), about(axis));
    }
    text += fmt::format("), first at h·|ω| = {}", pretty_number(first->h_w));
    if (fastest && fastest->growth > 0)
      text += fmt::format(", by up to {} a step", pretty_number(fastest->growth));
    text += ".";
  }
  if (slowest)
    text += fmt::format(" Loses more than a millionth a step on {} of it, up to {}.", share(lose, map.size()),
                        pretty_number(-slowest->growth));
  text += held_sentence(map, "clamped", "Is clamped") + held_sentence(map, "asleep", "Falls asleep");
  if (fail > 0) text += fmt::format(" Ends without a number on {} of it.", share(fail, map.size()));
  return text;
}

std::vector<Figure> map_figures(const Results& r) {
  constexpr std::size_t most_engines = 4;
  const auto maps = stability_maps(r.stability_map);
  std::map<std::string, std::size_t> drawn;
  std::vector<Figure> out;
  for (const std::string& solver : r.solvers) {
    const auto found = maps.find(solver);
    if (found == maps.end()) continue;
    const std::string family = r.family_of(solver);
    if (drawn[family]++ < (family == "engine" ? most_engines : 1))
      out.push_back(map_figure(solver, found->second));
  }
  return out;
}

}  // namespace polhode::report
