// Between simbody.cpp, which sees Simbody and must be C++17, and simbody_rows.cpp, which sees a scene and is
// C++20.
#pragma once
#include <cstdint>
#include <memory>
#include <string>

#include "solvers/engines/engine_body.hpp"

namespace polhode {

enum class SimbodyIntegrator { rk_merson, cpodes, verlet, semi_explicit_euler2 };

struct SimbodyCounts {
  std::int64_t steps = 0, rejected = 0, realizations = 0;
};

/// One body in a system of its own, with one of Simbody's integrators.
class SimbodyRun {
 public:
  virtual ~SimbodyRun() = default;
  /// Back to the start, for a run to t_end [s].
  virtual void restart(double t_end) = 0;
  /// Goes on to time t [s], or takes `most` steps at most. Returns what went wrong, in Simbody's words, or
  /// "".
  virtual std::string advance(double t, int most) = 0;
  virtual double time() const = 0;        // s
  virtual EngineState state() const = 0;  // at time()
  virtual SimbodyCounts counts() const = 0;
};

/// body      referred to as long as the run lives
/// accuracy  Simbody's: the relative size of the error of a step
/// throws    std::exception if Simbody refuses the body
std::unique_ptr<SimbodyRun> make_simbody(const EngineBody& body, SimbodyIntegrator integrator,
                                         double accuracy);

std::string simbody_version();

}  // namespace polhode
