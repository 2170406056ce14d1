// Stability: measured limits against linear theory and published ones, verdicts at the edge of what can be
// computed, exact scaling by powers of two, and interrupted runs that go on.
#include "experiments/stability.hpp"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "experiments/energy_growth.hpp"
#include "experiments/linear_theory.hpp"
#include "reports/csv.hpp"
#include "solvers/stability_function.hpp"
#include "tests/command.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

/// A built-in scene whose dial has one value alone.
Scene with_one_value(const char* id, double value) {
  Scene scene = find_scene(id);
  scene.dial->values = {value};
  return scene;
}

report::CsvTable limits(std::vector<Scene> scenes, const std::vector<const Method*>& methods) {
  Plan plan;
  plan.scenes = std::move(scenes);
  plan.methods = methods;
  plan.options.quick = true;
  plan.options.quiet = true;
  return report::parse_csv(csv(dial_table(plan)));
}

std::vector<const Method*> rows_with(bool (*wanted)(const Method&)) {
  std::vector<const Method*> list;
  for (const Method* m : all_methods())
    if (m->by_steps && wanted(*m)) list.push_back(m);
  return list;
}

// Real eigenvalues (drag), a pair on the imaginary axis, and pairs between: every explicit method whose
// function is known must meet its limit within 2 % (the issue of growth in 1024 steps: a hundredth beyond the
// limit |R|^2 - 1 is at least 1e-3 for the methods here but where R leaves one along the imaginary axis with
// a high power of z; there both sides call a gain of growth_resolution a step growth, and z is the tenth root
// of it).
TEST(StabilityLimits, OfExplicitMethodsAreThoseOfLinearTheory) {
  auto methods = rows_with(
      [](const Method& m) { return !m.stability_polynomial.empty() && m.stability_denominator.size() <= 1; });
  ASSERT_GE(methods.size(), 20U);
  if (sanitized) methods = select_methods({"euler", "rk4", "odeint-dopri5"});
  const auto table = limits({with_one_value("angular-drag", 3e4), with_one_value("critical-spring", 5e6),
                             with_one_value("undamped-spring", 5e3)},
                            methods);
  std::size_t compared = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.text(i, "outcome") == "unsupported") continue;
    const double measured = table.number(i, "largest_stable_near_rest_h_s");
    const double theory = table.number(i, "theory_h_s"), fastest = table.number(i, "fastest_per_s");
    // A matrix that a growing motion has driven off SO(3) carries the larger inertia R I_B R^T, whose rates
    // are slower: there the growth stops itself, and longer steps than those of theory survive.
    if (table.text(i, "solver").find("matrix") != std::string::npos && measured > theory) continue;
    if (std::isfinite(measured) && measured * fastest > 2e-2) {
      EXPECT_NEAR(measured / theory, 1, 0.02) << table.text(i, "solver") << " on " << table.text(i, "scene");
    } else {  // Euler on the imaginary axis: no step is stable
      EXPECT_LE(theory * fastest, 2e-2) << table.text(i, "solver") << " on " << table.text(i, "scene");
    }
    ++compared;
  }
  EXPECT_GE(compared, 2 * methods.size());
}

// w is stepped with the old attitude and q with the new w: 2/lambda where only drag acts, as Euler, and h
// omega = 2 on a spring, as the leapfrog rule that it is. Source: Hairer, Lubich & Wanner, Geometric
// Numerical Integration (2006), I.1.4.
TEST(StabilityLimits, OfSemiImplicitEuler) {
  const auto table = limits({with_one_value("angular-drag", 3e4), with_one_value("undamped-spring", 5e3)},
                            {&find_method("semi-implicit-euler")});
  ASSERT_EQ(table.rows(), 2U);
  for (std::size_t i = 0; i < 2; ++i)
    EXPECT_NEAR(table.number(i, "largest_stable_near_rest_h_s") * table.number(i, "fastest_per_s"), 2, 0.04)
        << table.text(i, "scene");
}

// |R| <= 1 in the left half plane: no step is too long, at the largest rates either; what is left of a fast
// decay is |R(-1e6)|, 1 for symmetric methods and of the order of 1e-6 for L-stable ones.
TEST(StabilityLimits, AStableMethodsHaveNone) {
  auto methods = select_methods({"implicit-midpoint", "gauss4", "gauss6", "arkode-sdirk-5-3-4",
                                 "arkode-kvaerno-5-3-4", "odeint-implicit-euler"});
  if (sanitized) methods = select_methods({"gauss4", "odeint-implicit-euler"});
  std::vector<Scene> scenes{with_one_value("angular-drag", 3e7)};
  if (!sanitized) scenes.push_back(with_one_value("critical-spring", 5e9));
  const auto table = limits(scenes, methods);
  ASSERT_EQ(table.rows(), scenes.size() * methods.size());
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::string where = table.text(i, "solver") + " on " + table.text(i, "scene");
    EXPECT_EQ(table.text(i, "theory_h_s"), "") << where;
    // The library's iteration (solvers/odeint_implicit_euler.cpp) loses its way where axes are coupled.
    if (table.text(i, "solver") == "odeint-implicit-euler" && table.text(i, "scene") == "critical-spring")
      continue;
    const double reached = table.number(i, "largest_stable_near_rest_h_s") * table.number(i, "fastest_per_s");
    EXPECT_GE(reached, 999) << where;  // as far as is tried
    if (table.text(i, "scene") != "angular-drag") continue;
    EXPECT_GE(reached, 1e7) << where;
    const double R = std::abs(amplification(find_method(table.text(i, "solver")), -1e6));
    EXPECT_NEAR(table.number(i, "fast_mode_left"), R, 1e-3) << where;
  }
}

TEST(StabilityFunctions, OfSymmetricMethodsHaveModulusOneOnTheImaginaryAxis) {
  for (const char* id : {"implicit-midpoint", "gauss4", "gauss6"})
    for (const double y : {0.1, 1.0, 10.0, 1e4})
      EXPECT_NEAR(std::abs(amplification(find_method(id), std::complex<double>(0, y))), 1, 1e-12)
          << id << " " << y;
}

// ---- a right step is not a stable one

TEST(Accuracy, StiffDragNeedsNoMoreStepsThanItsSlowMotionWhereTheMethodIsStiff) {
  const auto table =
      limits({with_one_value("angular-drag", 3e6)}, select_methods({"rk4", "arkode-kvaerno-7-4-5"}));
  ASSERT_EQ(table.rows(), 2U);
  EXPECT_EQ(table.text(0, "largest_accurate_h_1e3_s"),
            "");  // 1e8 steps for its stability: not within the ladder
  EXPECT_GT(table.number(1, "largest_accurate_h_1e3_s"), 1e-3);
}

// ---- the gyroscopic map

report::CsvTable map_of(const std::vector<std::string>& solvers) {
  Plan plan;
  plan.methods = select_methods(solvers);
  plan.options.quick = true;
  return report::parse_csv(csv(gyroscopic_map(plan)));
}

// w' = A w about a spin: Euler multiplies the energy beside the axis by 1 + h^2 |lambda|^2, so it gains at
// every step size; the implicit midpoint rule keeps the energy, which is quadratic; RK4 loses below h
// |lambda| = sqrt 8.
TEST(GyroscopicMap, EulerGainsMidpointKeepsRungeKuttaLoses) {
  const auto table = map_of({"euler", "implicit-midpoint", "rk4"});
  int seen = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    if (table.text(i, "axis") == "middle" || table.number(i, "inertia_ratio") > 1.9) continue;
    const std::string& solver = table.text(i, "solver");
    const double growth = table.number(i, "energy_growth_per_step"), h = table.number(i, "h_w");
    const std::string where = solver + " " + table.text(i, "axis") + " " + table.text(i, "inertia_ratio") +
                              " h|w| " + table.text(i, "h_w");
    if (solver == "euler" && h > 0.09 && h < 0.11 && table.number(i, "inertia_ratio") < 0.1) {
      EXPECT_GT(growth, 0) << where;
    }
    if (solver == "implicit-midpoint" && std::isfinite(growth)) {
      EXPECT_LE(std::abs(growth), 1e-13) << where;  // rounding of 512 steps
    }
    if (solver == "rk4" && h < 1) {
      EXPECT_LE(growth, 1e-12) << where;
    }
    ++seen;
  }
  EXPECT_GE(seen, 60);
}

// Bullet cuts the rotation of a step at pi/4 and says nothing; the map says it, at every shape.
TEST(GyroscopicMap, BulletIsClampedBeyondAQuarterOfPi) {
  const auto table = map_of({"bullet-implicit-body"});
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double h = table.number(i, "h_w");
    if (h > 0.8) {
      EXPECT_EQ(table.text(i, "outcome"), "clamped") << h;
    }
    if (h < 0.5) {
      EXPECT_EQ(table.text(i, "outcome"), "ok") << h;
    }
  }
}

// ---- extremes

report::CsvTable extremes_of(const std::vector<const Method*>& methods) {
  Plan plan;
  plan.methods = methods;
  plan.options.quick = true;
  return report::parse_csv(csv(extremes(plan)));
}

TEST(Extremes, TheClosedFormIsRightOnEveryFreeBody) {
  const auto table = extremes_of(select_methods({"exact", "exact-extended"}));
  ASSERT_GE(table.rows(), 2 * 19U);
  for (std::size_t i = 0; i < table.rows(); ++i)
    EXPECT_EQ(table.text(i, "verdict"), table.text(i, "case") == "corner" ? "unsupported" : "right")
        << table.text(i, "case") << " " << table.text(i, "value");
}

TEST(Extremes, EverySolverEndsWithAVerdict) {
  std::vector<const Method*> methods;
  for (const Method* m : all_methods())
    if (m->in_studies && m->family != "truth") methods.push_back(m);
  if (sanitized) methods = select_methods({"euler", "rk4", "taylor", "dmv2", "cvode-bdf", "bullet-*"});
  const auto table = extremes_of(methods);
  const std::set<std::string> verdicts{
      "right",  "bounded_but_wrong", "dissipates",    "gains_energy", "clamped",
      "asleep", "not_finite",        "solver_failed", "timeout",      "unsupported"};
  std::map<std::string, int> right;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    EXPECT_TRUE(verdicts.contains(table.text(i, "verdict"))) << table.text(i, "verdict");
    right[table.text(i, "case")] += table.text(i, "verdict") == "right";
  }
  for (const auto& [id, n] : right) EXPECT_GE(n, 1) << id << ": nobody is right";
  // A hundredth of a radian in one step: every method of order 2 and more has an error of 1e-6.
  EXPECT_GE(right["one-step"], static_cast<int>(methods.size()) / 2);
}

// ---- units do not matter

/// The scene in other units: masses times 2^m, lengths times 2^l, times times 2^t.
Scene in_units(Scene scene, int m, int l, int t) {
  RotationData& r = *scene.rotation;
  const double inertia = std::ldexp(1.0, m + 2 * l), rate = std::ldexp(1.0, -t);
  r.moments *= inertia;
  r.w0 *= rate;
  for (auto& load : r.loads) {
    if (auto* g = std::get_if<GravityAboutPivot<double>>(&load)) {
      g->mass = std::ldexp(g->mass, m);
      g->acceleration_S *= std::ldexp(1.0, l - 2 * t);
      g->center_B *= std::ldexp(1.0, l);
    } else if (auto* d = std::get_if<AngularDrag<double>>(&load)) {
      d->coefficients_B *= inertia * rate;
    }
  }
  scene.duration = std::ldexp(scene.duration, t);
  return scene;
}

class Scaling : public testing::TestWithParam<const Method*> {};

// A product of a double and a power of two is exact, and so is everything that steps do, if no constant with
// a unit hides in them. Steps of fixed size, since a default absolute tolerance has a unit.
TEST_P(Scaling, ByPowersOfTwoIsExact) {
  const Method& method = *GetParam();
  for (const char* id : {"hairer-vilmart", "heavy-top", "angular-drag"}) {
    const Scene scene = find_scene(id);
    Setting setting;
    setting.knob = Knob::steps;
    const auto run = [&](const Scene& s) {
      Grid grid;
      const double h = s.duration / 4096;
      grid.stretches.push_back({16 * h, 16, h});
      return run_once(method, s, setting, grid);
    };
    const Trajectory plain = run(scene);
    if (plain.outcome == Outcome::unsupported) continue;
    ASSERT_EQ(plain.samples.size(), 1U) << id << ": " << plain.reason;
    for (const auto& [m, l, t] : {std::tuple(40, 0, 0), std::tuple(-60, 30, 0), std::tuple(3, -7, 50)}) {
      const Trajectory scaled = run(in_units(scene, m, l, t));
      ASSERT_EQ(scaled.samples.size(), 1U) << id << ": " << scaled.reason;
      EXPECT_EQ(scaled.samples[0].q.coeffs(), plain.samples[0].q.coeffs())
          << id << " " << m << " " << l << " " << t;
      EXPECT_EQ(Vec3(scaled.samples[0].w_B * std::ldexp(1.0, t)), plain.samples[0].w_B)
          << id << " " << m << " " << l << " " << t;
    }
  }
}
std::vector<const Method*> own_rows() {
  return rows_with([](const Method& m) {
    return m.version.empty() && m.family != "truth" && m.family != "engine" && m.in_studies;
  });
}
INSTANTIATE_TEST_SUITE_P(Registry, Scaling, testing::ValuesIn(own_rows()),
                         [](const testing::TestParamInfo<const Method*>& of) {
                           std::string name(of.param->id);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

// ---- tolerances

TEST(Tolerances, TheErrorOfTaylorFollowsItsOwn) {
  Plan plan;
  plan.scenes = {find_scene("hairer-vilmart"), find_scene("heavy-top")};
  plan.methods = select_methods({"taylor"});
  const auto tables = tolerances(plan);
  const auto verdict = report::parse_csv(csv(tables.back()));
  ASSERT_GE(verdict.rows(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    // Order and step follow the tolerance together, so that the error does within a decade in fifteen.
    EXPECT_NEAR(verdict.number(i, "slope"), 1, 0.1) << verdict.text(i, "scene");
    EXPECT_EQ(verdict.number(i, "deceived_100"), 0) << verdict.text(i, "scene");
    EXPECT_EQ(verdict.text(i, "below_floor"), "keeps") << verdict.text(i, "scene");
  }
}

// ---- commands

TEST(StabilityCommand, TurnsADialOfAUsersOwnScene) {
  const TemporaryFolder folder;
  folder.write("mine.toml",
               "duration = 1\n[body]\ninertia = [1, 2, 2.5]\n[initial]\nangular_velocity = [1, 0, 0.2]\n"
               "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 2]\n");
  const CommandResult r = polhode_command(
      "stability --scene mine.toml --dial 'load[0].coefficients' --from 100 --to 1000 --solver euler --quick "
      "-o -",
      folder.path());
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const auto table = report::parse_csv(r.out);
  ASSERT_EQ(table.rows(), 2U);  // a quick look takes both ends
  for (std::size_t i = 0; i < 2; ++i) {
    // The largest coefficient is the dial's value, the others keep their ratio to it: rates of 1/2, 1/4,
    // 1/2.5 of it.
    EXPECT_EQ(table.text(i, "parameter"), "load[0].coefficients");
    EXPECT_NEAR(table.number(i, "fastest_per_s") / table.number(i, "parameter_value"), 0.5, 1e-12);
    EXPECT_NEAR(table.number(i, "largest_stable_h_s") * table.number(i, "fastest_per_s"), 2, 0.02);
  }
}

struct Refusal {
  std::string arguments;
  int exit_code;
  std::string words;
};
class StabilityRefusals : public testing::TestWithParam<Refusal> {};
TEST_P(StabilityRefusals, SayWhatIsNeeded) {
  const CommandResult r = polhode_command(GetParam().arguments);
  EXPECT_EQ(r.exit_code, GetParam().exit_code) << r.err;
  EXPECT_THAT(r.err, testing::HasSubstr(GetParam().words));
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << r.err;
}
INSTANTIATE_TEST_SUITE_P(
    All, StabilityRefusals,
    testing::Values(Refusal{"stability angular-drag --dial load[1].coefficients --from 1 --to 2", 65,
                            "load[1].coefficients"},
                    Refusal{"stability angular-drag --dial load[0].coefficients --from 1", 2, "--to"},
                    Refusal{"stability angular-drag --dial duration --from 2 --to 1", 2, "more than --from"},
                    Refusal{"stability --dial duration --from 1 --to 2", 2, "which scene"},
                    Refusal{"stability space-torque --dial duration --from 1 --to 2", 2, "does work"},
                    Refusal{"drift angular-drag --dial duration --from 1 --to 2", 2, "it is for stability"}));

// An interrupted run keeps what it has; the same command goes on from there, and ends with the bytes of a run
// in one go.
TEST(StabilityCommand, GoesOnAfterAnInterrupt) {
  const TemporaryFolder folder;
  const std::string command =
      "stability angular-drag --dial 'load[0].coefficients[0]' --from 3 --to 30 --quick --solver euler "
      "--solver rk4 "
      "--jobs 1 -o out";
  const auto file = [&](const char* name) { return folder.path() / "out" / name; };
  const auto is_interrupted = [&] {
    return nlohmann::json::parse(text_of(file("run.json")))["interrupted"] == true;
  };
  ASSERT_EQ(polhode_command(command, folder.path()).exit_code, 0);
  ASSERT_FALSE(is_interrupted());
  const std::string rows = text_of(file("stability.csv"));
  std::filesystem::remove_all(folder.path() / "out");

  // When rk4 begins, all of euler is done.
  const CommandResult run = interrupted_command(command, folder.path(), "stability: angular-drag, rk4");
  ASSERT_EQ(run.exit_code, 130) << run.out;
  ASSERT_TRUE(is_interrupted()) << run.out;
  const std::string part = text_of(file("stability.csv"));
  const report::CsvTable table = report::parse_csv(part);
  ASSERT_GE(table.rows(), 1U);
  ASSERT_EQ(table.text(0, "solver"), "euler");
  ASSERT_LT(part.size(), rows.size());
  // What was measured is not measured again: a limit that no run would give stays.
  const std::string limit = ',' + table.text(0, "largest_stable_h_s") + ',', no_limit = ",12345,";
  const auto exchanged = [](std::string text, const std::string& old, const std::string& with) {
    const std::size_t at = text.find(old);
    return at == std::string::npos ? "no " + old : text.replace(at, old.size(), with);
  };
  std::ofstream(file("stability.csv"), std::ios::binary) << exchanged(part, limit, no_limit);
  ASSERT_EQ(polhode_command(command, folder.path()).exit_code, 0);
  EXPECT_FALSE(is_interrupted());
  EXPECT_EQ(exchanged(text_of(file("stability.csv")), no_limit, limit), rows);
}

}  // namespace
}  // namespace polhode
