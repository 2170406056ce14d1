// `compare` sees what changed between two result folders, and only that.
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "reports/csv.hpp"
#include "tests/command.hpp"

namespace polhode {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class Compare : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    const CommandResult r = polhode_command(
        "work-precision hairer-vilmart --quick -q --solver rk4 --solver euler -o a", folder_->path());
    ASSERT_EQ(r.exit_code, 0) << r.err;
  }
  static void TearDownTestSuite() { delete folder_; }
  void SetUp() override {
    fs::remove_all(b());
    fs::copy(folder_->path() / "a", b(), fs::copy_options::recursive);
  }
  static fs::path b() { return folder_->path() / "b"; }

  /// Replaces one cell of a table of b.
  static void doctor(const std::string& file, std::size_t row, const std::string& column,
                     const std::string& value) {
    const report::CsvTable table = report::parse_csv(text_of(b() / file));
    std::string out;
    for (std::size_t i = 0; i < table.header().size(); ++i) out += (i ? "," : "") + table.header()[i];
    out += '\n';
    for (std::size_t r = 0; r < table.rows(); ++r) {
      for (std::size_t i = 0; i < table.header().size(); ++i) {
        const std::string& name = table.header()[i];
        out += (i ? "," : "") + (r == row && name == column ? value : table.text(r, name));
      }
      out += '\n';
    }
    std::ofstream(b() / file) << out;
  }
  static nlohmann::json found(int exit_code) {
    const CommandResult r = polhode_command("compare a b --json", folder_->path());
    EXPECT_EQ(r.exit_code, exit_code) << r.err << r.out;
    return nlohmann::json::parse(r.out, nullptr, false);
  }
  /// The first row of rk4 whose error means something.
  static std::size_t row_above_floor() {
    const report::CsvTable t = report::parse_csv(text_of(b() / "work_precision.csv"));
    for (std::size_t i = 0; i < t.rows(); ++i)
      if (t.text(i, "solver") == "rk4" && t.flag(i, "above_floor")) return i;
    return 0;
  }
  static double number(std::size_t row, const char* column) {
    return report::parse_csv(text_of(b() / "work_precision.csv")).number(row, column);
  }
  static std::string text(double x) {
    std::ostringstream s;
    s.precision(17);
    s << x;
    return s.str();
  }

  static TemporaryFolder* folder_;
};
TemporaryFolder* Compare::folder_ = nullptr;

TEST_F(Compare, AFolderIsLikeItself) {
  EXPECT_TRUE(found(0).empty());
  EXPECT_THAT(polhode_command("compare a b", folder_->path()).out, HasSubstr("No difference"));
}

TEST_F(Compare, AnErrorThatGrewIsFatal) {
  const std::size_t row = row_above_floor();
  doctor("work_precision.csv", row, "attitude_error_max_rad",
         text(2 * number(row, "attitude_error_max_rad")));
  const auto rows = found(1);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["change"], "worse");
  EXPECT_THAT(rows[0]["row"], HasSubstr("rk4"));
  EXPECT_NEAR(rows[0]["ratio"], 2, 1e-12);
  EXPECT_THAT(polhode_command("compare a b", folder_->path()).out, HasSubstr("accuracy got worse: 1"));
  // Seen from the other side it has become better.
  EXPECT_EQ(polhode_command("compare b a", folder_->path()).exit_code, 0);
}

TEST_F(Compare, RoundingIsNoChangeForTheWorse) {
  const std::size_t row = row_above_floor();
  doctor("work_precision.csv", row, "attitude_error_max_rad",
         text((1 + 1e-9) * number(row, "attitude_error_max_rad")));
  const auto rows = found(0);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["change"], "changed");
}

TEST_F(Compare, ARunThatFailsNowIsFatal) {
  doctor("work_precision.csv", row_above_floor(), "outcome", "diverged");
  EXPECT_EQ(found(1)[0]["change"], "worse");
}

TEST_F(Compare, ASlowerRunIsToldAndNotFatal) {
  const std::size_t row = row_above_floor();
  doctor("work_precision.csv", row, "time_min_s",
         text(number(row, "time_min_s") + 7 * number(row, "time_mad_s") + 1e-9));
  const auto rows = found(0);
  ASSERT_EQ(rows.size(), 1U);
  EXPECT_EQ(rows[0]["change"], "slower");
}

TEST_F(Compare, RowsThatAreGoneOrNew) {
  doctor("work_precision.csv", row_above_floor(), "solver", "another");
  const auto rows = found(0);
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["change"], "gone");
  EXPECT_EQ(rows[1]["change"], "new");
}

TEST_F(Compare, RefusesWhatIsNoFolder) {
  std::ofstream(b() / "datapackage.json") << "not json";
  EXPECT_EQ(polhode_command("compare a b", folder_->path()).exit_code, 65);
  EXPECT_EQ(polhode_command("compare a nowhere", folder_->path()).exit_code, 65);
  EXPECT_EQ(polhode_command("compare a", folder_->path()).exit_code, 2);
  EXPECT_EQ(polhode_command("compare a b c", folder_->path()).exit_code, 2);
}

}  // namespace
}  // namespace polhode
