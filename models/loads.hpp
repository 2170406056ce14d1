// The loads of a rotating body, one type each, and `Free`, the load that costs nothing.
//
// Each load knows its torque in both forms of the equations (body components with a quaternion, and space
// components with the rotation matrix of the lecture notes), its potential energy where it has one, the rate
// at which it changes the total energy, and the derivatives that a Jacobian needs. The number type S is that
// of the constants; torque_B takes any T that computes like S (the truth records it as a Taylor series).
//
// All components are of the principal frame of the body ("_B") or the space frame ("_S").
#pragma once
#include <optional>
#include <variant>
#include <vector>

#include "models/attitude.hpp"

namespace polhode {

/// Derivatives of a torque in body components with respect to the state of rotation.
struct TorqueJacobian {
  Eigen::Matrix<double, 3, 4> d_q = Eigen::Matrix<double, 3, 4>::Zero();  // per component (w, x, y, z) of q
  Mat3 d_w = Mat3::Zero();
};

/// No torque: the free body. Every term below is a compile-time zero.
template <class S>
struct Free {
  static constexpr bool present = false, needs_attitude = false;
  template <class T, class A>
  Vec3T<T> torque_B(const T&, const A&, const Vec3T<T>&) const {
    return Vec3T<T>(T(0), T(0), T(0));
  }
  Vec3 torque_S(double, const Mat3&, const Vec3&) const { return Vec3::Zero(); }
  template <class A>
  S potential_energy(const S&, const A&) const {
    return S(0);
  }
  template <class A>
  S energy_rate(const S&, const A&, const Vec3T<S>&) const {
    return S(0);
  }
  template <class A>
  void add_jacobian(double, const A&, const Vec3&, TorqueJacobian&) const {}
};

/// Weight of a body held at the space origin: tau = r x F with F = m g; conservative, V = -m g . (R r).
template <class S>
struct GravityAboutPivot {
  static constexpr const char* type = "gravity_about_pivot";
  static constexpr bool present = true, needs_attitude = true;
  S mass;                   // kg
  Vec3T<S> acceleration_S;  // m/s^2
  Vec3T<S> center_B;        // m, from the pivot to the centre of mass

  template <class T>
  Vec3T<T> torque_B(const T&, const QuaternionT<T>& q, const Vec3T<T>&) const {
    const Vec3T<S> arm = mass * center_B;
    return arm.template cast<T>().cross(to_body<T>(q, acceleration_S.template cast<T>()));
  }
  Vec3 torque_S(double, const Mat3& R, const Vec3&) const requires std::is_same_v<S, double> {
    return (R * center_B).cross(mass * acceleration_S);
  }
  S potential_energy(const S&, const QuaternionT<S>& q) const {
    return -mass * acceleration_S.dot(to_space<S>(q, center_B));
  }
  S energy_rate(const S&, const QuaternionT<S>&, const Vec3T<S>&) const { return S(0); }
  void add_jacobian(double, const Quaternion& q, const Vec3&,
                    TorqueJacobian& J) const requires std::is_same_v<S, double> {
    const Vec3 g_B = to_body<double>(q, acceleration_S);
    J.d_q += hat<double>(mass * center_B) * to_body_derivative(q, g_B);
  }
};

/// Viscous drag on the rotation: tau_B = -C w_B with a positive semidefinite matrix C (N m s); dissipates w .
/// C w.
template <class S>
struct AngularDrag {
  static constexpr const char* type = "angular_drag";
  static constexpr bool present = true, needs_attitude = false;
  Mat3T<S> coefficients_B;  // diagonal unless the body was given in axes that are not principal

  template <class T, class A>
  Vec3T<T> torque_B(const T&, const A&, const Vec3T<T>& w) const {
    const auto& c = coefficients_B;
    return Vec3T<T>(-(T(c(0, 0)) * w.x() + T(c(0, 1)) * w.y() + T(c(0, 2)) * w.z()),
                    -(T(c(1, 0)) * w.x() + T(c(1, 1)) * w.y() + T(c(1, 2)) * w.z()),
                    -(T(c(2, 0)) * w.x() + T(c(2, 1)) * w.y() + T(c(2, 2)) * w.z()));
  }
  Vec3 torque_S(double, const Mat3& R, const Vec3& w_S) const requires std::is_same_v<S, double> {
    return -(R * (coefficients_B * (R.transpose() * w_S)));
  }
  template <class A>
  S potential_energy(const S&, const A&) const {
    return S(0);
  }
  template <class A>
  S energy_rate(const S&, const A&, const Vec3T<S>& w) const {
    return -w.dot(coefficients_B * w);
  }
  template <class A>
  void add_jacobian(double, const A&, const Vec3&,
                    TorqueJacobian& J) const requires std::is_same_v<S, double> {
    J.d_w -= coefficients_B;
  }
};

/// Proportional-derivative attitude control to the identity of the space frame:
/// tau_B = -2 k sign(q_w) vec(q)/|q| - c w_B. Potential 4 k (1 - |q_w|/|q|), damping dissipates c |w|^2.
/// The torque jumps where q_w = 0, a turn by pi: the shorter way back changes side.
template <class S>
struct AttitudeSpring {
  static constexpr const char* type = "attitude_spring";
  static constexpr bool present = true, needs_attitude = true;
  S stiffness;  // k, N m
  S damping;    // c, N m s
  QuaternionT<S> principal_to_user{
      1, 0, 0, 0};  // frame of the user's body axes in principal axes: the spring turns those

  template <class T>
  Vec3T<T> torque_B(const T&, const QuaternionT<T>& q_SB, const Vec3T<T>& w) const {
    using std::sqrt;
    // vec(q) of the user's body axes, in principal components: rotating both sides of a product by the same
    // constant rotation turns its vector part, so vec(q_SU) in user axes equals vec(q_SB principal_to_user)
    // below.
    const QuaternionT<T> q = user_attitude(q_SB);
    const T k = sign_of(q.w()) * T(2 * stiffness) / T(sqrt(squared_norm(q)));
    const Vec3T<T> u = to_principal<T>(Vec3T<T>(q.x(), q.y(), q.z()));
    return Vec3T<T>(-(k * u.x()) - T(damping) * w.x(), -(k * u.y()) - T(damping) * w.y(),
                    -(k * u.z()) - T(damping) * w.z());
  }
  Vec3 torque_S(double t, const Mat3& R, const Vec3& w_S) const requires std::is_same_v<S, double> {
    const Vec3 w_B = R.transpose() * w_S;
    return R * torque_B<double>(t, quaternion_of(R), w_B);
  }
  S potential_energy(const S&, const QuaternionT<S>& q_SB) const {
    using std::abs;
    using std::sqrt;
    const QuaternionT<S> q = user_attitude(q_SB);
    return S(4) * stiffness * (S(1) - S(abs(q.w())) / S(sqrt(squared_norm(q))));
  }
  S energy_rate(const S&, const QuaternionT<S>&, const Vec3T<S>& w) const {
    return -damping * w.squaredNorm();
  }
  void add_jacobian(double, const Quaternion& q_SB, const Vec3&,
                    TorqueJacobian& J) const requires std::is_same_v<S, double> {
    const Quaternion q = user_attitude(q_SB);
    const double n = std::sqrt(squared_norm(q));
    const Eigen::Vector4d c(q.w(), q.x(), q.y(), q.z());
    Eigen::Matrix<double, 3, 4> d;  // of vec(q)/|q|
    d << Vec3::Zero(), Mat3::Identity();
    d = d / n - q.vec() * c.transpose() / (n * n * n);
    Eigen::Matrix4d right;  // dq_SB -> dq = dq_SB target^-1
    for (int i = 0; i < 4; ++i) {
      const Quaternion e(i == 0, i == 1, i == 2, i == 3);
      const Quaternion r = e * principal_to_user.conjugate();
      right.col(i) << r.w(), r.x(), r.y(), r.z();
    }
    const Mat3 turn = rotation_matrix<double>(principal_to_user);
    J.d_q -= 2 * stiffness * sign_of(q.w()) * turn.transpose() * d * right;
    J.d_w -= damping * Mat3::Identity();
  }

 private:
  // q_SU = q_SB q_BU with q_BU = principal_to_user^-1 (principal_to_user turns principal into user
  // components)
  template <class T>
  QuaternionT<T> user_attitude(const QuaternionT<T>& q_SB) const {
    return q_SB * principal_to_user.conjugate().template cast<T>();
  }
  template <class T>
  Vec3T<T> to_principal(const Vec3T<T>& u_user) const {
    return to_body<T>(principal_to_user.template cast<T>(), u_user);
  }
};

enum class Frame { body, space };

/// A torque that is constant in the body or in the space frame. Neither has a potential on SO(3).
template <class S, Frame F>
struct ConstantTorque {
  static constexpr const char* type = "constant_torque";
  static constexpr bool present = true, needs_attitude = F == Frame::space;
  Vec3T<S> torque;  // N m, in the frame F

  template <class T, class A>
  Vec3T<T> torque_B(const T&, const A& q, const Vec3T<T>&) const {
    if constexpr (F == Frame::body)
      return torque.template cast<T>();
    else
      return to_body<T>(q, torque.template cast<T>());
  }
  Vec3 torque_S(double, const Mat3& R, const Vec3&) const requires std::is_same_v<S, double> {
    if constexpr (F == Frame::body)
      return R * torque;
    else
      return torque;
  }
  template <class A>
  S potential_energy(const S&, const A&) const {
    return S(0);
  }
  template <class A>
  S energy_rate(const S& t, const A& q, const Vec3T<S>& w) const {
    return w.dot(torque_B<S>(t, q, w));
  }
  template <class A>
  void add_jacobian(double, const A& q, const Vec3&,
                    TorqueJacobian& J) const requires std::is_same_v<S, double> {
    if constexpr (F == Frame::space) J.d_q += to_body_derivative(q, to_body<double>(q, torque));
  }
};

/// Torque of the gravity gradient on a circular orbit in the x-y plane of space:
/// tau_B = 3 n^2 r_B x (I r_B), r_S = (cos nt, sin nt, 0). Potential 3/2 n^2 r_B . I r_B, which depends on
/// time.
template <class S>
struct GravityGradient {
  static constexpr const char* type = "gravity_gradient";
  static constexpr bool present = true, needs_attitude = true;
  S mean_motion;       // n, 1/s
  Vec3T<S> moments_B;  // principal moments, kg m^2

  template <class T>
  Vec3T<T> torque_B(const T& t, const QuaternionT<T>& q, const Vec3T<T>&) const {
    using std::cos;
    using std::sin;
    const T phase = T(mean_motion) * t;
    const Vec3T<T> r = to_body<T>(q, Vec3T<T>(cos(phase), sin(phase), T(0)));
    const S k = S(3) * mean_motion * mean_motion;
    return Vec3T<T>(T(k * (moments_B.z() - moments_B.y())) * r.y() * r.z(),
                    T(k * (moments_B.x() - moments_B.z())) * r.z() * r.x(),
                    T(k * (moments_B.y() - moments_B.x())) * r.x() * r.y());
  }
  Vec3 torque_S(double t, const Mat3& R, const Vec3&) const requires std::is_same_v<S, double> {
    const double phase = mean_motion * t;
    const Vec3 r_S(std::cos(phase), std::sin(phase), 0);
    return 3 * mean_motion * mean_motion * r_S.cross(R * moments_B.cwiseProduct(R.transpose() * r_S).eval());
  }
  S potential_energy(const S& t, const QuaternionT<S>& q) const {
    using std::cos;
    using std::sin;
    const S phase = mean_motion * t;
    const Vec3T<S> r = to_body<S>(q, Vec3T<S>(cos(phase), sin(phase), S(0)));
    return S(1.5) * mean_motion * mean_motion * r.dot(moments_B.cwiseProduct(r));
  }
  S energy_rate(const S& t, const QuaternionT<S>& q, const Vec3T<S>&) const {
    // dV/dt at fixed attitude: 3 n^2 (dr/dt)_B . I r_B
    using std::cos;
    using std::sin;
    const S phase = mean_motion * t;
    const Vec3T<S> r = to_body<S>(q, Vec3T<S>(cos(phase), sin(phase), S(0)));
    const Vec3T<S> r_dot = to_body<S>(q, Vec3T<S>(-sin(phase), cos(phase), S(0))) * mean_motion;
    return S(3) * mean_motion * mean_motion * r_dot.dot(moments_B.cwiseProduct(r));
  }
  void add_jacobian(double t, const Quaternion& q, const Vec3&,
                    TorqueJacobian& J) const requires std::is_same_v<S, double> {
    const double phase = mean_motion * t;
    const Vec3 r = to_body<double>(q, Vec3(std::cos(phase), std::sin(phase), 0));
    const Mat3 d_r =
        hat<double>(r) * moments_B.asDiagonal() - hat<double>(moments_B.cwiseProduct(r));  // of r x (I r)
    J.d_q += 3 * mean_motion * mean_motion * d_r * to_body_derivative(q, r);
  }
};

/// Any one load of rotation, as run-time data; what a scene stores.
template <class S>
using AnyTorque =
    std::variant<GravityAboutPivot<S>, AngularDrag<S>, AttitudeSpring<S>, ConstantTorque<S, Frame::body>,
                 ConstantTorque<S, Frame::space>, GravityGradient<S>>;

/// The same load with constants of another number type: exact in a wider one, correctly rounded in another.
template <class S, class From>
AnyTorque<S> cast_load(const AnyTorque<From>& load) {
  struct Cast {
    AnyTorque<S> operator()(const GravityAboutPivot<From>& l) const {
      return GravityAboutPivot<S>{static_cast<S>(l.mass), l.acceleration_S.template cast<S>(),
                                  l.center_B.template cast<S>()};
    }
    AnyTorque<S> operator()(const AngularDrag<From>& l) const {
      return AngularDrag<S>{l.coefficients_B.template cast<S>()};
    }
    AnyTorque<S> operator()(const AttitudeSpring<From>& l) const {
      return AttitudeSpring<S>{static_cast<S>(l.stiffness), static_cast<S>(l.damping),
                               l.principal_to_user.template cast<S>()};
    }
    AnyTorque<S> operator()(const ConstantTorque<From, Frame::body>& l) const {
      return ConstantTorque<S, Frame::body>{l.torque.template cast<S>()};
    }
    AnyTorque<S> operator()(const ConstantTorque<From, Frame::space>& l) const {
      return ConstantTorque<S, Frame::space>{l.torque.template cast<S>()};
    }
    AnyTorque<S> operator()(const GravityGradient<From>& l) const {
      return GravityGradient<S>{static_cast<S>(l.mean_motion), l.moments_B.template cast<S>()};
    }
  };
  return std::visit(Cast{}, load);
}

/// Several loads at once; they add up. A list known at run time: the price of generality is paid only by the
/// scenes that have more than one load.
template <class S>
struct SeveralTorques {
  static constexpr bool present = true, needs_attitude = true;
  std::vector<AnyTorque<S>> loads;

  // Out of line: inlined into every stage of every solver, the list would multiply compile time by ten and
  // the code it is inlined into by five, for a call that costs two nanoseconds beside the loads themselves.
  template <class T, class A>
  [[gnu::noinline]] Vec3T<T> torque_B(const T& t, const A& q, const Vec3T<T>& w) const {
    Vec3T<T> sum(T(0), T(0), T(0));
    for (const auto& load : loads)
      std::visit(
          [&](const auto& l) {
            if constexpr (fits<decltype(l), A>) sum += l.template torque_B<T>(t, q, w);
          },
          load);
    return sum;
  }
  [[gnu::noinline]] Vec3 torque_S(double t, const Mat3& R,
                                  const Vec3& w_S) const requires std::is_same_v<S, double> {
    Vec3 sum = Vec3::Zero();
    for (const auto& load : loads) std::visit([&](const auto& l) { sum += l.torque_S(t, R, w_S); }, load);
    return sum;
  }
  template <class A>
  [[gnu::noinline]] S potential_energy(const S& t, const A& q) const {
    S sum(0);
    for (const auto& load : loads)
      std::visit(
          [&](const auto& l) {
            if constexpr (fits<decltype(l), A>) sum += l.potential_energy(t, q);
          },
          load);
    return sum;
  }
  template <class A>
  [[gnu::noinline]] S energy_rate(const S& t, const A& q, const Vec3T<S>& w) const {
    S sum(0);
    for (const auto& load : loads)
      std::visit(
          [&](const auto& l) {
            if constexpr (fits<decltype(l), A>) sum += l.energy_rate(t, q, w);
          },
          load);
    return sum;
  }
  template <class A>
  [[gnu::noinline]] void add_jacobian(double t, const A& q, const Vec3& w,
                                      TorqueJacobian& J) const requires std::is_same_v<S, double> {
    for (const auto& load : loads)
      std::visit(
          [&](const auto& l) {
            if constexpr (fits<decltype(l), A>) l.add_jacobian(t, q, w, J);
          },
          load);
  }

 private:
  // Without an attitude (rates alone) the reader admits only loads that do not ask for one.
  template <class L, class A>
  static constexpr bool fits = !std::remove_cvref_t<L>::needs_attitude || requires(const A& a) {
    a.vec();
  };
};

/// Force on the centre of mass: weight m g and linear drag -b v. Either may be zero.
template <class S>
struct Forces {
  static constexpr bool present = true;
  Vec3T<S> acceleration_S;  // g, m/s^2
  S drag_per_mass;          // b/m, 1/s

  template <class T>
  Vec3T<T> acceleration(const Vec3T<T>& v) const {
    return Vec3T<T>(T(acceleration_S.x()) - T(drag_per_mass) * v.x(),
                    T(acceleration_S.y()) - T(drag_per_mass) * v.y(),
                    T(acceleration_S.z()) - T(drag_per_mass) * v.z());
  }
  S potential_energy_per_mass(const Vec3T<S>& p) const { return -acceleration_S.dot(p); }
};

/// No force: the centre of mass moves on a straight line.
template <class S>
struct NoForce {
  static constexpr bool present = false;
  template <class T>
  Vec3T<T> acceleration(const Vec3T<T>&) const {
    return Vec3T<T>(T(0), T(0), T(0));
  }
  S potential_energy_per_mass(const Vec3T<S>&) const { return S(0); }
};

}  // namespace polhode
