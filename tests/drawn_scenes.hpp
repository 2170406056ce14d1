// Scenes drawn at random, as the text of scene files: simple numbers as often as any, because generic ones
// hide faults and simple ones find them.
#pragma once
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "models/errors.hpp"

namespace polhode {

class DrawnScenes {
 public:
  explicit DrawnScenes(std::uint64_t seed) : random_(seed) {}

  /// Principal moments, one to three rates, an attitude: all of them numbers that people type.
  std::string simple() {
    std::string text = head() + "inertia = " + list(simple_moments()) + "\n\n[initial]\n";
    text += "orientation = " + list(simple_numbers(4, true)) + "\n";
    const char* forms[] = {"angular_velocity", "angular_velocity", "angular_velocity_space",
                           "angular_momentum"};
    text += std::string(forms[below(4)]) + " = " + list(simple_numbers(3, true)) + "\n";
    return text;
  }

  /// A tensor in axes that are not its own: generic, nearly or exactly symmetric, a needle, particles, parts.
  std::string not_principal() {
    std::string text = head();
    switch (below(6)) {
      case 0:
      case 1:
        text += "inertia = " + list(tensor(any_moments())) + "\n";
        break;
      case 2: {  // equal moments, turned
        const double a = uniform(0.5, 2), b = uniform(0.2, 1.9) * a;
        text += "inertia = " + list(tensor({a, a, b})) + "\n";
        break;
      }
      case 3: {  // exactly equal moments, along (1, 1, 1)
        const double off[] = {0.25, -0.25, 0.5};
        const double o = off[below(3)];
        text += "inertia = " + list({2, 2, 2, o, o, o}) + "\n";
        break;
      }
      case 4: {
        const double thin = std::pow(10, -uniform(2, 8));
        text += "inertia = " + list(tensor({1, 1 - thin * uniform(0, 0.9), thin})) + "\nphysical = false\n";
        break;
      }
      default:
        for (int i = 0; i < 4; ++i)
          text += "[[body.particle]]\nmass = " + number_text(simple_or(0.5, 2)) +
                  "\nposition = " + list({uniform(-1, 1), simple_or(-1, 1), uniform(-1, 1)}) + "\n";
    }
    return text + initial();
  }

  /// One or two loads on a body in any axes.
  std::string loaded() {
    std::string text = head() + "mass = 2\n";
    text += below(2) ? "inertia = " + list(simple_moments()) + "\n"
                     : "inertia = " + list(tensor(any_moments())) + "\n";
    text += below(2) ? initial() : simple_initial();
    const std::size_t first = below(6), count = 1 + below(2);
    for (std::size_t i = 0; i < count; ++i) text += load((first + i * (1 + below(5))) % 6);
    return text;
  }

  std::size_t below(std::size_t n) { return random_() % n; }
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(random_); }

 private:
  static std::string head() { return "duration = 5\n\n[body]\n"; }
  static std::string list(const std::vector<double>& v) {
    std::string text = "[";
    for (const double x : v)
      text += (text.size() > 1 ? ", " : "") + (x == 0 && std::signbit(x) ? "-0.0" : number_text(x));
    return text + "]";
  }
  double simple_number() {
    constexpr double numbers[] = {0, 0, -0.0, 0.5, 1, 2, 3, -1, -2, 0.7, -0.25, 4};
    return numbers[below(std::size(numbers))];
  }
  double simple_or(double a, double b) {
    constexpr double numbers[] = {0.5, 1, 2};
    return below(2) ? numbers[below(3)] : uniform(a, b);
  }
  std::vector<double> simple_numbers(int n, bool not_zero) {
    for (;;) {
      std::vector<double> v;
      bool zero = true;
      for (int i = 0; i < n; ++i) {
        v.push_back(simple_number());
        zero = zero && v.back() == 0;
      }
      if (!zero || !not_zero) return v;
    }
  }
  std::vector<double> simple_moments() {
    constexpr double numbers[] = {0.5, 1, 1.5, 2, 2.5, 3, 4, 5};
    for (;;) {
      const double a = numbers[below(8)], b = numbers[below(8)], c = numbers[below(8)];
      if (a + b >= c && b + c >= a && c + a >= b) return {a, b, c};
    }
  }
  /// Of a body that can be.
  std::vector<double> any_moments() {
    const double x = uniform(0.01, 1), y = uniform(0.01, 1), z = uniform(0.01, 1);
    return {y + z, z + x, x + y};
  }
  /// Those moments in turned axes: xx yy zz xy xz yz.
  std::vector<double> tensor(const std::vector<double>& m) {
    double q[4], n = 0;
    for (double& x : q) {
      x = uniform(-1, 1);
      n += x * x;
    }
    for (double& x : q) x /= std::sqrt(n);
    const double R[3][3] = {{1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]),
                             2 * (q[1] * q[3] + q[0] * q[2])},
                            {2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[1] * q[1] + q[3] * q[3]),
                             2 * (q[2] * q[3] - q[0] * q[1])},
                            {2 * (q[1] * q[3] - q[0] * q[2]), 2 * (q[2] * q[3] + q[0] * q[1]),
                             1 - 2 * (q[1] * q[1] + q[2] * q[2])}};
    const auto entry = [&](int i, int j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += R[i][k] * m[static_cast<std::size_t>(k)] * R[j][k];
      return sum;
    };
    return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
  }
  std::string initial() {
    const char* forms[] = {"angular_velocity", "angular_velocity_space", "angular_momentum"};
    return "\n[initial]\norientation = " +
           list({uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1)}) + "\n" + forms[below(3)] +
           " = " + list({uniform(-2, 2), uniform(-2, 2), uniform(-2, 2)}) + "\n";
  }
  std::string simple_initial() {
    return "\n[initial]\norientation = " + list(simple_numbers(4, true)) +
           "\nangular_velocity = " + list(simple_numbers(3, false)) + "\n";
  }
  std::string load(std::size_t kind) {
    const std::string head = "\n[[load]]\ntype = ";
    switch (kind) {
      case 0:
        return head + "\"gravity_about_pivot\"\nacceleration = " + list({0, 0, -simple_or(1, 9)}) +
               "\ncenter_of_mass = " + list({0, simple_number() / 8, simple_or(0.05, 0.5)}) + "\n";
      case 1:
        return head + "\"angular_drag\"\ncoefficients = " +
               list({simple_or(0.01, 0.5), simple_or(0.01, 0.5), simple_or(0.01, 0.5)}) + "\n";
      case 2:
        return head + "\"attitude_spring\"\nstiffness = " + number_text(simple_or(0.5, 3)) +
               "\ndamping = " + number_text(below(2) ? 0 : uniform(0.01, 1)) + "\n";
      case 3:
      case 4:
        return head + "\"constant_torque\"\ntorque = " + list(simple_numbers(3, true)) +
               "\nframe = " + (kind == 3 ? "\"body\"" : "\"space\"") + "\n";
      default:
        return head + "\"gravity_gradient\"\nmean_motion = " + number_text(simple_or(0.2, 1)) + "\n";
    }
  }

  std::mt19937_64 random_;
};

}  // namespace polhode
