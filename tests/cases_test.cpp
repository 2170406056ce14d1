// Scenes that users would bring (tests/cases), whose right values were found by others' arithmetic: Taylor
// series in (q, L), closed forms, exact fractions, or DOP853 at 2e-14 where 14 digits are shown. Values
// belong to the doubles of the file, in the file's own body axes. What the format says in other words is
// refused with those words.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/errors.hpp"
#include "solvers/floor.hpp"
#include "solvers/second_method.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string file_of(const std::string& name) {
  return std::string(POLHODE_TESTS) + "/cases/" + name + ".toml";
}
Scene scene_of(const std::string& name) { return read_scene(file_of(name)); }

/// The truth at t in the file's axes: q, then w.
std::array<Checked, 7> found(const Scene& scene, double t) {
  const std::array<double, 2> times{0, t};
  const Truth truth = reference_solution(scene, times);
  const SecondMethod second(exact_scene(scene));
  const StatedState s = second.stated(truth.samples.back());
  const Vec3T<Checked> w = second.rates_U(s);
  return {s.x[0], s.x[1], s.x[2], s.x[3], w[0], w[1], w[2]};
}

struct Shown {
  const char* file;
  double t;
  std::vector<std::string> q, w;
};
// How a test that fails is named.
void PrintTo(const Shown& shown, std::ostream* out) { *out << shown.file; }

class Case : public testing::TestWithParam<Shown> {};

TEST_P(Case, HasTheValueShown) {
  const Shown& shown = GetParam();
  const auto got = found(scene_of(shown.file), shown.t);
  const auto largest = [](const std::vector<std::string>& v) {
    std::size_t at = 0;
    for (std::size_t i = 1; i < v.size(); ++i)
      if (abs(Checked(v[i])) > abs(Checked(v[at]))) at = i;
    return at;
  };
  // 33 digits of each number; both sides are right to about 36.
  const auto expect = [&](const Checked& x, const std::string& want, const Checked& scale) {
    EXPECT_LE(Checked(abs(x - Checked(want)) / abs(scale)).convert_to<double>(), 2e-32)
        << "got " << x.str(35) << ", shown " << want;
  };
  const std::size_t q = largest(shown.q), w = largest(shown.w);
  // q and -q are one attitude.
  const int side = (got[q] < 0) == (Checked(shown.q[q]) < 0) ? 1 : -1;
  for (std::size_t i = 0; i < 4; ++i) expect(Checked(side * got[i]), shown.q[i], Checked(shown.q[q]));
  for (std::size_t i = 0; i < 3; ++i) expect(got[4 + i], shown.w[i], Checked(shown.w[w]));
}

INSTANTIATE_TEST_SUITE_P(
    All, Case,
    testing::Values(
        Shown{"urdf-inertial-rpy--by-hand",
              4,
              {"-5.26549462706162183991010239680328e-01", "6.00538978278256572347287609163565e-01",
               "2.71575733978803937396068854987374e-02", "-6.01133150890464815080734100606768e-01"},
              {"6.89073988578595802213745036128883e-01", "-6.24594288726362076386345480781426e-01",
               "-6.63396126313435852068771263999560e-01"}},
        Shown{"urdf-inertial-rpy--six",
              4,
              {"-5.18016592330147853799351856865100e-01", "5.48546239481542344541170934899700e-01",
               "3.10761261969124268147273905702740e-01", "-5.78085868431911348043851648586156e-01"},
              {"3.78124788946326665958260778187943e-01", "-1.28895109219964644531926868931373e-01",
               "-1.07287085108821743644906821791591e+00"}},
        Shown{"urdf-inertial-rpy--box-rpy",
              4,
              {"-5.18016592330147737908744152059934e-01", "5.48546239481542084010168488541443e-01",
               "3.10761261969124589267189698426157e-01", "-5.78085868431911526486077457127290e-01"},
              {"3.78124788946325676174932668203159e-01", "-1.28895109219964715207030413713470e-01",
               "-1.07287085108821788933449512778553e+00"}},
        Shown{"urdf-offdiagonal-order--input",
              10,
              {"-4.70254046041753963985156793937824e-01", "3.81197138648220785586986389152632e-01",
               "-4.69723920060467932077476048921904e-01", "6.42580199345417282892953807712215e-01"},
              {"9.91446532884482638260398497700197e-01", "-1.05671547397990978118393852516072e+00",
               "2.10027026413871487254346255010250e+00"}},
        Shown{"underflow--input",
              100,
              {"9.72965034654273832690482400009430e-01", "-7.17137290830169058135565275217313e-02",
               "-2.16446317718884644868268592824846e-01", "3.67038682859316352901506738506280e-02"},
              {"6.96980876099253515394782145314571e-02", "3.94497096218929415300530405368097e-01",
               "2.84758108573113834749452277514095e-02"}},
        Shown{"toutatis-deg-day--input",
              2001013,
              {"2.96254612595007416942249177115606e-01", "-6.55220338767939150881264220098907e-01",
               "-2.76003805046500663718382539112808e-02", "-6.94375785275529075105539118366903e-01"},
              {"-7.78675759683792409426914635839375e-06", "2.94186312478609136951273965069660e-07",
               "-1.96224275030571543516475868755933e-05"}},
        Shown{"goldstein-top--input",
              6,
              {"-6.43514450134070387891725831028692e-01", "-8.01500046947680900961803912397960e-02",
               "6.12527512290609021563792016463731e-02", "-7.58757688384733579951660297470276e-01"},
              {"1.43187804017994169600992481291933e-02", "2.10376320449927914898674211571692e-47",
               "3.43000000000000015987211554602254e+00"}},
        Shown{"pendulum-pivot--input",
              2.4,
              {"9.99754976725456748409796767628200e-01", "2.21356389716094548243597567094670e-02",
               "0.00000000000000000000000000000000e+00", "0.00000000000000000000000000000000e+00"},
              {"7.66236153832303765803759647597662e+00", "0.00000000000000000000000000000000e+00",
               "0.00000000000000000000000000000000e+00"}},
        Shown{"pendulum-pivot--part",
              2.4,
              {"9.99754976725456760444512612773211e-01", "2.21356389716089112770478814033872e-02",
               "0.00000000000000000000000000000000e+00", "0.00000000000000000000000000000000e+00"},
              {"7.66236153832303738953485767338308e+00", "0.00000000000000000000000000000000e+00",
               "0.00000000000000000000000000000000e+00"}},
        Shown{"loads-full-tensor--drag",
              6,
              {"3.51246989266910931576823509669949e-01", "5.95803440263288028875973106840523e-01",
               "7.18629174175470814647431603763913e-01", "-7.22213481267274664055673741645559e-02"},
              {"-1.03263089458997031705991620598219e+00", "2.30618847325955388234767537056709e-01",
               "-1.40988653744058422368226891631515e-01"}},
        Shown{"loads-full-tensor--torque-body",
              6,
              {"-1.88573254070567712457953263310723e-01", "-1.79537929304870620666917100812764e-01",
               "2.17195243229332090405754743802666e-01", "-9.40761652124866147074363655931760e-01"},
              {"-2.16814026808827349306924739723532e+00", "6.32447574679652467477194181816011e-01",
               "7.05941023128146836579208069822918e+00"}},
        Shown{"loads-full-tensor--torque-space",
              6,
              {"-3.67250307660641178659638215447730e-01", "-2.54967750619475908128364426822246e-01",
               "-8.06132592837344850056977590807838e-01", "-3.87645328144876174543399112080560e-01"},
              {"-9.16994706234072063089743572849912e+00", "3.44409475048608217580625443329238e+00",
               "-2.20726447354760793098498495903083e+00"}},
        Shown{"loads-full-tensor--spring",
              6,
              {"9.88703047277042511107911022665820e-01", "-1.33065921001786226720419907780593e-01",
               "3.31394780646741384315336324763441e-02", "-6.05104946818120961760065470597539e-02"},
              {"-1.48327007946451106604628612359148e+00", "9.12544854670186246391587749510445e-01",
               "-1.30529872770946979853383726536570e-01"}},
        Shown{"loads-full-tensor--pivot",
              6,
              {"-9.97709335062921046417348841860988e-01", "-7.34792281340455796951896554829882e-03",
               "-7.19333033474499590236249383731406e-03", "-6.68606517865884293511157758605012e-02"},
              {"-2.00249556049322047821810791506047e+00", "-4.79745497923166707086544762490781e-01",
               "3.01655148810786381198316471138491e+00"}},
        Shown{"loads-full-tensor--gg",
              6,
              {"-5.24630280773763007362625398476634e-01", "-4.18095209672023249485933426564206e-01",
               "3.18902119584321756608032007702794e-02", "7.40906524823338142468036943378367e-01"},
              {"1.91706453543663106858909173193056e-01", "1.10885282333959005267406881507646e+00",
               "1.84679016980304775927918659508703e+00"}},
        Shown{"loads-full-tensor--all",
              6,
              {"-4.98241020719907636069701964197165e-01", "1.07896226430698541571104474930014e-01",
               "-6.36484689912297529184408850629936e-01", "-5.78793166080290256070437008657268e-01"},
              {"-6.12452376795175089347217963186940e+00", "8.70683715124225950401641503866203e-01",
               "2.06117766238629689529874412590387e-01"}},
        Shown{"spring-over-half-turn--input",
              6,
              {"9.26033344160508661719925416557096e-01", "-3.27033495004673037647812797786753e-01",
               "5.18485711119032880944748356411070e-02", "-1.81171367278572255164620941369497e-01"},
              {"1.55688110091724145764035171927133e-01", "-1.93732296396334857326910917979445e-01",
               "-6.51402260728348841382243758151544e-02"}}),
    [](const testing::TestParamInfo<Shown>& shown) {
      std::string name = shown.param.file;
      for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
      return name;
    });

TEST(Cases, ATorqueAboutAPrincipalAxis) {
  const auto x = found(scene_of("urdf-inertial-rpy--torque"), 1);
  EXPECT_LT(abs(Checked(x[0] - cos(Checked(1) / 4))).convert_to<double>(), 1e-45);
  EXPECT_LT(abs(Checked(x[1] - sin(Checked(1) / 4))).convert_to<double>(), 1e-45);
  EXPECT_LT(abs(Checked(x[4] - 1)).convert_to<double>(), 1e-45);
}

TEST(Cases, PrincipalMomentsOfALink) {
  Vec3 moments = scene_of("urdf-offdiagonal-order--input").rotation->moments;
  std::sort(moments.data(), moments.data() + 3);
  EXPECT_NEAR(moments[0], 0.17958059, 0.5e-8);
  EXPECT_NEAR(moments[1], 0.31247395, 0.5e-8);
  EXPECT_NEAR(moments[2], 0.36134547, 0.5e-8);
}

TEST(Cases, AQuarterPeriodOfTheTennisRacket) {
  // L = (0, 2, 0.01): w_y is largest at the start and zero a quarter period on.
  const Scene scene = scene_of("underflow--input");
  EXPECT_GT(found(scene, 29.5277217615963)[5], 0);
  EXPECT_LT(found(scene, 29.5277217615965)[5], 0);
}

TEST(Cases, ATurnOverOfNextToNothing) {
  const Scene scene = scene_of("underflow--middle-1e-200");
  EXPECT_GT(found(scene, 709.18381332484)[5], 0);
  EXPECT_LT(found(scene, 709.18381332485)[5], 0);
  EXPECT_NEAR(found(scene, 1000)[5].convert_to<double>(), -1.2, 1e-14);
}

TEST(Cases, AHeavyTopNods) {
  // From 0.2 rad down to 0.2021008 rad and back in the period shown.
  const Scene scene = scene_of("goldstein-top--input");
  const auto tilt = [&](double t) {
    const auto x = found(scene, t);
    const Checked c = 1 - 2 * (x[1] * x[1] + x[2] * x[2]);
    return acos(c).convert_to<double>();
  };
  EXPECT_NEAR(tilt(0.925405398794870 / 2), 0.202100815388372, 1e-14);
  EXPECT_NEAR(tilt(0.925405398794870), 0.2, 1e-14);
}

TEST(Cases, APhysicalPendulum) {
  // A rod hung by its end, as numbers, as a shape and as a part: tilt from the downward vertical and its
  // rate.
  for (const char* name : {"pendulum-pivot--input", "pendulum-pivot--part", "pendulum-pivot--part-no-com",
                           "pendulum-pivot--shape"}) {
    const auto x = found(scene_of(name), 2.4);
    const Checked tilt = 2 * atan2(x[1], x[0]);
    // The ideal rod let go level; the doubles of the files are off by half an ulp each.
    EXPECT_NEAR(Checked(tilt - Checked("0.0442748941288046663")).convert_to<double>(), 0, 2e-15) << name;
    EXPECT_NEAR(Checked(x[4] - Checked("7.662361538323037407")).convert_to<double>(), 0, 4e-15) << name;
  }
}

/// With floor and duration as asked.
Floor floor_at(const std::string& name, double end) {
  Scene scene = scene_of(name);
  scene.duration = end;
  std::vector<double> times;
  for (int i = 0; i <= 16; ++i) times.push_back(end * i / 16);
  return floor_of(scene, times, reference_solution(scene, times), {});
}

TEST(Cases, AFlipThatRoundingDecides) {
  EXPECT_LT(floor_at("flip-floor--input", 30).attitude, 1e-9);
  EXPECT_GT(floor_at("flip-floor--input", 118).attitude, 3);
  EXPECT_GT(floor_at("flip-floor--input", 250).attitude, 3);
}

TEST(Cases, TinyAngularMomentaAcrossTheAxis) {
  for (const char* name :
       {"underflow--L-1e-160", "underflow--L-1e-200", "underflow--L-2.2250738585072014e-308",
        "underflow--L-5e-324", "underflow--middle-1e-10", "underflow--middle-1e-12",
        "underflow--middle-1e-20", "goldstein-top--1.9", "goldstein-top--mathematics",
        "pendulum-pivot--particle", "spring-over-half-turn--upside-down"}) {
    const Scene scene = scene_of(name);
    const auto x = found(scene, scene.duration);  // the proof is part of it
    EXPECT_NEAR((x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]).convert_to<double>(), 1, 1e-15)
        << name;
  }
}

std::string refusal(const std::string& name) {
  try {
    (void)scene_of(name);
  } catch (const InputError& e) {
    return e.what();
  }
  return "(read without complaint)";
}

TEST(Cases, OtherWordsLeadToOurs) {
  EXPECT_THAT(refusal("urdf-inertial-rpy--input"), HasSubstr("[xx, yy, zz, xy, xz, yz]"));
  EXPECT_THAT(refusal("urdf-inertial-rpy--two-parts"), HasSubstr("[xx, yy, zz, xy, xz, yz]"));
  EXPECT_THAT(refusal("urdf-inertial-rpy--body-orientation"), HasSubstr("R I R^T"));
  EXPECT_THAT(refusal("urdf-offdiagonal-order--3x3"), HasSubstr("xx, yy, zz, xy, xz, yz"));
  EXPECT_THAT(refusal("urdf-offdiagonal-order--nine"), HasSubstr("xx, yy, zz, xy, xz, yz"));
  EXPECT_THAT(refusal("urdf-offdiagonal-order--urdf-order"), HasSubstr("xx, yy, zz, xy, xz, yz"));
  EXPECT_THAT(refusal("goldstein-top--euler"), HasSubstr("orientation = [w, x, y, z]"));
  EXPECT_THAT(refusal("toutatis-deg-day--degrees"), HasSubstr("angular_velocity in rad/s"));
  EXPECT_THAT(refusal("toutatis-deg-day--deg-string"), HasSubstr("seconds"));
}

TEST(Cases, PhysicalFalseIsAdvisedOnlyWhereItHelps) {
  EXPECT_THAT(refusal("underflow--no-flag"), HasSubstr("physical = false"));
  for (const char* name :
       {"inertia--zero", "inertia--negative", "inertia--rowmajor", "urdf-offdiagonal-order--urdf-order"})
    EXPECT_THAT(refusal(name), AllOf(HasSubstr("> 0"), Not(HasSubstr("physical = false")))) << name;
  EXPECT_THAT(refusal("inertia--motor"), HasSubstr("triangle inequality"));
}

}  // namespace
}  // namespace polhode
