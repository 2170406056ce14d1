// Physics engines beside Bullet, where they are installed: the same step under other names, honest orders,
// loads through every engine's own interface, and what each does behind the user's back, reported.
#include "solvers/engines/engines.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "experiments/question.hpp"
#include "tests/command.hpp"
#include "tests/free_body_runs.hpp"

namespace polhode {

std::vector<Table> engines(const Plan& plan);

namespace {

using testing::HasSubstr;

/// The row of an id, or nothing where its engine is not installed.
const Method* row(std::string_view id) {
  for (const Method* m : all_methods())
    if (m->id == id) return m;
  return nullptr;
}
std::vector<const Method*> engine_rows() {
  std::vector<const Method*> rows;
  for (const Method* m : all_methods())
    if (m->family == "engine") rows.push_back(m);
  return rows;
}

Scene body(const Vec3& moments, const Vec3& w0) {
  Scene s = hairer_vilmart();
  s.rotation->moments = moments;
  s.rotation->w0 = w0;
  return s;
}

double energy_error(const Trajectory& t) {
  return std::abs(t.samples.back().rotational_energy / t.samples.front().rotational_energy - 1);
}

// ---- two runs at a time

// Studies run on all cores: whatever an engine shares between two of its worlds must not show.
TEST(Engines, RunsBesideEachOtherAreThoseOfOneAlone) {
  for (const Method* m : engine_rows()) {
    if (!m->in_studies || !m->by_steps) continue;
    const Grid grid = equal_grid(1, 1, 64);
    const auto end = [&] { return run(*m, hairer_vilmart(), {}, grid).samples.back(); };
    const Sample alone = end();
    std::atomic<int> different{0};
    const auto repeat = [&] {
      for (int k = 0; k < 50; ++k) different += end().w_B != alone.w_B;
    };
    {
      const std::jthread other(repeat);
      repeat();
    }
    EXPECT_EQ(different, 0) << m->id;
  }
}

// ---- one step under several names

TEST(Engines, MujocoTakesBulletsStepsOnAFreeBody) {
  // The same maps, in body and in space components: 1000 steps of 10 ms round some ten numbers each to 2e-16,
  // and the motion carries each for at most 10 s with conditioning 28: 1e-10 at the worst. Asked: 8 digits.
  const std::pair<const char*, const char*> pairs[] = {{"mujoco-euler", "bullet-explicit"},
                                                       {"dart", "bullet-explicit"},
                                                       {"bullet-multibody", "bullet-explicit"},
                                                       {"mujoco-implicit", "bullet-implicit-body"},
                                                       {"ode-quickstep", "ode-step"}};
  for (const auto& [one, other] : pairs) {
    if (!row(one) || !row(other)) continue;
    const Grid grid = equal_grid(10, 20, 50);
    const Trajectory a = run(*row(one), hairer_vilmart(), {}, grid);
    const Trajectory b = run(*row(other), hairer_vilmart(), {}, grid);
    ASSERT_EQ(a.samples.size(), b.samples.size()) << one << ": " << a.reason << b.reason;
    for (std::size_t i = 0; i < a.samples.size(); ++i) {
      EXPECT_LT(attitude_error(a.samples[i].q, b.samples[i].q), 1e-8) << one << ", " << other;
      EXPECT_LT((a.samples[i].w_B - b.samples[i].w_B).norm(), 1e-8 * 3) << one << ", " << other;
    }
  }
}

TEST(Engines, MujocosRungeKuttaIsOfOrderTwoInAttitudeAndFourInEnergy) {
  if (!row("mujoco-rk4")) return;
  // Steps of 0.05, 0.025, 0.0125 s: slopes to within 0.15, as everywhere.
  std::vector<double> attitude, energy, momentum;
  for (const std::int64_t steps : {200, 400, 800}) {
    const Trajectory t = run(*row("mujoco-rk4"), hairer_vilmart(), {}, equal_grid(10, 1, steps));
    attitude.push_back(error_at_10(t.samples.back()));
    energy.push_back(energy_error(t));
    momentum.push_back((t.samples.back().L - t.samples.front().L).norm());
    EXPECT_EQ(t.work.rhs_evals, 4 * steps);
  }
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_NEAR(std::log2(attitude[i - 1] / attitude[i]), 2, 0.15);
    EXPECT_NEAR(std::log2(momentum[i - 1] / momentum[i]), 2, 0.15);
    // As of any Runge-Kutta method of order 4, what adds up of the energy's error has order 5 and what does
    // not has 4.
    EXPECT_GT(std::log2(energy[i - 1] / energy[i]), 3.85);
    EXPECT_LT(std::log2(energy[i - 1] / energy[i]), 5.15);
  }
}

TEST(Engines, SinglePrecisionGetsWorseBelowItsFloor) {
  // Ten times smaller steps make the double build ten times better. In single precision each of the 2e5 steps
  // adds its own rounding, 6e-8 of |w|, and the sum has long passed the error of the method, which is 7e-4.
  const auto error = [](const char* id, std::int64_t steps) {
    return error_at_10(run(*row(id), hairer_vilmart(), {}, equal_grid(10, 1, steps)).samples.back());
  };
  EXPECT_NEAR(error("bullet-implicit-body", 20'000) / error("bullet-implicit-body", 200'000), 10, 0.5);
  EXPECT_GT(error("bullet-implicit-body-f32", 200'000), 1.5 * error("bullet-implicit-body-f32", 20'000));
  EXPECT_GT(error("bullet-implicit-body-f32", 200'000), 5 * error("bullet-implicit-body", 200'000));
}

// ---- loads and parts

std::vector<std::pair<std::string, Scene>> scenes_of_every_kind() {
  std::vector<std::pair<std::string, Scene>> all;
  const auto add = [&all](const char* name, std::vector<AnyTorque<double>> loads) {
    all.emplace_back(name, hairer_vilmart());
    all.back().second.rotation->loads = std::move(loads);
    all.back().second.rotation->q0 = Quaternion(0.8, 0.2, -0.4, 0.4);
  };
  const AngularDrag<double> drag{Vec3(0.1, 0.2, 0.3).asDiagonal()};
  const ConstantTorque<double, Frame::space> in_space{{0.5, -0.2, 0.3}};
  const GravityGradient<double> gradient{1.5, {0.6, 0.8, 1}};
  add("free", {});
  add("weight at a pivot", {GravityAboutPivot<double>{0.9, {0, 0, -9.81}, {0.05, 0.08, 0.2}}});
  add("spring", {AttitudeSpring<double>{2.0, 0.5}});
  add("body torque", {ConstantTorque<double, Frame::body>{{0.1, -0.8, 0.3}}});
  add("three torques", {drag, in_space, gradient});
  Scene particle;
  particle.duration = 1;
  particle.translation = TranslationData{.mass = 2,
                                         .p0 = Vec3(1, -2, 3),
                                         .v0 = Vec3(4, 5, -6),
                                         .acceleration = Vec3(0.3, 0.2, -9.81),
                                         .drag = 0.7,
                                         .has_force = true};
  all.emplace_back("particle", particle);
  add("falling body with drags", {drag});
  all.back().second.translation = particle.translation;
  return all;
}

double distance(const Scene& scene, const Sample& a, const Sample& b) {
  double d = 0;
  if (scene.rotation) d = std::max(attitude_error(a.q, b.q), (a.w_B - b.w_B).norm());
  if (scene.translation) d = std::max({d, (a.p - b.p).norm(), (a.v - b.v).norm()});
  return d;
}

TEST(Engines, LoadsReachThemWhole) {
  // Beside classical Runge-Kutta of steps of 1 ms, which is right to 1e-9 here. Over 1 s a first-order engine
  // errs by about h T/2 |y''| <= 1e-3 / 2 * 30, and half as much with half the step: a load that were left
  // out, doubled, turned or put in the wrong frame would stay whatever the step. An engine that chooses its
  // steps is near at once.
  for (const auto& [name, scene] : scenes_of_every_kind()) {
    const Sample exact = run(find_method("rk4"), scene, {}, equal_grid(1, 1, 1000)).samples.back();
    for (const Method* m : engine_rows()) {
      if (m->claims.attitude_order <= 0 && m->by_steps) continue;  // another motion, or steps of its own
      const std::string what = std::string(m->id) + ", " + name;
      if (!m->by_steps) {
        if (m->id == "simbody-semi-explicit-euler2") continue;  // right, but a minute away
        const Trajectory t = run(*m, scene, tolerance(1e-7), equal_grid(1, 1));
        ASSERT_EQ(t.outcome, Outcome::ok) << what << ": " << t.reason;
        EXPECT_LT(distance(scene, t.samples.back(), exact), 1e-3) << what;
        continue;
      }
      const Trajectory coarse = run(*m, scene, {}, equal_grid(1, 1, 1000));
      const Trajectory fine = run(*m, scene, {}, equal_grid(1, 1, 2000));
      ASSERT_EQ(fine.outcome, Outcome::ok) << what << ": " << fine.reason;
      const double e1 = distance(scene, coarse.samples.back(), exact),
                   e2 = distance(scene, fine.samples.back(), exact);
      EXPECT_LT(e1, 0.015) << what;
      // Single precision, and what has order 2 or none left to show, is at its floor.
      if (m->epsilon < 1e-10 && e1 > 1e-5) {
        EXPECT_GT(e1 / e2, 1.8) << what;
      }
    }
  }
}

TEST(Engines, RunAgainFromTheStart) {
  for (const Method* m : engine_rows()) {
    const Setting setting = m->by_steps ? Setting{} : tolerance(1e-4);
    const Prepared p = m->prepare(hairer_vilmart(), setting);
    ASSERT_TRUE(p.integrate) << m->id << p.unsupported;
    Trajectory first, again;
    const Grid grid = equal_grid(2, 4, 50);
    p.integrate(grid, first);
    p.integrate(equal_grid(1, 1, 100), again);
    p.integrate(grid, again);
    ASSERT_EQ(first.samples.size(), 5u) << m->id << ": " << first.reason;
    ASSERT_EQ(again.samples.size(), 5u) << m->id;
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_EQ(first.samples[i].q.coeffs(), again.samples[i].q.coeffs()) << m->id;
      EXPECT_EQ(first.samples[i].w_B, again.samples[i].w_B) << m->id;
    }
    EXPECT_EQ(first.work.steps, again.work.steps) << m->id;
    EXPECT_GT(first.work.rhs_evals, 0) << m->id;
  }
}

// ---- behind the user's back

TEST(Engines, DefaultsOfBulletFallAsleep) {
  // Below 0.8 m/s and 1 rad/s for two seconds; a btMultiBody sleeps when the squares of its velocities add up
  // to less than its own threshold.
  for (const char* id : {"bullet-defaults", "bullet-multibody-defaults"}) {
    const Trajectory t = run(*row(id), body({0.6, 0.8, 1}, {0.05, 0.1, 0.02}), {}, equal_grid(10, 100, 10));
    EXPECT_EQ(t.outcome, Outcome::asleep) << id << ": " << t.reason;
    EXPECT_THAT(t.reason, HasSubstr("sleep"));
    ASSERT_FALSE(t.samples.empty());
    EXPECT_NEAR(t.samples.back().t, 2.0, 0.2) << id;
  }
}

TEST(Engines, DefaultsOfBulletTakeSixtySteps) {
  // Steps of 1/60 s whatever is asked: from 600 calls over 10 s, or from 6000, the same 600 steps. What is
  // asked between two of them is the last one's state.
  const Trajectory few = run(*row("bullet-defaults"), hairer_vilmart(), {}, equal_grid(10, 1, 600));
  const Trajectory many = run(*row("bullet-defaults"), hairer_vilmart(), {}, equal_grid(10, 1, 6000));
  ASSERT_EQ(few.outcome, Outcome::ok) << few.reason;
  EXPECT_EQ(few.work.rhs_evals, 600);
  EXPECT_NEAR(double(many.work.rhs_evals), 600, 1);  // the clock that gathers h may miss a step by rounding
  const Trajectory exact = run(*row("bullet-world"), hairer_vilmart(), {}, equal_grid(10, 1, 600));
  EXPECT_LT(attitude_error(few.samples.back().q, exact.samples.back().q), 1e-12);
  // A longer call loses what is beyond one step.
  const Trajectory longer = run(*row("bullet-defaults"), hairer_vilmart(), {}, equal_grid(10, 1, 500));
  EXPECT_EQ(longer.outcome, Outcome::clamped);
  EXPECT_THAT(longer.reason, HasSubstr("1/60"));
}

TEST(Engines, DefaultsOfMultibodiesDampAndCutVelocities) {
  const Trajectory damped =
      run(*row("bullet-multibody-defaults"), hairer_vilmart(), {}, equal_grid(10, 1, 600));
  ASSERT_EQ(damped.outcome, Outcome::ok) << damped.reason;
  // Damping 0.04 (1 + |w|) per second or more: at least exp(-2 * 0.04 * 10) = 0.45 of the energy is left at
  // most.
  EXPECT_LT(damped.samples.back().rotational_energy, 0.45 * damped.samples.front().rotational_energy);
  Scene fast = hairer_vilmart();
  fast.translation = TranslationData{.mass = 1, .v0 = Vec3(300, 0, 0)};
  // Damping takes a fifth of 300 m/s in the first step; the limit takes the rest.
  const Trajectory cut = run(*row("bullet-multibody-defaults"), fast, {}, equal_grid(1, 1, 60));
  EXPECT_EQ(cut.outcome, Outcome::clamped) << cut.reason;
  EXPECT_THAT(cut.reason, HasSubstr("100"));
}

TEST(Engines, ABlowUpIsAnOutcomeAndSilent) {
  // The explicit gyroscopic step multiplies the energy of a thin rod by itself: at 100 rad/s and 10 ms it is
  // beyond 1e10 rad/s within the second. MuJoCo would reset the body and go on, DART abort the program.
  const Scene rod = body({1.7231e-4, 6.58e-6, 1.7243e-4}, {1, 100, 1});
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  for (const Method* m : engine_rows()) {
    if (!m->by_steps) continue;
    const Prepared p = m->prepare(rod, {});
    Trajectory t;
    p.integrate(equal_grid(10, 10, 100), t);
    if (m->id == "mujoco-euler" || m->id == "dart") {
      EXPECT_EQ(t.outcome, Outcome::diverged) << m->id << ": " << t.reason;
      EXPECT_THAT(t.reason, HasSubstr("1e10"));
    }
    if (t.outcome != Outcome::ok) {
      EXPECT_FALSE(t.reason.empty()) << m->id;
    }
    Scene wild = rod;
    wild.rotation->w0 = Vec3(1e200, 1e200, 1e200);
    const Prepared q = m->prepare(wild, {});
    q.integrate(equal_grid(10, 1, 100), t);
    EXPECT_NE(t.outcome, Outcome::ok) << m->id;
  }
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_FALSE(std::filesystem::exists("MUJOCO_LOG.TXT"));
}

TEST(Engines, StepsBackwardsAreTakenOrRefused) {
  for (const Method* m : engine_rows()) {
    if (!m->by_steps || m->id.find("defaults") != std::string_view::npos) continue;
    Grid back;
    back.stretches = {{-0.1, 10, -0.01}};
    const Trajectory t = run(*m, hairer_vilmart(), {}, back);
    EXPECT_TRUE(t.outcome == Outcome::ok || t.outcome == Outcome::solver_failed) << m->id << ": " << t.reason;
  }
}

TEST(Engines, SimbodyKeepsItsAccuracyItsLimitsAndItsInterpolation) {
  const Method* const merson = row("simbody-rk-merson");
  if (!merson) return;
  // Accuracy is local: about a thousand steps of 1e-8 each, grown by the conditioning of 28.
  const Trajectory t = run(*merson, hairer_vilmart(), tolerance(1e-8), equal_grid(10, 1));
  EXPECT_LT(error_at_10(t.samples.back()), 1e-5);
  EXPECT_GT(t.work.rhs_evals, 4 * t.work.steps);
  // Asked times do not change the steps: what is in between is interpolated.
  const Trajectory often = run(*merson, hairer_vilmart(), tolerance(1e-8), equal_grid(10, 200));
  ASSERT_EQ(often.samples.size(), 201u) << often.reason;
  EXPECT_EQ(often.work.steps, t.work.steps);
  Setting limited = tolerance(1e-8);
  limited.step_limit = 50;
  EXPECT_EQ(run(*merson, hairer_vilmart(), limited, equal_grid(10, 2)).outcome, Outcome::step_limit);
  Setting hurried = tolerance(1e-10);
  hurried.timeout_s = 0;
  EXPECT_EQ(run(*merson, hairer_vilmart(), hurried, equal_grid(1000, 1)).outcome, Outcome::timeout);
}

TEST(Engines, SettingsAndVersionAreStated) {
  for (const Method* m : engine_rows()) {
    EXPECT_FALSE(m->settings.empty()) << m->id;
    EXPECT_TRUE(m->version.find(' ') != std::string_view::npos) << m->id << ": '" << m->version << "'";
  }
  const CommandResult listed = polhode_command("list engines");
  EXPECT_EQ(listed.exit_code, 0);
  for (const Method* m : engine_rows()) {
    EXPECT_THAT(listed.out, HasSubstr(std::string(m->settings)));
    EXPECT_THAT(listed.out, HasSubstr(std::string(m->version)));
  }
}

// ---- the question about them

TEST(Engines, TheQuestionTellsRightFromWrong) {
  Plan plan;
  plan.scenes = {find_scene("hairer-vilmart"), find_scene("heavy-top")};  // the second does not turn freely
  plan.options.quick = plan.options.quiet = true;
  plan.options.solvers = {"bullet-none", "bullet-implicit-body*"};
  plan.methods = select_methods(plan.options.solvers);
  const Table table = engines(plan)[0];
  ASSERT_EQ(table.rows.size(), 9u);  // three solvers, three step sizes
  const auto cell = [&](std::size_t row, std::string_view column) -> const Cell& {
    const auto at = std::find_if(table.columns.begin(), table.columns.end(),
                                 [&](const Column& c) { return c.name == column; });
    return table.rows[row][static_cast<std::size_t>(at - table.columns.begin())];
  };
  const auto said = [&](std::size_t row, std::string_view column) {
    return std::get<std::string>(cell(row, column));
  };
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(said(i, "outcome"), "ok");
  EXPECT_EQ(said(0, "mode"), "none");
  EXPECT_THAT(said(0, "verdict"), HasSubstr("not this motion"));
  EXPECT_EQ(said(3, "mode"), "implicit-body");
  EXPECT_EQ(said(3, "precision"), "double");
  EXPECT_THAT(said(3, "verdict"), HasSubstr("energy lost"));
  EXPECT_EQ(said(6, "mode"), "implicit-body");
  EXPECT_EQ(said(6, "precision"), "single");
  for (const char* order : {"attitude_order", "energy_order", "momentum_order"})
    EXPECT_NEAR(std::get<double>(cell(5, order)), 1, 0.15) << order;
  const double h = std::get<double>(cell(5, "h_s")), ns = std::get<double>(cell(5, "ns_per_step"));
  EXPECT_NEAR(std::get<double>(cell(5, "real_time_factor")) / (h / (1e-9 * ns)), 1, 1e-12);
}

// ---- modules

/// A program of its own: the binary with its modules and scenes, which may be spoilt.
class Copy {
 public:
  Copy() {
    namespace fs = std::filesystem;
    const fs::path binary(POLHODE_BINARY), from = binary.parent_path().parent_path();
    fs::create_directories(modules());
    fs::create_directories(folder_.path() / "bin");
    fs::copy(binary, folder_.path() / "bin" / "polhode");
    for (const auto& file : fs::directory_iterator(from / "lib" / "polhode"))
      fs::create_symlink(file.path(), modules() / file.path().filename());
    fs::create_symlink(from / "share", folder_.path() / "share");
  }
  std::filesystem::path modules() const { return folder_.path() / "lib" / "polhode"; }
  /// Replaces a module by this file's worth of bytes.
  void put(const std::string& module, const std::string& bytes) const {
    std::filesystem::remove(modules() / module);
    std::ofstream(modules() / module, std::ios::binary) << bytes;
  }
  CommandResult operator()(const std::string& arguments, const std::string& environment = "") const {
    const auto out = folder_.path() / "out", err = folder_.path() / "err";
    const std::string command = environment + " '" + (folder_.path() / "bin" / "polhode").string() + "' " +
                                arguments + " >'" + out.string() + "' 2>'" + err.string() + "' </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(out), text_of(err)};
  }

 private:
  TemporaryFolder folder_;
};

TEST(EngineModules, ASpoiltOneIsOneSentenceAndDisturbsNothing) {
  const Copy copy;
  const std::string whole = text_of(copy.modules() / "polhode-bullet-f32.so");
  ASSERT_GT(whole.size(), 1000u);
  std::string other_version = whole;
  const std::size_t stamp = engine_stamp;
  std::string stamp_bytes(sizeof stamp, '\0');
  std::memcpy(stamp_bytes.data(), &stamp, sizeof stamp);
  const std::size_t at = other_version.find(stamp_bytes);
  ASSERT_NE(at, std::string::npos);
  ++other_version[at];

  const auto expect_one_sentence = [&copy](const char* what, const char* said) {
    const CommandResult r = copy("simulate hairer-vilmart --solver bullet-none-f32 --steps 1000");
    EXPECT_EQ(r.exit_code, 69) << what << r.err;
    EXPECT_EQ(r.out, "") << what;
    EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 1) << what << r.err;
    EXPECT_THAT(r.err, HasSubstr("bullet-f32")) << what;
    EXPECT_THAT(r.err, HasSubstr(said)) << what;
    // The engine beside it, our own solvers, and the lists go on.
    EXPECT_EQ(copy("simulate hairer-vilmart --solver bullet-none --steps 1000").exit_code, 0) << what;
    const CommandResult list = copy("list engines");
    EXPECT_EQ(list.exit_code, 0) << what;
    EXPECT_THAT(list.out, HasSubstr(said)) << what;
  };
  std::filesystem::remove(copy.modules() / "polhode-bullet-f32.so");
  expect_one_sentence("missing", "libbullet-dev");
  copy.put("polhode-bullet-f32.so", "not a module\n");
  expect_one_sentence("text", "cannot be opened");
  copy.put("polhode-bullet-f32.so", whole.substr(0, whole.size() / 2));
  expect_one_sentence("half", "cannot be opened");
  copy.put("polhode-bullet-f32.so", other_version);
  expect_one_sentence("of another version", "another version");
}

TEST(EngineModules, OnlyWhatIsAskedForIsOpened) {
  const auto opened = [](const std::string& arguments) {
    const Copy copy;
    const CommandResult r = copy(arguments + " --quiet", "LD_DEBUG=files");
    EXPECT_EQ(r.exit_code, 0) << arguments;
    std::vector<std::string> modules;
    for (std::size_t i = 0; i < engine_count(); ++i) {
      const std::string& id = open_engine(i).id;
      if (r.err.find("/polhode-" + id + ".so") != std::string::npos) modules.push_back(id);
    }
    return modules;
  };
  EXPECT_THAT(opened("simulate hairer-vilmart --solver rk4 --steps 10"), testing::IsEmpty());
  EXPECT_THAT(opened("simulate hairer-vilmart --solver odeint-rk4 --steps 10"), testing::IsEmpty());
  EXPECT_THAT(opened("simulate hairer-vilmart --solver bullet-none --steps 1000"),
              testing::ElementsAre("bullet", "bullet-f32"));
}

}  // namespace
}  // namespace polhode
