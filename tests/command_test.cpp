// The program as users meet it: refusals with their sentence and exit code, results, and their repeatability.
#include "tests/command.hpp"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/stat.h>

#include "reports/csv.hpp"
#include "solvers/registry.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;

struct Refusal {
  const char* arguments;
  int exit_code;
  const char* fragment;  // of standard error
};

void PrintTo(const Refusal& r, std::ostream* out) { *out << "polhode " << r.arguments; }

class Refused : public testing::TestWithParam<Refusal> {};

TEST_P(Refused, WithASentenceAndItsExitCode) {
  const TemporaryFolder folder;
  folder.write("bad.toml", "duration = 1\n[body]\nmass = -1\ninertia = [1, 1, 1]\n");
  folder.write(
      "unknown-key.toml",
      "duration = 1\n[body]\nmass = 1\ninertia = [1, 1, 1]\n[initial]\nangular_velocty = [0, 0, 1]\n");
  folder.write(
      "triangle.toml",
      "duration = 1\n[body]\nmass = 1\ninertia = [1, 1, 3]\n[initial]\nangular_velocity = [0, 0, 1]\n");
  folder.write(
      "nan.toml",
      "duration = 1\n[body]\nmass = 1\ninertia = [1, 1, nan]\n[initial]\nangular_velocity = [0, 0, 1]\n");
  folder.write("zero-q.toml",
               "duration = 1\n[body]\nmass = 1\ninertia = [1, 1, 1]\n[initial]\norientation = [0, 0, 0, 0]\n"
               "angular_velocity = [0, 0, 1]\n");
  folder.write("type.toml", "duration = \"long\"\n[body]\nmass = 1\ninertia = [1, 1, 1]\n");
  folder.write("not-toml.toml", "duration = = 1\n");
  folder.write("binary.toml", std::string("\0\xff\xfe\x80", 4));
  folder.write("full/x", "");
  std::filesystem::create_directory(folder.path() / "full");
  folder.write("full/x", "not ours");
  std::filesystem::create_directory(folder.path() / "folder.toml");
  folder.write("big.toml", "");
  std::filesystem::resize_file(folder.path() / "big.toml", 100'000'000);
  const CommandResult r = polhode_command(GetParam().arguments, folder.path());
  EXPECT_EQ(r.exit_code, GetParam().exit_code) << r.err;
  EXPECT_THAT(r.err, HasSubstr(GetParam().fragment));
  EXPECT_THAT(r.err, testing::StartsWith("polhode: "));
  EXPECT_EQ(r.out, "");
}

INSTANTIATE_TEST_SUITE_P(
    CommandLine, Refused,
    testing::Values(
        Refusal{"", 2, "subcommand"}, Refusal{"sudy", 2, "did you mean 'study'"},
        Refusal{"study --frobnicate", 2, "--frobnicate"}, Refusal{"simulate", 2, "needs one scene"},
        Refusal{"simulate hairer-vilmart sphere", 2, "needs one scene"},
        Refusal{"simulate hairer-vilmrt", 2, "hairer-vilmart"},
        Refusal{"simulate hairer-vilmart --solver rk5 --steps 10", 2, "rk4"},
        Refusal{"simulate hairer-vilmart --solver 'zz*' --steps 10", 2, "unknown solver 'zz*'"},
        Refusal{"simulate hairer-vilmart --solver rk4", 2, "--steps"},
        Refusal{"simulate hairer-vilmart --solver rk4 --rtol 1e-6", 2, "fixed steps"},
        Refusal{"simulate hairer-vilmart --solver cvode-adams --steps 10", 2, "--rtol"},
        Refusal{"simulate hairer-vilmart --solver rk4 --h 0.3", 2, "whole number"},
        Refusal{"simulate hairer-vilmart --solver rk4 --h 1e-3x", 2, "1e-3x"},
        Refusal{"simulate hairer-vilmart --solver rk4 --h nan", 2, "nan"},
        Refusal{"simulate hairer-vilmart --solver rk4 --h ''", 2, "--h"},
        Refusal{"simulate hairer-vilmart --solver rk4 --h -0.1", 2, "--h"},
        Refusal{"simulate hairer-vilmart --solver rk4 --steps 0", 2, "--steps"},
        Refusal{"simulate hairer-vilmart --solver rk4 --steps 1.5", 2, "1.5"},
        Refusal{"simulate hairer-vilmart --solver rk4 --steps 99999999999999999999", 2, "--steps"},
        Refusal{"simulate hairer-vilmart --solver rk4 --steps 10 --h 1", 2, "exclude each other"},
        Refusal{"simulate hairer-vilmart --times 1,2 --samples 3", 2, "exclude each other"},
        Refusal{"simulate hairer-vilmart --times 2,1", 2, "must increase"},
        Refusal{"simulate hairer-vilmart --times 1,,2", 2, "--times"},
        Refusal{"simulate hairer-vilmart --times 11", 2, "outside"},
        Refusal{"simulate hairer-vilmart --digits 31", 2, "--digits"},
        Refusal{"simulate hairer-vilmart --digits 25 --solver rk4 --steps 10", 2, "reference"},
        Refusal{"simulate thrown-particle --solver rk4-matrix --steps 10", 2, "attitude"},
        Refusal{"simulate missing.toml", 65, "missing.toml"},
        Refusal{"simulate folder.toml", 65, "folder.toml"}, Refusal{"simulate bad.toml", 65, "bad.toml:3"},
        Refusal{"simulate unknown-key.toml", 65, "angular_velocity"},
        Refusal{"simulate triangle.toml", 65, "I1 + I2"}, Refusal{"simulate nan.toml", 65, "nan.toml:4"},
        Refusal{"simulate zero-q.toml", 65, "orientation"}, Refusal{"simulate type.toml", 65, "type.toml:1"},
        Refusal{"simulate not-toml.toml", 65, "not-toml.toml"},
        Refusal{"simulate binary.toml", 65, "binary.toml"},
        Refusal{"simulate big.toml", 65, "at most 1000000"},
        Refusal{"show hairer-vilmart --truth-budget 0", 2, "0.001"},
        Refusal{"list scenes --truth-budget 1", 2, "cannot follow it"},
        Refusal{"list things", 2, "scenes, solvers, engines"}, Refusal{"show", 2, "needs one scene"},
        Refusal{"report full", 65, "not a result folder"},
        Refusal{"study hairer-vilmart hairer-vilmart", 2, "twice"},
        Refusal{"convergence hairer-vilmart --solver rk4 -o full", 73, "not made by polhode"},
        Refusal{"convergence hairer-vilmart --solver rk4 -o /proc/nowhere/x", 73, "/proc/nowhere"},
        Refusal{"simulate hairer-vilmart -o folder.toml", 73, "folder"},
        Refusal{"simulate hairer-vilmart -o no/such/place.csv", 73, "no/such/place.csv"},
        Refusal{"study hairer-vilmart -o x.csv", 2, "folder"}, Refusal{"study --steps 10", 2, "--steps"},
        Refusal{"convergence sphere --h 0.1", 2, "ladder"}, Refusal{"stability hairer-vilmart", 2, "[stiff]"},
        Refusal{"convergence sphere --solver cvode-adams", 2, "fixed step"},
        Refusal{"stability angular-drag --rtol 1e-6", 2, "--rtol"}));

TEST(Command, FullDiskIsToldNotIgnored) {
  if (!std::filesystem::exists("/dev/full")) return;
  const CommandResult r = polhode_command("simulate hairer-vilmart -o /dev/full");
  EXPECT_EQ(r.exit_code, 73) << r.err;
}

TEST(Command, HelpHasAShortName) {
  EXPECT_EQ(polhode_command("-h").out, polhode_command("--help").out);
  const CommandResult verb = polhode_command("drift -h");
  EXPECT_EQ(verb.exit_code, 0) << verb.err;
  EXPECT_THAT(verb.out, testing::HasSubstr("--h H"));
}

TEST(Command, HelpNamesEveryVerb) {
  const CommandResult r = polhode_command("--help");
  EXPECT_EQ(r.exit_code, 0);
  for (const char* verb :
       {"study", "convergence", "work-precision", "drift", "stability", "simulate", "list", "show"})
    EXPECT_THAT(r.out, HasSubstr(verb));
}

TEST(Command, SimulateGivesExactlyTheAskedRows) {
  const CommandResult asked =
      polhode_command("simulate hairer-vilmart --solver rk4 --steps 1000 --times 0.5,1,7.25");
  const auto table = report::parse_csv(asked.out);
  ASSERT_EQ(table.rows(), 3U) << asked.err;
  EXPECT_EQ(table.text(0, "t_s"), "0.5");
  EXPECT_EQ(table.text(2, "t_s"), "7.25");
  const auto uniform =
      report::parse_csv(polhode_command("simulate tumbling-box --solver rk4 --h 0.001 --samples 4").out);
  ASSERT_EQ(uniform.rows(), 5U);
  EXPECT_EQ(uniform.text(0, "t_s"), "0");
  EXPECT_EQ(uniform.text(4, "t_s"), "10");
  // The parabola of the box: z = 8 t - 4.9 t^2, which RK4 integrates exactly up to rounding of 1e4 sums of
  // ~400 m.
  EXPECT_NEAR(uniform.number(4, "pz_m"), 80 - 490, 1e-9);
}

TEST(Command, TwoStudiesAgreeToTheByteInTheirAccuracyColumns) {
  const TemporaryFolder folder;
  // One solver of each kind; the sanitizers see one scene and three kinds.
  std::string solvers;
  std::set<std::string_view> families;
  for (const Method* m : all_methods())
    if (m->in_studies && families.insert(m->family).second) solvers += "--solver " + std::string(m->id) + " ";
  const std::string what =
      sanitized ? "hairer-vilmart --quick -q --solver rk4 --solver cvode-bdf --solver bullet-implicit-body "
                : "hairer-vilmart angular-drag --quick -q " + solvers;
  ASSERT_EQ(polhode_command("study " + what + "-o a", folder.path()).exit_code, 0);
  ASSERT_EQ(polhode_command("study " + what + "-o b --jobs 1", folder.path()).exit_code, 0);
  for (const char* file : {"convergence.csv", "orders.csv", "drift.csv", "drift_verdict.csv", "stability.csv",
                           "solvers.csv", "scenes.csv"})
    EXPECT_EQ(text_of(folder.path() / "a" / file), text_of(folder.path() / "b" / file)) << file;
  const auto a = report::parse_csv(text_of(folder.path() / "a/work_precision.csv"));
  const auto b = report::parse_csv(text_of(folder.path() / "b/work_precision.csv"));
  ASSERT_EQ(a.rows(), b.rows());
  for (std::size_t i = 0; i < a.rows(); ++i)
    for (const char* column :
         {"scene", "solver", "knob", "knob_value", "outcome", "steps", "rejected_steps", "rhs_evals",
          "attitude_error_max_rad", "rate_error_max_rel", "energy_error_max_rel", "momentum_error_max_rel",
          "unit_defect_max", "above_floor"})
      EXPECT_EQ(a.text(i, column), b.text(i, column)) << column << " of row " << i;
  for (const char* file : {"index.html", "run.json", "datapackage.json"})
    EXPECT_FALSE(text_of(folder.path() / "a" / file).empty()) << file;
  const auto run = nlohmann::json::parse(text_of(folder.path() / "a/run.json"));
  EXPECT_EQ(run["program"], "polhode");
  EXPECT_EQ(run["contraction"], "off");
  // A folder of ours is replaced whole: nothing of the old one stays.
  std::ofstream(folder.path() / "a/left-over") << "x";
  ASSERT_EQ(polhode_command("stability angular-drag --solver euler --quick -q -o a", folder.path()).exit_code,
            0);
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "a/left-over"));
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "a/stability.csv"));
}

TEST(Command, StabilityLimitsAreThoseOfLinearTheory) {
  const CommandResult r = polhode_command(
      "stability angular-drag --dial 'load[0].coefficients[0]' --from 300 --to 3e5 --solver rk4 --quick -o "
      "- " +
      std::string(sanitized ? "" : "--solver euler"));
  const auto table = report::parse_csv(r.out);
  ASSERT_EQ(table.rows(), sanitized ? 2U : 4U) << r.err;  // both ends, two solvers
  std::size_t compared = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double measured = table.number(i, "largest_stable_h_s"), theory = table.number(i, "theory_h_s");
    // The other axes turn and couple at a few rad/s, which shifts the limit by their rate over the stiff one:
    // by less than a thousandth at these rates of 1e3 1/s and more. The bisection of a quick look ends at
    // 5e-3.
    EXPECT_NEAR(measured / theory, 1, 6e-3)
        << table.text(i, "solver") << " " << table.text(i, "parameter_value");
    ++compared;
    const double stiff_rate =
        table.number(i, "parameter_value") / 0.3;  // of the scene: moment 0.3 about that axis
    const double published = table.text(i, "solver") == "euler" ? 2.0 : 2.785293563405282;
    // Beyond the limit |R|^2 grows at a rate of at least 2 per unit of h lambda: where it exceeds one by what
    // is called growth (1e-7), h lambda does by half of that at most.
    EXPECT_NEAR(theory * stiff_rate, published, 0.51e-7);
  }
  EXPECT_EQ(compared, table.rows());
}

TEST(Command, FailedRunsKeepTheirRow) {
  const CommandResult r =
      polhode_command("work-precision thrown-particle --solver rk4-matrix --solver rk4 --quick -o -");
  EXPECT_THAT(r.out, HasSubstr("thrown-particle,rk4-matrix,steps,,unsupported,"));
  EXPECT_THAT(r.out, HasSubstr("thrown-particle,rk4,steps,"));
}

TEST(Command, ListsAreGeneratedFromTheRegistry) {
  const auto solvers = nlohmann::json::parse(polhode_command("list solvers --json").out);
  ASSERT_GE(solvers.size(), 20U);
  for (const auto& s : solvers)
    for (const char* key :
         {"id", "family", "knob", "order", "summary", "source", "claims", "available", "missing"})
      EXPECT_TRUE(s.contains(key)) << s["id"] << " lacks " << key;
  const auto scenes = nlohmann::json::parse(polhode_command("list scenes --json").out);
  EXPECT_GE(scenes.size(), 15U);
}

}  // namespace
}  // namespace polhode
