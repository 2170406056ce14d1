// Boost.Odeint's implicit steppers, which want ublas vectors and a Jacobian, behind an interface of neither.
//
// The ublas of Boost 1.74 does not compile as C++20 (std::allocator has lost what it asks for): its file is
// compiled as C++17, and this header is all that both sides include.
#pragma once
#include <cstddef>
#include <memory>

namespace polhode {

/// Equations y' = f(t, y) of a size known at run time.
class ImplicitEquations {
 public:
  virtual ~ImplicitEquations() = default;
  virtual std::size_t size() const = 0;
  virtual void rhs(double t, const double* y, double* d) = 0;
  virtual void jacobian(double t, const double* y, double* J) = 0;  // by rows
  virtual void time_derivative(double t, const double* y, double* d) = 0;
};

/// A stepper of the library. It keeps a reference to its equations.
class ImplicitStepper {
 public:
  virtual ~ImplicitStepper() = default;
  /// One step of size h from (t, y); returns why there is none, or nullptr.
  virtual const char* step(double* y, double t, double h) = 0;
  /// A trial step of the library's controller, which moves t and sets h. False: rejected.
  virtual bool try_step(double* y, double& t, double& h) = 0;
  /// Forgets the trial steps so far.
  virtual void restart() = 0;
};

/// corrected    with the right sign of d4: solvers/odeint_rosenbrock4.cpp
/// atol, rtol   tolerances of the controller; for steps of fixed size any
std::unique_ptr<ImplicitStepper> odeint_rosenbrock4_stepper(ImplicitEquations& equations, bool corrected,
                                                            double atol, double rtol);
/// At fixed step alone.
std::unique_ptr<ImplicitStepper> odeint_implicit_euler_stepper(ImplicitEquations& equations);

}  // namespace polhode
