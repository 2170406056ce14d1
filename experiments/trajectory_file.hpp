// A trajectory that another program wrote: CSV with named columns, or TUM ("t x y z qx qy qz qw").
#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "models/attitude.hpp"

namespace polhode {

/// What a file holds, as it stands there: user's body axes, SI units and radians unless flagged. Parts that
/// it lacks are empty.
struct TrajectoryFile {
  std::vector<double> t;                 // s, increasing
  std::vector<std::array<double, 4>> q;  // by the names of the columns: (w, x, y, z), any length
  std::vector<Vec3> w, p, v, L;          // rad/s, m, m/s, kg m^2/s
  std::vector<double> energy;            // J
  bool space_rates = false;              // the header says that w is in the space frame
  bool degrees = false;                  // ... and in degrees; they are converted already
  bool tum = false;
  std::vector<std::string> ignored;  // columns that mean nothing here
};

/// Reads a trajectory of either format, told apart by its first line.
///
/// Columns are found by name, whatever their order and case: t or time; px or x; vx; qw; wx; energy; Lx and
/// so on, with or without a unit at the end (_s, _m, _m_per_s, _rad_per_s, _deg_per_s, _J, _kg_m2_per_s);
/// rates may say their frame (wx_space_rad_per_s). throws   InputError with file, line, column and what is
/// needed
TrajectoryFile read_trajectory(const std::filesystem::path& file);

}  // namespace polhode
