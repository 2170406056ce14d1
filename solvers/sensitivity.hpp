// How small disturbances of a scene's motion change from mark to mark.
//
//   theta' = -w x theta + delta,   delta' = A delta + B theta,   A = d(w')/dw,  B = d(w')/d(theta)
//
// along the motion itself. Marks lie half a radian apart, in the time scale of the motion where they are: a
// lattice that depends on the scene alone, not on the times that somebody asks for.
#pragma once
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "models/attitude.hpp"
#include "models/scene.hpp"
#include "solvers/erased_model.hpp"
#include "solvers/radau_table.hpp"

namespace polhode {

/// Of a disturbance: a small rotation in body axes [rad] and a change of the rates [rad/s]. The former stays
/// zero in scenes without attitude.
using DisturbanceMap = Eigen::Matrix<double, 6, 6>;

/// The motion from one mark to the next.
struct Stretch {
  static constexpr int stages = 7;
  double begin = 0, end = 0;                    // s
  std::array<double, stages + 1> times{};       // from begin to end
  std::array<DisturbanceMap, stages + 1> maps;  // from begin to these; the first is the identity
  std::array<Vec3, stages + 1> rates;

  const DisturbanceMap& across() const { return maps.back(); }
  /// Between begin and end, by interpolation to nine digits.
  DisturbanceMap map_to(double t) const;
  Vec3 rates_at(double t) const;
};

/// Goes along the motion of a scene that has a rotation.
///
/// The motion comes from the closed form of the scene, else from Taylor series in 64 bits of arithmetic, from
/// Radau IIA in the same where it is stiff. The linear equations above are solved beside it by Radau IIA of
/// 7 stages, to the rounding of a double: what is lost on the way grows like any disturbance. Decays are
/// damped, however fast. Where the torque of a spring jumps, half a turn away, the jump itself is left out.
class Sensitivity {
 public:
  explicit Sensitivity(const Scene& scene);

  /// From where it stands to the next mark, or to `latest` if that comes first. Nothing: the motion cannot
  /// be followed.
  std::optional<Stretch> next(double latest);

  /// States (of the model in double precision, one a column) at increasing times.
  using Path = std::function<bool(std::span<const double> times, Eigen::MatrixXd& states)>;

 private:
  void solve(Stretch& stretch, const Eigen::MatrixXd& states) const;

  std::unique_ptr<ErasedModel> model_;
  Path path_;
  RadauTable<double> table_;
  double t_ = 0, h_ = 0;  // where it stands, and its last step
  Eigen::VectorXd y_;
};

/// Attitude and rates of the motion that starts from the doubles of the scene, at increasing times, right to
/// about the rounding of a double. Nothing: it cannot be followed.
struct Turning {
  Quaternion q{1, 0, 0, 0};
  Vec3 w_B = Vec3::Zero();
};
std::optional<std::vector<Turning>> motion_of_doubles(const Scene& scene, std::span<const double> times);

}  // namespace polhode
