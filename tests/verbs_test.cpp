// What every verb shares: JSON, completion, the manual page; and bench and doctor, which measure the machine.
#include "experiments/verbs.hpp"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "solvers/registry.hpp"
#include "tests/command.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;

nlohmann::json json_of(const std::string& arguments, const std::filesystem::path& where = ".") {
  const CommandResult r = polhode_command(arguments, where);
  EXPECT_EQ(r.exit_code, 0) << arguments << ": " << r.err;
  const auto j = nlohmann::json::parse(r.out, nullptr, false);
  EXPECT_FALSE(j.is_discarded()) << arguments << ": " << r.out.substr(0, 200);
  return j;
}

TEST(Verbs, JsonIsTheTable) {
  const TemporaryFolder folder;
  const auto rows = json_of("simulate sphere --solver rk4 --steps 100 --samples 4 --json");
  ASSERT_EQ(rows.size(), 5U);
  EXPECT_EQ(rows[4]["t_s"], 10);
  EXPECT_TRUE(rows[0]["qw"].is_number());
  const auto digits = json_of("simulate sphere --digits 25 --json");
  EXPECT_EQ(digits[1]["qw"].get<std::string>().find('e'), std::string(digits[1]["qw"]).size() - 4);
  const auto orders =
      json_of("convergence hairer-vilmart --solver rk4 --quick --json -o " + (folder.path() / "r").string());
  EXPECT_EQ(orders[0]["solver"], "rk4");
  EXPECT_EQ(json_of("report r --json", folder.path())["page"], "r/index.html");
  const auto summary = json_of("study hairer-vilmart --solver rk4 --quick --json -o r", folder.path());
  ASSERT_EQ(summary.size(), 3U);
  EXPECT_EQ(summary[0]["solver"], "rk4");
  EXPECT_TRUE(summary[0]["time_s"].is_number());
  EXPECT_TRUE(summary[0]["below_floor"].is_boolean());
}

TEST(Verbs, PlotFitsATerminal) {
  const TemporaryFolder folder;
  const CommandResult r = polhode_command(
      "work-precision hairer-vilmart --solver rk4 --solver euler --solver dop853 --quick --plot -o r",
      folder.path());
  ASSERT_EQ(r.exit_code, 0) << r.err;
  const std::string plot = r.out.substr(r.out.find("hairer-vilmart: largest"));
  EXPECT_THAT(plot, HasSubstr("attitude error"));
  EXPECT_THAT(plot, HasSubstr(" dop853"));
  EXPECT_THAT(plot, HasSubstr("ms"));
  EXPECT_EQ(plot.find('\033'), std::string::npos);  // no terminal, no colours
  std::istringstream lines(plot);
  int n = 0;
  for (std::string line; std::getline(lines, line); ++n) EXPECT_LE(line.size(), 80U) << line;
  EXPECT_GE(n, 25);
  EXPECT_EQ(polhode_command("work-precision hairer-vilmart --plot -o -").exit_code, 2);
  EXPECT_EQ(polhode_command("drift hairer-vilmart --plot").exit_code, 2);
}

TEST(Verbs, CompletionAndManualKnowEverything) {
  const std::string script = polhode_command("completion bash").out, page = polhode_command("manual").out;
  for (const Verb& v : all_verbs()) {
    EXPECT_THAT(script, HasSubstr(std::string("    ") + v.id + ")\n"));
    EXPECT_THAT(page,
                HasSubstr(std::string(v.summary).substr(0, 20).substr(0, std::string(v.summary).find('-'))));
  }
  for (const Method* m : all_methods()) EXPECT_THAT(script, HasSubstr(std::string(m->id)));
  for (const OptionInfo& o : all_options()) {
    std::string name(o.long_name());
    EXPECT_THAT(script, HasSubstr(name));
    for (std::size_t i = 0; (i = name.find('-', i)) != std::string::npos; i += 2) name.insert(i, "\\");
    EXPECT_THAT(page, HasSubstr(name));
  }
  // Every line that begins with a dot is a request that man knows.
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with('.')) {
      EXPECT_THAT(line, testing::ContainsRegex("^\\.(TH|SH|TP|B|I|RI)( |$)"));
    }

  const TemporaryFolder folder;
  const auto completed = [&](const std::string& typed) {
    folder.write("try.sh", script + "COMP_WORDS=(" + typed +
                               "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); _polhode; " +
                               "printf '%s\\n' \"${COMPREPLY[@]}\" >out\n");
    const std::string command = "cd '" + folder.path().string() + "' && bash try.sh";
    EXPECT_EQ(std::system(command.c_str()), 0);
    return text_of(folder.path() / "out");
  };
  EXPECT_EQ(completed("polhode adv"), "advise\n");
  EXPECT_EQ(completed("polhode advise hairer"), "hairer-vilmart\n");
  EXPECT_EQ(completed("polhode advise heavy-top --norm att"), "attitude\n");
  EXPECT_EQ(completed("polhode simulate heavy-top --solver dop853-"), "dop853-compensated\n");
  EXPECT_EQ(completed("polhode judge heavy-top --max"), "--max-error\n");
  EXPECT_EQ(completed("polhode list sol"), "solvers\n");
  EXPECT_EQ(polhode_command("completion zsh").exit_code, 2);
  EXPECT_EQ(polhode_command("completion").exit_code, 2);
  EXPECT_EQ(polhode_command("manual page").exit_code, 2);
}

TEST(Verbs, BenchSpeaksTheSchemaOfItsLibrary) {
  const auto j = json_of(
      "bench hairer-vilmart thrown-particle --solver rk4 --solver exact --solver rk4-matrix --quick --json");
  EXPECT_TRUE(j["context"].contains("num_cpus"));
  std::set<std::string> names;
  for (const auto& b : j["benchmarks"]) {
    for (const char* key : {"name", "run_name", "run_type", "repetitions"}) EXPECT_TRUE(b.contains(key)) << b;
    names.insert(
        b["run_name"].get<std::string>().substr(0, b["run_name"].get<std::string>().find("/repeats")));
    if (b["run_type"] != "iteration" || b.contains("error_occurred")) continue;
    for (const char* key : {"cpu_time", "real_time", "time_unit", "iterations", "real_time_factor"})
      EXPECT_TRUE(b.contains(key)) << b;
    if (!b["name"].get<std::string>().starts_with("hairer-vilmart/rk4/")) continue;
    EXPECT_LT(b["attitude_error_max_rad"], 1e-6);
    // The same measurement in other words.
    EXPECT_NEAR(b["ns_per_step"].get<double>() * b["steps"].get<double>() / b["cpu_time"].get<double>(), 1,
                1e-6);
    EXPECT_NEAR(b["steps_per_s"].get<double>() * b["ns_per_step"].get<double>(), 1e9, 1e3);
  }
  EXPECT_EQ(names.size(), 6U);  // the matrix form of a particle keeps its row, as an error
  EXPECT_EQ(polhode_command("bench nowhere").exit_code, 2);
  EXPECT_EQ(polhode_command("bench --samples 3").exit_code, 2);
  EXPECT_EQ(polhode_command("bench sphere --solver rk4 --h 0.3").exit_code, 2);
}

TEST(Verbs, DoctorFindsThisBuildHealthy) {
  const auto rows = json_of("doctor --json");
  std::set<std::string> checked;
  for (const auto& row : rows) {
    EXPECT_NE(row["status"], "bad") << row;
    checked.insert(row["check"]);
  }
  for (const char* check : {"version", "compiler", "contraction to fused operations", "numbers below 2e-308",
                            "clock", "closed form", "truth in 50 digits", "order of rk4"})
    EXPECT_TRUE(checked.count(check)) << check;
  EXPECT_EQ(polhode_command("doctor hairer-vilmart").exit_code, 2);
  EXPECT_EQ(polhode_command("doctor --steps 3").exit_code, 2);
  EXPECT_EQ(polhode_command("doctor --frobnicate").exit_code, 2);
}

}  // namespace
}  // namespace polhode
