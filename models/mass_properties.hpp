// Mass properties of a body: from principal moments, a full tensor, particles, solids, shells and compounds.
//
//   I = sum m (|r|^2 1 - r r^T)            particles: off-diagonals are minus sum m x y
//   I = integral of rho (|r|^2 1 - r r^T)  solids, by their closed forms
//   I_O = I_C + m (|d|^2 1 - d d^T)        parallel axes;   I' = R I R^T  turned
#pragma once
#include <string>
#include <vector>

#include "models/attitude.hpp"

namespace polhode {

/// Mass, centre of mass and inertia tensor about the centre of mass, in one set of body axes.
struct MassProperties {
  double mass = 0;              // kg
  Vec3 center = Vec3::Zero();   // m, from the origin of the body axes
  Mat3 inertia = Mat3::Zero();  // kg m^2, about the centre of mass
};

struct PointMass {
  double mass;    // kg
  Vec3 position;  // m
};

/// A set of point masses.
MassProperties mass_properties(const std::vector<PointMass>& particles);

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
MassProperties primitive(const std::string& shape, const std::vector<double>& size, double mass);

/// What is wrong with the lengths of a primitive, or "": not positive and finite, a hole that leaves no wall,
/// too large or small to compute with, or no such shape.
std::string primitive_fault(const std::string& shape, const std::vector<double>& size);

/// Volume [m^3] (area [m^2] for a shell and a disc) of a primitive: density times it is the mass.
double primitive_volume(const std::string& shape, const std::vector<double>& size);

/// The shapes there are, and the keys that each needs: "size" (three lengths), "radius", "length", "radii"
/// ...
std::vector<std::string> primitive_shapes();
std::vector<std::string> primitive_needs(const std::string& shape);

/// The same body in axes that are turned by q (part -> body) and moved by d.
MassProperties placed(const MassProperties& part, const Quaternion& q, const Vec3& d);

/// Several bodies rigidly joined, in the axes that they share. Off-diagonal entries below the rounding of the
/// sum (8 eps of the largest entry) are set to zero, so that a symmetric arrangement has exactly its own
/// axes.
MassProperties joined(const std::vector<MassProperties>& parts);

/// Inertia about another point at d from the centre of mass (parallel axes).
Mat3 inertia_about(const MassProperties& body, const Vec3& d);

/// Principal moments and the rotation that takes principal to the given components. The moments are not
/// sorted: each axis keeps the number of the given axis that it lies closest to, so that the rotation is
/// small.
struct PrincipalAxes {
  Vec3 moments;
  Quaternion principal_to_given;  // exactly the identity if the tensor was diagonal
};
PrincipalAxes principal_axes(const Mat3& inertia);

/// What is wrong with three principal moments, or "" if a body can have them: all finite and positive, and no
/// one larger than the sum of the others. Prints the moments and the failing condition, "I1 + I2 >= I3". The
/// inequality may be missed by 1e-6 of the largest moment: three moments of a flat body, printed to seven
/// digits, each off by half a unit of 1e-6 of itself, miss it by half that of their sum, which is twice the
/// largest. Positive means above 1e-14 of the largest: less is what rounding leaves of zero when a rod is
/// diagonalised. With `physical` false the triangle inequality is not asked for.
std::string inertia_fault(const Vec3& moments, bool physical);

}  // namespace polhode
