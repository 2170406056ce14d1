// The reference against 23 cases whose states are known to 30 digits, in the library and at the command line.
#include "solvers/reference.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "experiments/truth.hpp"
#include "tests/command.hpp"
#include "tests/reference_cases.hpp"

namespace polhode {
namespace {

using namespace reference_cases;

// The states are printed with 30 significant digits: each component is off by up to half a unit of its 30th
// digit, at most 5e-30 of itself, so of the largest one. The reference adds what it states of itself, below.
constexpr double print_rounding = 5e-30;
// Order 48 with local terms of 1e-43, some thousands of steps, and a growth of perturbations of at most 1e9
// (the near-separatrix case) leave 1e-43 * 1e4 * 1e9 = 1e-30 at worst; 50 digits of arithmetic leave less.
constexpr double own_error = 1e-30;

double max_norm(const auto& v) {
  Wide largest(0);
  for (int i = 0; i < v.size(); ++i) largest = std::max<Wide>(largest, abs(v[i]));
  return largest.template convert_to<double>();
}
double relative_gap(const auto& got, const auto& want) {
  using Same = std::decay_t<decltype(want)>;
  const double scale = max_norm(want);
  return max_norm(Same(got - want)) / (scale > 0 ? scale : 1);
}
double attitude_gap(const QuaternionT<Wide>& got, const QuaternionT<Wide>& want) {
  const Eigen::Matrix<Wide, 4, 1> a = got.coeffs(), b = want.coeffs(), minus = -b;
  return std::min(relative_gap(a, b), relative_gap(a, minus));  // q and -q are one attitude
}
double digits(double gap) { return -std::log10(std::max(gap, 1e-50)); }

class ReferenceCase : public testing::TestWithParam<std::string> {
 protected:
  ReferenceCase()
      : data(read_json(GetParam())), inputs(data.at("inputs")), times(numbers(data.at("times"))) {}
  Scene scene() const { return scene_of(inputs, GetParam(), times.back()); }
  const Json& state(std::size_t i) const { return data.at("binary64_inputs").at("states").at(i); }

  Json data, inputs;
  std::vector<double> times;
};

TEST_P(ReferenceCase, AgreesToTheLastPrintedDigit) {
  const Truth truth = reference_solution(scene(), times);
  ASSERT_EQ(truth.samples.size(), times.size());
  double worst_q = 0, worst_w = 0, worst_p = 0, worst_v = 0;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const WideSample& s = truth.samples[i];
    worst_q = std::max(worst_q, attitude_gap(s.q, wide_quaternion(state(i).at("q"))));
    worst_w = std::max(worst_w, relative_gap(s.w_B, wide_vector(state(i).at("omega_body"))));
    Vec3T<Wide> p = s.p, v = s.v;
    const Json& torque = inputs.at("torque");
    if (torque.at("model") == "gravity_gradient") continue;  // p, v there are the prescribed orbit
    if (torque.at("model") == "heavy_top_pivot") {           // p = R r, v = w_S x p
      p = to_space<Wide>(s.q, vector(torque.at("r_com_body")).cast<Wide>());
      v = to_space<Wide>(s.q, s.w_B).cross(p);
    }
    worst_p = std::max(worst_p, relative_gap(p, wide_vector(state(i).at("p"))));
    worst_v = std::max(worst_v, relative_gap(v, wide_vector(state(i).at("v"))));
  }
  RecordProperty("digits_q", std::to_string(digits(worst_q)));
  RecordProperty("digits_w", std::to_string(digits(worst_w)));
  RecordProperty("seconds", std::to_string(truth.cost_s));
  EXPECT_LE(worst_q, print_rounding + own_error);
  EXPECT_LE(worst_w, print_rounding + own_error);
  EXPECT_LE(worst_p, print_rounding + own_error);
  EXPECT_LE(worst_v, print_rounding + own_error);
  // What it says of itself: small enough to print 20 digits, and not smaller than a tenth of what it misses.
  EXPECT_LT(truth.attitude_uncertainty, 1e-20);
  EXPECT_LT(truth.rate_uncertainty, 1e-20);
  EXPECT_LE(worst_q, 10 * truth.attitude_uncertainty + print_rounding);
  EXPECT_LE(worst_w, 10 * truth.rate_uncertainty + print_rounding);
}

TEST_P(ReferenceCase, TextFilesAndTheCommandLineLoseNoDigit) {
  const TemporaryFolder folder;
  const auto file = folder.write("scene.toml", toml_of(inputs, data.at("times").back().get<std::string>()));
  std::string asked;
  for (const auto& t : data.at("times")) asked += (asked.empty() ? "" : ",") + t.get<std::string>();
  const CommandResult run = polhode_command("simulate '" + file.string() + "' --digits 30 --times " + asked);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto columns = columns_of(run.out);
  const auto at = [&](const char* name, std::size_t i) { return Wide(columns.at(name).at(i)); };
  ASSERT_EQ(columns.at("t_s").size(), times.size());
  // --digits 30 in scientific form prints 31 significant ones: nothing to add to the rounding of the file.
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_EQ(nearest_double(columns.at("t_s").at(i)), times[i]);
    const QuaternionT<Wide> q(at("qw", i), at("qx", i), at("qy", i), at("qz", i));
    const Vec3T<Wide> w(at("wx_rad_per_s", i), at("wy_rad_per_s", i), at("wz_rad_per_s", i));
    EXPECT_LE(attitude_gap(q, wide_quaternion(state(i).at("q"))), print_rounding + own_error);
    EXPECT_LE(relative_gap(w, wide_vector(state(i).at("omega_body"))), print_rounding + own_error);
    ASSERT_EQ(columns.contains("px_m"), moves(inputs));
    if (!moves(inputs)) continue;
    const Vec3T<Wide> p(at("px_m", i), at("py_m", i), at("pz_m", i)),
        v(at("vx_m_per_s", i), at("vy_m_per_s", i), at("vz_m_per_s", i));
    EXPECT_LE(relative_gap(p, wide_vector(state(i).at("p"))), print_rounding + own_error);
    EXPECT_LE(relative_gap(v, wide_vector(state(i).at("v"))), print_rounding + own_error);
  }
}

TEST_P(ReferenceCase, ConditioningIsThatOfTheCase) {
  // The file: growth of max|dq| per max|w0|; ours: growth of the angle, 2 |dq|_2, per |w0|_2. Of four numbers
  // |dq|_2 is 1 to 2 times the largest, of three |w0|_2 is 1 to sqrt 3 times: ours is 2 to 4 sqrt 3 = 6.93
  // times theirs. 3 % more on each side for the three digits printed.
  double theirs = 0;
  for (const double g : numbers(data.at("conditioning").at("growth_q"))) theirs = std::max(theirs, g);
  const auto truth = truth_of(scene(), times);
  if (theirs < 1) {
    EXPECT_LT(truth->floor().attitude_growth, 7.2);  // a damped case forgets: ours is bounded below by 1
  } else {
    EXPECT_GT(truth->floor().attitude_growth, 2 * 0.97 * theirs);
    EXPECT_LT(truth->floor().attitude_growth, 4 * std::sqrt(3.0) * 1.03 * theirs);
  }
  EXPECT_GE(truth->floor().conditioning, truth->floor().attitude_growth);
  EXPECT_GE(truth->floor().attitude, 4e-16);  // that a quaternion of doubles resolves
}

std::string test_name(const testing::TestParamInfo<std::string>& info_of_case) {
  std::string name = info_of_case.param;
  std::replace_if(
      name.begin(), name.end(), [](unsigned char c) { return !std::isalnum(c); }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(All, ReferenceCase, testing::ValuesIn(case_names()), test_name);

TEST(Reference, AllCasesAreThere) { EXPECT_EQ(case_names().size(), 23u); }

// An uncertainty is honest if the true error is known and not much larger. These two bodies have closed forms
// in sines and cosines, evaluated here in the same 50 digits. A sum of some hundred rounded steps is allowed
// on top: each rounds the attitude by a few units of 2^-168 = 3e-51.
constexpr double wide_rounding = 1e-47;

TEST(Reference, StatesItsErrorOnASphere) {
  const Json data = read_json("PD3_sphere");
  const std::vector<double> times = numbers(data.at("times"));
  const Scene scene = scene_of(data.at("inputs"), "sphere", times.back());
  const Truth truth = series_solution(scene, times);
  const QuaternionT<Wide> q0 = normalised<Wide>(scene.rotation->q0.cast<Wide>());
  const Vec3T<Wide> w0 = scene.rotation->w0.cast<Wide>();
  for (const WideSample& s : truth.samples) {
    const QuaternionT<Wide> exact = q0 * exp_rotation<Wide>(w0 * s.t);
    EXPECT_LE(attitude_error<Wide>(exact, s.q), 10 * truth.attitude_uncertainty + wide_rounding);
    EXPECT_EQ(s.w_B, w0);
  }
}

TEST(Reference, StatesItsErrorOnASymmetricBody) {
  // Moments (A, A, C): in the body the transverse rate turns with (C - A)/A w3, in space the body precesses
  // about L with |L|/A: q = q0 exp(L_B t/A) exp(-(C - A)/A w3 t e3), L_B = I w0.
  const Json data = read_json("PD2_symmetric");
  const std::vector<double> times = numbers(data.at("times"));
  const Scene scene = scene_of(data.at("inputs"), "symmetric", times.back());
  const Truth truth = series_solution(scene, times);
  const QuaternionT<Wide> q0 = normalised<Wide>(scene.rotation->q0.cast<Wide>());
  const Vec3T<Wide> w0 = scene.rotation->w0.cast<Wide>(), I = scene.rotation->moments.cast<Wide>();
  const Wide rate = (I.z() - I.x()) / I.x() * w0.z();
  for (const WideSample& s : truth.samples) {
    const QuaternionT<Wide> exact = q0 * exp_rotation<Wide>(I.cwiseProduct(w0) * (s.t / I.x())) *
                                    exp_rotation<Wide>(Vec3T<Wide>(Wide(0), Wide(0), Wide(-rate * s.t)));
    EXPECT_LE(attitude_error<Wide>(exact, s.q), 10 * truth.attitude_uncertainty + wide_rounding);
    const Wide c = cos(Wide(rate * s.t)), n = sin(Wide(rate * s.t));
    const Vec3T<Wide> w(c * w0.x() - n * w0.y(), n * w0.x() + c * w0.y(), w0.z());
    EXPECT_LE(relative_gap(s.w_B, w), 10 * truth.rate_uncertainty + wide_rounding);
  }
}

}  // namespace
}  // namespace polhode
