// `judge` knows a right file from one that was written down wrongly, and says by how much it is wrong.
#include <cmath>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "experiments/grid.hpp"
#include "experiments/question.hpp"
#include "reports/csv.hpp"
#include "tests/command.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;
using Row = std::map<std::string, double>;

constexpr const char* names[] = {"t_s", "qw",           "qx",           "qy",
                                 "qz",  "wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};

std::vector<Row> rows_of(const std::string& csv) {
  const report::CsvTable table = report::parse_csv(csv);
  std::vector<Row> rows;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Row row;
    for (const char* name : names) row[name] = table.number(i, name);
    rows.push_back(row);
  }
  return rows;
}

std::string csv_of(const std::vector<Row>& rows) {
  std::string text = "t_s,qw,qx,qy,qz,wx_rad_per_s,wy_rad_per_s,wz_rad_per_s\n";
  for (const Row& row : rows) {
    for (const char* name : names) text += (name == names[0] ? "" : ",") + shortest(row.at(name));
    text += '\n';
  }
  return text;
}

Quaternion attitude(const Row& r) { return {r.at("qw"), r.at("qx"), r.at("qy"), r.at("qz")}; }
Vec3 rates(const Row& r) { return {r.at("wx_rad_per_s"), r.at("wy_rad_per_s"), r.at("wz_rad_per_s")}; }
void set(Row& r, const Vec3& w) {
  r["wx_rad_per_s"] = w.x();
  r["wy_rad_per_s"] = w.y();
  r["wz_rad_per_s"] = w.z();
}
void set(Row& r, double w, double x, double y, double z) {
  r["qw"] = w;
  r["qx"] = x;
  r["qy"] = y;
  r["qz"] = z;
}

struct Judged {
  int exit_code;
  nlohmann::json verdict;
  std::vector<std::string> mistakes;
  double max(const std::string& quantity) const {
    for (const auto& e : verdict["errors"])
      if (e["quantity"] == quantity) return e["max"];
    return std::nan("");
  }
};

Judged judge(const std::string& scene, const std::string& text, const std::string& options = "") {
  const TemporaryFolder folder;
  folder.write("t.csv", text);
  const CommandResult r = polhode_command("judge " + scene + " t.csv --json " + options, folder.path());
  Judged j{r.exit_code, nlohmann::json::parse(r.out, nullptr, false), {}};
  EXPECT_FALSE(j.verdict.is_discarded()) << r.err;
  if (!j.verdict.is_discarded())
    for (const auto& m : j.verdict["mistakes"]) j.mistakes.push_back(m["id"]);
  return j;
}

// heavy-top: a torque that needs the attitude, and nothing conserved but the energy; a part of its motion,
// because its truth takes a second.
constexpr const char* scenes[] = {"hairer-vilmart --duration 5", "heavy-top --duration 0.25"};

Scene scene_of(const std::string& id) {
  Scene scene = find_scene(id.substr(0, id.find(' ')));
  const auto duration = id.find("--duration ");
  if (duration != std::string::npos) scene.duration = std::stod(id.substr(duration + 11));
  return scene;
}

const std::string& good_file(const std::string& scene) {
  static std::map<std::string, std::string> files;
  std::string& text = files[scene];
  if (text.empty())
    text = polhode_command("simulate " + scene + " --solver dop853 --rtol 1e-10 --samples 40").out;
  return text;
}

TEST(Judge, GivesAGoodFileItsTrueError) {
  for (const std::string id : scenes) {
    const Scene scene = scene_of(id);
    const auto times = uniform_times(scene.duration, 40);
    const Trajectory run = run_once(find_method("rk4"), scene, {}, grid_of_steps(times, 2000));
    const Errors errors = errors_of(scene, *truth_of(scene, times), run.samples, 1, 2.3e-16);
    const Judged j =
        judge(id, polhode_command("simulate " + id + " --solver rk4 --steps 2000 --samples 40").out);
    EXPECT_EQ(j.exit_code, 0);
    EXPECT_TRUE(j.mistakes.empty()) << j.mistakes.front();
    // The file holds the same doubles, but for axes turned to the user's and back: a few ulp of the states.
    EXPECT_NEAR(j.max("attitude"), errors.attitude_max, 1e-14) << id;
    EXPECT_NEAR(j.max("rate"), errors.rate_max, 1e-14) << id;
    EXPECT_NEAR(j.max("energy"), errors.energy_max, 1e-13) << id;
    EXPECT_NEAR(j.max("momentum"), errors.momentum_max, 1e-14) << id;
  }
}

struct Written {
  const char* id;
  std::function<void(std::vector<Row>&)> mistake;
};

TEST(Judge, RecognisesEachKnownMistakeAndNoOther) {
  const auto each = [](auto f) {
    return [f](std::vector<Row>& rows) {
      for (Row& r : rows) f(r);
    };
  };
  const Written all[] = {
      {"scalar-last", each([](Row& r) { set(r, r["qx"], r["qy"], r["qz"], r["qw"]); })},
      {"inverse-attitude", each([](Row& r) { set(r, r["qw"], -r["qx"], -r["qy"], -r["qz"]); })},
      {"space-rates", each([](Row& r) { set(r, to_space<double>(attitude(r), rates(r))); })},
      {"degrees", each([](Row& r) { set(r, rates(r) * (180 / M_PI)); })},
      {"one-row-late",
       [](std::vector<Row>& rows) {
         for (std::size_t i = rows.size() - 1; i > 0; --i) {
           const double t = rows[i]["t_s"];
           rows[i] = rows[i - 1];
           rows[i]["t_s"] = t;
         }
       }},
  };
  for (const std::string scene : scenes)
    for (const Written& w : all) {
      std::vector<Row> rows = rows_of(good_file(scene));
      w.mistake(rows);
      const Judged j = judge(scene, csv_of(rows));
      EXPECT_THAT(j.mistakes, testing::ElementsAre(w.id)) << scene;
      EXPECT_GT(std::max(j.max("attitude"), j.max("rate")), 1e-2) << scene << " " << w.id;
    }
}

TEST(Judge, RecognisesAMissingGyroscopicTerm) {
  for (const std::string id : scenes) {
    // Euler's equations without (I w) x w, by small steps of our own: order 1, and so 1e-3 beside a mistake
    // of 1.
    const Scene scene = scene_of(id);
    const RotationData& r = *scene.rotation;
    std::string text = "t,qw,qx,qy,qz,wx,wy,wz\n";
    Quaternion q = normalised<double>(r.q0);
    Vec3 w = r.w0;
    constexpr int steps = 60'000;
    const double h = scene.duration / steps;
    for (int i = 0; i <= steps; ++i) {
      if (i % 1000 == 0) {
        const Quaternion u = q * r.principal_to_user.conjugate();
        const Vec3 v = to_space<double>(r.principal_to_user, w);
        text += shortest(i == steps ? scene.duration : i * h);
        for (const double x : {u.w(), u.x(), u.y(), u.z(), v.x(), v.y(), v.z()}) text += ',' + shortest(x);
        text += '\n';
      }
      for (const auto& load : r.loads)
        w += h * std::visit([&](const auto& l) { return l.template torque_B<double>(i * h, q, w); }, load)
                     .cwiseQuotient(r.moments);
      q = q * exp_rotation<double>(h * w);
    }
    EXPECT_THAT(judge(id, text).mistakes, testing::ElementsAre("no-gyroscopic-term")) << id;
  }
  // An engine's own: Bullet with its flag at zero.
  const CommandResult engine =
      polhode_command("simulate hairer-vilmart --solver bullet-none --steps 4000 --samples 40");
  if (engine.exit_code == 0) {
    EXPECT_THAT(judge("hairer-vilmart", engine.out).mistakes, testing::ElementsAre("no-gyroscopic-term"));
  }
}

TEST(Judge, ReadsTumAndOtherNames) {
  std::string tum = "# timestamp tx ty tz qx qy qz qw\n", renamed = "QX,qy,qz,qw,extra,Time\n";
  for (Row& r : rows_of(good_file("hairer-vilmart"))) {
    tum += shortest(r["t_s"]) + " 0 0 0";
    for (const char* c : {"qx", "qy", "qz", "qw"}) tum += ' ' + shortest(-r[c]);  // -q is the same attitude
    tum += '\n';
    for (const char* c : {"qx", "qy", "qz", "qw"}) renamed += shortest(3 * r[c]) + ',';  // of any length
    renamed += "text," + shortest(r["t_s"]) + "\r\n";
  }
  const double error = judge("hairer-vilmart", good_file("hairer-vilmart")).max("attitude");
  for (const std::string& text : {tum, renamed}) {
    const Judged j = judge("hairer-vilmart", text);
    EXPECT_NEAR(j.max("attitude"), error, 1e-14);
    EXPECT_TRUE(std::isnan(j.max("rate")));
    EXPECT_TRUE(j.mistakes.empty());
  }
  EXPECT_THAT(judge("hairer-vilmart", tum, "--quaternion wxyz").mistakes,
              testing::ElementsAre("scalar-last"));
}

TEST(Judge, IsACheckForCi) {
  const std::string& text = good_file("hairer-vilmart");
  const double error = judge("hairer-vilmart", text).max("attitude");
  const auto with = [&](double limit) {
    return judge("hairer-vilmart", text, "--max-error " + shortest(limit)).exit_code;
  };
  EXPECT_EQ(with(1.01 * error), 0);
  EXPECT_EQ(with(0.99 * error), 1);
  EXPECT_EQ(judge("hairer-vilmart", text, "--norm energy --max-error 1e-30").exit_code, 1);
}

#ifdef POLHODE_BARE_BULLET
TEST(Judge, GivesABareBulletProgramItsTrueError) {
  const TemporaryFolder folder;
  const std::string command =
      std::string(POLHODE_BARE_BULLET) + " 4000 40 >'" + (folder.path() / "bare.csv").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const Judged bare = judge("hairer-vilmart", text_of(folder.path() / "bare.csv"));
  const Judged ours = judge(
      "hairer-vilmart",
      polhode_command("simulate hairer-vilmart --solver bullet-implicit-body --steps 4000 --samples 40").out);
  EXPECT_TRUE(bare.mistakes.empty());
  EXPECT_GT(bare.max("attitude"), 1e-3);  // order 1: h = 2.5e-3
  // The same arithmetic in both programs; turning rates between frames rounds.
  EXPECT_NEAR(bare.max("attitude"), ours.max("attitude"), 1e-12);
  EXPECT_NEAR(bare.max("energy"), ours.max("energy"), 1e-12);
}
#endif

TEST(Judge, RefusesBadFilesWithTheirPlace) {
  const TemporaryFolder folder;
  folder.write("head.csv", "time,alpha\n0,1\n");
  folder.write("part.csv", "t,qw,qx,qy\n0,1,0,0\n");
  folder.write("number.csv", "t,qw,qx,qy,qz\n0,1,0,0,0\n1,1,0,nan,0\n");
  folder.write("short.csv", "t,qw,qx,qy,qz\n0,1,0,0,0\n\n1,1,0,0\n");
  folder.write("order.csv", "t,qw,qx,qy,qz\n1,1,0,0,0\n1,1,0,0,0\n");
  folder.write("zero.csv", "t,qw,qx,qy,qz\n0,0,0,0,0\n");
  folder.write("late.csv", "t,qw,qx,qy,qz\n0,1,0,0,0\n11,1,0,0,0\n");
  folder.write("empty.csv", "");
  folder.write("none.csv", "t,qw,qx,qy,qz\n");
  folder.write("twice.csv", "t,wx,wx,wy,wz\n0,1,1,1,1\n");
  folder.write("tum.txt", "# t x y z qx qy qz qw\n0 0 0 0 0 0 0 1\n1 0 0 0 0 0 x 1\n");
  folder.write("binary.csv", std::string("t,\0\xff\x01", 5));
  folder.write("space.csv", "t,wx_space,wy_space,wz_space\n0,1,0,0\n");
  folder.write("particle.csv", "t,px,py,pz\n0,1,0,0\n");
  struct Bad {
    const char *file, *fragment;
  };
  for (const Bad& bad :
       {Bad{"head.csv", "head.csv:1"}, Bad{"part.csv", "needs all or none"},
        Bad{"number.csv", "number.csv:3: column 'qy': got 'nan'"},
        Bad{"short.csv", "short.csv:4: got 4 fields, needs 5"}, Bad{"order.csv", "order.csv:3"},
        Bad{"zero.csv", "zero.csv:2"}, Bad{"late.csv", "--duration"}, Bad{"empty.csv", "needs"},
        Bad{"none.csv", "no rows"}, Bad{"twice.csv", "twice"}, Bad{"tum.txt", "tum.txt:3"},
        Bad{"binary.csv", "zero byte"}, Bad{"space.csv", "attitude"}, Bad{"particle.csv", "nothing in it"},
        Bad{"missing.csv", "missing.csv"}, Bad{".", "'.'"}}) {
    const CommandResult r = polhode_command(std::string("judge hairer-vilmart ") + bad.file, folder.path());
    EXPECT_EQ(r.exit_code, 65) << bad.file << ": " << r.err;
    EXPECT_THAT(r.err, HasSubstr(bad.fragment));
    EXPECT_EQ(r.out, "");
  }
  EXPECT_EQ(polhode_command("judge hairer-vilmart").exit_code, 2);
  EXPECT_EQ(polhode_command("judge hairer-vilmart late.csv --norm speed", folder.path()).exit_code, 2);
  EXPECT_EQ(polhode_command("judge hairer-vilmart late.csv --steps 3", folder.path()).exit_code, 2);
}

}  // namespace
}  // namespace polhode
