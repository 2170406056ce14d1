// Mass properties in closed form. Sources: the integrals of each primitive are in any text on dynamics
// (Goldstein, Classical Mechanics, ch. 5; the tables of Meriam & Kraige, Dynamics, app. D); composites by
// parallel axes.
#include "models/mass_properties.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "models/errors.hpp"
#include "models/landen.hpp"
#include "models/wide.hpp"

namespace polhode {
namespace {

template <class S>
S epsilon() {
  return std::numeric_limits<S>::epsilon();
}
template <class S>
const S& pi() {
  return half_turn<S>();
}
template <class S>
S sq(const S& x) {
  return x * x;
}
/// n/d, correctly rounded.
template <class S>
S ratio(int n, int d) {
  return S(n) / S(d);
}

// Moments per mass about the centre of mass, where that lies on the z axis, and the measure (volume or area).
template <class S>
struct Unit {
  Vec3T<S> moments;
  S measure;
  S center_z = S(0);
};

// A body of revolution about z: transverse and axial moment per mass.
template <class S>
Unit<S> round(const S& transverse, const S& axial, const S& measure, const S& center_z = S(0)) {
  return {Vec3T<S>(transverse, transverse, axial), measure, center_z};
}

template <class S>
Vec3T<S> box_moments(const S& a, const S& b, const S& c) {
  return Vec3T<S>(sq(b) + sq(c), sq(c) + sq(a), sq(a) + sq(b)) / S(12);
}

template <class S>
using Size = std::vector<S>;

template <class S>
Unit<S> box(const Size<S>& s) {
  return {box_moments(s[0], s[1], s[2]), s[0] * s[1] * s[2]};
}
template <class S>
Unit<S> sphere(const Size<S>& s) {
  const S m = ratio<S>(2, 5) * sq(s[0]);
  return round<S>(m, m, ratio<S>(4, 3) * pi<S>() * s[0] * sq(s[0]));
}
template <class S>
Unit<S> ellipsoid(const Size<S>& s) {
  return {Vec3T<S>(sq(s[1]) + sq(s[2]), sq(s[2]) + sq(s[0]), sq(s[0]) + sq(s[1])) / S(5),
          ratio<S>(4, 3) * pi<S>() * s[0] * s[1] * s[2]};
}
template <class S>
Unit<S> cylinder(const Size<S>& s) {
  return round<S>(sq(s[0]) / 4 + sq(s[1]) / 12, sq(s[0]) / 2, pi<S>() * sq(s[0]) * s[1]);
}
template <class S>
Unit<S> capsule(const Size<S>& s) {
  const S &r = s[0], &l = s[1];
  const S middle = pi<S>() * r * r * l, caps = ratio<S>(4, 3) * pi<S>() * r * r * r, total = middle + caps;
  const S ball = ratio<S>(2, 5) * r * r;
  // The centre of a half ball lies 3/8 r from its plane, and its moment there is 83/320 m r^2.
  const S transverse =
      (middle * (r * r / 4 + l * l / 12) + caps * (ball + l * l / 4 + 3 * l * r / 8)) / total;
  return round<S>(transverse, (middle * r * r / 2 + caps * ball) / total, total);
}
template <class S>
Unit<S> cone(const Size<S>& s) {
  return round<S>(3 * sq(s[0]) / 20 + 3 * sq(s[1]) / 80, 3 * sq(s[0]) / 10, pi<S>() * sq(s[0]) * s[1] / 3,
                  s[1] / 4);
}
template <class S>
Unit<S> torus(const Size<S>& s) {
  const S R2 = sq(s[0]), r2 = sq(s[1]);
  return round<S>(R2 / 2 + 5 * r2 / 8, R2 + 3 * r2 / 4, 2 * pi<S>() * pi<S>() * s[0] * r2);
}
template <class S>
Unit<S> disc(const Size<S>& s) {
  return round<S>(sq(s[0]) / 4, sq(s[0]) / 2, pi<S>() * sq(s[0]));
}

// Hollow bodies; differences of powers are divided out by hand where they have a common factor, so that a
// thin wall keeps its digits.
template <class S>
Unit<S> hollow_sphere(const Size<S>& s) {
  const S &a = s[0], &b = s[1];
  const S cubes = a * a + a * b + b * b;  // (a^3 - b^3)/(a - b)
  const S fifths = a * a * a * a + a * a * a * b + a * a * b * b + a * b * b * b + b * b * b * b;
  const S m = ratio<S>(2, 5) * fifths / cubes;
  return round<S>(m, m, ratio<S>(4, 3) * pi<S>() * (a - b) * cubes);
}
template <class S>
Unit<S> hollow_cylinder(const Size<S>& s) {
  const S &a = s[0], &b = s[1], &l = s[2];
  return round<S>((a * a + b * b) / 4 + l * l / 12, (a * a + b * b) / 2, pi<S>() * (a - b) * (a + b) * l);
}
template <class S>
Unit<S> hollow_box(const Size<S>& s) {
  const S outer = s[0] * s[1] * s[2], inner = s[3] * s[4] * s[5];
  return {(outer * box_moments(s[0], s[1], s[2]) - inner * box_moments(s[3], s[4], s[5])) / (outer - inner),
          outer - inner};
}

// Thin shells of even mass per area.
template <class S>
Unit<S> sphere_shell(const Size<S>& s) {
  const S m = 2 * sq(s[0]) / 3;
  return round<S>(m, m, 4 * pi<S>() * sq(s[0]));
}
template <class S>
Unit<S> box_shell(const Size<S>& s) {
  const S &a = s[0], &b = s[1], &c = s[2];
  const Vec3T<S> area(2 * b * c, 2 * c * a, 2 * a * b);  // of the pair of faces across each axis
  Vec3T<S> sum = Vec3T<S>::Zero();
  for (int i = 0; i < 3; ++i) {
    // A pair of plates: a box without its own thickness, at half of it from the centre.
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const std::array<S, 3> edge{a, b, c};
    const S &x = edge[static_cast<std::size_t>(i)], &y = edge[static_cast<std::size_t>(j)],
            &z = edge[static_cast<std::size_t>(k)];
    sum[i] += area[i] * (y * y + z * z) / 12;
    sum[j] += area[i] * (z * z / 12 + x * x / 4);
    sum[k] += area[i] * (y * y / 12 + x * x / 4);
  }
  return {sum / area.sum(), area.sum()};
}
template <class S>
Unit<S> tube(const Size<S>& s) {
  return round<S>(sq(s[0]) / 2 + sq(s[1]) / 12, sq(s[0]), 2 * pi<S>() * s[0] * s[1]);
}
template <class S>
Unit<S> cylinder_shell(const Size<S>& s) {
  const S &r = s[0], &l = s[1];
  const S side = l / (l + r), ends = r / (l + r);
  return round<S>(side * (r * r / 2 + l * l / 12) + ends * (r * r / 4 + l * l / 4),
                  side * r * r + ends * r * r / 2, 2 * pi<S>() * r * (l + r));
}
template <class S>
Unit<S> cone_shell(const Size<S>& s) {
  using std::sqrt;
  return round<S>(sq(s[0]) / 4 + sq(s[1]) / 18, sq(s[0]) / 2,
                  pi<S>() * s[0] * S(sqrt(S(sq(s[0]) + sq(s[1])))), s[1] / 3);
}
template <class S>
Unit<S> capsule_shell(const Size<S>& s) {
  const S &r = s[0], &l = s[1];
  const S side = l / (l + 2 * r), caps = 2 * r / (l + 2 * r);
  // The centre of a half sphere of no thickness lies half a radius from its plane.
  return round<S>(side * (r * r / 2 + l * l / 12) + caps * (2 * r * r / 3 + l * l / 4 + l * r / 2),
                  side * r * r + caps * 2 * r * r / 3, 2 * pi<S>() * r * (l + 2 * r));
}

struct Shape {
  const char* name;
  std::vector<std::string> needs;
  Unit<double> (*in_double)(const Size<double>&);
  Unit<Resolved> (*resolved)(const Size<Resolved>&);

  template <class S>
  Unit<S> unit(const std::vector<double>& size) const {
    const Size<S> lengths(size.begin(), size.end());
    if constexpr (std::is_same_v<S, double>)
      return in_double(lengths);
    else
      return resolved(lengths);
  }
};

const std::vector<Shape>& shapes() {
  static const std::vector<Shape> table = {
      {"box", {"size"}, box<double>, box<Resolved>},
      {"sphere", {"radius"}, sphere<double>, sphere<Resolved>},
      {"ellipsoid", {"radii"}, ellipsoid<double>, ellipsoid<Resolved>},
      {"cylinder", {"radius", "length"}, cylinder<double>, cylinder<Resolved>},
      {"capsule", {"radius", "length"}, capsule<double>, capsule<Resolved>},
      {"cone", {"radius", "length"}, cone<double>, cone<Resolved>},
      {"torus", {"radius", "tube_radius"}, torus<double>, torus<Resolved>},
      {"disc", {"radius"}, disc<double>, disc<Resolved>},
      {"hollow_sphere", {"radius", "inner_radius"}, hollow_sphere<double>, hollow_sphere<Resolved>},
      {"hollow_cylinder",
       {"radius", "inner_radius", "length"},
       hollow_cylinder<double>,
       hollow_cylinder<Resolved>},
      {"hollow_box", {"size", "inner_size"}, hollow_box<double>, hollow_box<Resolved>},
      {"sphere_shell", {"radius"}, sphere_shell<double>, sphere_shell<Resolved>},
      {"box_shell", {"size"}, box_shell<double>, box_shell<Resolved>},
      {"tube", {"radius", "length"}, tube<double>, tube<Resolved>},
      {"cylinder_shell", {"radius", "length"}, cylinder_shell<double>, cylinder_shell<Resolved>},
      {"cone_shell", {"radius", "length"}, cone_shell<double>, cone_shell<Resolved>},
      {"capsule_shell", {"radius", "length"}, capsule_shell<double>, capsule_shell<Resolved>},
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

template <class S>
Unit<S> unit_of(const std::string& name, const std::vector<double>& size) {
  const std::string fault = primitive_fault(name, size);
  if (!fault.empty()) throw InputError(fault);
  return shape_named(name)->unit<S>(size);
}

template <class S>
Mat3T<S> point_inertia(const Vec3T<S>& d) {
  return Mat3T<S>(d.squaredNorm() * Mat3T<S>::Identity() - d * d.transpose());
}

template <class S>
void drop_rounding(Mat3T<S>& inertia) {
  using std::abs;
  const S floor = 8 * epsilon<S>() * inertia.cwiseAbs().maxCoeff();
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (i != j && abs(inertia(i, j)) <= floor) inertia(i, j) = S(0);
}

/// A, symmetric, becomes diagonal by turns in the planes of two axes; V collects them: V diag V^T is what A
/// was. Source: Golub & Van Loan, Matrix Computations, 8.5.
template <class S>
void diagonalise(Mat3T<S>& A, Mat3T<S>& V) {
  using std::abs;
  using std::sqrt;
  V = Mat3T<S>::Identity();
  for (int sweep = 0; sweep < 60; ++sweep) {
    bool turned = false;
    for (int p = 0; p < 2; ++p)
      for (int q = p + 1; q < 3; ++q) {
        // Not against the largest entry, but against the two that it stands between: small moments keep their
        // digits.
        if (A(p, q) == S(0) ||
            abs(A(p, q)) <= epsilon<S>() * epsilon<S>() * sqrt(S(abs(A(p, p) * A(q, q))))) {
          A(p, q) = A(q, p) = S(0);
          continue;
        }
        turned = true;
        const S cot = (A(q, q) - A(p, p)) / (S(2) * A(p, q));
        const S t = (cot < S(0) ? S(-1) : S(1)) / (abs(cot) + sqrt(S(cot * cot + S(1))));
        const S c = S(1) / sqrt(S(t * t + S(1))), s = t * c;
        const int r = 3 - p - q;
        const S along = t * A(p, q), rp = A(r, p), rq = A(r, q);
        A(p, p) -= along;
        A(q, q) += along;
        A(p, q) = A(q, p) = S(0);
        A(r, p) = A(p, r) = c * rp - s * rq;
        A(r, q) = A(q, r) = s * rp + c * rq;
        const Vec3T<S> vp = V.col(p), vq = V.col(q);
        V.col(p) = c * vp - s * vq;
        V.col(q) = s * vp + c * vq;
      }
    if (!turned) return;
  }
}

/// Of a rotation matrix, by its largest component.
template <class S>
QuaternionT<S> unit_quaternion(const Mat3T<S>& R) {
  const Eigen::Matrix<S, 4, 1> squares(S(1) + R(0, 0) + R(1, 1) + R(2, 2), S(1) + R(0, 0) - R(1, 1) - R(2, 2),
                                       S(1) - R(0, 0) + R(1, 1) - R(2, 2),
                                       S(1) - R(0, 0) - R(1, 1) + R(2, 2));
  int at = 0;
  for (int i = 1; i < 4; ++i)
    if (squares[i] > squares[at]) at = i;
  const S a = R(2, 1) - R(1, 2), b = R(0, 2) - R(2, 0), c = R(1, 0) - R(0, 1);
  const S d = R(0, 1) + R(1, 0), e = R(0, 2) + R(2, 0), f = R(1, 2) + R(2, 1);
  QuaternionT<S> q;
  switch (at) {
    case 0:
      q = QuaternionT<S>(squares[0], a, b, c);
      break;
    case 1:
      q = QuaternionT<S>(a, squares[1], d, e);
      break;
    case 2:
      q = QuaternionT<S>(b, d, squares[2], f);
      break;
    default:
      q = QuaternionT<S>(c, e, f, squares[3]);
  }
  return normalised<S>(q);
}

}  // namespace

template <class S>
MassPropertiesT<S> mass_properties(const std::vector<PointMass>& particles) {
  std::vector<MassPropertiesT<S>> parts;
  for (const PointMass& p : particles)
    parts.push_back({S(p.mass), p.position.template cast<S>(), Mat3T<S>::Zero()});
  return joined<S>(parts);
}

template <class S>
MassPropertiesT<S> primitive(const std::string& shape, const std::vector<double>& size,
                             const std::type_identity_t<S>& mass) {
  const Unit<S> unit = unit_of<S>(shape, size);
  return {mass, Vec3T<S>(S(0), S(0), unit.center_z), Vec3T<S>(mass * unit.moments).asDiagonal()};
}

template <class S>
S primitive_volume(const std::string& shape, const std::vector<double>& size) {
  return unit_of<S>(shape, size).measure;
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
  // In the wide type: a thin wall is a difference that a double may lose.
  const Unit<Resolved> unit = shape->unit<Resolved>(size);
  bool computable = std::isnormal(static_cast<double>(unit.measure));
  for (int i = 0; i < 3; ++i) computable = computable && std::isnormal(static_cast<double>(unit.moments[i]));
  if (!computable || !(unit.moments.minCoeff() > Resolved(0)))
    return name + " with lengths too large or too small to compute with";
  return "";
}

template <class S>
MassPropertiesT<S> placed(const MassPropertiesT<S>& part, const std::type_identity_t<QuaternionT<S>>& q,
                          const std::type_identity_t<Vec3T<S>>& d) {
  const Mat3T<S> R = rotation_matrix<S>(q);
  const Mat3T<S> turned = R * part.inertia * R.transpose();
  return {part.mass, Vec3T<S>(d + R * part.center), Mat3T<S>((turned + turned.transpose()) / S(2))};
}

template <class S>
MassPropertiesT<S> joined(const std::vector<MassPropertiesT<std::type_identity_t<S>>>& parts) {
  MassPropertiesT<S> whole;
  for (const auto& p : parts) {
    whole.mass += p.mass;
    whole.center += p.mass * p.center;
  }
  if (whole.mass > S(0)) whole.center /= whole.mass;
  // About the common centre, not the origin: far from the origin the difference of the two would lose digits.
  for (const auto& p : parts) whole.inertia += inertia_about<S>(p, Vec3T<S>(p.center - whole.center));
  drop_rounding(whole.inertia);
  return whole;
}

template <class S>
Mat3T<S> inertia_about(const MassPropertiesT<S>& body, const std::type_identity_t<Vec3T<S>>& d) {
  return Mat3T<S>(body.inertia + body.mass * point_inertia<S>(d));
}

template <class S>
PrincipalAxesT<S> principal_axes(const Mat3T<std::type_identity_t<S>>& inertia) {
  using std::abs;
  using std::sqrt;
  const QuaternionT<S> identity(S(1), S(0), S(0), S(0));
  const bool diagonal = inertia(0, 1) == S(0) && inertia(0, 2) == S(0) && inertia(1, 2) == S(0);
  const S size = inertia.cwiseAbs().maxCoeff();
  // What is not finite is for inertia_fault to refuse.
  if (diagonal || !(size <= std::numeric_limits<S>::max())) return {inertia.diagonal(), identity};
  Mat3T<S> values = inertia / size, vectors;
  diagonalise(values, vectors);

  // Number and sign the axes so that the rotation from the given ones is the smallest of the 24.
  std::array<int, 3> order{0, 1, 2}, best = order;
  S best_sum(-1);
  do {
    S sum(0);
    for (int i = 0; i < 3; ++i) sum += abs(vectors(i, order[static_cast<std::size_t>(i)]));
    if (sum > best_sum) {
      best_sum = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  Mat3T<S> R;
  Vec3T<S> moments;
  for (int i = 0; i < 3; ++i) {
    const int from = best[static_cast<std::size_t>(i)];
    R.col(i) = vectors.col(from) * S(vectors(i, from) < S(0) ? -1 : 1);
    moments[i] = values(from, from) * size;
  }
  if (R.determinant() < S(0)) {
    int weakest = 0;
    for (int i = 1; i < 3; ++i)
      if (R(i, i) < R(weakest, weakest)) weakest = i;
    R.col(weakest) = -R.col(weakest);
  }
  // Of a tensor of doubles, two moments are equal or differ by far more than this: a polynomial in its
  // entries vanishes or does not.
  if constexpr (!std::is_floating_point_v<S>) {
    const S same = sqrt(epsilon<S>()) * size;
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 2), std::pair(0, 1)})
      if (abs(moments[i] - moments[j]) <= same) moments[i] = moments[j];
    for (int i = 0; i < 3; ++i)
      if (abs(moments[i]) <= same) moments[i] = S(0);
  }
  return {moments, unit_quaternion<S>(R)};
}

template <class S>
InertiaFault inertia_fault(const Vec3T<std::type_identity_t<S>>& wide_moments, bool physical) {
  using std::abs;
  const Vec3 moments(static_cast<double>(wide_moments[0]), static_cast<double>(wide_moments[1]),
                     static_cast<double>(wide_moments[2]));
  const S largest = wide_moments.maxCoeff();
  const auto fault = [&](const std::string& condition, bool only_unphysical = false) {
    return InertiaFault{"principal moments I1 = " + number_text(moments[0]) +
                            ", I2 = " + number_text(moments[1]) + ", I3 = " + number_text(moments[2]) +
                            " kg m^2 break " + condition,
                        only_unphysical};
  };
  const auto name = [](int i) { return std::string("I") + std::to_string(i + 1); };
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(moments[i])) return fault(name(i) + " finite");
  // In doubles, less than 1e-14 of the largest is what rounding leaves of zero when a rod is diagonalised.
  const S zero = std::is_floating_point_v<S> ? S(1e-14) * largest : S(0);
  for (int i = 0; i < 3; ++i) {
    // Of masses on a line the other two moments are equal, to the rounding of what was given.
    const S &other = wide_moments[(i + 1) % 3], &third = wide_moments[(i + 2) % 3];
    const bool on_line = abs(S(other - third)) <= S(1e-6) * largest;
    if (wide_moments[i] >= S(0) && wide_moments[i] <= zero && largest > S(0))
      return fault(name(i) + (on_line ? " > 0: all mass lies on a line, and about it there is nothing to turn"
                                      : " > 0"));
    if (!(wide_moments[i] > S(0))) return fault(name(i) + " > 0");
    if (!std::isnormal(moments[i]) || !std::isfinite(1 / moments[i]) || !std::isfinite(moments.sum()))
      return fault(name(i) + " and 1/" + name(i) + " within the range of double precision");
  }
  for (int i = 0; i < 3 && physical; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    if (wide_moments[j] + wide_moments[k] < wide_moments[i] - S(1e-6) * largest)
      return fault(
          "the triangle inequality " + name(std::min(j, k)) + " + " + name(std::max(j, k)) + " >= " + name(i),
          true);
  }
  return {};
}

#define POLHODE_IN(S)                                                                                       \
  template MassPropertiesT<S> mass_properties<S>(const std::vector<PointMass>&);                            \
  template MassPropertiesT<S> primitive<S>(const std::string&, const std::vector<double>&, const S&);       \
  template S primitive_volume<S>(const std::string&, const std::vector<double>&);                           \
  template MassPropertiesT<S> placed<S>(const MassPropertiesT<S>&, const QuaternionT<S>&, const Vec3T<S>&); \
  template MassPropertiesT<S> joined<S>(const std::vector<MassPropertiesT<S>>&);                            \
  template Mat3T<S> inertia_about<S>(const MassPropertiesT<S>&, const Vec3T<S>&);                           \
  template PrincipalAxesT<S> principal_axes<S>(const Mat3T<S>&);                                            \
  template InertiaFault inertia_fault<S>(const Vec3T<S>&, bool);
POLHODE_IN(double)
POLHODE_IN(Resolved)
#undef POLHODE_IN

}  // namespace polhode
