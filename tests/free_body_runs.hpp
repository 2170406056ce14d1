// Runs of the free body of Hairer & Vilmart, whose state at t = 10 is known to 18 digits.
#pragma once
#include <algorithm>

#include <gtest/gtest.h>

#include "models/attitude.hpp"
#include "solvers/registry.hpp"

namespace polhode {

/// Free body of Hairer & Vilmart: principal moments (.6, .8, 1), momentum (1.8, .4, -.9) in the body frame at
/// the start.
inline Scene hairer_vilmart() {
  Scene scene;
  scene.duration = 10;
  RotationData rotation;
  rotation.moments = Vec3(0.6, 0.8, 1);
  rotation.w0 = Vec3(1.8 / 0.6, 0.4 / 0.8, -0.9);
  scene.rotation = rotation;
  return scene;
}

/// Samples at equal distances, with so many fixed steps between two of them.
inline Grid equal_grid(double duration, int samples, std::int64_t steps_between = 1) {
  Grid grid;
  grid.from_start = true;
  for (int i = 1; i <= samples; ++i)
    grid.stretches.push_back(
        {duration * i / samples, steps_between, duration / samples / static_cast<double>(steps_between)});
  return grid;
}

inline Setting tolerance(double rtol) {
  Setting setting;
  setting.knob = Knob::tolerance;
  setting.rtol = rtol;
  return setting;
}

inline Trajectory run(const Method& method, const Scene& scene, const Setting& setting, const Grid& grid) {
  const Prepared prepared = method.prepare(scene, setting);
  EXPECT_TRUE(prepared.integrate) << method.id << ": " << prepared.unsupported;
  Trajectory trajectory;
  if (prepared.integrate) prepared.integrate(grid, trajectory);
  return trajectory;
}

/// Distance of a sample from the state of the Hairer-Vilmart body at t = 10 that is known to 18 digits
/// (40-digit Taylor series; momentum in the body frame).
inline double error_at_10(const Sample& s) {
  const Quaternion q(-0.73606136416079394, -0.57078695124035073, -0.29938857183079009, -0.20683908610467319);
  const Vec3 m(1.76596250851820754, -0.69546419703308912, 0.77955498148187109);
  return std::max(attitude_error(q, s.q), (Vec3(0.6, 0.8, 1).cwiseProduct(s.w_B) - m).norm() / m.norm());
}

}  // namespace polhode
