// Eigenvalues and stability functions.
#include "experiments/linear_theory.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "experiments/energy_growth.hpp"
#include "solvers/erased_model.hpp"
#include "solvers/stability_function.hpp"

namespace polhode {

Quaternion rest_attitude(const Scene& scene) { return normalised(scene.rotation->principal_to_user); }

Linearised linearised(const Scene& scene) {
  const auto model = erased_model(scene);
  std::vector<double> y(model->initial().begin(), model->initial().end());
  Linearised result;
  const auto& loads = scene.rotation->loads;
  result.at_rest = !loads.empty() && std::ranges::none_of(loads, [](const AnyTorque<double>& load) {
    return std::holds_alternative<GravityAboutPivot<double>>(load);
  });
  const int w_at = model->has_attitude() ? 4 : 0;
  if (result.at_rest) {
    std::fill_n(y.begin(), w_at + 3, 0.0);
    if (model->has_attitude()) {
      const Quaternion q = rest_attitude(scene);
      const double components[] = {q.w(), q.x(), q.y(), q.z()};
      std::ranges::copy(components, y.begin());
    }
  }
  Eigen::MatrixXd J(model->size(), model->size());
  model->jacobian(0.0, y.data(), J.data());
  // Of the rotation alone: free fall has nothing that grows.
  const int n = w_at + 3;
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(J.topLeftCorner(n, n));
  int fast = 0;
  for (int i = 0; i < n; ++i) {
    const std::complex<double> lambda = solver.eigenvalues()[i];
    result.eigenvalues.push_back(lambda);
    if (std::abs(lambda) > result.fastest) {
      result.fastest = std::abs(lambda);
      fast = i;
    }
  }
  const Eigen::Vector3cd rates = solver.eigenvectors().col(fast).tail<3>();
  const Vec3 real = rates.real(), imaginary = rates.imag();
  const Vec3& larger = real.norm() >= imaginary.norm() ? real : imaginary;
  if (larger.norm() > 0) result.fast_axis = larger.normalized();
  if (result.at_rest && result.fastest > 0 && solver.eigenvalues()[fast].imag() == 0) {
    const Eigen::VectorXd mode = solver.eigenvectors().col(fast).real();
    const double length = mode.tail<3>().norm();
    if (length > 0) {
      result.fast_rates = mode.tail<3>() / length;
      if (w_at > 0) {
        const Quaternion d(mode[0], mode[1], mode[2], mode[3]), q = rest_attitude(scene);
        result.fast_turn = (q.conjugate() * d).vec() / length;
      }
    }
  }
  return result;
}

std::optional<double> theoretical_limit(const Method& method, const Linearised& scene, double low,
                                        double high) {
  const auto stable = [&](double h) {
    return std::ranges::all_of(scene.eigenvalues, [&](const std::complex<double>& lambda) {
      if (std::abs(lambda) < 0.1 * scene.fastest) return true;
      return std::norm(amplification(method, h * lambda)) <= 1 + growth_resolution;
    });
  };
  if (!stable(low)) return low;
  double inside = low;
  while (inside < high) {
    double h = std::min(high, inside * 1.01);
    if (stable(h)) {
      inside = h;
      continue;
    }
    for (int i = 0; i < 40; ++i) {
      const double middle = std::sqrt(inside * h);
      (stable(middle) ? inside : h) = middle;
    }
    return inside;
  }
  return std::nullopt;
}

}  // namespace polhode
