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

/// Half a unit of the last digit shown, and for DOP853's values what it left: `slack` units.
void expect_digits(const Checked& got, const std::string& shown, double slack, const std::string& what) {
  const auto point = shown.find('.'), exponent = shown.find('e');
  const std::size_t digits = (exponent == shown.npos ? shown.size() : exponent) - point - 1;
  const double unit = std::pow(10.0, -double(digits)) *
                      (exponent == shown.npos ? 1 : std::pow(10.0, std::stod(shown.substr(exponent + 1))));
  EXPECT_LE(abs(Checked(got - Checked(shown))).convert_to<double>(), (0.5 + slack) * unit * 1.001)
      << what << ": got " << got.str(25) << ", shown " << shown;
}

struct Shown {
  const char* file;
  double t;
  std::vector<std::string> q, w;
  double slack = 0;  // units of the last digit
};

class Case : public testing::TestWithParam<Shown> {};

TEST_P(Case, HasTheValueShown) {
  const Shown& shown = GetParam();
  auto got = found(scene_of(shown.file), shown.t);
  if (!shown.q.empty()) {
    int largest = 0;
    for (int i = 1; i < 4; ++i)
      if (abs(Checked(shown.q[std::size_t(i)])) > abs(Checked(shown.q[std::size_t(largest)]))) largest = i;
    // q and -q are one attitude.
    const bool other = (got[std::size_t(largest)] < 0) != (Checked(shown.q[std::size_t(largest)]) < 0);
    for (std::size_t i = 0; i < 4; ++i)
      expect_digits(other ? Checked(-got[i]) : got[i], shown.q[i], shown.slack, "q" + std::to_string(i));
  }
  for (std::size_t i = 0; i < shown.w.size(); ++i)
    expect_digits(got[4 + i], shown.w[i], shown.slack, "w" + std::to_string(i));
}

const std::vector<std::string> urdf_q{"-0.52654946270616217", "0.60053897827825660", "0.02715757339788038",
                                      "-0.60113315089046479"},
    urdf_w{"0.68907398857859584", "-0.62459428872636205", "-0.66339612631343422"};

INSTANTIATE_TEST_SUITE_P(
    All, Case,
    testing::Values(
        Shown{"urdf-inertial-rpy--by-hand", 4, urdf_q, urdf_w},
        // Its six numbers are rounded ones of another body's turned tensor.
        Shown{"urdf-inertial-rpy--torque",
              1,
              {"0.96891242171064478", "0.24740395925452293", "0.0", "0.0"},
              {"1.0"}},
        Shown{"urdf-offdiagonal-order--input",
              10,
              {"-0.4702540460417535", "0.3811971386482210", "-0.4697239200604680", "0.6425801993454174"},
              {"0.9914465328844830", "-1.0567154739799096", "2.1002702641387147"}},
        Shown{"underflow--input",
              100,
              {"0.97296503465427383", "-0.07171372908301691", "-0.21644631771888464", "0.03670386828593164"},
              {}},
        Shown{"toutatis-deg-day--input",
              2001013,
              {"0.29625461259500689", "-0.65522033876793914", "-0.02760038050465048", "-0.69437578527552929"},
              {"-7.7867575968379244e-6", "2.9418631247859986e-7", "-1.9622427503057155e-5"}},
        Shown{"goldstein-top--input",
              6,
              {"-0.64351445013407", "-0.08015000469477", "0.06125275122906", "-0.75875768838473"},
              {}},
        Shown{"loads-full-tensor--drag",
              6,
              {"0.351246989266914", "0.595803440263293", "0.718629174175466", "-0.0722213481267252"},
              {"-1.03263089458997", "0.230618847325956", "-0.140988653744059"}},
        Shown{"loads-full-tensor--torque-body",
              6,
              {"-0.18857325407057", "-0.179537929304893", "0.217195243229331", "-0.940761652124862"},
              {"-2.16814026808828", "0.63244757467966", "7.05941023128146"}},
        Shown{"loads-full-tensor--torque-space",
              6,
              {"-0.367250307660641", "-0.254967750619492", "-0.806132592837339", "-0.387645328144878"},
              {"-9.16994706234071", "3.44409475048611", "-2.2072644735476"}},
        Shown{"loads-full-tensor--spring",
              6,
              {"0.988703047277043", "-0.133065921001783", "0.0331394780646711", "-0.0605104946818074"},
              {"-1.48327007946451", "0.912544854670191", "-0.130529872770959"}},
        Shown{"loads-full-tensor--pivot",
              6,
              {"-0.997709335062929", "-0.0073479228135551", "-0.0071933303346876", "-0.0668606517864542"},
              {"-2.0024955604926", "-0.479745497923616", "3.01655148810824"}},
        Shown{"loads-full-tensor--gg",
              6,
              {"-0.524630280773771", "-0.418095209672036", "0.0318902119584431", "0.740906524823325"},
              {"0.191706453543684", "1.10885282333961", "1.84679016980306"}},
        Shown{"loads-full-tensor--all",
              6,
              {"-0.498241020719923", "0.107896226430689", "-0.636484689912308", "-0.578793166080267"},
              {"-6.12452376795174", "0.870683715124132", "0.206117766238607"}},
        Shown{"spring-over-half-turn--input",
              6,
              {"0.92603334416051", "-0.32703349500467", "0.05184857111191", "-0.18117136727857"},
              {}}),
    [](const auto& info) {
      std::string name = info.param.file;
      for (char& c : name)
        if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
      return name;
    });

TEST(Cases, TheSameLinkInThreeForms) {
  const auto want = found(scene_of("urdf-inertial-rpy--by-hand"), 4);
  // The six numbers are those of a tensor turned by rpy (0.3, -0.7, 1.1), so is the box: another body in
  // other axes, one and the same in these two files to the rounding of their digits.
  const auto six = found(scene_of("urdf-inertial-rpy--six"), 4),
             box = found(scene_of("urdf-inertial-rpy--box-rpy"), 4);
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_LT(abs(Checked(six[i] - box[i])).convert_to<double>(), 1e-14) << i;
  EXPECT_GT(abs(Checked(six[4] - want[4])).convert_to<double>(), 1e-3);
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
    const double rounded = std::string(name) == "pendulum-pivot--input" ? 1e-15 : 3e-17;
    EXPECT_NEAR(Checked(tilt - Checked("0.0442748941288046663")).convert_to<double>(), 0, rounded) << name;
    EXPECT_NEAR(Checked(x[4] - Checked("7.66236153832303740711")).convert_to<double>(), 0, 50 * rounded)
        << name;
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
  EXPECT_THAT(refusal("toutatis-deg-day--degrees"), AllOf(HasSubstr("orientation = [w, x, y, z]")));
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
