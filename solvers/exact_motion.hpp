// How a truth is found: what the closed forms, the series and the implicit method have in common.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "models/exact_scene.hpp"
#include "solvers/reference.hpp"

namespace polhode {

/// A motion that is known at any time up to its end.
class ExactMotion {
 public:
  struct Uncertainty {
    double attitude = 0, rate = 0;  // rad, relative
  };

  virtual ~ExactMotion() = default;
  /// The states at times (increasing).
  virtual std::vector<WideSample> at(std::span<const Wide> times, const Allowance& allowance) const = 0;
  /// Of samples that `at` has given: the largest up to their end.
  virtual Uncertainty uncertainty(std::span<const WideSample> samples, const Allowance& allowance) const = 0;
  virtual std::string kind() const = 0;
  virtual std::int64_t steps() const { return 0; }
  /// As Motion's; "" where there is nothing to keep.
  virtual std::string saved() const { return ""; }
};

/// The closed form of the scene; null if it has none.
std::unique_ptr<ExactMotion> closed_motion(const Scene& scene);

/// By Taylor series. Throws Refused if the steps are too many.
std::unique_ptr<ExactMotion> series_motion(const ExactScene& exact, double until, const Allowance& allowance);
std::unique_ptr<ExactMotion> restored_series(const ExactScene& exact, std::string_view bytes);

/// By Radau IIA. Throws Error with exit code 70 if it finds no step size.
std::unique_ptr<ExactMotion> implicit_motion(const Scene& scene, double until, const Allowance& allowance);
std::unique_ptr<ExactMotion> restored_implicit(const Scene& scene, std::string_view bytes);

}  // namespace polhode
