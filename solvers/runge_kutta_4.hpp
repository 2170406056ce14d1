// One step of the classical Runge-Kutta method on a flat state; shared by the quaternion and the matrix form.
#pragma once
#include <array>
#include <cstddef>

namespace polhode {

/// y(t + h) - y(t) from y(t) = y for y' = f(t, y); f(t, const double* y, double* dydt).
template <class F, std::size_t n>
std::array<double, n> runge_kutta_4_increment(const F& f, double t, double h,
                                              const std::array<double, n>& y) {
  std::array<double, n> k1, k2, k3, k4, x;
  f(t, y.data(), k1.data());
  for (std::size_t i = 0; i < n; ++i) x[i] = y[i] + 0.5 * h * k1[i];
  f(t + 0.5 * h, x.data(), k2.data());
  for (std::size_t i = 0; i < n; ++i) x[i] = y[i] + 0.5 * h * k2[i];
  f(t + 0.5 * h, x.data(), k3.data());
  for (std::size_t i = 0; i < n; ++i) x[i] = y[i] + h * k3[i];
  f(t + h, x.data(), k4.data());
  for (std::size_t i = 0; i < n; ++i) x[i] = h / 6 * ((k1[i] + k4[i]) + 2 * (k2[i] + k3[i]));
  return x;
}

/// y(t + h).
template <class F, std::size_t n>
std::array<double, n> runge_kutta_4(const F& f, double t, double h, const std::array<double, n>& y) {
  std::array<double, n> x = runge_kutta_4_increment(f, t, h, y);
  for (std::size_t i = 0; i < n; ++i) x[i] = y[i] + x[i];
  return x;
}

}  // namespace polhode
