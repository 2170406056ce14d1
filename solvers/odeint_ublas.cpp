// See the header: compiled as C++17.

// The library's own checks throw on numbers that are not finite, where a run is to end as an outcome.
#ifndef BOOST_UBLAS_NDEBUG
#define BOOST_UBLAS_NDEBUG 1
#endif
#include "solvers/odeint_ublas.hpp"

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
// after the stepper, whose includes it forgets
#include <boost/numeric/odeint/stepper/implicit_euler.hpp>
#include <boost/numeric/odeint/stepper/rosenbrock4_controller.hpp>
#include <boost/numeric/ublas/lu.hpp>
#include <boost/numeric/ublas/matrix.hpp>
#include <boost/numeric/ublas/vector.hpp>

namespace polhode {
namespace {

namespace odeint = boost::numeric::odeint;
namespace ublas = boost::numeric::ublas;
using Vector = ublas::vector<double>;
using Matrix = ublas::matrix<double>;  // by rows

struct Rhs {
  ImplicitEquations* equations;
  void operator()(const Vector& y, Vector& d, double t) const { equations->rhs(t, &y[0], &d[0]); }
};
struct Jacobian {
  ImplicitEquations* equations;
  void operator()(const Vector& y, Matrix& J, double t, Vector& d_t) const {
    equations->jacobian(t, &y[0], &J(0, 0));
    equations->time_derivative(t, &y[0], &d_t[0]);
  }
};

using LibraryCoefficients = odeint::default_rosenbrock_coefficients<double>;
struct Corrected : LibraryCoefficients {
  static constexpr double d4 = -0.3620000000000023e-01;  // hides the one of the library
};

template <class Coefficients>
class Rosenbrock4 final : public ImplicitStepper {
 public:
  Rosenbrock4(ImplicitEquations& equations, double atol, double rtol)
      : system_(Rhs{&equations}, Jacobian{&equations}), atol_(atol), rtol_(rtol), y_(equations.size()) {
    Rosenbrock4::restart();
  }
  const char* step(double* y, double t, double h) override {
    std::copy(y, y + y_.size(), y_.begin());
    controller_->stepper().do_step(system_, y_, t, h);
    std::copy(y_.begin(), y_.end(), y);
    return nullptr;
  }
  bool try_step(double* y, double& t, double& h) override {
    std::copy(y, y + y_.size(), y_.begin());
    const bool good = controller_->try_step(system_, y_, t, h) == odeint::success;
    if (good) std::copy(y_.begin(), y_.end(), y);
    return good;
  }
  // The controller has no reset of its own, and its step before is that of another run.
  void restart() override { controller_.emplace(atol_, rtol_); }

 private:
  std::pair<Rhs, Jacobian> system_;
  double atol_, rtol_;
  Vector y_;
  std::optional<odeint::rosenbrock4_controller<odeint::rosenbrock4<double, Coefficients>>> controller_;
};

/// Ends the library's iteration from inside: it has no other door.
struct GivenUp {
  const char* why;
};

class ImplicitEuler final : public ImplicitStepper {
 public:
  explicit ImplicitEuler(ImplicitEquations& equations)
      : equations_(equations), y_(equations.size()), shadow_(y_.size(), y_.size()), pivots_(y_.size()) {}

  const char* step(double* y, double t, double h) override {
    std::copy(y, y + y_.size(), y_.begin());
    calls_ = 0;
    h_ = h;
    try {
      stepper_.do_step(std::pair(RhsInLimits{this}, ShadowedJacobian{this}), y_, t, h);
    } catch (const GivenUp& given_up) {
      return given_up.why;
    }
    std::copy(y_.begin(), y_.end(), y);
    return nullptr;
  }
  bool try_step(double*, double&, double&) override { std::abort(); }  // has no controller
  void restart() override {}

 private:
  struct RhsInLimits {
    ImplicitEuler* run;
    void operator()(const Vector& y, Vector& d, double t) const { run->rhs(y, d, t); }
  };
  struct ShadowedJacobian {
    ImplicitEuler* run;
    void operator()(const Vector& y, Matrix& J, double t) const { run->jacobian(y, J, t); }
  };

  void rhs(const Vector& y, Vector& d, double t) {
    if (++calls_ > 200) throw GivenUp{"the library's Newton iteration does not settle"};
    equations_.rhs(t, &y[0], &d[0]);
    if (calls_ > 1) factorise();  // as the library is about to do
  }
  void jacobian(const Vector& y, Matrix& J, double t) {
    equations_.jacobian(t, &y[0], &J(0, 0));
    shadow_ = h_ * J - ublas::identity_matrix<double>(y.size());
    for (std::size_t i = 0; i < pivots_.size(); ++i) pivots_(i) = i;
    factorise();
  }
  void factorise() {
    if (ublas::lu_factorize(shadow_, pivots_) != 0)
      throw GivenUp{"the matrix of the library's Newton iteration is singular"};
  }

  ImplicitEquations& equations_;
  Vector y_;
  odeint::implicit_euler<double> stepper_;
  Matrix shadow_;
  ublas::permutation_matrix<std::size_t> pivots_;
  double h_ = 0;
  int calls_ = 0;
};

}  // namespace

std::unique_ptr<ImplicitStepper> odeint_rosenbrock4_stepper(ImplicitEquations& equations, bool corrected,
                                                            double atol, double rtol) {
  if (corrected) return std::make_unique<Rosenbrock4<Corrected>>(equations, atol, rtol);
  return std::make_unique<Rosenbrock4<LibraryCoefficients>>(equations, atol, rtol);
}
std::unique_ptr<ImplicitStepper> odeint_implicit_euler_stepper(ImplicitEquations& equations) {
  return std::make_unique<ImplicitEuler>(equations);
}

}  // namespace polhode
