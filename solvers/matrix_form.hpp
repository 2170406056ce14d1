// The lecture notes' state: rotation matrix R_SB and angular velocity in space components, [R (9, by
// columns)][w_S], then [p v]. Its right-hand side is the Newton-Euler equation as it stands there.
#pragma once
#include "models/newton_euler.hpp"
#include "solvers/fixed_step.hpp"

namespace polhode {

struct MatrixForm {
  static constexpr std::string_view needs = "needs an attitude: its state is a rotation matrix";

  template <class M>
  using State = std::array<double, 12 + static_cast<std::size_t>(M::Translating::size)>;

  static Mat3 matrix_of(const double* y) { return Eigen::Map<const Mat3>(y); }
  static Vec3 w_of(const double* y) { return Vec3(y[9], y[10], y[11]); }

  [[gnu::noinline]] static void put_rotation(double* y, const Quaternion& q, const Vec3& w_B) {
    const Mat3 R = rotation_matrix<double>(q);
    Eigen::Map<Mat3>{y} = R;
    Eigen::Map<Vec3>{y + 9} = R * w_B;
  }
  template <WithAttitude M>
  static State<M> start(const M& m) {
    State<M> y;
    put_rotation(y.data(), m.rotation.attitude_of(m.initial.data()), m.rotation.w_of(m.initial.data()));
    for (std::size_t i = 12; i < y.size(); ++i) y[i] = m.initial[i - 12 + M::rotation_size];
    return y;
  }

  /// R' = [w]x R,  w' = I^-1(tau - w x I w) with I = R I_B R^T and the true inverse of that matrix, or with
  /// R I_B^-1 R^T for it, which is its inverse as long as R is a rotation.
  template <WithAttitude M>
  static void rhs(const M& m, double t, const double* y, double* d, bool turned_inverse = false) {
    const Mat3 R = matrix_of(y);
    const Vec3 w = w_of(y);
    for (int c = 0; c < 3; ++c) Eigen::Map<Vec3>(d + 3 * c) = w.cross(R.col(c));
    const Mat3 I = inertia_S(R, m.rotation.moments());
    Vec3 tau = Vec3::Zero();
    if constexpr (M::Rotating::has_load) tau = m.rotation.load.torque_S(t, R, w);
    if (turned_inverse) {
      const Vec3 torque = R.transpose() * (tau - w.cross(I * w));
      Eigen::Map<Vec3>(d + 9) = R * m.rotation.inverse_moments().cwiseProduct(torque);
    } else if (m.rotation.has_gyroscopic_term())
      Eigen::Map<Vec3>(d + 9) = angular_acceleration_S(I, w, tau);
    else if constexpr (M::Rotating::has_load)
      Eigen::Map<Vec3>(d + 9) = I.inverse() * tau;
    else
      Eigen::Map<Vec3>(d + 9).setZero();
    m.translation.rhs(t, y + 12, d + 12);
  }

  /// Momentum and energy are those of the matrix as it is; only the attitude is read off its nearest
  /// rotation. (Out of line and no template: what needs no model is compiled once.)
  [[gnu::noinline]] static Sample sample_of_rotation(const Mat3& R, const Vec3& w, const Vec3& moments) {
    Sample s;
    s.q = quaternion_of(nearest_rotation(R));
    s.w_B = R.transpose() * w;
    s.L = angular_momentum_S(inertia_S(R, moments), w);
    s.rotational_energy = 0.5 * w.dot(s.L);
    s.unit_defect = (R.transpose() * R - Mat3::Identity()).norm();
    return s;
  }
  template <WithAttitude M>
  [[gnu::noinline]] static Sample sample(const M& m, double t, const State<M>& y) {
    Sample s = sample_of_rotation(matrix_of(y.data()), w_of(y.data()), m.rotation.moments());
    s.t = t;
    typename M::State flat{};
    flat[0] = s.q.w();
    flat[1] = s.q.x();
    flat[2] = s.q.y();
    flat[3] = s.q.z();
    for (std::size_t i = 12; i < y.size(); ++i) flat[i - 12 + M::rotation_size] = y[i];
    if constexpr (M::has_translation) {
      s.p = m.position(flat.data());
      s.v = m.velocity(flat.data());
    }
    s.total_energy = s.rotational_energy + m.other_energy(t, flat.data());
    return s;
  }

  /// Back to SO(3) by Gram-Schmidt on the columns: the first keeps its direction, the second its plane, and
  /// the third is their cross product. Cheap and usual; the polar factor would be the nearest rotation
  /// instead.
  template <class State>
  static void orthonormalise(State& y) {
    Mat3 R = matrix_of(y.data());
    R.col(0) /= R.col(0).norm();
    R.col(1) -= R.col(0).dot(R.col(1)) * R.col(0);
    R.col(1) /= R.col(1).norm();
    R.col(2) = R.col(0).cross(R.col(1));
    Eigen::Map<Mat3>(y.data()) = R;
  }
};

}  // namespace polhode
