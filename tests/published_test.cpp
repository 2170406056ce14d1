// Numbers that others have published, each to its last printed digit: physics engines and their benchmarks,
// test sets for differential equations, multibody codes, papers. Where the published problem has decimal
// inputs and more digits than a double, it is solved here in 50 digits from the decimals; a scene has the
// nearest doubles instead.
#include <cmath>
#include <numbers>

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <gtest/gtest.h>

#include "experiments/truth.hpp"
#include "models/model.hpp"
#include "models/newton_euler.hpp"
#include "models/taylor_series.hpp"
#include "solvers/registry.hpp"
#include "solvers/runge_kutta_4.hpp"
#include "tests/command.hpp"
#include "tests/reference_cases.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using namespace reference_cases;
using WideVec = Vec3T<Wide>;

/// |got - printed| is at most half a unit of the last printed digit, and `slack` for what got itself may be
/// off by.
void expect_digits(const Wide& got, const std::string& printed, double slack = 0) {
  const std::size_t exponent = printed.find('e'), point = printed.find('.');
  const std::size_t decimals =
      point == std::string::npos ? 0 : std::min(exponent, printed.size()) - point - 1;
  const int power = exponent == std::string::npos ? 0 : std::stoi(printed.substr(exponent + 1));
  const double half_unit = 0.5 * std::pow(10, power - static_cast<double>(decimals));
  const double gap = Wide(abs(Wide(got - Wide(printed)))).convert_to<double>();
  EXPECT_LE(gap, half_unit * (1 + 1e-12) + slack) << "got " << got.str(20) << ", printed " << printed;
}

/// The flow of a model in 50 digits, by equal steps of its Taylor series of order 40.
template <class M>
typename M::State flow(const M& m, const Wide& t_end, int steps) {
  TaylorSeries<M> series(m, 40);
  typename M::State y = m.initial;
  const Wide h = t_end / steps;
  for (int i = 0; i < steps; ++i) {
    series.expand(Wide(h * i), y);
    y = series.at(h);
  }
  return y;
}

using FreeBody = Model<Wide, Rotation<Wide, Free>, NoTranslation>;
using FreeRates = Model<Wide, Rotation<Wide, Free, Shape::triaxial, AttitudePart::absent>, NoTranslation>;

FreeBody free_body(const WideVec& moments, const WideVec& w0) {
  return {{moments, {}}, {}, {Wide(1), Wide(0), Wide(0), Wide(0), w0.x(), w0.y(), w0.z()}};
}
FreeRates free_rates(const WideVec& moments, const WideVec& w0) {
  return {{moments, {}}, {}, {w0.x(), w0.y(), w0.z()}};
}
WideVec decimals(const char* x, const char* y, const char* z) { return {Wide(x), Wide(y), Wide(z)}; }

Scene body(const Vec3& moments, const Vec3& w0, double duration) {
  Scene s;
  s.duration = duration;
  s.rotation.emplace();
  s.rotation->moments = moments;
  s.rotation->w0 = w0;
  return s;
}

Trajectory run(const std::string& solver, const Scene& scene, const Grid& grid, const Setting& setting = {}) {
  const Prepared p = find_method(solver).prepare(scene, setting);
  Trajectory out;
  EXPECT_TRUE(p.integrate) << solver << ": " << p.unsupported;
  if (p.integrate) p.integrate(grid, out);
  EXPECT_EQ(out.outcome, Outcome::ok) << solver << ": " << out.reason;
  return out;
}
Grid to_the_end(double end, std::int64_t steps) {
  Grid g;
  g.from_start = true;
  g.stretches.push_back({end, steps, end / static_cast<double>(steps)});
  return g;
}

/// Rounding every number of a scene to a double moves its solution by at most this: ten numbers or fewer,
/// half an ulp (1.1e-16) each, times the growth of a perturbation.
double effect_of_doubles(const Scene& scene) {
  const std::vector<double> end{scene.duration};
  return 10 * 1.2e-16 * truth_of(scene, end)->floor().conditioning;
}

/// Runs the program and returns the columns of the CSV that it prints.
std::map<std::string, std::vector<std::string>> printed_by(const std::string& arguments) {
  const CommandResult r = polhode_command(arguments);
  EXPECT_EQ(r.exit_code, 0) << arguments << '\n' << r.err;
  return columns_of(r.out);
}

// ---- Test sets for differential equations ----

TEST(Published, HairerVilmartBody) {
  // J. Phys. A 39 (2006) 13225: body momentum and attitude at t = 10, 17 decimals.
  const WideVec I = decimals("0.6", "0.8", "1"), m0 = decimals("1.8", "0.4", "-0.9");
  const auto y = flow(free_body(I, m0.cwiseQuotient(I)), Wide(10), 100);
  const char* m[] = {"1.76596250851820754", "-0.69546419703308912", "0.77955498148187109"};
  const char* q[] = {"-0.73606136416079394", "-0.57078695124035073", "-0.29938857183079009",
                     "-0.20683908610467319"};
  for (std::size_t i = 0; i < 4; ++i) expect_digits(y[i], q[i]);
  for (int i = 0; i < 3; ++i) expect_digits(I[i] * y[static_cast<std::size_t>(i + 4)], m[i]);

  const Scene scene = find_scene("hairer-vilmart");
  const double rounding = effect_of_doubles(scene);
  const auto columns = printed_by("simulate hairer-vilmart --digits 20");
  ASSERT_EQ(columns.at("qw").size(), 2u);
  const char* names[] = {"qw", "qx", "qy", "qz"};
  for (std::size_t i = 0; i < 4; ++i) expect_digits(Wide(columns.at(names[i])[1]), q[i], rounding);

  // An adaptive solver at a fine tolerance: every step adds a local error of rtol and some rounding, and each
  // grows by the conditioning at most.
  const Setting fine{.knob = Knob::tolerance, .rtol = 1e-14, .atol = 1e-14};
  const Trajectory t = run("odeint-rkf78", scene, to_the_end(10, 1), fine);
  const std::vector<double> end{10.0};
  const double bound = static_cast<double>(t.work.steps) * 2e-14 * truth_of(scene, end)->floor().conditioning;
  EXPECT_LT(bound, 1e-10);
  const Sample& s = t.samples.back();
  const double got[] = {s.q.w(), s.q.x(), s.q.y(), s.q.z()};
  for (std::size_t i = 0; i < 4; ++i) expect_digits(Wide(got[i]), q[i], bound);
}

TEST(Published, TumblingBoxAtTenSeconds) {
  const WideVec I = decimals("0.80833333", "0.68333333", "0.14166667"), w0 = decimals("0.1", "5", "0.1");
  const auto y = flow(free_body(I, w0), Wide(10), 250);
  const char* w[] = {"2.75583887620128821", "-3.73596515670833006", "-3.16180722449863095"};
  const char* q[] = {"0.22516442045649994", "-0.61992762658906863", "-0.27702897036680045",
                     "0.69874578433765395"};
  const Wide sign = y[0] < 0 ? Wide(-1) : Wide(1);
  for (std::size_t i = 0; i < 4; ++i) expect_digits(sign * y[i], q[i]);
  for (std::size_t i = 0; i < 3; ++i) expect_digits(y[i + 4], w[i]);

  const Scene scene = find_scene("tumbling-box");
  const auto columns = printed_by("simulate tumbling-box --digits 20");
  const char* names[] = {"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};
  for (std::size_t i = 0; i < 3; ++i)
    expect_digits(Wide(columns.at(names[i]).back()), w[i], 5 * effect_of_doubles(scene));  // |w| = 5.6

  const Setting fine{.knob = Knob::tolerance, .rtol = 1e-14, .atol = 1e-14};
  const Trajectory t = run("odeint-rkf78", scene, to_the_end(10, 1), fine);
  const std::vector<double> end{10.0};
  const double bound =
      static_cast<double>(t.work.steps) * 2e-14 * truth_of(scene, end)->floor().conditioning * 6;
  EXPECT_LT(bound, 1e-7);
  for (int i = 0; i < 3; ++i) expect_digits(Wide(t.samples.back().w_B[i]), w[i], bound);
}

TEST(Published, EulersEquationsWithTheTextbookInertia) {
  const auto y = flow(free_rates(decimals("0.5", "2", "3"), decimals("1", "0", "0.9")), Wide(20), 200);
  const char* w[] = {"0.606203853964812222", "0.628747210450177970", "0.807385148575602576"};
  const char* names[] = {"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};
  const double rounding = 2 * effect_of_doubles(find_scene("euler-equations"));  // |w| <= 1.6
  const auto columns = printed_by("simulate euler-equations --digits 20");
  for (std::size_t i = 0; i < 3; ++i) {
    expect_digits(y[i], w[i]);
    expect_digits(Wide(columns.at(names[i]).back()), w[i], rounding);
  }
}

/// y' = (a y2 y3, b y1 y3, c y1 y2 + d sin^2 t): DETEST B5 and the rigid body of SciMLBenchmarks.
template <class S>
struct ForcedRates {
  using Scalar = S;
  using State = std::array<S, 3>;
  static constexpr int size = 3;
  S a, b, c, d;
  State initial;
  template <class T>
  void rhs(const T& t, const T* y, T* f) const {
    using std::sin;
    const T s = sin(t);
    f[0] = T(a) * y[1] * y[2];
    f[1] = T(b) * y[0] * y[2];
    f[2] = T(c) * y[0] * y[1] + T(d) * s * s;
  }
};

TEST(Published, SciMLRigidBodyWithForcing) {
  const char* printed[] = {"-0.668862422980134302", "-0.587698402204068395", "2.01077739307361082"};
  // The forcing enters the third equation alone, so that 1.25 y1^2 + 2 y2^2 stays at 1.25: two of the printed
  // numbers check each other, to the 18 digits that they have.
  const Wide y1(printed[0]), y2(printed[1]);
  expect_digits(Wide("1.25") * y1 * y1 + 2 * y2 * y2, "1.25000000000000000", 2e-18);
  const ForcedRates<Wide> wide{
      Wide(-2), Wide("1.25"), Wide("-0.5"), Wide("0.25"), {Wide(1), Wide(0), Wide("0.9")}};
  const auto y = flow(wide, Wide(10), 100);
  for (std::size_t i = 0; i < 3; ++i) expect_digits(y[i], printed[i]);

  // The same in doubles by our Runge-Kutta step: of order 4, and at 2e4 steps down to rounding.
  const ForcedRates<double> m{-2, 1.25, -0.5, 0.25, {1, 0, 0.9}};
  const auto error = [&](int steps) {
    auto x = m.initial;
    const double h = 10.0 / steps;
    for (int i = 0; i < steps; ++i)
      x = runge_kutta_4([&m](double t, const double* s, double* f) { m.rhs(t, s, f); }, i * h, h, x);
    double worst = 0;
    for (std::size_t i = 0; i < 3; ++i) worst = std::max(worst, std::abs(x[i] - nearest_double(printed[i])));
    return worst;
  };
  const double coarse = error(400), fine = error(800), finest = error(1600);
  EXPECT_NEAR(std::log2(coarse / fine), 4, 0.15);
  EXPECT_NEAR(std::log2(fine / finest), 4, 0.15);
  // Rounding: 2e4 steps of 2e-16 on numbers of up to 2, grown by at most ten.
  EXPECT_LT(error(20000), 1e-10);
}

TEST(Published, DetestB5) {
  const char* printed[] = {"-0.9396570798729192", "-0.3421177754000779", "0.7414126596199957"};
  const ForcedRates<Wide> b5{Wide(1), Wide(-1), Wide("-0.51"), Wide(0), {Wide(0), Wide(1), Wide(1)}};
  const auto y = flow(b5, Wide(20), 200);
  // In closed form (sn, cn, dn)(t | k^2 = 0.51), here in 50 digits. What the test set prints is from doubles,
  // and off by up to thirteen ulp of one.
  Wide cn, dn;
  const Wide sn = boost::math::jacobi_elliptic(Wide(sqrt(Wide("0.51"))), Wide(20), &cn, &dn);
  const Wide exact[] = {sn, cn, dn};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_LT(abs(Wide(y[i] - exact[i])).convert_to<double>(), 1e-35);
    expect_digits(y[i], printed[i], 13 * 2.3e-16);
  }

  // Its coefficients (1, -1, -0.51) belong to no body as they are ((I2 - I3)/I1 = 1 and (I3 - I1)/I2 = -1
  // leave I3 = 0), but scaled rates y_i = s_i w_i obey Euler's equations of any body with I2 > I1 > I3, here
  // (4, 5, 3): y1' = a s1/(s2 s3) y2 y3 with a = (I2 - I3)/I1 and so on, hence s3^2 = -ab, s2^2 = -ac/0.51,
  // s1^2 = bc/0.51.
  const Wide a = Wide(2) / 4, b = Wide(-1) / 5, c = Wide(-1) / 3;
  const Wide s[] = {sqrt(Wide(b * c / Wide("0.51"))), sqrt(Wide(-a * c / Wide("0.51"))), sqrt(Wide(-a * b))};
  const TemporaryFolder folder;
  const auto file = folder.write(
      "b5.toml",
      "title = \"DETEST B5\"\nduration = 20.0\nattitude = false\n[body]\ninertia = [4, 5, 3]\n[initial]\n"
      "angular_velocity = [0, " +
          Wide(1 / s[1]).str(25) + ", " + Wide(1 / s[2]).str(25) + "]\n");
  const double rounding = 4 * effect_of_doubles(read_scene(file));  // |w0| = 3.6, s <= 0.6
  const auto columns = printed_by("simulate '" + file.string() + "' --digits 20");
  const char* names[] = {"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};
  for (std::size_t i = 0; i < 3; ++i)
    expect_digits(s[i] * Wide(columns.at(names[i]).back()), printed[i], rounding);
}

// ---- Multibody and space-flight codes ----

TEST(Published, ExudynHeavyTop) {
  const Scene top = find_scene("heavy-top");
  const std::vector<double> times{0.01, 2.0};
  const Truth truth = reference_solution(top, times);
  const auto w_S = [&](std::size_t i) {
    return to_space<Wide>(truth.samples[i].q, truth.samples[i].w_B).y();
  };
  // Published from a fine integration in doubles, whose rounding shows long before the 16 printed digits end.
  // At 0.01 s: a thousand steps, each with an ulp of 150 (2.8e-14) in no preferred direction, twice 9e-13. At
  // 2 s: what an attitude in doubles can reach at all here, times the spin, times the usual ten.
  expect_digits(w_S(0), "149.8473939540758", 2e-12);
  expect_digits(w_S(1), "-106.16380414306643", 10 * truth_of(top, times)->floor().attitude * 150);
}

TEST(Published, ExudynSingleSteps) {
  // Printed from doubles with 15 decimals: the printed numbers, and ours, are each off by rounding of half an
  // ulp of 6 in each of some five operations.
  const Scene s = body({5.2988, 1.1775, 4.3568}, {2, 4, 6}, 1e-3);
  const auto step = [&](const char* solver, double h) {
    Grid g;
    g.stretches.push_back({h, 1, h});
    return run(solver, s, g).samples.back().w_B;
  };
  constexpr double rounding = 5 * 4.4e-16;
  const char* rk4[] = {"1.985608117600764", "3.990428541317109", "6.007531319827856"};
  const char* euler[] = {"1.998559990941345", "3.99904", "6.000756757253030"};
  for (int i = 0; i < 3; ++i) {
    expect_digits(Wide(step("rk4", 1e-3)[i]), rk4[i], rounding);
    expect_digits(Wide(step("euler", 1e-4)[i]), euler[i], rounding);
  }
}

TEST(Published, OrekitDistanceToConstantRate) {
  // The middle rate starts with 1e-3 rad/s^2: 5.0e-4 t^2 rad apart, two digits printed.
  const Scene s = body({0.375, 0.5, 0.625}, {0.05, 0, 0.04}, 1);
  const std::vector<double> times{0.1, 1.0};
  const Truth truth = reference_solution(s, times);
  const auto apart = [&](std::size_t i) {
    const WideSample& x = truth.samples[i];
    return attitude_error<Wide>(exp_rotation<Wide>(s.rotation->w0.cast<Wide>() * x.t), x.q);
  };
  expect_digits(apart(0), "5.0e-6");
  expect_digits(apart(1), "5.0e-4");
}

/// The period of the rates of a free body that starts with rate `axis` at zero, near a guess: one Newton step
/// on that rate, which leaves the square of the guess's error.
Wide period_near(const FreeRates& m, int axis, const Wide& guess, int steps) {
  const auto y = flow(m, guess, steps);
  typename FreeRates::State slope;
  m.rhs(guess, y.data(), slope.data());
  for (int i = 0; i < 3; ++i)  // it is the whole period, not a half: every rate is back with its sign
    EXPECT_LT(abs(Wide(y[static_cast<std::size_t>(i)] - m.initial[static_cast<std::size_t>(i)]))
                  .convert_to<double>(),
              1e-9);
  return guess - y[static_cast<std::size_t>(axis)] / slope[static_cast<std::size_t>(axis)];
}

TEST(Published, PrincipiaDzhanibekovPeriod) {
  const FreeRates m = free_rates(decimals("3", "5", "9"), {Wide(0), Wide(2) / 5, Wide("0.01") / 9});
  expect_digits(period_near(m, 0, Wide("118.1108870464"), 240), "118.110887046385744");
}

TEST(Published, SimbodyDzhanibekovPeriod) {
  // Published as 0.0612666667 and so on; the digits of the period are those of the fractions behind the
  // decimals (the ten printed ones move it by 5e-8 s).
  const WideVec I = WideVec(Wide(919), Wide(967), Wide(83)) / Wide(15000);
  const WideVec w0 = decimals("10", "0", "1e-10");
  expect_digits(period_near(free_rates(I, w0), 1, Wide("14.9686865148"), 1500), "14.9686865148128");
  // Moments by size: I.z < I.x < I.y, and the polhode runs round the smallest (L^2 < 2 E I.x):
  // k^2 = (I.y - I.x)(L^2 - 2 E I.z) / ((I.x - I.z)(2 E I.y - L^2)).
  const Wide twice_E = w0.dot(I.cwiseProduct(w0)), L2 = I.cwiseProduct(w0).squaredNorm();
  const Wide k2 = (I.y() - I.x()) * (L2 - twice_E * I.z()) / ((I.x() - I.z()) * (twice_E * I.y() - L2));
  expect_digits(1 - k2, "1.66e-22");
}

TEST(Published, DrakeCylinder) {
  // Spin 3 rad/s about its axis, precession sqrt(29) rad/s about L: all inputs are exact in binary, or a
  // factor of two apart, so that 30 digits can be asked of the truth.
  const Scene s = body({0.04, 0.04, 0.02}, {2, 4, 6}, 10);
  const std::vector<double> times{1.0, 10.0};
  for (const WideSample& x : series_solution(s, times).samples) {
    const QuaternionT<Wide> exact =
        exp_rotation<Wide>(WideVec(Wide(2), Wide(4), Wide(3)) * x.t) *  // of length sqrt(29)
        exp_rotation<Wide>(WideVec(Wide(0), Wide(0), Wide(3 * x.t)));
    EXPECT_LT(attitude_error<Wide>(exact, x.q).convert_to<double>(), 1e-30);
  }
}

// ---- Physics engines ----

constexpr const char* box_with_six_digits =
    "title = \"boxes\"\nduration = 10.0\n[body]\nmass = 10.0\ninertia = [0.808333, 0.683333, 0.141667]\n"
    "[initial]\nvelocity = [-2, 2, 8]\nangular_velocity = [0.1, 5.0, 0.1]\n"
    "[[load]]\ntype = \"gravity\"\nacceleration = [0, 0, -9.8]\n";

TEST(Published, BulletTumblingBoxByTheProgram) {
  // BENCHMARK_boxes_dt.csv, largest over all steps. The library's own test takes every step; here the program
  // samples 1e4 times, so every step, every second and every tenth: the errors grow slowly, and the digits
  // are the same.
  const TemporaryFolder folder;
  const auto file = folder.write("box.toml", box_with_six_digits);
  struct Row {
    const char *h, *momentum, *energy;
  };
  std::vector<Row> rows{{"1e-3", "0.0124501", "0.0135771"}};
  if (!sanitized)
    rows.insert(rows.end(), {{"5e-4", "0.00626166", "0.00679101"}, {"1e-4", "0.00125827", "0.0013586"}});
  for (const Row& row : rows) {
    const auto columns = printed_by("drift '" + file.string() +
                                    "' --solver bullet-implicit-body --samples 10000 --h " + row.h + " -o -");
    ASSERT_EQ(columns.at("t_s").size(), 10000u);
    double momentum = 0, energy = 0;
    for (std::size_t i = 0; i < 10000; ++i) {
      momentum = std::max(momentum, nearest_double(columns.at("momentum_drift_rel")[i]));
      energy = std::max(energy, std::abs(nearest_double(columns.at("total_energy_drift_rel")[i])));
    }
    expect_digits(Wide(momentum), row.momentum);
    expect_digits(Wide(energy), row.energy);
  }
}

/// The step published as "ode": gyroscopic torque of the old state in space components, then the quaternion
/// with the new rate, q + h/2 (0, w) q, normalised. Largest |L - L0|/|L0| over all steps.
double momentum_drift_of_explicit_world_step(const Vec3& moments, int steps) {
  const double h = 10.0 / steps;
  Quaternion q(1, 0, 0, 0);
  Vec3 w(0.1, 5, 0.1);
  const Vec3 L0 = moments.cwiseProduct(w);
  double worst = 0;
  for (int i = 0; i < steps; ++i) {
    w += h * angular_acceleration_S(inertia_S(rotation_matrix(q), moments), w, Vec3::Zero());
    const Quaternion slope = Quaternion(0, w.x(), w.y(), w.z()) * q;
    q.coeffs() += h / 2 * slope.coeffs();
    q = normalised(q);
    const Vec3 L = angular_momentum_S(inertia_S(rotation_matrix(q), moments), w);
    worst = std::max(worst, (L - L0).norm() / L0.norm());
  }
  return worst;
}

TEST(Published, OdeTumblingBox) {
  // With the inertia in six digits, as for Bullet: with eight, the sixth digit of the drift is another.
  const Vec3 moments(0.808333, 0.683333, 0.141667);
  expect_digits(Wide(momentum_drift_of_explicit_world_step(moments, 10000)), "0.0130708");
  expect_digits(Wide(momentum_drift_of_explicit_world_step(moments, 100000)), "0.0012715");
}

TEST(Published, SemiImplicitEulerFallsHalfAStepTooFar) {
  // g T h/2 = 0.049 m. Rounding: 1e4 sums of |p| <= 490 to half an ulp, 2.8e-14 each, and of |v| <= 98
  // to 7.1e-15 each, carried for at most 10 s: 1e-9 m at worst.
  const Scene box = find_scene("tumbling-box");
  const std::vector<double> end{10.0};
  const Wide exact = reference_solution(box, end).samples.front().p.z();
  const Trajectory t = run("semi-implicit-euler", box, to_the_end(10, 10000));
  EXPECT_NEAR(Wide(t.samples.back().p.z() - exact).convert_to<double>(), -0.049, 1e-9);
  EXPECT_EQ(box.translation->acceleration.z(), -9.8);
  // By the program, with every engine that falls like this; Bullet and what is installed beside it.
  const std::vector<std::string> engines{"bullet-implicit-body", "mujoco-euler", "ode-step", "dart"};
  for (const Method* m : all_methods())
    if (const std::string id(m->id); std::count(engines.begin(), engines.end(), id) > 0) {
      const auto columns = printed_by("simulate tumbling-box --h 1e-3 --solver " + id);
      EXPECT_NEAR(Wide(Wide(columns.at("pz_m").back()) - exact).convert_to<double>(), -0.049, 1e-9) << id;
    }
}

TEST(Published, MujocoFreeBody) {
  // engine_forward_test.cc: a box of half sizes 0.1, 0.2, 0.3 m and 1 kg, 500 steps of 10 ms. Its Euler is
  // the step that Bullet calls explicit, its `implicit` the one Newton step of Bullet's default.
  const Scene box = body(Vec3(0.13, 0.10, 0.05) / 3, {1, 2, 3}, 5);
  const auto growth = [&](const char* solver) {
    const Trajectory t = run(solver, box, to_the_end(5, 500));
    return Wide(t.samples.back().rotational_energy / t.samples.front().rotational_energy);
  };
  expect_digits(growth("bullet-explicit"), "1.086895");
  expect_digits(growth("bullet-implicit-body"), "0.926008");

  // The same by the program, with MuJoCo itself where it is installed.
  const TemporaryFolder folder;
  const auto file = folder.write("box.toml",
                                 "title = \"box\"\nduration = 5.0\n[body]\nmass = 1.0\nshape = \"box\"\n"
                                 "size = [0.2, 0.4, 0.6]\n[initial]\nangular_velocity = [1, 2, 3]\n");
  const auto printed_growth = [&](const std::string& solver) {
    const auto columns = printed_by("simulate '" + file.string() + "' --h 0.01 --solver " + solver);
    return Wide(Wide(columns.at("energy_J").back()) / Wide(columns.at("energy_J").front()));
  };
  const std::vector<std::string> explicit_ones{"bullet-explicit", "bullet-multibody", "mujoco-euler", "dart"},
      implicit_ones{"bullet-implicit-body", "bullet-world", "mujoco-implicit"};
  for (const Method* m : all_methods()) {
    const std::string id(m->id);
    if (std::count(explicit_ones.begin(), explicit_ones.end(), id) > 0)
      expect_digits(printed_growth(id), "1.086895");
    if (std::count(implicit_ones.begin(), implicit_ones.end(), id) > 0)
      expect_digits(printed_growth(id), "0.926008");
  }
}

/// Bullet's explicit gyroscopic step with what it cuts: the torque at 100 N m and the rotation of a step at
/// pi/4. Energy at the end over energy at the start, for a thin rod spun at s rad/s.
double energy_growth_of_thin_rod(double s) {
  const Vec3 moments(1.7231e-4, 6.58e-6, 1.7243e-4);
  constexpr double h = 1e-3, largest_turn = std::numbers::pi / 4;
  Quaternion q(1, 0, 0, 0);
  Vec3 w(0.01 * s, s, 0.01 * s);
  const auto energy = [&] {
    const Vec3 w_B = to_body(q, w);
    return 0.5 * w_B.dot(moments.cwiseProduct(w_B));
  };
  const double start = energy();
  for (int i = 0; i < 10000; ++i) {
    const Mat3 R = rotation_matrix(q);
    Vec3 torque = w.cross(angular_momentum_S(inertia_S(R, moments), w));
    if (torque.norm() > 100) torque *= 100 / torque.norm();
    w -= h * (R * (R.transpose() * torque).cwiseQuotient(moments));
    Vec3 turn = h * w;
    if (turn.norm() > largest_turn) turn *= largest_turn / turn.norm();
    q = normalised<double>(exp_rotation<double>(turn) * q);
  }
  return energy() / start;
}

TEST(Published, ThinRodGainsEnergyFromTheExplicitStep) {
  expect_digits(Wide(energy_growth_of_thin_rod(10)), "1.0079");
  const auto columns = printed_by("simulate thin-rod --solver bullet-explicit --h 1e-3");
  const auto& energy = columns.at("energy_J");
  expect_digits(Wide(energy.back()) / Wide(energy.front()), "1.0079");
  // At 100 rad/s both cuts are met: bullet-explicit ends such a run as clamped, its step goes on. Two digits.
  expect_digits(Wide(energy_growth_of_thin_rod(100)), "7.0e6");
  const TemporaryFolder folder;
  const auto file = folder.write("rod.toml",
                                 "title = \"rod\"\nduration = 10.0\n[body]\nmass = 1.0\n"
                                 "inertia = [1.7231e-4, 6.58e-6, 1.7243e-4]\n[initial]\n"
                                 "angular_velocity = [1, 100, 1]\n");
  const CommandResult cut =
      polhode_command("simulate '" + file.string() + "' --solver bullet-explicit --h 1e-3");
  EXPECT_EQ(cut.exit_code, 1);
  EXPECT_NE(cut.err.find("clamped"), std::string::npos) << cut.err;
  EXPECT_NE(cut.err.find("pi/4"), std::string::npos) << cut.err;
}

}  // namespace
}  // namespace polhode
