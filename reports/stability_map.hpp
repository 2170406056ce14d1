// Stability maps: what a solver does to the energy of a body that spins freely, over the shape of the body
// and the step, in words and drawn.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "reports/figures.hpp"

namespace polhode::report {

/// One run of stability_map.csv.
struct MapCell {
  std::string axis, outcome;  // the principal axis of `least`, `middle` or `greatest` moment
  double ratio = 0;           // axial over transverse moment: 0 rod, 1 sphere, 2 disc
  double h_w = 0;             // step times |w|, rad
  double growth = 0;          // of the energy per step; NaN where the run failed
  double theory = 0;          // largest h_w without growth by linear theory; NaN: no limit, or no theory
  bool grows = false;         // the energy has a trend upwards, or the run blew up
};

/// The map of each solver, in file order.
std::map<std::string, std::vector<MapCell>> stability_maps(const CsvTable& table);

/// Where the solver gains energy, where it loses it, and where it does neither because it is held.
std::string map_sentence(const std::vector<MapCell>& map);

/// Heat maps for papers, of at most one solver of each family and four engines: the page draws all of them.
std::vector<Figure> map_figures(const Results& results);

}  // namespace polhode::report
