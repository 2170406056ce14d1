// The report: what it reads, what it says, and what it must never do (hide a failed run, let text become
// markup, write a path of this machine into a script). Drawing needs gnuplot; every test here holds with and
// without it. What the page does with its data is tested in a browser: page_test.py.
#include "reports/report.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include "reports/csv.hpp"
#include "reports/figures.hpp"
#include "reports/findings.hpp"
#include "reports/pack.hpp"
#include "reports/page.hpp"
#include "reports/stability_map.hpp"
#include "reports/words.hpp"

namespace polhode::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* work_header =
    "scene,solver,knob,knob_value,outcome,steps,rejected_steps,rhs_evals,jacobian_evals,attitude_error_max_"
    "rad,"
    "rate_error_max_rel,energy_error_max_rel,momentum_error_max_rel,unit_defect_max,time_min_s,time_median_s,"
    "time_mad_s,repeats,above_floor\n";

std::string work_row(const std::string& scene, const std::string& solver, int steps, const std::string& error,
                     const std::string& time, const std::string& outcome = "ok", int above = 1) {
  std::ostringstream row;
  row << scene << ',' << solver << ",steps," << steps << ',' << outcome << ',' << steps << ",0," << 4 * steps
      << ",0," << error << ",,,,," << time << ',' << time << ",0,3," << above << '\n';
  return row.str();
}

std::string contents(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// A result folder that disappears with the test.
class Report : public ::testing::Test {
 protected:
  Report() {
    std::string pattern = (std::filesystem::temp_directory_path() / "polhode-report-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
  }
  ~Report() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }

  void put(const std::string& name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  /// Makes the report; returns what its page is told.
  std::string page() {
    outcome_ = write_report(folder_);
    return page_data(read_results(folder_), folder_, {}, read_provenance(folder_), outcome_.notes);
  }

  std::filesystem::path folder_;
  ReportOutcome outcome_;
};

TEST(Csv, QuotedFieldsHoldCommasQuotesAndLineBreaks) {
  const CsvTable t = parse_csv("a,b,c\r\n\"x, y\",\"say \"\"hi\"\"\",\"two\nlines\"\r\n1e-3,,last");
  ASSERT_EQ(t.rows(), 2u);
  EXPECT_EQ(t.text(0, "a"), "x, y");
  EXPECT_EQ(t.text(0, "b"), "say \"hi\"");
  EXPECT_EQ(t.text(0, "c"), "two\nlines");
  EXPECT_EQ(t.number(1, "a"), 1e-3);
  EXPECT_EQ(t.text(1, "c"), "last");
}

TEST(Csv, WhatIsNoNumberIsNan) {
  const CsvTable t = parse_csv("x\n1e-3x\n\"\"\n1e-400\n-2.5e-300\n");
  EXPECT_TRUE(std::isnan(t.number(0, "x")));
  EXPECT_TRUE(std::isnan(t.number(0, "absent")));
  // The second record is one empty field, which RFC 4180 writers produce for an empty cell; blank records are
  // skipped.
  EXPECT_EQ(t.number(1, "x"), 0.0);  // below the smallest double
  EXPECT_EQ(t.number(2, "x"), -2.5e-300);
}

TEST(Csv, AMissingFileIsAnEmptyTable) { EXPECT_TRUE(read_csv("/no/such/folder/table.csv").empty()); }

TEST(Words, NumbersReadLikeAPaper) {
  EXPECT_EQ(pretty_number(1e-8), "10⁻⁸");
  EXPECT_EQ(pretty_number(3.21e-9), "3.21·10⁻⁹");
  EXPECT_EQ(pretty_number(9.999e-9), "10⁻⁸");
  EXPECT_EQ(pretty_number(1000), "1000");
  EXPECT_EQ(pretty_number(0), "0");
  EXPECT_EQ(pretty_time(1.234e-5), "12.3 µs");
  EXPECT_EQ(pretty_time(0.9999e-3), "1 ms");
  EXPECT_EQ(file_name_of("../Heavy top/<1>"), "heavy-top-1");
  EXPECT_EQ(file_name_of("///"), "scene");
}

TEST(Pack, NumbersAreRoundedAndNothingElseIs) {
  EXPECT_EQ(rounded_csv("t,x,who\n1.23456789e-7,1048577,\"1.23456789, so\"\n,-0.1234567,v1.23456789\n", 5),
            "t,x,who\n1.2346e-07,1048577,\"1.23456789, so\"\n,-0.12346,v1.23456789\n");
  EXPECT_EQ(rounded_csv("x\n1e-8\n0.5", 5), "x\n1e-8\n0.5");  // never longer than it was
}

TEST(Pack, PacksAsTheStandardsSay) {
  // RFC 1950 and 4648: zlib's stream of one letter, made by another program.
  EXPECT_EQ(packed("a"), "eNpLBAAAYgBi");
  EXPECT_EQ(packed("</script>").find('<'), std::string::npos);
}

TEST(Findings, OrdersAreMetWithinTheirBand) {
  EXPECT_TRUE(order_met(4, 4.1, 0.01));
  EXPECT_FALSE(order_met(4, 3.8, 0.01));
  EXPECT_TRUE(order_met(4, 3.8, 0.11));  // twice its own error
}

// Ten cells: three grow (one blew up), one loses, two are held, one has no number, three keep.
constexpr const char* some_map =
    "solver,axis,inertia_ratio,h_w,outcome,energy_growth_per_step,grows,theory_h_w\n"
    "rk4,least,0.5,0.01,ok,-1e-14,0,1.5\nrk4,least,0.5,0.1,ok,1e-13,0,1.5\nrk4,least,0.5,1,ok,-2e-3,0,1.5\n"
    "rk4,least,0.5,10,diverged,,,1.5\nrk4,middle,0.5,0.01,ok,1e-13,0,\nrk4,middle,0.5,0.1,ok,1e-5,1,\n"
    "rk4,middle,0.5,1,ok,0.25,1,\nrk4,middle,0.5,10,solver_failed,,,\n"
    "rk4,greatest,1.5,0.01,asleep,0,,\nrk4,greatest,1.5,1,clamped,-0.1,,\n";

TEST(StabilityMap, InWordsCountsEveryCellOnce) {
  const auto maps = stability_maps(parse_csv(some_map));
  ASSERT_EQ(maps.size(), 1u);
  EXPECT_EQ(
      map_sentence(maps.at("rk4")),
      "Gains energy on 30 % of this map (25 % about the axis of least moment, 50 % about the middle axis, 0 "
      "% "
      "about the axis of greatest moment), first at h·|ω| = 0.1, by up to 0.25 a step. Loses more than a "
      "millionth a step on 10 % of it, up to 0.002. Is clamped on 10 % of it, at h·|ω| = 1. Falls "
      "asleep on 10 % of it, at h·|ω| = 0.01. Ends without a number on 10 % of it.");
  EXPECT_EQ(map_sentence({maps.at("rk4").front()}), "Gains energy nowhere on this map.");
}

TEST_F(Report, AnEmptyFolderSaysSo) {
  EXPECT_THAT(page(), HasSubstr("This folder holds no runs."));
  EXPECT_EQ(outcome_.figures, 0);
}

TEST_F(Report, TablesWithOnlyAHeaderSaySo) {
  put("work_precision.csv", work_header);
  put("drift.csv", "scene,solver,knob,knob_value,t_s,rotational_energy_drift_rel\n");
  put("orders.csv", "");
  put("run.json", "{ not json");
  const std::string told = page();
  EXPECT_THAT(told, HasSubstr("This folder holds no runs."));
  EXPECT_THAT(told, HasSubstr("is not JSON"));
}

TEST_F(Report, TheVerdictNamesTheCheapestMeasuredRun) {
  put("work_precision.csv",
      std::string(work_header) + work_row("box", "slow", 10, "1e-3", "1e-3") +
          work_row("box", "slow", 100, "1e-9", "1e-1") + work_row("box", "quick", 10, "1e-3", "1e-5") +
          work_row("box", "quick", 100, "1e-9", "1e-3") + work_row("box", "quick", 200, "1e-10", "2e-3") +
          work_row("box", "crude", 10, "1e-1", "1e-7") +
          work_row("box", "lucky", 10, "1e-9", "1e-9", "clamped"));
  EXPECT_THAT(page(),
              HasSubstr("At 10⁻⁸ rad, quick is the cheapest of 4 solvers: 1 ms; slow needs 100 times that. "
                        "2 of 4 did not get there."));
}

TEST_F(Report, FiguresShowTheBestOfEachFamilyWhereAllWouldCrowd) {
  put("solvers.csv", "solver,family\na1,a\na2,a\nb1,b\nb2,b\nc1,c\n");
  put("work_precision.csv",
      std::string(work_header) + work_row("box", "a1", 10, "1e-9", "2e-3") +
          work_row("box", "a2", 10, "1e-9", "1e-3") + work_row("box", "b1", 10, "1e-2", "1e-3") +
          work_row("box", "b2", 10, "1e-3", "1e-1") + work_row("box", "c1", 10, "", "", "not_finite"));
  const Results r = read_results(folder_);
  // a2 is the cheaper one at 1e-8, b2 the more accurate of those that do not get there, c1 all that c has.
  const CsvTable few = telling_rows(r, r.scenes.front(), r.work_precision, 3);
  ASSERT_EQ(few.rows(), 3u);
  EXPECT_EQ(few.text(0, "solver"), "a2");
  EXPECT_EQ(few.text(1, "solver"), "b2");
  EXPECT_EQ(few.text(2, "solver"), "c1");
  EXPECT_EQ(telling_rows(r, r.scenes.front(), r.work_precision, 5).rows(), 5u);
}

TEST_F(Report, DriftIsRankedOverTheWholeTimeOnly) {
  put("drift.csv",
      "scene,solver,knob,knob_value,t_s,rotational_energy_drift_rel\n"
      "box,good,steps,10,1,1e-9\nbox,good,steps,10,100,-2e-9\nbox,poor,steps,10,100,0.5\nbox,gone,steps,10,1,"
      "1e-15\n");
  EXPECT_THAT(page(),
              HasSubstr("Over 100 s, good keeps the rotational energy best, within 2·10⁻⁹; poor misses it by "
                        "up to 0.5. 1 run ended before that time."));
}

TEST_F(Report, NobodyIsRankedBelowTheFloor) {
  put("scenes.csv",
      "scene,title,duration_s,unknowns,left_out,truth_uncertainty_rad,floor_attitude_rad\nbox,Box,1,7,,1e-9,"
      "1e-7\n");
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4", 10, "1e-3", "1e-3") +
                                work_row("box", "rk4", 100, "1e-9", "1e-1"));
  EXPECT_THAT(page(), HasSubstr("rk4 alone was run here: it reaches 10⁻⁶ rad for 100 ms."));
}

TEST_F(Report, FailedRunsTravelWithThePage) {
  const std::string failed = work_row("box", "euler", 10, "", "", "not_finite");
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4", 10, "1e-3", "1e-3") + failed);
  EXPECT_THAT(page(), HasSubstr(failed.substr(0, failed.size() - 1)));
}

TEST_F(Report, TextNeverBecomesMarkup) {
  put("scenes.csv", "scene,title\nbox,\"</script><script>alert('1')</script><!-- & \"\"co\"\"\"\n");
  put("work_precision.csv", std::string(work_header) + work_row("box", "<i>x</i>", 10, "1e-3", "1e-3"));
  put("run.json", R"({"cpu": "<img src=x>", "<k>": {"<l>": ["<m>"]}})");
  page();
  const std::string html = contents(folder_ / "index.html");
  // All text is in the packed data; around it stands the page as it was built.
  constexpr std::string_view mark = "{{data}}";
  const auto place = page_template.find(mark);
  ASSERT_NE(place, std::string_view::npos);
  const std::string_view after = page_template.substr(place + mark.size());
  ASSERT_GT(html.size(), place + after.size());
  EXPECT_EQ(html.compare(0, place, page_template.substr(0, place)), 0);
  EXPECT_EQ(html.compare(html.size() - after.size(), after.size(), after), 0);
  EXPECT_EQ(html.substr(place, html.size() - after.size() - place).find('<'), std::string::npos);
}

TEST_F(Report, ScriptsHoldRelativePathsOnly) {
  put("work_precision.csv", std::string(work_header) +
                                work_row("/tmp/my scene.toml", "it's", 10, "1e-3", "1e-3") +
                                work_row("/tmp/my scene.toml", "it's", 20, "1e-4", "2e-3"));
  page();
  const std::string script = contents(folder_ / "figures/work-precision-tmp-my-scene-toml.gp");
  EXPECT_THAT(script, HasSubstr("plot 'work-precision-tmp-my-scene-toml.csv'"));
  EXPECT_THAT(script, HasSubstr("name = 'work-precision-tmp-my-scene-toml-'.mm.'mm'"));
  EXPECT_THAT(script, HasSubstr("mine('it''s')"));
  EXPECT_THAT(script, Not(HasSubstr(folder_.string())));
}

TEST_F(Report, EveryFigureIsDrawnOrANoteSaysWhyNot) {
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4", 10, "1e-3", "1e-3") +
                                work_row("box", "rk4", 20, "1e-300", "2e-3") +
                                work_row("box", "one", 20, "0", "2e-3") +
                                work_row("box", "hollow", 20, "1e-9", "2e-3", "ok", 0));
  put("convergence.csv",
      "scene,solver,steps,h_s,outcome,attitude_error_max_rad,above_floor\nbox,rk4,10,0.1,ok,1e-3,1\n"
      "box,rk4,20,0.05,ok,0,0\nbox,euler,10,0.1,not_finite,,\nbox,only-zero,10,0.1,ok,0,1\n");
  put("drift.csv",
      "scene,solver,knob,knob_value,t_s,attitude_error_rad,rotational_energy_drift_rel,momentum_drift_rel\n"
      "box,rk4,steps,10,0,0,0,0\nbox,rk4,steps,10,1,1e-5,-1e-9,1e-300\nbox,rk4,steps,10,2,1e-5,1e300,1e-300\n"
      "box,rk4,rtol,1e-8,2,1e-5,0,0\n");
  put("stability.csv",
      "scene,solver,parameter,parameter_value,h_s,outcome,largest_stable_h_s,theory_h_s,energy_growth_per_"
      "step\n"
      "box,rk4,coefficients[1],10,0.3,diverged,0.278,0.2785,2\nbox,dirk,coefficients[1],10,,ok,5,,\n"
      "box,none,coefficients[1],10,,unsupported,,,\n");
  put("stability_map.csv", some_map);
  page();
  int scripts = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "figures"))
    scripts += entry.path().extension() == ".gp";
  // Work, evaluations, convergence, energy drift, stability and its map; the momentum has nothing but noise
  // below any axis.
  EXPECT_EQ(scripts, 6);
  // Cells of one colour above each other are one rectangle, and together they cover their columns once: four
  // steps with a decade from each to the next, half of one beyond the first and the last.
  const CsvTable drawn = parse_csv(contents(folder_ / "figures/stability-map-rk4.csv"));
  std::map<std::string, std::vector<std::string>> shades;
  std::map<std::string, double> decades;
  for (std::size_t i = 0; i < drawn.rows(); ++i)
    if (const auto kind = drawn.text(i, "kind"); kind == "cell" || kind == "failed") {
      shades[drawn.text(i, "axis")].push_back(drawn.text(i, "shade"));
      decades[drawn.text(i, "axis")] += std::log10(drawn.number(i, "y2") / drawn.number(i, "y1"));
    }
  EXPECT_THAT(shades["least"], ::testing::SizeIs(3));   // keeps twice, loses, blew up
  EXPECT_THAT(shades["middle"], ::testing::SizeIs(4));  // keeps, gains, gains most, no number
  EXPECT_EQ(shades["middle"].back(), "");
  EXPECT_NEAR(decades["least"], 4, 1e-5);  // six digits are written
  EXPECT_NEAR(decades["middle"], 4, 1e-5);
  if (outcome_.figures == scripts) {
    EXPECT_THAT(outcome_.notes, ::testing::IsEmpty());
    // One column of a page is 84 mm wide, two are 174 mm: 317 and 657 px of 1/96 inch.
    EXPECT_THAT(contents(folder_ / "figures/work-precision-box-84mm.svg"), HasSubstr("width=\"317\""));
    EXPECT_THAT(contents(folder_ / "figures/work-precision-box-174mm.svg"), HasSubstr("width=\"657\""));
    EXPECT_THAT(contents(folder_ / "figures/work-precision-box-84mm.pdf"), HasSubstr("%%EOF"));
  } else {
    ASSERT_FALSE(outcome_.notes.empty());
    EXPECT_THAT(outcome_.notes.front(), HasSubstr("gnuplot"));
    EXPECT_THAT(outcome_.notes.front(), Not(HasSubstr("could not draw")));
  }
}

TEST_F(Report, WithoutGnuplotTheScriptsAndANoteRemain) {
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4", 10, "1e-3", "1e-3"));
  const char* path = getenv("PATH");
  const std::string before = path ? path : "";
  setenv("PATH", folder_.c_str(), 1);
  const std::string told = page();
  setenv("PATH", before.c_str(), 1);
  EXPECT_EQ(outcome_.figures, 0);
  ASSERT_EQ(outcome_.notes.size(), 1u);
  EXPECT_THAT(outcome_.notes.front(), HasSubstr("gnuplot is not installed"));
  EXPECT_THAT(told, HasSubstr("gnuplot is not installed"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "figures/evaluations-box.gp"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "figures/evaluations-box.csv"));
}

TEST_F(Report, AnErrorOfZeroSitsOnTheLowerEndWithAMark) {
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4", 10, "1e-3", "1e-3") +
                                work_row("box", "rk4", 20, "0", "2e-3"));
  const std::vector<Figure> figures = figures_of(read_results(folder_));
  ASSERT_FALSE(figures.empty());
  EXPECT_THAT(figures.front().script, HasSubstr("set yrange [0.001:0.01]"));
  EXPECT_THAT(figures.front().script, HasSubstr("shown(y) = y < 0.001 ? 0.001 : y"));
  EXPECT_THAT(figures.front().script, HasSubstr("pointtype 11 pointsize 0.8"));
}

TEST_F(Report, ASolverLooksTheSameInEveryFolderOfOneRegistry) {
  const std::string registry =
      "solver,family,order,source,version,summary\neuler,c,1,,,\nrk4,c,4,,,\nrk4-matrix,c,4,,,\nreference,"
      "truth,,,,\n";
  put("solvers.csv", registry);
  put("work_precision.csv", std::string(work_header) + work_row("box", "rk4-matrix", 10, "1e-3", "1e-3"));
  const Mark alone = read_results(folder_).marks.at("rk4-matrix");
  put("work_precision.csv", std::string(work_header) + work_row("box", "euler", 10, "1e-3", "1e-3") +
                                work_row("box", "rk4-matrix", 10, "1e-3", "1e-3"));
  const Results together = read_results(folder_);
  EXPECT_EQ(together.marks.at("rk4-matrix").colour, alone.colour);
  EXPECT_EQ(together.marks.at("rk4-matrix").filled, alone.filled);
  EXPECT_NE(together.marks.at("rk4-matrix").colour, together.marks.at("rk4").colour);
}

TEST_F(Report, WhatCannotBeWrittenIsAnErrorWithItsPath) {
  std::filesystem::create_directory(folder_ / "index.html");
  try {
    write_report(folder_);
    FAIL() << "a folder was written as a file";
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("index.html"));
  }
}

}  // namespace
}  // namespace polhode::report
