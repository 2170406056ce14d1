// Mass properties against sums and integrals that are done here in another way than in the library: slices
// and rings for what is round, walls and plates for boxes, particles for the rest.
#include "models/mass_properties.hpp"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/errors.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;
constexpr double pi = std::numbers::pi;

// Measure, centre on the axis, and moments about the centre for unit density.
struct Integrals {
  double measure = 0, first = 0, axial = 0, transverse = 0;  // the last two about the origin
  double center() const { return first / measure; }
  double axial_per_mass() const { return axial / measure; }
  double transverse_per_mass() const { return transverse / measure - center() * center(); }
};

constexpr int slices = 4000;

// A solid of revolution cut into rings a >= r >= b across the axis; z runs with u in [0, 1].
Integrals solid(const std::function<double(double)>& z, const std::function<double(double)>& outer,
                const std::function<double(double)>& inner) {
  Integrals sum;
  for (int i = 0; i < slices; ++i) {
    const double u = (i + 0.5) / slices, dz = z((i + 1.0) / slices) - z(double(i) / slices);
    const double a2 = std::pow(outer(u), 2), b2 = std::pow(inner(u), 2), volume = pi * (a2 - b2) * dz;
    sum.measure += volume;
    sum.first += volume * z(u);
    sum.axial += volume * (a2 + b2) / 2;
    sum.transverse += volume * ((a2 + b2) / 4 + z(u) * z(u));
  }
  return sum;
}

// A surface of revolution cut into hoops along its profile (r, z)(u).
Integrals& add_surface(Integrals& sum, const std::function<double(double)>& r,
                       const std::function<double(double)>& z) {
  for (int i = 0; i < slices; ++i) {
    const double u = (i + 0.5) / slices, u0 = double(i) / slices, u1 = (i + 1.0) / slices;
    const double area = 2 * pi * r(u) * std::hypot(r(u1) - r(u0), z(u1) - z(u0));
    sum.measure += area;
    sum.first += area * z(u);
    sum.axial += area * r(u) * r(u);
    sum.transverse += area * (r(u) * r(u) / 2 + z(u) * z(u));
  }
  return sum;
}

// The midpoint rule in u errs by the second derivative over 24 N^2, N = 4000: 3e-9 times the derivatives of
// profiles like sin(pi u), pi^2 to pi^4: below 3e-7.
constexpr double quadrature = 5e-7;

void expect_round(const std::string& shape, const std::vector<double>& size, const Integrals& expected) {
  SCOPED_TRACE(shape);
  const double mass = 2.5;
  const MassProperties body = primitive(shape, size, mass);
  EXPECT_EQ(body.mass, mass);
  EXPECT_NEAR(primitive_volume(shape, size) / expected.measure, 1, quadrature);
  EXPECT_NEAR(body.center.z(), expected.center(), quadrature);
  EXPECT_EQ(body.center.head<2>().norm(), 0);
  EXPECT_NEAR(body.inertia(2, 2) / (mass * expected.axial_per_mass()), 1, quadrature);
  EXPECT_NEAR(body.inertia(0, 0) / (mass * expected.transverse_per_mass()), 1, quadrature);
  EXPECT_EQ(body.inertia(0, 0), body.inertia(1, 1));
  EXPECT_TRUE(body.inertia.isDiagonal(0));
}

auto constant(double c) {
  return [c](double) { return c; };
}
auto line(double from, double to) {
  return [=](double u) { return from + u * (to - from); };
}
auto sine(double size, double offset = 0) {  // over the half circle from -90 to 90 degrees
  return [=](double u) { return offset + size * std::sin(pi * (u - 0.5)); };
}
auto cosine(double size, double offset = 0) {
  return [=](double u) { return offset + size * std::cos(pi * (u - 0.5)); };
}

TEST(MassProperties, SolidsOfRevolutionAreTheSumOfTheirSlices) {
  const double r = 0.7, l = 1.9;
  expect_round("cylinder", {r, l}, solid(line(-l / 2, l / 2), constant(r), constant(0)));
  expect_round("hollow_cylinder", {r, 0.4, l}, solid(line(-l / 2, l / 2), constant(r), constant(0.4)));
  expect_round("sphere", {r}, solid(sine(r), cosine(r), constant(0)));
  expect_round("ellipsoid", {r, r, l}, solid(sine(l), cosine(r), constant(0)));
  expect_round("cone", {r, l}, solid(line(0, l), line(r, 0), constant(0)));
  expect_round("torus", {l, r}, solid(sine(r), cosine(r, l), cosine(-r, l)));

  Integrals caps = solid(sine(r), cosine(r), constant(0)),
            capsule = solid(line(-l / 2, l / 2), constant(r), constant(0));
  // Each half of the ball moves out by l/2: integral of (|z| + l/2)^2 = z^2 + l |z| + l^2/4.
  const double half_first = pi * r * r * r * r / 4;  // of |z| over half a ball
  capsule.measure += caps.measure;
  capsule.axial += caps.axial;
  capsule.transverse += caps.transverse + l * 2 * half_first + l * l / 4 * caps.measure;
  expect_round("capsule", {r, l}, capsule);

  Integrals hollow = solid(sine(r), cosine(r), constant(0));
  const Integrals hole = solid(sine(0.6), cosine(0.6), constant(0));
  hollow.measure -= hole.measure;
  hollow.axial -= hole.axial;
  hollow.transverse -= hole.transverse;
  expect_round("hollow_sphere", {r, 0.6}, hollow);
}

TEST(MassProperties, ShellsAreTheSumOfTheirHoops) {
  const double r = 0.7, l = 1.9;
  Integrals sphere, tube, closed, cone, capsule, disc;
  expect_round("sphere_shell", {r}, add_surface(sphere, cosine(r), sine(r)));
  expect_round("tube", {r, l}, add_surface(tube, constant(r), line(-l / 2, l / 2)));
  add_surface(closed, constant(r), line(-l / 2, l / 2));
  add_surface(closed, line(0, r), constant(l / 2));
  expect_round("cylinder_shell", {r, l}, add_surface(closed, line(0, r), constant(-l / 2)));
  expect_round("cone_shell", {r, l}, add_surface(cone, line(r, 0), line(0, l)));
  add_surface(capsule, constant(r), line(-l / 2, l / 2));
  for (const double side : {-1.0, 1.0})
    add_surface(
        capsule, [&](double u) { return r * std::cos(pi / 2 * u); },
        [&](double u) { return side * (l / 2 + r * std::sin(pi / 2 * u)); });
  expect_round("capsule_shell", {r, l}, capsule);
  expect_round("disc", {r}, add_surface(disc, line(0, r), constant(0)));
}

TEST(MassProperties, AGridOfParticlesIsABoxButForTheSizeOfItsCells) {
  // n particles along an edge a, at the middles of n cells: sum of x^2 is m a^2/12 (1 - 1/n^2) exactly.
  const Vec3 edge(0.1, 0.4, 0.9);
  const int n = 10;
  std::vector<PointMass> particles;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k)
        particles.push_back({10.0 / (n * n * n), edge.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5)) / n});
  const MassProperties cloud = mass_properties(particles), box = primitive("box", {0.1, 0.4, 0.9}, 10);
  EXPECT_NEAR(cloud.mass, 10, 1e-12);  // 1000 additions of rounding 1e-15 each
  EXPECT_LT((cloud.center - edge / 2).norm(), 1e-13);
  EXPECT_LT((cloud.inertia - box.inertia * (1 - 1.0 / (n * n))).norm(), 1e-13);
  // The published inertia of the tumbling box is that of this box, to its eight digits.
  EXPECT_LT((box.inertia.diagonal() - Vec3(0.80833333, 0.68333333, 0.14166667)).cwiseAbs().maxCoeff(), 5e-9);
}

TEST(MassProperties, AHollowBoxIsItsSixWallsAndAThinOneItsShell) {
  const Vec3 outer(1.0, 1.4, 2.2);
  const auto walls = [&](const Vec3& t) {  // thickness along each axis; density 1
    std::vector<MassProperties> parts;
    const auto add = [&](const Vec3& s, const Vec3& at) {
      parts.push_back(placed(primitive("box", {s[0], s[1], s[2]}, s.prod()), Quaternion(1, 0, 0, 0), at));
    };
    for (const double side : {-0.5, 0.5}) {
      add({t[0], outer[1], outer[2]}, {side * (outer[0] - t[0]), 0, 0});
      add({outer[0] - 2 * t[0], t[1], outer[2]}, {0, side * (outer[1] - t[1]), 0});
      add({outer[0] - 2 * t[0], outer[1] - 2 * t[1], t[2]}, {0, 0, side * (outer[2] - t[2])});
    }
    return joined(parts);
  };
  const Vec3 thick(0.1, 0.2, 0.3), inner = outer - 2 * thick;
  const std::vector<double> size = {outer[0], outer[1], outer[2], inner[0], inner[1], inner[2]};
  const MassProperties compound = walls(thick);
  EXPECT_NEAR(primitive_volume("hollow_box", size), compound.mass, 1e-14);
  EXPECT_LT((primitive("hollow_box", size, compound.mass).inertia - compound.inertia).norm(), 1e-14);

  // Thickness 1e-6 of walls about 1 m wide: the shell is its limit, with an error of the same size.
  const MassProperties thin = walls(Vec3::Constant(1e-6));
  EXPECT_LT(
      (primitive("box_shell", {1.0, 1.4, 2.2}, thin.mass).inertia / thin.mass - thin.inertia / thin.mass)
          .norm(),
      1e-5);
  EXPECT_NEAR(primitive_volume("box_shell", {1.0, 1.4, 2.2}), thin.mass / 1e-6, 1e-4);
}

TEST(MassProperties, AnEllipsoidKnowsItsAxesApart) {
  // m (b^2 + c^2)/5 about the first semi-axis, and cyclic: 2 (4 + 9)/5, 2 (9 + 1)/5, 2 (1 + 4)/5
  const MassProperties e = primitive("ellipsoid", {1, 2, 3}, 2);
  EXPECT_LT((e.inertia.diagonal() - Vec3(5.2, 4.0, 2.0)).norm(), 1e-15);
}

TEST(MassProperties, ProductsOfInertiaOfParticlesAreMinusTheSumOfMxy) {
  // Two particles of 3 kg at +-(1, 2, 0): I_xx = 2*3*4, I_yy = 2*3*1, I_zz = 2*3*5, I_xy = -2*3*2
  const MassProperties body = mass_properties({{3, {1, 2, 0}}, {3, {-1, -2, 0}}});
  Mat3 expected;
  expected << 24, -12, 0, -12, 6, 0, 0, 0, 30;
  EXPECT_EQ(body.inertia, expected);
  EXPECT_EQ(body.center, Vec3::Zero());
  // About a point: a single particle has nothing but m d^2.
  const Mat3 about = inertia_about(mass_properties({{2, {5, 5, 5}}}), Vec3(0, 0, 3));
  EXPECT_EQ(about, Mat3(Vec3(18, 18, 0).asDiagonal()));
}

TEST(MassProperties, TurningAndMovingABodyTurnsAndMovesItsParticles) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Quaternion q = normalised(Quaternion(0.3, -0.5, 0.7, 0.2));
  const Vec3 d(0.4, -1.2, 0.8);
  std::vector<PointMass> before, after;
  for (int i = 0; i < 20; ++i) {
    const PointMass p{1.5 + uniform(random), Vec3(uniform(random), uniform(random), uniform(random))};
    before.push_back(p);
    after.push_back({p.mass, d + to_space<double>(q, p.position)});
  }
  const MassProperties moved = placed(mass_properties(before), q, d), direct = mass_properties(after);
  // Sums of 20 terms of size 10 at most: 20 * 10 * 2e-16.
  EXPECT_LT((moved.inertia - direct.inertia).norm(), 5e-14);
  EXPECT_LT((moved.center - direct.center).norm(), 5e-15);
  EXPECT_NEAR(moved.mass, direct.mass, 1e-14);
}

TEST(MassProperties, TwoHalvesAreTheWholeAlsoFarFromTheOrigin) {
  const MassProperties whole = primitive("box", {1, 2, 3}, 6), half = primitive("box", {1, 2, 1.5}, 3);
  for (const double far : {0.0, 1e6}) {
    const Vec3 at(far, far, far), up(0, 0, 0.75);
    const Quaternion none(1, 0, 0, 0);
    const MassProperties both = joined({placed(half, none, at + up), placed(half, none, at - up)});
    // The positions themselves are rounded to 1e-10 at 1e6 m; nothing larger, such as m d^2 eps = 1e-3, may
    // enter.
    EXPECT_LT((both.inertia - whole.inertia).norm(), far > 0 ? 1e-8 : 1e-14) << far;
    EXPECT_LT((both.center - at).norm(), far > 0 ? 1e-9 : 1e-15);
  }
}

TEST(MassProperties, APartTurnedByARightAngleLeavesATensorThatIsExactlyDiagonal) {
  const MassProperties rod = primitive("cylinder", {0.01, 0.2}, 0.3);
  const MassProperties body = joined({placed(rod, Quaternion(1, 0, 1, 0), Vec3::Zero()),
                                      placed(rod, Quaternion(1, -1, 0, 0), Vec3(0, 0.1, 0))});
  EXPECT_TRUE(body.inertia.isDiagonal(0));
  EXPECT_EQ(principal_axes(body.inertia).principal_to_given.coeffs(), Quaternion(1, 0, 0, 0).coeffs());
}

TEST(PrincipalAxes, OfADiagonalTensorAreLeftAsTheyAre) {
  const Vec3 moments(0.80833333, 0.14166667, 0.68333333);
  const PrincipalAxes axes = principal_axes(moments.asDiagonal());
  EXPECT_EQ(axes.moments, moments);
  EXPECT_EQ(axes.principal_to_given.coeffs(), Quaternion(1, 0, 0, 0).coeffs());
}

TEST(PrincipalAxes, GiveTheTensorBackAndKeepTheNumberingOfNearbyAxes) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 500; ++i) {
    const Vec3 moments = Vec3(2, 3, 4) + 0.3 * Vec3(normal(random), normal(random), normal(random));
    const double size = i < 250 ? 0.3 : 3.0;
    const Vec3 turn = Vec3(normal(random), normal(random), normal(random)).normalized() * size;
    const Mat3 R = exp_rotation_matrix<double>(turn);
    const Mat3 I = R * moments.asDiagonal() * R.transpose();
    const PrincipalAxes axes = principal_axes(0.5 * (I + I.transpose()));
    const Mat3 P = rotation_matrix<double>(axes.principal_to_given);
    EXPECT_NEAR(P.determinant(), 1, 1e-15 * 8);
    EXPECT_NEAR(squared_norm(axes.principal_to_given), 1, 1e-15);
    // Backward stable: a few eps of |I|, here 1e-15 * 8.
    EXPECT_LT((P * axes.moments.asDiagonal() * P.transpose() - I).norm(), 3e-14);
    // The worst of the 24 frames nearest to a given one is 62.8 degrees off (the deltoid of the cube group).
    EXPECT_LT(attitude_error(Quaternion(1, 0, 0, 0), axes.principal_to_given), 1.1);
    if (size < 0.5) {
      EXPECT_LT((axes.moments - moments).norm(), 1e-13);
    }
  }
}

TEST(InertiaFault, NamesTheConditionAndPrintsTheMoments) {
  const std::string wrong = inertia_fault(Vec3(0.5, 2, 3), true).text;
  EXPECT_THAT(wrong, HasSubstr("I1 + I2 >= I3"));
  EXPECT_THAT(wrong, HasSubstr("I1 = 0.5, I2 = 2, I3 = 3"));
  EXPECT_EQ(inertia_fault(Vec3(0.5, 2, 3), false).text, "");
  EXPECT_THAT(inertia_fault(Vec3(3, 0.5, 2), true).text, HasSubstr("I2 + I3 >= I1"));
  EXPECT_THAT(inertia_fault(Vec3(2, 3, 0.5), true).text, HasSubstr("I1 + I3 >= I2"));
  for (const bool physical : {true, false}) {
    EXPECT_THAT(inertia_fault(Vec3(1, 1, 0), physical).text, HasSubstr("I3 > 0"));
    EXPECT_THAT(inertia_fault(Vec3(-1, 1, 1), physical).text, HasSubstr("I1 > 0"));
    EXPECT_THAT(inertia_fault(Vec3(0, 0, 0), physical).text, HasSubstr("I1 > 0"));
    EXPECT_THAT(inertia_fault(Vec3(1, std::nan(""), 1), physical).text, HasSubstr("I2 finite"));
    EXPECT_THAT(inertia_fault(Vec3(1, 1, INFINITY), physical).text, HasSubstr("I3 finite"));
    EXPECT_THAT(inertia_fault(Vec3::Constant(1e-320), physical).text, HasSubstr("range"));
  }
}

TEST(InertiaFault, AllowsFlatBodiesWhoseDigitsWereRounded) {
  EXPECT_EQ(inertia_fault(Vec3(0.25, 0.25, 0.5), true).text, "");  // a disc, exactly
  // 1/3 + 1/3 = 2/3 in seven digits: 0.6666667 misses by 1e-7, and in three digits by 1e-3: that is an error
  EXPECT_EQ(inertia_fault(Vec3(0.3333333, 0.3333333, 0.6666667), true).text, "");
  EXPECT_NE(inertia_fault(Vec3(0.333, 0.333, 0.667), true).text, "");
  EXPECT_EQ(inertia_fault(Vec3(1e-5, 1, 1.000005), true).text, "");  // a needle
  // Collinear particles have no moment about their line, however it lies.
  const auto rod = mass_properties({{1, {1, 2, 3}}, {1, {-1, -2, -3}}, {2, {2, 4, 6}}});
  EXPECT_THAT(inertia_fault(principal_axes(rod.inertia).moments, true).text, HasSubstr("lies on a line"));
  // A moment of zero beside two that differ is no line.
  EXPECT_THAT(inertia_fault(Vec3(1, 2, 0), true).text, testing::Not(HasSubstr("line")));
  EXPECT_THAT(inertia_fault(Vec3(0, 0, 1), true).text, testing::Not(HasSubstr("line")));
}

TEST(Primitive, RefusesLengthsThatLeaveNoBody) {
  for (const auto& shape : primitive_shapes()) {
    EXPECT_FALSE(primitive_needs(shape).empty());
    EXPECT_THROW(primitive(shape, {}, 1), InputError) << shape;
    EXPECT_THROW(primitive(shape, {1, 2, 3, 4, 5, 6, 7}, 1), InputError) << shape;
  }
  EXPECT_THAT(primitive_fault("sphere", {-1}), HasSubstr("-1"));
  EXPECT_THAT(primitive_fault("hollow_sphere", {1, 1}),
              HasSubstr("inner_radius 1 is not less than its radius 1"));
  EXPECT_THAT(primitive_fault("hollow_box", {1, 1, 1, 0.5, 2, 0.5}), HasSubstr("inner_size 2"));
  EXPECT_THAT(primitive_fault("torus", {1, 2}), HasSubstr("tube_radius"));
  EXPECT_THAT(primitive_fault("sphere", {1e200}), HasSubstr("too large"));
  EXPECT_THAT(primitive_fault("cube", {1}), HasSubstr("box"));
}

}  // namespace
}  // namespace polhode
