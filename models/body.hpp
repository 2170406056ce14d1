// The particle and the rigid body: their equations of motion, Jacobian, energy and momentum, as types that
// hold only what a scene has.
//
//   rotation     I w' = (I w) x w + tau_B,   q' = 1/2 q (0, w_B)
//   translation  p' = v,                     m v' = F
//
// A model is a flat state of `size` numbers, [q (4)] [w_B (3)] [p (3) v (3)], whose absent parts take no
// room, and functions on it. Which parts there are is decided by types, so that a free top pays for no load,
// a sphere for no gyroscopic term, and a body whose attitude nobody asks for has none.
#pragma once
#include <array>
#include <concepts>
#include <span>

#include "models/attitude.hpp"
#include "models/loads.hpp"

namespace polhode {

/// Stands where an attitude would, in models that have none.
struct NoAttitude {};

/// spherical: three equal moments, (I w) x w = 0; any: asked of the moments at run time.
enum class Shape { triaxial, spherical, any };
enum class AttitudePart { integrated, absent };

/// Rotation of a rigid body about its centre of mass (or about a pivot, with the inertia taken there).
///
/// S          number type of the constants; T in the functions: any type that computes like it
/// LoadT      the torque, one of models/loads.hpp
/// moments    principal moments [kg m^2], body frame = principal frame
template <class S, template <class> class LoadT, Shape shape = Shape::triaxial,
          AttitudePart attitude = AttitudePart::integrated>
class Rotation {
 public:
  using Load = LoadT<S>;
  static constexpr bool present = true;
  static constexpr bool has_attitude = attitude == AttitudePart::integrated;
  static constexpr bool has_load = Load::present;
  static constexpr int w_at = has_attitude ? 4 : 0;
  static constexpr int size = w_at + 3;

  Rotation(const Vec3T<S>& moments, Load torque_load)
      : load(std::move(torque_load)),
        moments_(moments),
        inverse_(S(1) / moments.x(), S(1) / moments.y(), S(1) / moments.z()),
        gyro_((moments.y() - moments.z()) / moments.x(), (moments.z() - moments.x()) / moments.y(),
              (moments.x() - moments.y()) / moments.z()),
        triaxial_(!(moments.x() == moments.y() && moments.y() == moments.z())) {}

  template <class T>
  static auto attitude_of(const T* y) {
    if constexpr (has_attitude)
      return QuaternionT<T>(y[0], y[1], y[2], y[3]);
    else
      return NoAttitude{};
  }
  template <class T>
  static Vec3T<T> w_of(const T* y) {
    return Vec3T<T>(y[w_at], y[w_at + 1], y[w_at + 2]);
  }

  /// w' of Euler's equations: I^-1((I w) x w + tau_B) [rad/s^2].
  template <class T, class A>
  [[gnu::always_inline]] Vec3T<T> angular_acceleration(const T& t, const A& q, const Vec3T<T>& w) const {
    Vec3T<T> a(T(0), T(0), T(0));
    if (has_gyroscopic_term())
      a = Vec3T<T>(T(gyro_.x()) * (w.y() * w.z()), T(gyro_.y()) * (w.z() * w.x()),
                   T(gyro_.z()) * (w.x() * w.y()));
    if constexpr (has_load) {
      const Vec3T<T> tau = load.template torque_B<T>(t, q, w);
      a = Vec3T<T>(a.x() + T(inverse_.x()) * tau.x(), a.y() + T(inverse_.y()) * tau.y(),
                   a.z() + T(inverse_.z()) * tau.z());
    }
    return a;
  }

  template <class T>
  [[gnu::always_inline]] void rhs(const T& t, const T* y, T* d) const {
    const Vec3T<T> w = w_of(y);
    if constexpr (has_attitude) {
      const T half(S(0.5));
      const T hx = half * w.x(), hy = half * w.y(), hz = half * w.z();
      d[0] = -(y[1] * hx + y[2] * hy + y[3] * hz);
      d[1] = y[0] * hx + y[2] * hz - y[3] * hy;
      d[2] = y[0] * hy + y[3] * hx - y[1] * hz;
      d[3] = y[0] * hz + y[1] * hy - y[2] * hx;
    }
    const Vec3T<T> a = angular_acceleration<T>(t, attitude_of(y), w);
    d[w_at] = a.x();
    d[w_at + 1] = a.y();
    d[w_at + 2] = a.z();
  }

  /// Adds the derivative of the right-hand side to J, whose first rows and columns are this part's.
  template <class Matrix>
  void jacobian(double t, const double* y, Matrix& J) const requires std::is_same_v<S, double> {
    const Vec3 w = w_of(y);
    if constexpr (has_attitude) {
      J.template block<4, 4>(0, 0) << 0, -w.x(), -w.y(), -w.z(), w.x(), 0, w.z(), -w.y(), w.y(), -w.z(), 0,
          w.x(), w.z(), w.y(), -w.x(), 0;
      J.template block<4, 4>(0, 0) *= 0.5;
      J.template block<4, 3>(0, 4) << -y[1], -y[2], -y[3], y[0], -y[3], y[2], y[3], y[0], -y[1], -y[2], y[1],
          y[0];
      J.template block<4, 3>(0, 4) *= 0.5;
    }
    Mat3 d_w = Mat3::Zero();
    if (has_gyroscopic_term())
      d_w << 0, gyro_.x() * w.z(), gyro_.x() * w.y(), gyro_.y() * w.z(), 0, gyro_.y() * w.x(),
          gyro_.z() * w.y(), gyro_.z() * w.x(), 0;
    if constexpr (has_load) {
      TorqueJacobian d_tau;
      load.add_jacobian(t, attitude_of(y), w, d_tau);
      d_w += inverse_.asDiagonal() * d_tau.d_w;
      if constexpr (has_attitude) J.template block<3, 4>(w_at, 0) = inverse_.asDiagonal() * d_tau.d_q;
    }
    J.template block<3, 3>(w_at, w_at) = d_w;
  }

  /// Is there an (I w) x w? Known to the compiler, unless the shape is `any`.
  constexpr bool has_gyroscopic_term() const {
    if constexpr (shape == Shape::any)
      return triaxial_;
    else
      return shape == Shape::triaxial;
  }
  const Vec3T<S>& moments() const { return moments_; }
  const Vec3T<S>& inverse_moments() const { return inverse_; }
  const Vec3T<S>& gyroscopic_constants() const { return gyro_; }  // (I2-I3)/I1 and cyclic [1]
  S kinetic_energy(const Vec3T<S>& w) const { return S(0.5) * w.dot(moments_.cwiseProduct(w)); }
  Vec3T<S> momentum_B(const Vec3T<S>& w) const { return moments_.cwiseProduct(w); }

  Load load;

 private:
  Vec3T<S> moments_, inverse_, gyro_;
  bool triaxial_;
};

/// Stands where a rotation would, in scenes of a particle.
struct NoRotation {
  static constexpr bool present = false, has_attitude = false, has_load = false;
  static constexpr int size = 0;
  template <class T>
  void rhs(const T&, const T*, T*) const {}
  template <class Matrix>
  void jacobian(double, const double*, Matrix&) const {}
};

/// Translation of a mass point: p' = v, v' = F/m.
template <class S, template <class> class ForceT>
struct Translation {
  static constexpr bool present = true;
  static constexpr int size = 6;
  S mass;  // kg
  ForceT<S> force;

  template <class T>
  [[gnu::always_inline]] void rhs(const T&, const T* y, T* d) const {
    const Vec3T<T> a = force.template acceleration<T>(Vec3T<T>(y[3], y[4], y[5]));
    for (int i = 0; i < 3; ++i) d[i] = y[i + 3];
    for (int i = 0; i < 3; ++i) d[i + 3] = a[i];
  }
  template <class Matrix>
  void jacobian(int at, Matrix& J) const {
    J.template block<3, 3>(at, at + 3) = Mat3::Identity();
    if constexpr (requires { force.drag_per_mass; })
      J.template block<3, 3>(at + 3, at + 3) = -force.drag_per_mass * Mat3::Identity();
  }
  S kinetic_energy(const Vec3T<S>& v) const { return S(0.5) * mass * v.squaredNorm(); }
  S potential_energy(const Vec3T<S>& p) const { return mass * force.potential_energy_per_mass(p); }
};

struct NoTranslation {
  static constexpr bool present = false;
  static constexpr int size = 0;
  template <class T>
  void rhs(const T&, const T*, T*) const {}
  template <class Matrix>
  void jacobian(int, Matrix&) const {}
};

/// A scene's equations: rotation part x translation part, each optional, and the initial state.
template <class S, class RotationPart, class TranslationPart>
struct Model {
  using Scalar = S;
  using Rotating = RotationPart;
  using Translating = TranslationPart;
  static constexpr int rotation_size = RotationPart::size;
  static constexpr int size = RotationPart::size + TranslationPart::size;
  static constexpr bool has_rotation = RotationPart::present;
  static constexpr bool has_attitude = RotationPart::has_attitude;
  static constexpr bool has_translation = TranslationPart::present;
  using State = std::array<S, static_cast<std::size_t>(size)>;

  RotationPart rotation;
  TranslationPart translation;
  State initial{};

  // Always inlined: the compiler's own measure counts a solver's stages and makes a function of it.
  template <class T>
  [[gnu::always_inline]] void rhs(const T& t, const T* y, T* d) const {
    rotation.rhs(t, y, d);
    translation.rhs(t, y + rotation_size, d + rotation_size);
  }

  /// d(rhs)/dy at (t, y): overwrites J (size x size).
  template <class Matrix>
  void jacobian(double t, const double* y, Matrix&& J) const {
    J.setZero();
    rotation.jacobian(t, y, J);
    translation.jacobian(rotation_size, J);
  }

  Vec3T<S> position(const S* y) const requires has_translation {
    return Vec3T<S>(y[rotation_size], y[rotation_size + 1], y[rotation_size + 2]);
  }
  Vec3T<S> velocity(const S* y) const requires has_translation {
    return Vec3T<S>(y[rotation_size + 3], y[rotation_size + 4], y[rotation_size + 5]);
  }

  /// Kinetic energy of the rotation [J].
  S rotational_energy(const S* y) const {
    if constexpr (has_rotation)
      return rotation.kinetic_energy(rotation.w_of(y));
    else
      return S(0);
  }

  /// Potential energy of the loads and kinetic energy of the translation [J]: what, beside the rotation,
  /// makes up the total.
  S other_energy(const S& t, const S* y) const {
    S e(0);
    if constexpr (has_rotation) e += rotation.load.potential_energy(t, rotation.attitude_of(y));
    if constexpr (has_translation)
      e += translation.kinetic_energy(velocity(y)) + translation.potential_energy(position(y));
    return e;
  }
  S total_energy(const S& t, const S* y) const { return rotational_energy(y) + other_energy(t, y); }

  /// Rate at which loads without a potential (or with one that depends on time) change the total energy [W].
  S energy_rate(const S& t, const S* y) const {
    S p(0);
    if constexpr (has_rotation) p += rotation.load.energy_rate(t, rotation.attitude_of(y), rotation.w_of(y));
    if constexpr (has_translation)
      if constexpr (requires { translation.force.drag_per_mass; })
        p -= translation.mass * translation.force.drag_per_mass * velocity(y).squaredNorm();
    return p;
  }

  /// Angular momentum about the centre of mass (or the pivot) [kg m^2/s]: in the space frame if there is an
  /// attitude, else in the body frame.
  Vec3T<S> angular_momentum(const S* y) const {
    if constexpr (has_attitude)
      return to_space<S>(rotation.attitude_of(y), rotation.momentum_B(rotation.w_of(y)));
    else if constexpr (has_rotation)
      return rotation.momentum_B(rotation.w_of(y));
    else
      return Vec3T<S>(S(0), S(0), S(0));
  }
};

/// What a stepper may ask of a model; a stepper that asks for more says so in its own concept, and a model
/// that cannot give it is `unsupported` there.
template <class M>
concept AnyModel = requires(const M& m, const double* y, double* d) {
  { M::size } -> std::convertible_to<int>;
  m.rhs(0.0, y, d);
};
template <class M>
concept WithRotation = AnyModel<M> && M::has_rotation;
template <class M>
concept WithAttitude = AnyModel<M> && M::has_attitude;

}  // namespace polhode
