// Figures of a result folder for papers, as gnuplot scripts that read the data beside them.
#pragma once
#include <string>
#include <vector>

#include "reports/results.hpp"

namespace polhode::report {

/// One figure before it is drawn.
struct Figure {
  std::string kind;    // work-precision, evaluations, convergence, energy-drift, momentum-drift, stability,
                       // stability-map
  std::string scene;   // id; empty: of no scene
  std::string name;    // stem of figures/NAME.gp, NAME.csv, NAME-84mm.svg, NAME-84mm.pdf, NAME-174mm.svg, ...
  std::string title;   // above the axes
  std::string script;  // run in the folder of the figure; holds relative paths only
  std::string data;    // what it reads
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
