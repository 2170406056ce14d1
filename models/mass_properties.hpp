// Mass properties of a body: from principal moments, a full tensor, particles, solids, shells and compounds.
//
//   I = sum m (|r|^2 1 - r r^T)            particles: off-diagonals are minus sum m x y
//   I = integral of rho (|r|^2 1 - r r^T)  solids, by their closed forms
//   I_O = I_C + m (|d|^2 1 - d d^T)        parallel axes;   I' = R I R^T  turned
//
// In any number type S: double, or the wide type in which a scene is resolved (models/wide.hpp).
#pragma once
#include <string>
#include <type_traits>
#include <vector>

#include "models/attitude.hpp"

namespace polhode {

/// Mass, centre of mass and inertia tensor about the centre of mass, in one set of body axes.
template <class S>
struct MassPropertiesT {
  S mass = S(0);                        // kg
  Vec3T<S> center = Vec3T<S>::Zero();   // m, from the origin of the body axes
  Mat3T<S> inertia = Mat3T<S>::Zero();  // kg m^2, about the centre of mass
};
using MassProperties = MassPropertiesT<double>;

struct PointMass {
  double mass;    // kg
  Vec3 position;  // m
};

/// A set of point masses.
template <class S = double>
MassPropertiesT<S> mass_properties(const std::vector<PointMass>& particles);

/// Solid or shell of a named shape, of given mass, in its own axes: x, y, z along the edges of a box or the
/// semi-axes of an ellipsoid, z the axis of everything round.
///
/// The origin is the centre of mass, but for "cone" and "cone_shell": theirs is the centre of the base, the
/// apex lies at z = length and the centre of mass a quarter (a third) of the length above the base. Shells
/// are thin and of even mass per area; box and cylinder shells are closed, "tube" is open, a cone shell has
/// no base. The length of a capsule is that of its cylinder, without the half spheres.
///
/// shape    one of primitive_shapes()
/// size     what the shape needs, in the order that `primitive_needs(shape)` names it, three numbers for
/// "size",
///          "inner_size" and "radii", one for every other key [m]
/// throws   InputError with primitive_fault(shape, size) if that is not empty
template <class S = double>
MassPropertiesT<S> primitive(const std::string& shape, const std::vector<double>& size,
                             const std::type_identity_t<S>& mass);

/// What is wrong with the lengths of a primitive, or "": not positive and finite, a hole that leaves no wall,
/// too large or small to compute with, or no such shape.
std::string primitive_fault(const std::string& shape, const std::vector<double>& size);

/// Volume [m^3] (area [m^2] for a shell and a disc) of a primitive: density times it is the mass.
template <class S = double>
S primitive_volume(const std::string& shape, const std::vector<double>& size);

/// The shapes there are, and the keys that each needs: "size" (three lengths), "radius", "length", "radii"
/// ...
std::vector<std::string> primitive_shapes();
std::vector<std::string> primitive_needs(const std::string& shape);

/// The same body in axes that are turned by the unit q (part -> body) and moved by d.
template <class S>
MassPropertiesT<S> placed(const MassPropertiesT<S>& part, const std::type_identity_t<QuaternionT<S>>& q,
                          const std::type_identity_t<Vec3T<S>>& d);

/// Several bodies rigidly joined, in the axes that they share. Off-diagonal entries below the rounding of the
/// sum (8 eps of the largest entry) are set to zero, so that a symmetric arrangement has exactly its own
/// axes.
template <class S = double>
MassPropertiesT<S> joined(const std::vector<MassPropertiesT<std::type_identity_t<S>>>& parts);

/// Inertia about another point at d from the centre of mass (parallel axes).
template <class S>
Mat3T<S> inertia_about(const MassPropertiesT<S>& body, const std::type_identity_t<Vec3T<S>>& d);

/// Principal moments and the rotation that takes principal to the given components. The moments are not
/// sorted: each axis keeps the number of the given axis that it lies closest to, so that the rotation is
/// small. In a wide type, moments that agree to half its digits are equal: those of a tensor of doubles then
/// are, or differ by far more.
template <class S>
struct PrincipalAxesT {
  Vec3T<S> moments;
  QuaternionT<S> principal_to_given;  // exactly the identity if the tensor was diagonal
};
using PrincipalAxes = PrincipalAxesT<double>;
/// By Jacobi's rotations, which find small moments beside large ones as well as S can hold them.
template <class S = double>
PrincipalAxesT<S> principal_axes(const Mat3T<std::type_identity_t<S>>& inertia);

/// What is wrong with three principal moments.
struct InertiaFault {
  std::string text;              // "" if nothing is; prints the moments and the failing condition
  bool only_unphysical = false;  // no body has them, but as mathematics they would do

  explicit operator bool() const { return !text.empty(); }
};

/// A body can have three moments that are finite and positive, and no one larger than the sum of the others
/// ("I1 + I2 >= I3"). The inequality may be missed by 1e-6 of the largest moment: three moments of a flat
/// body, printed to seven digits, each off by half a unit of 1e-6 of itself, miss it by half that of their
/// sum, which is twice the largest. A moment counts as zero if it is that to the digits of S: in a wide type
/// then exactly, for a body whose mass lies on a line. With `physical` false the triangle inequality is not
/// asked for.
template <class S = double>
InertiaFault inertia_fault(const Vec3T<std::type_identity_t<S>>& moments, bool physical);

}  // namespace polhode
