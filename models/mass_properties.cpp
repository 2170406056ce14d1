// Mass properties in closed form. Sources: the integrals of each primitive are in any text on dynamics
// (Goldstein, Classical Mechanics, ch. 5; the tables of Meriam & Kraige, Dynamics, app. D); composites by
// parallel axes.
#include "models/mass_properties.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Eigenvalues>

#include "models/errors.hpp"

namespace polhode {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

double sq(double x) { return x * x; }

// Moments per mass about the centre of mass, where that lies on the z axis, and the measure (volume or area).
struct Unit {
  Vec3 moments;
  double measure;
  double center_z = 0;
};

// A body of revolution about z: transverse and axial moment per mass.
Unit round(double transverse, double axial, double measure, double center_z = 0) {
  return {Vec3(transverse, transverse, axial), measure, center_z};
}

Vec3 box_moments(double a, double b, double c) {
  return Vec3(sq(b) + sq(c), sq(c) + sq(a), sq(a) + sq(b)) / 12;
}

using Size = std::vector<double>;

Unit box(const Size& s) { return {box_moments(s[0], s[1], s[2]), s[0] * s[1] * s[2]}; }
Unit sphere(const Size& s) { return round(0.4 * sq(s[0]), 0.4 * sq(s[0]), 4.0 / 3 * pi * s[0] * sq(s[0])); }
Unit ellipsoid(const Size& s) {
  return {Vec3(sq(s[1]) + sq(s[2]), sq(s[2]) + sq(s[0]), sq(s[0]) + sq(s[1])) / 5,
          4.0 / 3 * pi * s[0] * s[1] * s[2]};
}
Unit cylinder(const Size& s) {
  return round(sq(s[0]) / 4 + sq(s[1]) / 12, sq(s[0]) / 2, pi * sq(s[0]) * s[1]);
}
Unit capsule(const Size& s) {
  const double r = s[0], l = s[1];
  const double middle = pi * r * r * l, caps = 4.0 / 3 * pi * r * r * r, total = middle + caps;
  // The centre of a half ball lies 3/8 r from its plane, and its moment there is 83/320 m r^2.
  const double transverse =
      (middle * (r * r / 4 + l * l / 12) + caps * (0.4 * r * r + l * l / 4 + 0.375 * l * r)) / total;
  return round(transverse, (middle * r * r / 2 + caps * 0.4 * r * r) / total, total);
}
Unit cone(const Size& s) {
  return round(0.15 * sq(s[0]) + 0.0375 * sq(s[1]), 0.3 * sq(s[0]), pi * sq(s[0]) * s[1] / 3, s[1] / 4);
}
Unit torus(const Size& s) {
  const double R2 = sq(s[0]), r2 = sq(s[1]);
  return round(R2 / 2 + 0.625 * r2, R2 + 0.75 * r2, 2 * pi * pi * s[0] * r2);
}
Unit disc(const Size& s) { return round(sq(s[0]) / 4, sq(s[0]) / 2, pi * sq(s[0])); }

// Hollow bodies; differences of powers are divided out by hand where they have a common factor, so that a
// thin wall keeps its digits.
Unit hollow_sphere(const Size& s) {
  const double a = s[0], b = s[1];
  const double cubes = a * a + a * b + b * b;  // (a^3 - b^3)/(a - b)
  const double fifths = a * a * a * a + a * a * a * b + a * a * b * b + a * b * b * b + b * b * b * b;
  const double m = 0.4 * fifths / cubes;
  return round(m, m, 4.0 / 3 * pi * (a - b) * cubes);
}
Unit hollow_cylinder(const Size& s) {
  const double a = s[0], b = s[1], l = s[2];
  return round((a * a + b * b) / 4 + l * l / 12, (a * a + b * b) / 2, pi * (a - b) * (a + b) * l);
}
Unit hollow_box(const Size& s) {
  const double outer = s[0] * s[1] * s[2], inner = s[3] * s[4] * s[5];
  return {(outer * box_moments(s[0], s[1], s[2]) - inner * box_moments(s[3], s[4], s[5])) / (outer - inner),
          outer - inner};
}

// Thin shells of even mass per area.
Unit sphere_shell(const Size& s) { return round(2 * sq(s[0]) / 3, 2 * sq(s[0]) / 3, 4 * pi * sq(s[0])); }
Unit box_shell(const Size& s) {
  const double a = s[0], b = s[1], c = s[2];
  const Vec3 area(2 * b * c, 2 * c * a, 2 * a * b);  // of the pair of faces across each axis
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < 3; ++i) {
    // A pair of plates: a box without its own thickness, at half of it from the centre.
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const std::array<double, 3> edge{a, b, c};
    const double x = edge[static_cast<std::size_t>(i)], y = edge[static_cast<std::size_t>(j)],
                 z = edge[static_cast<std::size_t>(k)];
    sum[i] += area[i] * (y * y + z * z) / 12;
    sum[j] += area[i] * (z * z / 12 + x * x / 4);
    sum[k] += area[i] * (y * y / 12 + x * x / 4);
  }
  return {sum / area.sum(), area.sum()};
}
Unit tube(const Size& s) { return round(sq(s[0]) / 2 + sq(s[1]) / 12, sq(s[0]), 2 * pi * s[0] * s[1]); }
Unit cylinder_shell(const Size& s) {
  const double r = s[0], l = s[1], side = l / (l + r), ends = r / (l + r);
  return round(side * (r * r / 2 + l * l / 12) + ends * (r * r / 4 + l * l / 4),
               side * r * r + ends * r * r / 2, 2 * pi * r * (l + r));
}
Unit cone_shell(const Size& s) {
  return round(sq(s[0]) / 4 + sq(s[1]) / 18, sq(s[0]) / 2, pi * s[0] * std::hypot(s[0], s[1]), s[1] / 3);
}
Unit capsule_shell(const Size& s) {
  const double r = s[0], l = s[1], side = l / (l + 2 * r), caps = 2 * r / (l + 2 * r);
  // The centre of a half sphere of no thickness lies half a radius from its plane.
  return round(side * (r * r / 2 + l * l / 12) + caps * (2 * r * r / 3 + l * l / 4 + l * r / 2),
               side * r * r + caps * 2 * r * r / 3, 2 * pi * r * (l + 2 * r));
}

struct Shape {
  const char* name;
  std::vector<std::string> needs;
  Unit (*unit)(const Size&);
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> table = {
      {"box", {"size"}, box},
      {"sphere", {"radius"}, sphere},
      {"ellipsoid", {"radii"}, ellipsoid},
      {"cylinder", {"radius", "length"}, cylinder},
      {"capsule", {"radius", "length"}, capsule},
      {"cone", {"radius", "length"}, cone},
      {"torus", {"radius", "tube_radius"}, torus},
      {"disc", {"radius"}, disc},
      {"hollow_sphere", {"radius", "inner_radius"}, hollow_sphere},
      {"hollow_cylinder", {"radius", "inner_radius", "length"}, hollow_cylinder},
      {"hollow_box", {"size", "inner_size"}, hollow_box},
      {"sphere_shell", {"radius"}, sphere_shell},
      {"box_shell", {"size"}, box_shell},
      {"tube", {"radius", "length"}, tube},
      {"cylinder_shell", {"radius", "length"}, cylinder_shell},
      {"cone_shell", {"radius", "length"}, cone_shell},
      {"capsule_shell", {"radius", "length"}, capsule_shell},
  };
  return table;
}

const Shape* shape_named(const std::string& name) {
  for (const Shape& s : shapes())
    if (name == s.name) return &s;
  return nullptr;
}

std::size_t lengths_of(const std::string& need) {
  return need == "size" || need == "inner_size" || need == "radii" ? 3 : 1;
}

Unit unit_of(const std::string& name, const Size& size) {
  const std::string fault = primitive_fault(name, size);
  if (!fault.empty()) throw InputError(fault);
  return shape_named(name)->unit(size);
}

Mat3 point_inertia(const Vec3& d) { return d.squaredNorm() * Mat3::Identity() - d * d.transpose(); }

void drop_rounding(Mat3& inertia) {
  const double floor = 8 * epsilon * inertia.cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j && std::abs(inertia(i, j)) <= floor) inertia(i, j) = 0;
}

}  // namespace

MassProperties mass_properties(const std::vector<PointMass>& particles) {
  std::vector<MassProperties> parts;
  for (const PointMass& p : particles) parts.push_back({p.mass, p.position, Mat3::Zero()});
  return joined(parts);
}

MassProperties primitive(const std::string& shape, const std::vector<double>& size, double mass) {
  const Unit unit = unit_of(shape, size);
  return {mass, Vec3(0, 0, unit.center_z), (mass * unit.moments).asDiagonal()};
}

double primitive_volume(const std::string& shape, const std::vector<double>& size) {
  return unit_of(shape, size).measure;
}

std::vector<std::string> primitive_shapes() {
  std::vector<std::string> names;
  for (const Shape& s : shapes()) names.emplace_back(s.name);
  return names;
}

std::vector<std::string> primitive_needs(const std::string& shape) {
  const Shape* known = shape_named(shape);
  return known ? known->needs : std::vector<std::string>{};
}

std::string primitive_fault(const std::string& name, const std::vector<double>& size) {
  const Shape* shape = shape_named(name);
  if (!shape) return "shape \"" + name + "\" is none of " + name_list(primitive_shapes());
  std::size_t count = 0;
  for (const auto& need : shape->needs) count += lengths_of(need);
  if (size.size() != count)
    return name + " of " + std::to_string(size.size()) + " lengths, where it has " + std::to_string(count);
  for (const double x : size)
    if (!(x > 0) || !std::isfinite(x)) return name + " with a length of " + number_text(x);
  // Of two keys the second may be what is taken out of, or wound around, the first: it must leave a wall or a
  // hole.
  const auto& needs = shape->needs;
  if (needs.size() > 1 &&
      (needs[1] == "inner_radius" || needs[1] == "inner_size" || needs[1] == "tube_radius")) {
    const std::size_t n = lengths_of(needs[1]);
    for (std::size_t i = 0; i < n; ++i)
      if (!(size[n + i] < size[i]))
        return name + " whose " + needs[1] + " " + number_text(size[n + i]) + " is not less than its " +
               needs[0] + " " + number_text(size[i]);
  }
  const Unit unit = shape->unit(size);
  if (!unit.moments.allFinite() || !std::isnormal(unit.measure) || !(unit.moments.minCoeff() > 0))
    return name + " with lengths too large or too small to compute with";
  return "";
}

MassProperties placed(const MassProperties& part, const Quaternion& q, const Vec3& d) {
  const Mat3 R = rotation_matrix<double>(q);
  const Mat3 turned = R * part.inertia * R.transpose();
  return {part.mass, d + R * part.center, 0.5 * (turned + turned.transpose())};
}

MassProperties joined(const std::vector<MassProperties>& parts) {
  MassProperties whole;
  for (const auto& p : parts) {
    whole.mass += p.mass;
    whole.center += p.mass * p.center;
  }
  if (whole.mass > 0) whole.center /= whole.mass;
  // About the common centre, not the origin: far from the origin the difference of the two would lose digits.
  for (const auto& p : parts) whole.inertia += inertia_about(p, p.center - whole.center);
  drop_rounding(whole.inertia);
  return whole;
}

Mat3 inertia_about(const MassProperties& body, const Vec3& d) {
  return body.inertia + body.mass * point_inertia(d);
}

PrincipalAxes principal_axes(const Mat3& inertia) {
  const bool diagonal = inertia(0, 1) == 0 && inertia(0, 2) == 0 && inertia(1, 2) == 0;
  if (diagonal || !inertia.allFinite())  // what is not finite is for inertia_fault to refuse
    return {inertia.diagonal(), Quaternion(1, 0, 0, 0)};
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia);
  const Mat3& vectors = solver.eigenvectors();

  // Number and sign the axes so that the rotation from the given ones is the smallest of the 24.
  std::array<int, 3> order{0, 1, 2}, best = order;
  double best_sum = -1;
  do {
    double sum = 0;
    for (int i = 0; i < 3; ++i) sum += std::abs(vectors(i, order[static_cast<std::size_t>(i)]));
    if (sum > best_sum) {
      best_sum = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  Mat3 R;
  Vec3 moments;
  for (int i = 0; i < 3; ++i) {
    const int from = best[static_cast<std::size_t>(i)];
    R.col(i) = vectors.col(from) * (vectors(i, from) < 0 ? -1 : 1);
    moments[i] = solver.eigenvalues()[from];
  }
  if (R.determinant() < 0) {
    Eigen::Index weakest = 0;
    R.diagonal().minCoeff(&weakest);
    R.col(weakest) = -R.col(weakest);
  }
  return {moments, normalised<double>(quaternion_of(R))};
}

std::string inertia_fault(const Vec3& moments, bool physical) {
  const double largest = moments.maxCoeff();
  const auto fault = [&](const std::string& condition) {
    return "principal moments I1 = " + number_text(moments[0]) + ", I2 = " + number_text(moments[1]) +
           ", I3 = " + number_text(moments[2]) + " kg m^2 break " + condition;
  };
  const auto name = [](int i) { return std::string("I") + std::to_string(i + 1); };
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(moments[i])) return fault(name(i) + " finite");
  for (int i = 0; i < 3; ++i) {
    if (!(moments[i] > 0) || moments[i] <= 1e-14 * largest) return fault(name(i) + " > 0 (beyond rounding)");
    if (!std::isfinite(1 / moments[i]) || !std::isfinite(moments.sum()))
      return fault(name(i) + " and 1/" + name(i) + " within the range of double precision");
  }
  if (physical)
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      if (moments[j] + moments[k] < moments[i] - 1e-6 * largest)
        return fault("the triangle inequality " + name(std::min(j, k)) + " + " + name(std::max(j, k)) +
                     " >= " + name(i));
    }
  return "";
}

}  // namespace polhode
