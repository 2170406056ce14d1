// Attitude algebra: the hat map, rotation matrices and quaternions, exponential and logarithm on SO(3).
//
// Conventions: q = (w, x, y, z) is a Hamilton quaternion, scalar first, an active rotation body -> space;
// q and -q are the same attitude; R_SB(q) maps body to space components. A quaternion that is not of unit
// length stands for the attitude q/|q|: nothing here renormalises a state behind its owner's back.
//
// Everything is a template of the number type, because the truth runs the same equations in 50 digits.
#pragma once
#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace polhode {

template <class S>
using Vec3T = Eigen::Matrix<S, 3, 1>;
template <class S>
using Mat3T = Eigen::Matrix<S, 3, 3>;
template <class S>
using QuaternionT = Eigen::Quaternion<S>;  // constructor order (w, x, y, z); products do not renormalise
using Vec3 = Vec3T<double>;
using Mat3 = Mat3T<double>;
using Quaternion = QuaternionT<double>;

/// -1 or +1; a zero counts as positive. (A function of its own, because a Taylor series needs to hold it.)
template <class T>
T sign_of(const T& x) {
  return x < T(0) ? T(-1) : T(1);
}

/// The cross product as a matrix: hat(a) b = a x b.
template <class S>
Mat3T<S> hat(const Vec3T<S>& a) {
  Mat3T<S> m;
  m << S(0), -a.z(), a.y(), a.z(), S(0), -a.x(), -a.y(), a.x(), S(0);
  return m;
}

/// Inverse of hat: the axial vector of the antisymmetric part of m.
template <class S>
Vec3T<S> vee(const Mat3T<S>& m) {
  return Vec3T<S>(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1)) * S(0.5);
}

/// Squared length of a quaternion [1].
template <class T>
T squared_norm(const QuaternionT<T>& q) {
  return q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z();
}

/// q of unit length; the direction of q is kept. q = 0 gives NaN.
template <class S>
QuaternionT<S> normalised(const QuaternionT<S>& q) {
  using std::sqrt;
  const S s = S(1) / sqrt(squared_norm(q));
  return QuaternionT<S>(q.w() * s, q.x() * s, q.y() * s, q.z() * s);
}

/// Components in the body frame of a vector given in the space frame: R(q/|q|)^T a_S, q of any non-zero
/// length.
template <class T>
Vec3T<T> to_body(const QuaternionT<T>& q, const Vec3T<T>& a_S) {
  // conj(q) a q, written out: (w^2 - u.u) a + 2 (u.a) u - 2 w u x a, over |q|^2
  const Vec3T<T> u(q.x(), q.y(), q.z());
  const T uu = u.x() * u.x() + u.y() * u.y() + u.z() * u.z();
  const T ww = q.w() * q.w();
  const T ua = u.x() * a_S.x() + u.y() * a_S.y() + u.z() * a_S.z();
  const T inverse = T(1) / (ww + uu);
  const Vec3T<T> c = u.cross(a_S);
  const T diagonal = (ww - uu) * inverse, along = T(2) * ua * inverse, across = T(2) * q.w() * inverse;
  return Vec3T<T>(diagonal * a_S.x() + along * u.x() - across * c.x(),
                  diagonal * a_S.y() + along * u.y() - across * c.y(),
                  diagonal * a_S.z() + along * u.z() - across * c.z());
}

/// Components in the space frame of a vector given in the body frame: R(q/|q|) a_B, q of any non-zero length.
template <class T>
Vec3T<T> to_space(const QuaternionT<T>& q, const Vec3T<T>& a_B) {
  return to_body<T>(QuaternionT<T>(q.w(), -q.x(), -q.y(), -q.z()), a_B);
}

/// R_SB(q/|q|), 3x3, for q of any non-zero length.
template <class S>
Mat3T<S> rotation_matrix(const QuaternionT<S>& q) {
  Mat3T<S> R;
  for (int i = 0; i < 3; ++i) R.col(i) = to_space<S>(q, Vec3T<S>::Unit(i));
  return R;
}

/// The proper rotation nearest to m in the Frobenius norm (polar factor by SVD); det = +1 always.
Mat3 nearest_rotation(const Mat3& m);

/// Unit quaternion of a rotation matrix (the branch with the largest component, so no cancellation); w >= 0
/// is not enforced. m must be a rotation; project it first if it is not.
inline Quaternion quaternion_of(const Mat3& m) { return Quaternion(m); }

/// exp of a rotation vector [rad]: the unit quaternion (cos |v|/2, sin(|v|/2) v/|v|), smooth at v = 0.
template <class S>
QuaternionT<S> exp_rotation(const Vec3T<S>& v) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  const S angle2 = v.squaredNorm() * S(0.25);  // (|v|/2)^2
  const S angle = sqrt(angle2);
  const S sinc = angle > S(0) ? sin(angle) / angle : S(1);  // the quotient keeps its digits down to a = 0
  const S s = sinc * S(0.5);
  return QuaternionT<S>(cos(angle), v.x() * s, v.y() * s, v.z() * s);
}

/// log of an attitude: the rotation vector [rad], length in [0, pi]; q of any non-zero length, q and -q
/// agree.
template <class S>
Vec3T<S> log_rotation(const QuaternionT<S>& q) {
  using std::atan2;
  const S sign = q.w() < S(0) ? S(-1) : S(1);
  const Vec3T<S> u = q.vec() * sign;
  const S n = u.norm(), w = q.w() * sign;
  const S factor = n > S(0) ? S(2) * atan2(n, w) / n : S(2);
  return u * factor;
}

/// exp of a rotation vector as a matrix (Rodrigues); (1 - cos a)/a^2 as 2 sin^2(a/2)/a^2, which keeps its
/// digits.
template <class S>
Mat3T<S> exp_rotation_matrix(const Vec3T<S>& v) {
  using std::sin;
  using std::sqrt;
  const S a2 = v.squaredNorm(), a = sqrt(a2);
  if (!(a > S(0))) return Mat3T<S>::Identity() + hat(v);
  const S half = sin(a * S(0.5)) / a;
  const Mat3T<S> k = hat(v);
  return Mat3T<S>::Identity() + (sin(a) / a) * k + (S(2) * half * half) * (k * k);
}

/// Angle of the rotation that takes one attitude to another.
///
/// a, b     attitudes, body to space, of any non-zero length; q and -q are the same attitude
/// returns  angle in [0, pi] [rad]; resolves down to about 4e-16 rad
/// throws   nothing; a non-finite input gives NaN
/// source   2 atan2(|v|, |w|) of conj(a) b; acos has no digits left below 1e-8 rad
template <class S>
S attitude_error(const QuaternionT<S>& a, const QuaternionT<S>& b) {
  using std::abs;
  using std::atan2;
  const QuaternionT<S> d = a.conjugate() * b;
  return S(2) * atan2(d.vec().norm(), S(abs(d.w())));
}

/// Derivative of u = R(q/|q|)^T a_S with respect to the four components (w, x, y, z) of q: 3x4.
///
/// q, u_B   the attitude (any non-zero length) and the value of u there
/// source   q + dq = q (1 + e) with e = q^-1 dq; the scalar part of e changes the length alone, the vector
/// part
///          turns the body by 2 e: du = 2 u x e
inline Eigen::Matrix<double, 3, 4> to_body_derivative(const Quaternion& q, const Vec3& u_B) {
  Eigen::Matrix<double, 3, 4> vec_of_quotient;  // dq -> vec(conj(q) dq)
  vec_of_quotient.col(0) = -q.vec();
  vec_of_quotient.rightCols<3>() = q.w() * Mat3::Identity() - hat<double>(q.vec());
  return hat<double>(u_B) * vec_of_quotient * (2.0 / squared_norm(q));
}

}  // namespace polhode
