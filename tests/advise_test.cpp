// `advise` is honest: what it says reaches the error when it is run again, and its first is the fastest.
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/command.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;

nlohmann::json advice(const std::string& arguments, const std::filesystem::path& where = ".") {
  const CommandResult r = polhode_command("advise " + arguments + " --json", where);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  return nlohmann::json::parse(r.out, nullptr, false);
}

// Some of each kind: by steps, by tolerance, without either, an engine.
constexpr const char* few =
    "--solver rk4 --solver dop853 --solver 'odeint-*' --solver symmetric-split --solver exact --solver "
    "cvode-adams "
    "--solver euler ";

TEST(Advise, WhatItSaysReachesTheErrorWhenItIsRunAgain) {
  const TemporaryFolder folder;
  for (const std::string scene : {"hairer-vilmart", "heavy-top --duration 0.25"}) {
    const auto rows = advice(scene + " --error 1e-6 --quick " + few);
    ASSERT_GE(rows.size(), 3U);
    for (const auto& row : rows) {
      EXPECT_LE(row["error"], 1e-6) << row;
      if (row["rank"] > 4) continue;
      const std::string command = row["command"].get<std::string>().substr(std::string("polhode ").size());
      ASSERT_EQ(polhode_command(command + " -o t.csv", folder.path()).exit_code, 0) << command;
      const CommandResult judged =
          polhode_command("judge " + scene + " t.csv --max-error 1e-6 --json", folder.path());
      EXPECT_EQ(judged.exit_code, 0) << command << judged.out << judged.err;
      // The same run, whose error judge finds from the file: the same but for the rounding of a turned
      // quaternion.
      EXPECT_NEAR(nlohmann::json::parse(judged.out)["errors"][0]["max"], row["error"], 1e-14) << command;
    }
  }
}

TEST(Advise, RanksByTimeAndSaysTies) {
  const auto rows = advice(std::string("hairer-vilmart --error 1e-8 --quick ") + few);
  ASSERT_GE(rows.size(), 3U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["rank"], i + 1);
    if (i > 0) {
      EXPECT_GE(rows[i]["time_min_s"], rows[i - 1]["time_min_s"]);
    }
    const double apart = rows[i]["time_min_s"].get<double>() - rows[0]["time_min_s"].get<double>();
    const double spread = rows[i]["time_mad_s"].get<double>() + rows[0]["time_mad_s"].get<double>();
    EXPECT_EQ(rows[i]["tied"], apart <= spread);
    EXPECT_FALSE(rows[i]["why"].get<std::string>().empty());
  }
  // A closed form of 0.4 us beside steppers of 5 us and more: no clock can be that wrong.
  EXPECT_EQ(rows[0]["solver"], "exact");
}

TEST(Advise, RefinesItsSettings) {
  // A plain ladder of powers of two would leave up to a factor of two of rk4's steps; six bisections leave 2
  // % and the grain of 16 samples. A sixteenth fewer steps must miss: the error goes with their fourth power.
  const auto rows = advice("hairer-vilmart --error 1e-7 --quick --solver rk4");
  ASSERT_EQ(rows.size(), 1U);
  const double steps = rows[0]["knob_value"];
  EXPECT_LE(rows[0]["error"], 1e-7);
  EXPECT_GE(rows[0]["error"], 1e-7 * std::pow(1 - 1.0 / 16, 4)) << "steps " << steps;
}

TEST(Advise, OfThoseThatReachTheErrorABudgetKeepsTheFastOnes) {
  // Nobody gets there in a picosecond, all do in ten seconds.
  const CommandResult none =
      polhode_command(std::string("advise hairer-vilmart --error 1e-4 --budget 0.001ns --quick ") + few);
  EXPECT_EQ(none.exit_code, 1) << none.out;
  EXPECT_THAT(none.out + none.err, testing::HasSubstr("more than that time"));
  // How many are left out as far slower is up to the clock; the fastest is not.
  const auto kept = advice(std::string("hairer-vilmart --error 1e-4 --budget 10s --quick ") + few);
  ASSERT_FALSE(kept.empty());
  EXPECT_EQ(kept[0]["solver"], "exact");
  for (const auto& row : kept) EXPECT_LE(row["time_min_s"], 10) << row;
}

TEST(Advise, KeepsABudgetAndAStep) {
  for (const auto& row : advice(std::string("hairer-vilmart --budget '20 us' --quick ") + few))
    EXPECT_LE(row["time_min_s"], 20e-6) << row;
  const auto rows = advice(std::string("hairer-vilmart --engine-step 1/60 --quick ") + few);
  ASSERT_GE(rows.size(), 3U);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["knob_value"], 600);
    if (i > 0) {
      EXPECT_GE(rows[i]["error"], rows[i - 1]["error"]);
    }
  }
}

TEST(Advise, SaysOfAFolderWhatItsTableSays) {
  const TemporaryFolder folder;
  std::string table =
      "scene,solver,knob,knob_value,outcome,rhs_evals,attitude_error_max_rad,time_min_s,time_median_s,time_"
      "mad_s\n";
  table += "s,a,steps,10,ok,40,1e-3,1e-6,1e-6,1e-8\n";   // does not get there
  table += "s,a,steps,20,ok,80,1e-7,3e-6,3e-6,1e-7\n";   // does, in 3 us
  table += "s,a,steps,40,ok,160,1e-9,6e-6,6e-6,1e-7\n";  // and so does this, later
  table += "s,b,rtol,1e-8,ok,50,1e-8,2.9e-6,3e-6,2e-8\n";
  table += "s,c,rtol,1e-8,diverged,50,,,,\n";
  table += "s,d,steps,5,ok,5,1e-9,8e-6,8e-6,1e-7\n";
  folder.write("work_precision.csv", table);
  const auto rows = advice(". --error 1e-6", folder.path());
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0]["solver"], "b");
  EXPECT_EQ(rows[1]["solver"], "a");
  EXPECT_EQ(rows[1]["knob_value"], 20);
  EXPECT_EQ(rows[1]["tied"], true);  // 0.1 us apart, spreads of 0.12 us together
  EXPECT_EQ(rows[2]["solver"], "d");
  EXPECT_EQ(rows[2]["tied"], false);
}

TEST(Advise, RefusesWhatItCannotDo) {
  const TemporaryFolder folder;
  struct Bad {
    const char* arguments;
    int exit_code;
    const char* fragment;
  };
  for (const Bad& bad :
       {Bad{"advise hairer-vilmart", 2, "--error"}, Bad{"advise --error 1e-6", 2, "one scene"},
        Bad{"advise hairer-vilmart --error 0", 2, "--error"},
        Bad{"advise hairer-vilmart --error 1e-6x", 2, "1e-6x"},
        Bad{"advise hairer-vilmart --budget 10", 2, "unit"},
        Bad{"advise hairer-vilmart --engine-step 1/0", 2, "1/60"},
        Bad{"advise hairer-vilmart --engine-step 20", 2, "goes 0.5 times"},
        Bad{"advise hairer-vilmart --error 1e-6 --norm position", 2, "no such error"},
        Bad{"advise . --error 1e-6", 65, "work_precision.csv"},
        Bad{"advise no.toml --error 1", 65, "no.toml"},
        Bad{"show hairer-vilmart --error 1", 2, "show cannot follow it"}}) {
    const CommandResult r = polhode_command(bad.arguments, folder.path());
    EXPECT_EQ(r.exit_code, bad.exit_code) << bad.arguments << ": " << r.err;
    EXPECT_THAT(r.err, HasSubstr(bad.fragment)) << bad.arguments;
  }
  // Nobody gets there: that is an answer, with its own exit code.
  EXPECT_EQ(polhode_command("advise hairer-vilmart --error 1e-12 --solver euler --quick").exit_code, 1);
}

}  // namespace
}  // namespace polhode
