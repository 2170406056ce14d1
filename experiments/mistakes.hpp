// What people get wrong when they write a trajectory down, recognised by undoing it.
#pragma once
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/trajectory_file.hpp"
#include "experiments/truth.hpp"

namespace polhode {

/// How the numbers of a file are to be understood.
struct Reading {
  bool scalar_last = false;  // the numbers under qw, qx, qy, qz are x, y, z, w
  bool inverse = false;      // the attitude is space to body
  bool space_rates = false;  // w is in the space frame
  bool degrees = false;      // w is in degrees per second
  int late = 0;              // row i holds the state of time i - late
};

/// The rows [0, n) of a file as samples in the principal frame. Parts that the file lacks keep their
/// defaults; energies and momentum follow from the state where that is there, else they are the file's own.
std::vector<Sample> samples_of(const Scene& scene, const TrajectoryFile& file, const Reading& reading);

/// One mistake: undoing it makes the error of `quantity` fall from `before` to `after` (medians over the
/// rows).
struct Mistake {
  std::string_view id, what, quantity;
  double before, after;
};

/// The mistakes without which the file lies ten times nearer to the truth, for each alone; usually none.
///
/// truth  at the times of the file, [first, ...)
std::vector<Mistake> likely_mistakes(const Scene& scene, const TrajectoryFile& file, const Reading& reading,
                                     std::span<const WideSample> truth);

}  // namespace polhode
