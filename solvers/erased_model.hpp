// A scene's equations with their type no longer seen, for libraries that call back at run time anyway
// (SUNDIALS) and for questions asked once a run. A call costs a nanosecond more than the model's own.
#pragma once
#include <memory>
#include <span>

#include "solvers/method.hpp"

namespace polhode {

class ErasedModel {
 public:
  virtual ~ErasedModel() = default;
  virtual bool has_attitude() const = 0;  // then the state begins with q
  /// [q (4)] [w_B (3)] [p (3) v (3)]
  virtual std::span<const double> initial() const = 0;
  /// d = dy/dt at (t, y). Their lengths are that of initial().
  virtual void rhs(double t, const double* y, double* d) const = 0;
  /// J = d(rhs)/dy, a square matrix by columns.
  virtual void jacobian(double t, const double* y, double* J) const = 0;
  virtual Sample sample(double t, const double* y) const = 0;

  int size() const { return static_cast<int>(initial().size()); }
};

/// The smallest model of the scene.
std::unique_ptr<ErasedModel> erased_model(const Scene& scene);

}  // namespace polhode
