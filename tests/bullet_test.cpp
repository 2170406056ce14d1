// Bullet: published numbers, exact single steps, its limits reported, and the bare body against the whole
// world.
#include <cmath>
#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "models/model.hpp"
#include "solvers/registry.hpp"

namespace polhode {
namespace {

Scene body(const Vec3& moments, const Vec3& w0, double duration = 10) {
  Scene s;
  s.duration = duration;
  s.rotation.emplace();
  s.rotation->moments = moments;
  s.rotation->w0 = w0;
  return s;
}

Scene particle(const Vec3& v0, const Vec3& acceleration, double drag, double mass) {
  Scene s;
  s.duration = 10;
  s.translation = TranslationData{.mass = mass,
                                  .v0 = v0,
                                  .acceleration = acceleration,
                                  .drag = drag,
                                  .has_force = acceleration != Vec3::Zero() || drag != 0};
  return s;
}

// Tumbling box of scpeters/benchmark. Its world file has the inertia in full; its published numbers, to every
// digit and for all step sizes that divide 10 s, are those of the inertia in six digits, as Gazebo passes
// text on.
Scene tumbling_box() {
  Scene s = body({0.808333, 0.683333, 0.141667}, {0.1, 5, 0.1});
  s.translation = particle({-2, 2, 8}, {0, 0, -9.8}, 0, 10).translation;
  return s;
}

Scene hairer_vilmart_body() { return body({0.6, 0.8, 1}, {1.8 / 0.6, 0.4 / 0.8, -0.9}); }

Grid even_grid(double end, std::int64_t steps, std::int64_t samples) {
  Grid g;
  g.from_start = true;
  for (std::int64_t i = 1; i <= samples; ++i)
    g.stretches.push_back({end * static_cast<double>(i) / static_cast<double>(samples), steps / samples,
                           end / static_cast<double>(steps)});
  return g;
}

Trajectory run(const std::string& solver, const Scene& scene, const Grid& grid, const Setting& setting = {}) {
  const Prepared p = find_method(solver).prepare(scene, setting);
  Trajectory out;
  EXPECT_TRUE(p.integrate) << solver << ": " << p.unsupported;
  if (p.integrate) p.integrate(grid, out);
  return out;
}

double momentum_error(const Trajectory& t) {
  const Vec3& start = t.samples.front().L;
  double worst = 0;
  for (const Sample& s : t.samples) worst = std::max(worst, (s.L - start).norm() / start.norm());
  return worst;
}

template <class Energy>
double energy_error(const Trajectory& t, Energy energy) {
  const double start = energy(t.samples.front());
  double worst = 0;
  for (const Sample& s : t.samples) worst = std::max(worst, std::abs((energy(s) - start) / start));
  return worst;
}
double total(const Sample& s) { return s.total_energy; }
double rotational(const Sample& s) { return s.rotational_energy; }

void expect_same_bits(const Trajectory& a, const Trajectory& b, const std::string& what) {
  EXPECT_EQ(a.outcome, Outcome::ok) << what << ": " << a.reason;
  EXPECT_EQ(b.outcome, Outcome::ok) << what << ": " << b.reason;
  ASSERT_EQ(a.samples.size(), b.samples.size()) << what;
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const Sample &x = a.samples[i], &y = b.samples[i];
    EXPECT_TRUE(x.q.coeffs() == y.q.coeffs() && x.w_B == y.w_B && x.p == y.p && x.v == y.v && x.L == y.L &&
                x.total_energy == y.total_energy)
        << what << " at t = " << x.t;
  }
}

// Half a unit of the last of six significant digits.
double half_unit(double value) { return 0.5 * std::pow(10, std::floor(std::log10(value)) - 5); }

TEST(Bullet, PublishedTumblingBox) {
  // BENCHMARK_boxes_dt.csv, rows "bullet", complex: the largest |L - L0|/|L0| and |E - E0|/E0 over all steps,
  // E with the energies of the fall, which are 98 % of E0 and hide the rotation.
  struct Row {
    std::int64_t steps;
    double momentum, energy;
  };
  for (const Row& row : {Row{10000, 0.0124501, 0.0135771}, Row{12500, 0.00998344, 0.0108632},
                         Row{20000, 0.00626166, 0.00679101}, Row{25000, 0.00501523, 0.00543321},
                         Row{50000, 0.00251355, 0.00271700}, Row{100000, 0.00125827, 0.00135860}}) {
    const Trajectory t = run("bullet-implicit-body", tumbling_box(), even_grid(10, row.steps, row.steps));
    ASSERT_EQ(t.outcome, Outcome::ok) << t.reason;
    EXPECT_NEAR(momentum_error(t), row.momentum, half_unit(row.momentum)) << row.steps << " steps";
    EXPECT_NEAR(energy_error(t, total), row.energy, half_unit(row.energy)) << row.steps << " steps";
  }
}

TEST(Bullet, FreeFallIsLateByHalfAStep) {
  // Semi-implicit Euler falls g T h/2 too far. Rounding: 1e4 additions to |p| <= 490 at 3e-14 each, and of
  // those to |v| <= 98 at 7e-15, each carried for at most 10 s: 1e-9 m.
  const Trajectory t = run("bullet-implicit-body", tumbling_box(), even_grid(10, 10000, 1));
  const double exact = 8.0 * 10 - 0.5 * 9.8 * 100;
  EXPECT_NEAR(t.samples.back().p.z() - exact, -0.049, 1e-9);
}

TEST(Bullet, PublishedThinRod) {
  // The explicit gyroscopic step feeds a thin rod: energy times 1.0079 in 10 s at 10 rad/s. At 100 rad/s
  // Bullet runs into both of its limits and prints whatever they leave; here the run ends at the first, with
  // what it had.
  const Vec3 moments(1.7231e-4, 6.58e-6, 1.7243e-4);
  const Trajectory slow = run("bullet-explicit", body(moments, {0.1, 10, 0.1}), even_grid(10, 10000, 1));
  EXPECT_NEAR(slow.samples.back().rotational_energy / slow.samples.front().rotational_energy, 1.0079, 5e-5);
  const Trajectory fast = run("bullet-explicit", body(moments, {1, 100, 1}), even_grid(10, 10000, 100));
  EXPECT_EQ(fast.outcome, Outcome::clamped);
  EXPECT_NE(fast.reason.find("pi/4"), std::string::npos) << fast.reason;
  EXPECT_GT(fast.samples.size(), 1u);
  EXPECT_LT(fast.samples.size(), 101u);
  EXPECT_LT(fast.work.steps, 10000);
}

Vec3 vector_of(const nlohmann::json& j) {
  return {std::stod(j[0].get<std::string>()), std::stod(j[1].get<std::string>()),
          std::stod(j[2].get<std::string>())};
}

TEST(Bullet, ExactSingleSteps) {
  // 1, 2 and 10 steps in 70-digit arithmetic. Ten steps round a few dozen numbers of size up to 2 to 2e-16
  // each.
  constexpr double tolerance = 1e-14;
  std::ifstream file(POLHODE_TESTS "/reference/fingerprints_P.json");
  ASSERT_TRUE(file) << "tests/reference/fingerprints_P.json";
  const nlohmann::json set = nlohmann::json::parse(file);
  for (const auto& problem : set.at("problems")) {
    const auto& in = problem.at("inputs");
    Scene s = body(vector_of(in.at("inertia_body")), vector_of(in.at("omega_body0")));
    const auto& q0 = in.at("q0");
    s.rotation->q0 = Quaternion(std::stod(q0[0].get<std::string>()), std::stod(q0[1].get<std::string>()),
                                std::stod(q0[2].get<std::string>()), std::stod(q0[3].get<std::string>()));
    const auto& torque = in.at("torque");
    if (torque.at("model") != "none") {
      s.rotation->about_pivot = true;
      s.rotation->loads.push_back(GravityAboutPivot<double>{std::stod(in.at("mass").get<std::string>()),
                                                            vector_of(torque.at("gravity_world")),
                                                            vector_of(torque.at("r_com_body"))});
    }
    const double h = std::stod(in.at("h").get<std::string>());
    for (const auto& [count, want] : problem.at("results").at("bullet_semi_implicit").at("steps").items()) {
      const std::int64_t steps = std::stoll(count);
      Grid grid;
      grid.stretches.push_back({static_cast<double>(steps) * h, steps, h});
      for (const char* solver : {"bullet-implicit-body", "bullet-implicit-world", "bullet-world"}) {
        const std::string what = problem.at("id").get<std::string>() + ", " + count + " steps, " + solver;
        const Trajectory t = run(solver, s, grid);
        ASSERT_EQ(t.samples.size(), 1u) << what << t.reason;
        const Sample& got = t.samples.front();
        const auto& q = want.at("q");
        const Quaternion exact(std::stod(q[0].get<std::string>()), std::stod(q[1].get<std::string>()),
                               std::stod(q[2].get<std::string>()), std::stod(q[3].get<std::string>()));
        EXPECT_LT(attitude_error(exact, got.q), tolerance) << what;
        EXPECT_LT((got.w_B - vector_of(want.at("omega_body"))).norm(), tolerance) << what;
        EXPECT_LT((got.L - vector_of(want.at("L_world"))).norm(), tolerance) << what;
        EXPECT_NEAR(got.rotational_energy, std::stod(want.at("E_rot").get<std::string>()), tolerance) << what;
      }
    }
  }
}

TEST(Bullet, NoGyroscopicTermKeepsTheEnergyOfTheWrongMotion) {
  // w stays constant in space, so the energy does, to rounding: 1e4 steps of 2e-16 in random directions, and
  // ten times that allowed. The momentum is off by percent, at every step size the same.
  for (const std::int64_t steps : {1000, 10000}) {
    const Trajectory t = run("bullet-none", tumbling_box(), even_grid(10, steps, 100));
    EXPECT_LT(energy_error(t, rotational), 1e-13) << steps;
    EXPECT_GT(momentum_error(t), 0.03) << steps;
    EXPECT_LT(momentum_error(t), 0.04) << steps;
    EXPECT_LT((t.samples.back().w_B - t.samples.front().w_B).norm() / 5, 0.1) << "it never tumbles";
  }
}

TEST(Bullet, NewtonStepIsTheSameInEitherFrame) {
  // In exact arithmetic the two implicit forms are one map in two frames; 1000 steps apart by rounding that
  // grows linearly: 1000 * 10 s * 2e-16.
  const Trajectory in_body = run("bullet-implicit-body", hairer_vilmart_body(), even_grid(10, 1000, 10));
  const Trajectory in_space = run("bullet-implicit-world", hairer_vilmart_body(), even_grid(10, 1000, 10));
  for (std::size_t i = 0; i < in_body.samples.size(); ++i) {
    EXPECT_LT(attitude_error(in_body.samples[i].q, in_space.samples[i].q), 2e-12);
    EXPECT_LT((in_body.samples[i].w_B - in_space.samples[i].w_B).norm(), 2e-12);
  }
}

std::vector<std::pair<std::string, Scene>> scenes_of_every_kind() {
  std::vector<std::pair<std::string, Scene>> all;
  const auto loaded = [](std::vector<AnyTorque<double>> loads) {
    Scene s = hairer_vilmart_body();
    s.rotation->loads = std::move(loads);
    return s;
  };
  const GravityAboutPivot<double> weight{0.9, {0, 0, -9.81}, {0.05, 0.08, 0.2}};
  const AngularDrag<double> drag{Vec3(0.1, 0.2, 0.3).asDiagonal()};
  const AttitudeSpring<double> spring{2.0, 0.5};
  const ConstantTorque<double, Frame::body> in_body{{0.1, -0.2, 0.3}};
  const ConstantTorque<double, Frame::space> in_space{{0.1, -0.2, 0.3}};
  const GravityGradient<double> gradient{0.7, {0.6, 0.8, 1}};
  all.emplace_back("free", hairer_vilmart_body());
  all.emplace_back("sphere", body({0.4, 0.4, 0.4}, {1, 2, 3}));
  all.emplace_back("weight at a pivot", loaded({weight}));
  all.emplace_back("angular drag", loaded({drag}));
  all.emplace_back("spring", loaded({spring}));
  all.emplace_back("body torque", loaded({in_body}));
  all.emplace_back("space torque", loaded({in_space}));
  all.emplace_back("gravity gradient", loaded({gradient}));
  all.emplace_back("three torques", loaded({drag, in_space, gradient}));
  all.emplace_back("falling box", tumbling_box());
  all.emplace_back("particle in gravity", particle({1, 2, 3}, {0, 0, -9.81}, 0, 2));
  all.emplace_back("particle without force", particle({1, 2, 3}, {0, 0, 0}, 0, 2));
  Scene dragged = tumbling_box();
  dragged.translation->drag = 0.7;
  dragged.rotation->loads = {drag};
  all.emplace_back("falling box with drags", dragged);
  return all;
}

TEST(Bullet, BareBodyEqualsTheWorldToTheLastBit) {
  for (const char* suffix : {"", "-f32"})
    for (const auto& [name, scene] : scenes_of_every_kind())
      expect_same_bits(run(std::string("bullet-implicit-body") + suffix, scene, even_grid(5, 1000, 100)),
                       run(std::string("bullet-world") + suffix, scene, even_grid(5, 1000, 100)),
                       name + suffix);
}

TEST(Bullet, RunsAgainFromTheStart) {
  // One set-up serves many runs, also after one that ended early.
  for (const char* solver :
       {"bullet-implicit-body", "bullet-world", "bullet-implicit-body-f32", "bullet-world-f32"}) {
    const Prepared p = find_method(solver).prepare(hairer_vilmart_body(), {});
    Trajectory first, again;
    p.integrate(even_grid(10, 1000, 10), first);
    p.integrate(even_grid(10, 10, 10), again);
    EXPECT_EQ(again.outcome, Outcome::clamped) << solver;  // 3 rad a step
    p.integrate(even_grid(10, 1000, 10), again);
    expect_same_bits(first, again, solver);
    EXPECT_EQ(again.work.steps, 1000);
    EXPECT_EQ(again.work.rhs_evals, 1000);
  }
}

TEST(Bullet, SaysWhenItCutsTheRotation) {
  // |w| h just under pi/4 = 0.7854 runs; just over ends the run in its first step, with the sample at the
  // start.
  for (const char* solver :
       {"bullet-none", "bullet-explicit", "bullet-implicit-world", "bullet-implicit-body", "bullet-world",
        "bullet-implicit-body-f32", "bullet-world-f32"}) {
    const Trajectory under = run(solver, body({1, 1, 1}, {0, 78.5, 0}, 1), even_grid(1, 100, 10));
    EXPECT_EQ(under.outcome, Outcome::ok) << solver << under.reason;
    EXPECT_EQ(under.samples.size(), 11u) << solver;
    const Trajectory over = run(solver, body({1, 1, 1}, {0, 78.6, 0}, 1), even_grid(1, 100, 10));
    EXPECT_EQ(over.outcome, Outcome::clamped) << solver;
    EXPECT_NE(over.reason.find("pi/4"), std::string::npos) << over.reason;
    EXPECT_EQ(over.samples.size(), 1u) << solver;
    EXPECT_EQ(over.work.steps, 1) << solver;
  }
}

TEST(Bullet, SaysWhenItCutsTheTorque) {
  // |w x (I w)| of I = (1, 2, 3), w = (a, a, a) is a^2 |(1, -2, 1)| = 2.449 a^2 N m; the cut is at 100, a
  // = 6.390.
  const auto outcome = [](const char* solver, double a) {
    return run(solver, body({1, 2, 3}, {a, a, a}, 0.001), even_grid(0.001, 1, 1));
  };
  EXPECT_EQ(outcome("bullet-explicit", 6.38).outcome, Outcome::ok);
  const Trajectory cut = outcome("bullet-explicit", 6.40);
  EXPECT_EQ(cut.outcome, Outcome::clamped);
  EXPECT_NE(cut.reason.find("100 N m"), std::string::npos) << cut.reason;
  EXPECT_EQ(outcome("bullet-explicit-f32", 6.40).outcome, Outcome::clamped);
  EXPECT_EQ(outcome("bullet-implicit-body", 6.40).outcome, Outcome::ok);
}

TEST(Bullet, SlowBodiesStayAwake) {
  // Below 1 rad/s Bullet's defaults put a body to sleep after 2 s and set w to 0.
  for (const char* solver : {"bullet-implicit-body", "bullet-world"}) {
    const Trajectory t = run(solver, body({0.6, 0.8, 1}, {0.05, 0.1, 0.02}), even_grid(10, 1000, 10));
    EXPECT_GT(t.samples.back().w_B.norm(), 0.1) << solver;
  }
}

TEST(Bullet, BothPrecisionsInOneProcess) {
  // 100 steps in single precision round some ten numbers each to 6e-8: at most 6e-5 apart, and more than
  // double precision could explain. The double build gives the same bits before and after the other has run.
  const Scene scene = hairer_vilmart_body();
  const Grid grid = even_grid(1, 100, 10);
  const Trajectory before = run("bullet-implicit-body", scene, grid);
  const Trajectory single = run("bullet-implicit-body-f32", scene, grid);
  const Trajectory after = run("bullet-implicit-body", scene, grid);
  expect_same_bits(before, after, "double, before and after single");
  const Sample &d = before.samples.back(), &f = single.samples.back();
  EXPECT_GT((d.w_B - f.w_B).norm(), 1e-9);
  EXPECT_LT((d.w_B - f.w_B).norm(), 6e-5);
  EXPECT_GT(f.unit_defect, 1e-9);  // of a matrix of floats
  EXPECT_LT(f.unit_defect, 3e-6);  // of one step, not of many: Bullet normalises
  EXPECT_LT(d.unit_defect, 1e-14);
  EXPECT_EQ(find_method("bullet-implicit-body").version, find_method("bullet-implicit-body-f32").version);
}

TEST(Bullet, RefusesWhatItCannotServe) {
  Scene rates = hairer_vilmart_body();
  rates.rotation->attitude = false;
  const Prepared p = find_method("bullet-implicit-body").prepare(rates, {});
  EXPECT_FALSE(p.integrate);
  EXPECT_NE(p.unsupported.find("attitude"), std::string::npos) << p.unsupported;
  // Its world takes a step below its epsilon for none: 1e-8 s in single precision, but not in double.
  EXPECT_EQ(run("bullet-world-f32", hairer_vilmart_body(), even_grid(1e-7, 10, 1)).outcome,
            Outcome::solver_failed);
  EXPECT_EQ(run("bullet-world", hairer_vilmart_body(), even_grid(1e-7, 10, 1)).outcome, Outcome::ok);
  EXPECT_EQ(run("bullet-world", hairer_vilmart_body(), even_grid(10, 1000, 1), {.timeout_s = 0}).outcome,
            Outcome::timeout);
}

}  // namespace
}  // namespace polhode
