// The contract of truth: by content and not by name, within a budget, a refusal as a value and a row,
// interrupted at any moment, paid for once.
#include "experiments/truth.hpp"

#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <set>
#include <thread>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include "experiments/grid.hpp"
#include "experiments/stability.hpp"
#include "models/errors.hpp"
#include "reports/csv.hpp"
#include "solvers/thread_time.hpp"
#include "tests/command.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;

/// A free body, which has a closed form.
Scene free_body(const Vec3& w0) {
  Scene scene;
  scene.id = "free-body";
  scene.unknowns = 7;
  scene.duration = 10;
  RotationData r;
  r.moments = Vec3(1, 2, 3);
  r.w0 = w0;
  scene.rotation = r;
  return scene;
}

/// A motion that nobody follows in 50 digits: 1e9 rad under a torque.
Scene endless() {
  Scene scene = free_body(Vec3(1e6, 2e5, -3e5));
  scene.id = "endless";
  scene.duration = 1000;
  scene.rotation->loads = {ConstantTorque<double, Frame::body>{Vec3(0.1, 0.2, 0.3)}};
  return scene;
}
constexpr const char* endless_file =
    "title = \"Endless\"\nduration = 1000\n[body]\nmass = 1\ninertia = [1, 2, 3]\n[initial]\n"
    "angular_velocity = [1e6, 2e5, -3e5]\n[[load]]\ntype = \"constant_torque\"\ntorque = [0.1, 0.2, 0.3]\n"
    "frame = \"body\"\n";

Options with_budget(double seconds) {
  Options options;
  options.truth_budget_s = seconds;
  options.quiet = true;
  return options;
}

double rate_at_end(const Scene& scene, double t) {
  const double times[] = {t};
  return truth_of(scene, times)->truth.samples.back().w_B.x().convert_to<double>();
}

TEST(TruthOf, IsThatOfTheContentNotOfTheName) {
  const Scene a = free_body(Vec3(1, 0.2, 0.3)), b = free_body(Vec3(2, 0.2, 0.3));
  ASSERT_EQ(a.id, b.id);
  const double end[] = {10.0};
  for (const Scene* s : {&a, &b, &a})
    EXPECT_EQ(rate_at_end(*s, 10), reference_solution(*s, end).samples.back().w_B.x().convert_to<double>());
  EXPECT_NE(rate_at_end(a, 10), rate_at_end(b, 10));
  Scene renamed = a;
  renamed.id = "another";
  renamed.title = "Another";
  EXPECT_EQ(truth_of(a, end), truth_of(renamed, end));  // one truth, found once
}

TEST(TruthOf, AnyTimesCanBeAsked) {
  const Scene scene = free_body(Vec3(0.7, 0.2, 0.3));
  for (const double t : {10.0, 0.01, 25.0, 3.0}) {  // beyond the duration, too
    const double times[] = {t / 2, t};
    const auto truth = truth_of(scene, times);
    ASSERT_EQ(truth->truth.samples.size(), 3U);  // with the start
    EXPECT_EQ(truth->truth.samples.back().t, Wide(t));
    EXPECT_EQ(truth->truth.samples.back().w_B, reference_solution(scene, times).samples.back().w_B) << t;
  }
}

TEST(TruthOf, ManyThreadsMayAskAtOnce) {
  constexpr int scenes = 4, askers = 4;
  std::vector<std::shared_ptr<const SceneTruth>> got(scenes * askers);
  std::vector<double> floors(got.size());
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < got.size(); ++i)
      threads.emplace_back([&, i] {
        const Scene scene = free_body(Vec3(3, 0.2, 0.01 * double(i % scenes + 1)));
        got[i] = truth_of(scene, uniform_times(scene.duration, 8));
        floors[i] = got[i]->floor().attitude;
      });
  }
  std::set<const SceneTruth*> different;
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i], got[i % scenes]);
    EXPECT_EQ(floors[i], floors[i % scenes]);
    different.insert(got[i].get());
  }
  EXPECT_EQ(different.size(), std::size_t{scenes});
}

TEST(TruthOf, OneThatIsOutOfReachIsAValueThatSaysWhy) {
  Scene scene = endless();
  scene.rotation->w0.z() += 1;
  const double times[] = {500.0, 1000.0};
  const double began = thread_seconds();
  const auto refused = truth_of(scene, times, with_budget(0.25));
  EXPECT_LT(thread_seconds() - began, 2);
  ASSERT_FALSE(refused->is_known());
  EXPECT_TRUE(refused->truth.samples.empty());
  EXPECT_THAT(refused->truth.refusal, HasSubstr("0.25 s"));
  EXPECT_THAT(refusal_text(scene, *refused), HasSubstr("no truth of 'endless': "));
  EXPECT_THAT(refusal_text(scene, *refused), HasSubstr("; --truth-budget S allows more"));
  // Paid once, for these times and for others.
  const double again = thread_seconds(), other[] = {999.0};
  EXPECT_EQ(truth_of(scene, times, with_budget(0.25)), refused);
  truth_of(scene, times, with_budget(0.1));
  EXPECT_LT(thread_seconds() - again, 0.1);
  EXPECT_FALSE(truth_of(scene, other, with_budget(0.25))->is_known());
  // More is tried when more is allowed.
  EXPECT_THAT(truth_of(scene, times, with_budget(0.5))->truth.refusal, HasSubstr("0.5 s"));
  EXPECT_TRUE(std::isnan(refused->floor().conditioning));
  EXPECT_EQ(refused->floor().attitude, 4e-16);
  EXPECT_THROW(needed_truth_of(scene, times, with_budget(0.25)), Error);
  // The first thousandth of a millionth of it can be had all the same.
  const double early[] = {1e-6};
  EXPECT_TRUE(truth_of(scene, early, with_budget(10))->is_known());
}

TEST(TruthOf, OthersAreNotHeldUp) {
  Scene slow = endless();
  slow.rotation->w0.z() += 2;
  std::atomic<bool> slow_is_done = false;
  std::jthread thread([&] {
    const double times[] = {1000.0};
    truth_of(slow, times, with_budget(2));
    slow_is_done = true;
  });
  const Scene quick = free_body(Vec3(4, 0.2, 0.3));
  for (int i = 1; i <= 5; ++i) rate_at_end(quick, i);
  EXPECT_FALSE(slow_is_done);
}

TEST(NoTruth, IsARowOfTolerances) {
  Plan plan;
  plan.options = with_budget(0.1);
  plan.options.quick = true;
  plan.scenes = {endless()};
  plan.methods = {&find_method("cvode-adams"), &find_method("rk4")};
  const std::vector<Table> tables = tolerances(plan);
  ASSERT_EQ(tables.front().rows.size(), 1U);  // rk4 has no tolerance
  EXPECT_EQ(std::get<std::string>(tables.front().rows[0][4]), "no_truth");
  EXPECT_TRUE(tables.back().rows.empty());
}

TEST(NoTruth, IsARowOfEachQuestionAndTheOtherScenesGoOn) {
  const TemporaryFolder folder;
  folder.write("endless.toml", endless_file);
  const CommandResult r = polhode_command(
      "study endless.toml hairer-vilmart --quick --solver rk4 --solver dop853 --truth-budget 0.2 -o out",
      folder.path());
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::string note = "note: no truth of 'endless': ";
  EXPECT_THAT(r.err, HasSubstr(note));
  EXPECT_EQ(r.err.find(note), r.err.rfind(note)) << r.err;  // once
  EXPECT_THAT(r.err, HasSubstr("--truth-budget S allows more"));
  EXPECT_THAT(r.out, HasSubstr("no truth"));
  const auto table_of = [&](const char* file) {
    return report::parse_csv(text_of(folder.path() / "out" / file));
  };
  for (const char* file : {"convergence.csv", "work_precision.csv", "drift.csv", "motion.csv"}) {
    const auto t = table_of(file);
    std::multiset<std::string> refused;
    std::size_t good = 0;
    for (std::size_t i = 0; i < t.rows(); ++i)
      if (t.text(i, "scene") == "endless") {
        EXPECT_EQ(t.text(i, "outcome"), "no_truth") << file;
        refused.insert(t.text(i, "solver"));
        for (const char* column : {"attitude_error_max_rad", "rate_error_max_rel", "time_min_s", "qw"})
          EXPECT_EQ(t.has(column) ? t.text(i, column) : "", "") << file << ": " << column;
      } else {
        good += t.text(i, "outcome") == "ok";
      }
    EXPECT_EQ(refused, (std::multiset<std::string>{"rk4", "dop853"})) << file;
    EXPECT_GT(good, 10U) << file;
  }
  const auto verdicts = table_of("drift_verdict.csv");
  std::size_t refused = 0;
  for (std::size_t i = 0; i < verdicts.rows(); ++i)
    if (verdicts.text(i, "scene") == "endless") {
      EXPECT_EQ(verdicts.text(i, "class"), "no_truth");
      ++refused;
    }
  EXPECT_EQ(refused, 12U);  // two solvers, six quantities
  const auto scenes = table_of("scenes.csv");
  ASSERT_EQ(scenes.rows(), 2U);
  EXPECT_THAT(scenes.text(0, "truth"), testing::StartsWith("none: "));
  EXPECT_EQ(scenes.text(0, "floor_attitude_rad"), "");
  EXPECT_NE(scenes.text(1, "floor_attitude_rad"), "");
  EXPECT_FALSE(text_of(folder.path() / "out" / "index.html").empty());
}

TEST(NoTruth, EndsWhatIsNothingWithoutIt) {
  const TemporaryFolder folder;
  folder.write("endless.toml", endless_file);
  folder.write("run.csv", "t_s,qw,qx,qy,qz\n0,1,0,0,0\n1000,1,0,0,0\n");
  for (const char* command : {"simulate endless.toml --solver reference", "judge endless.toml run.csv",
                              "advise endless.toml --error 1e-6"}) {
    const CommandResult r = polhode_command(std::string(command) + " --truth-budget 0.2", folder.path());
    EXPECT_EQ(r.exit_code, 1) << command;
    EXPECT_EQ(r.out, "") << command;
    EXPECT_THAT(r.err, HasSubstr("polhode: no truth of 'endless': ")) << command;
    EXPECT_THAT(r.err, HasSubstr("--truth-budget S allows more")) << command;
  }
  EXPECT_EQ(polhode_command("simulate endless.toml --solver rk4 --duration 1e-5 --steps 100", folder.path())
                .exit_code,
            0);
}

TEST(NoTruth, IsShown) {
  const TemporaryFolder folder;
  folder.write("endless.toml", endless_file);
  const CommandResult text = polhode_command("show endless.toml --truth-budget 0.2", folder.path());
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("none: "));
  EXPECT_THAT(text.out, HasSubstr("principal moments"));
  const CommandResult json = polhode_command("show endless.toml --truth-budget 0.2 --json", folder.path());
  EXPECT_EQ(json.exit_code, 0);
  const auto truth = nlohmann::json::parse(json.out)["truth"];
  EXPECT_TRUE(truth["kind"].is_null());
  EXPECT_THAT(truth["refusal"].get<std::string>(), HasSubstr("0.2 s"));
  EXPECT_TRUE(
      nlohmann::json::parse(polhode_command("show hairer-vilmart --json").out)["truth"]["refusal"].is_null());
}

/// How a command ended that got a signal after so many seconds of CPU time, and how long that took, s.
struct Ended {
  int exit_code = -1;
  double seconds = 0;
  std::string err;
};
Ended signalled(const std::string& arguments, const TemporaryFolder& folder, int signal, double after) {
  const auto err = folder.path() / "err";
  const pid_t child = fork();
  if (child == 0) {
    const int null = open("/dev/null", O_RDWR), to = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(null, STDIN_FILENO);
    dup2(null, STDOUT_FILENO);
    dup2(to, STDERR_FILENO);
    if (chdir(folder.path().c_str()) != 0) _exit(126);
    const std::string command = "exec '" + std::string(POLHODE_BINARY) + "' " + arguments;
    execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
    _exit(127);
  }
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto ticks = [child] {
    std::string stat = text_of("/proc/" + std::to_string(child) + "/stat");
    std::istringstream fields(stat.substr(std::min(stat.size(), stat.rfind(')') + 1)));
    std::string skipped;
    for (int i = 0; i < 11; ++i) fields >> skipped;
    double user = 0, system = 0;
    fields >> user >> system;
    return user + system;
  };
  const double enough = after * static_cast<double>(sysconf(_SC_CLK_TCK));
  for (const auto began = now(); ticks() < enough && now() - began < std::chrono::seconds(60);)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  const auto began = now();
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  Ended e;
  e.seconds = std::chrono::duration<double>(now() - began).count();
  e.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  e.err = text_of(err);
  return e;
}

class Interrupt : public testing::TestWithParam<int> {};

TEST_P(Interrupt, EndsATruthAtOnce) {
  const TemporaryFolder folder;
  folder.write("endless.toml", endless_file);
  folder.write("run.csv", "t_s,qw,qx,qy,qz\n0,1,0,0,0\n1000,1,0,0,0\n");
  for (const char* command : {"show endless.toml", "simulate endless.toml --solver reference",
                              "judge endless.toml run.csv", "advise endless.toml --error 1e-6",
                              "convergence endless.toml --solver rk4 -o out", "bench endless.toml"}) {
    const Ended e = signalled(command, folder, GetParam(), 0.5);
    EXPECT_EQ(e.exit_code, 130) << command << ": " << e.err;
    EXPECT_LT(e.seconds, 2) << command;
    EXPECT_THAT(e.err, HasSubstr("polhode: interrupted")) << command;
    EXPECT_THAT(e.err, Not(HasSubstr("no truth"))) << command;
  }
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));  // nothing was there to keep
}

TEST_P(Interrupt, KeepsTheScenesThatWereDone) {
  const TemporaryFolder folder;
  folder.write("endless.toml", endless_file);
  const Ended e = signalled("convergence hairer-vilmart endless.toml --quick --solver euler -o out", folder,
                            GetParam(), sanitized ? 10 : 2);
  EXPECT_EQ(e.exit_code, 130) << e.err;
  const auto t = report::parse_csv(text_of(folder.path() / "out" / "convergence.csv"));
  ASSERT_GT(t.rows(), 0U);
  for (std::size_t i = 0; i < t.rows(); ++i) EXPECT_EQ(t.text(i, "scene"), "hairer-vilmart");
}

INSTANTIATE_TEST_SUITE_P(Signals, Interrupt, testing::Values(SIGINT, SIGTERM));

double seconds_of_children() {
  rusage used{};
  getrusage(RUSAGE_CHILDREN, &used);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

TEST(TruthOnDisk, IsPaidForOnce) {
  const TemporaryFolder folder, cache;
  const std::string kept = getenv("XDG_CACHE_HOME");
  setenv("XDG_CACHE_HOME", cache.path().c_str(), 1);
  // Some seconds: a hundred radians under a torque.
  std::string file = endless_file;
  const std::string before = "angular_velocity = [1e6, 2e5, -3e5]";
  file.replace(file.find(before), before.size(), "angular_velocity = [1, 0.2, -0.3]");
  folder.write("long.toml", file);
  double cost[2];
  nlohmann::json shown[2];
  for (const int i : {0, 1}) {
    const double began = seconds_of_children();
    const CommandResult r =
        polhode_command("show long.toml --duration 100 --json --truth-budget 600", folder.path());
    cost[i] = seconds_of_children() - began;
    ASSERT_EQ(r.exit_code, 0) << r.err;
    shown[i] = nlohmann::json::parse(r.out);
    shown[i]["truth"].erase("cost_s");
  }
  setenv("XDG_CACHE_HOME", kept.c_str(), 1);
  EXPECT_EQ(shown[0], shown[1]);
  EXPECT_FALSE(std::filesystem::is_empty(cache.path()));
  EXPECT_LT(cost[1], 0.5 * cost[0]);
}

}  // namespace
}  // namespace polhode
