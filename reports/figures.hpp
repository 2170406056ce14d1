// Figures of a result folder, as gnuplot scripts that read the tables beside them.
#pragma once
#include <string>
#include <vector>

#include "reports/results.hpp"

namespace polhode::report {

/// One figure before it is drawn.
struct Figure {
  enum class Kind {
    work,
    evaluations,
    convergence,
    energy_drift,
    momentum_drift,
    stability
  } kind = Kind::work;
  std::string scene;          // id
  std::string name;           // stem of figures/NAME.gp, .svg and .pdf
  std::string title;          // above the axes
  std::string script;         // run from the result folder; holds relative paths only
  int width = 0, height = 0;  // px of the SVG
};

/// Scripts of all figures that the tables have data for, scene by scene.
std::vector<Figure> figures_of(const Results& results);

/// A field as gnuplot compares it.
///
/// Single-quoted with quotes doubled and control characters dropped; cut at the first comma or double quote,
/// because stringcolumn() of gnuplot 5.4 ends a quoted field there.
std::string gnuplot_field(std::string_view text);

/// Any text as a single-quoted gnuplot string.
std::string gnuplot_text(std::string_view text);

}  // namespace polhode::report
