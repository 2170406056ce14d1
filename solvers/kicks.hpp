// The torque of a splitting: a kick at fixed attitude, solved exactly.
//
// A torque here is at most linear in the rates (drag), so that at a fixed attitude and time
//   m' = tau(I^-1 m)  has the solution  m + h phi_1(h D I^-1) tau(I^-1 m),  D = d tau/d w,
// phi_1(z) = (e^z - 1)/z: explicit, symmetric, and two kicks at one attitude make one of the summed length.
// Without drag that is h tau.
#pragma once
#include <vector>

#include "solvers/body_momentum_form.hpp"

namespace polhode {

/// phi_1(A): scaled to a small norm, by Taylor, and doubled back.
[[gnu::noinline]] inline Mat3 phi_1(Mat3 A) {
  int doublings = 0;
  for (; A.cwiseAbs().maxCoeff() > 0.05 && doublings < 40; ++doublings) A *= 0.5;
  Mat3 phi = Mat3::Identity();
  for (int k = 9; k >= 2; --k) phi = Mat3::Identity() + A * phi / k;
  for (; doublings > 0; --doublings) {
    phi = phi + 0.5 * phi * A * phi;  // phi_1(2 A) = phi_1(A) (e^A + 1)/2
    A *= 2;
  }
  return phi;
}

/// Kicks of a few lengths, the same at each step.
class Kicks {
 public:
  /// Prepares kicks of lengths h * fractions[i].
  template <class M>
  void set_up(const M& m, const typename M::State& y, double h, std::span<const double> fractions) {
    if constexpr (M::Rotating::has_load) {
      if (h == h_) return;
      h_ = h;
      TorqueJacobian slope;
      m.rotation.load.add_jacobian(0.0, M::Rotating::attitude_of(y.data()), Vec3::Zero(), slope);
      damped_ = !slope.d_w.isZero(0);
      if (!damped_) return;
      const Mat3 decay = slope.d_w * m.rotation.inverse_moments().asDiagonal();
      factors_.clear();
      for (const double fraction : fractions) factors_.push_back(phi_1(h * fraction * decay));
    }
  }
  /// The kick number i, of the given length.
  template <class M>
  [[gnu::always_inline]] void kick(const M& m, double t, const Quaternion& q, Vec3& momentum, std::size_t i,
                                   double length) const {
    if constexpr (M::Rotating::has_load) {
      const Vec3 tau =
          m.rotation.load.template torque_B<double>(t, q, product(m.rotation.inverse_moments(), momentum));
      if (damped_)
        momentum += length * (factors_[i] * tau);
      else
        momentum += length * tau;
    }
  }

 private:
  double h_ = 0;
  bool damped_ = false;
  std::vector<Mat3> factors_;
};

}  // namespace polhode
