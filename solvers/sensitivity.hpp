// How small disturbances of a scene's motion grow from one time to the next.
#pragma once
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/scene.hpp"

namespace polhode {

/// Linear maps of disturbances from each time to every later one.
struct Sensitivity {
  int attitude = 0;  // rows and columns of the attitude: 3 or 0; those of the rates follow
  std::vector<std::vector<Eigen::MatrixXd>> maps;  // [i][k]: from time i to time i + 1 + k
  std::vector<double> rates;  // |w| at the times, rad/s: what disturbances of the rates are relative to
  bool known = true;          // false: too long or too stiff to follow
};

/// Disturbance: a small rotation in body axes [rad], and a change of the rates over |w| (at least a
/// thousandth of the largest |w|). The scene must have a rotation; times increase and begin with 0. From
/// motions beside each other that start at a distance of 1e-12: those of a free body by its closed form,
/// others by runs in 64-bit arithmetic, good for a growth of 1e10. (The maps from one time to the next would
/// do by their products, if products of growth and decay did not cancel.)
Sensitivity sensitivity(const Scene& scene, std::span<const double> times);

}  // namespace polhode
