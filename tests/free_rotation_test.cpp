// The closed form of the free body: properties over ten thousand random bodies, corners, published periods.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "models/extended_free_rotation.hpp"
#include "models/wide.hpp"
#include "tests/sanitized.hpp"

namespace polhode {
namespace {

using WideVec = Vec3T<Wide>;
using WideQuaternion = QuaternionT<Wide>;
using WideState = FreeRotation<Wide>::State;

struct Case {
  Vec3 moments, w0;
  Quaternion q0;
  double t;
};

FreeRotation<Wide> wide(const Case& c) {
  return FreeRotation<Wide>(c.moments, c.q0.cast<Wide>(), c.w0.cast<Wide>());
}
double gap(const WideQuaternion& a, const WideQuaternion& b) {
  return attitude_error<Wide>(a, b).convert_to<double>();
}
double gap(const WideVec& a, const WideVec& b) { return WideVec(a - b).norm().convert_to<double>(); }

/// Growth of a relative disturbance of the initial rates to time t, as an angle and relative to |w0|; one at
/// least, since an answer in doubles is rounded.
std::pair<double, double> conditioning(const Case& c, const WideState& x) {
  double attitude = 1, rate = 1;
  const double w = c.w0.norm();
  for (int axis = 0; axis < 3; ++axis) {
    Case other = c;
    other.w0[axis] += 1e-9 * w;
    const double step = (other.w0[axis] - c.w0[axis]) / w;
    const WideState y = wide(other).at(Wide(c.t));
    attitude = std::max(attitude, gap(x.q, y.q) / step);
    rate = std::max(rate, gap(x.w_B, y.w_B) / (w * step));
  }
  return {attitude, rate};
}

class Bodies {
 public:
  explicit Bodies(unsigned seed) : generator_(seed) {}
  double between(double a, double b) { return a + (b - a) * uniform_(generator_); }
  double log_between(double a, double b) { return std::exp(between(std::log(a), std::log(b))); }
  Vec3 vector() { return {between(-1, 1), between(-1, 1), between(-1, 1)}; }
  Quaternion quaternion() { return {between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)}; }
  Vec3 shuffled(const Vec3& v) {
    std::array<double, 3> a = {v.x(), v.y(), v.z()};
    std::shuffle(a.begin(), a.end(), generator_);
    return {a[0], a[1], a[2]};
  }
  /// A body that can exist, with ratios of moments up to 1e8, turning by some radians in t of either sign.
  Case any() {
    const double least = log_between(1e-8, 1), largest = 1;
    const double middle =
        std::max(largest - least, least) + (largest - std::max(largest - least, least)) * between(0, 1);
    const double spin = log_between(1e-6, 1e6);
    return {log_between(1e-10, 1e10) * shuffled({least, middle, largest}), spin * vector(), quaternion(),
            between(-50, 50) / spin};
  }

 private:
  std::mt19937_64 generator_;
  std::uniform_real_distribution<double> uniform_{0, 1};
};

/// Eight units of rounding, each grown by the conditioning: the set-up rounds a dozen constants by half a
/// unit, and their errors have no preferred direction.
void expect_eight_ulp(const Case& c, const char* what) {
  constexpr double ulp = std::numeric_limits<double>::epsilon();
  const WideState x = wide(c).at(Wide(c.t));
  const auto [attitude, rate] = conditioning(c, x);
  const auto message = [&] {
    return testing::Message() << what << ": moments " << c.moments.transpose() << ", w0 " << c.w0.transpose()
                              << ", t " << c.t;
  };
  const auto y = FreeRotation<double>(c.moments, c.q0, c.w0).at(c.t);
  EXPECT_LT(gap(x.q, y.q.cast<Wide>()), 8 * ulp * attitude) << message();
  EXPECT_LT(gap(x.w_B, y.w_B.cast<Wide>()), 8 * ulp * rate * c.w0.norm()) << message();
  // A product of four quaternions, each of length one to two units.
  EXPECT_LT(std::abs(y.q.norm() - 1), 8 * ulp) << message();
  // The extended one does not lose more, and not with time: half a unit of each of two sines and cosines,
  // doubled on the way from q to the angle, the rounding of the result, and the 64-bit set-up (2048 times
  // finer) grown by the conditioning.
  const auto z = ExtendedFreeRotation(c.moments, c.q0, c.w0).at(c.t);
  EXPECT_LT(gap(x.q, z.q.cast<Wide>()), 4 * ulp + 32 * ulp / 2048 * attitude) << message();
}

// A quarter of ten thousand bodies for each of four seeds; the sanitizers see the same code in a tenth.
constexpr int body_count = sanitized ? 250 : 2500;
class FreeRotationProperty : public testing::TestWithParam<unsigned> {
 protected:
  Bodies bodies{GetParam()};
};

TEST_P(FreeRotationProperty, DoublesAreRightToEightUnits) {
  for (int i = 0; i < body_count; ++i) expect_eight_ulp(bodies.any(), "any");
}

// Properties of the motion itself, in 50 digits. Rounding there is 1e-50, set-up and evaluation some dozens
// of it; growth with time and near the separatrix is at most 1e12 for these bodies.
constexpr double wide_rounding = 1e-36;

TEST_P(FreeRotationProperty, SolvesTheEquations) {
  // Central differences at h = 1e-8 of the time of a radian: truncation h^2/6 times third derivatives, which
  // are at most (ratio of moments 10) * 10 here: 1e-14; rounding 1e-50/h is nothing.
  for (int i = 0; i < body_count; ++i) {
    Case c = bodies.any();
    c.moments = bodies.shuffled({bodies.between(0.3, 0.6), bodies.between(0.6, 0.8), 0.9});
    const FreeRotation<Wide> motion = wide(c);
    const Wide t(c.t), w = c.w0.norm(), h = Wide(1e-8) / w;
    const WideState x = motion.at(t), before = motion.at(t - h), after = motion.at(t + h);
    const WideVec I = c.moments.cast<Wide>();
    const WideVec acceleration = I.cwiseProduct(x.w_B).cross(x.w_B).cwiseQuotient(I);
    EXPECT_LT(gap(WideVec((after.w_B - before.w_B) / (Wide(2) * h * w * w)), WideVec(acceleration / (w * w))),
              1e-14);
    const Wide side = before.q.dot(after.q) < 0 ? -1 : 1;
    const WideQuaternion slope = x.q * WideQuaternion(Wide(0), x.w_B.x() / 2, x.w_B.y() / 2, x.w_B.z() / 2);
    using Four = Eigen::Matrix<Wide, 4, 1>;
    const Four found = (after.q.coeffs() - side * before.q.coeffs()) / (Wide(2) * h);
    const double missed = Four((found - slope.coeffs()) / w).norm().convert_to<double>();
    EXPECT_LT(missed, 1e-14);
  }
}

TEST_P(FreeRotationProperty, KeepsMomentumAndEnergy) {
  for (int i = 0; i < body_count; ++i) {
    const Case c = bodies.any();
    const WideVec I = c.moments.cast<Wide>(), w0 = c.w0.cast<Wide>();
    const WideState x = wide(c).at(Wide(c.t));
    const WideVec L0 = to_space<Wide>(c.q0.cast<Wide>(), I.cwiseProduct(w0));
    EXPECT_LT(gap(to_space<Wide>(x.q, I.cwiseProduct(x.w_B)), L0),
              wide_rounding * L0.norm().convert_to<double>());
    const Wide E0 = w0.dot(I.cwiseProduct(w0)), E = x.w_B.dot(I.cwiseProduct(x.w_B));
    EXPECT_LT(abs(Wide(E / E0 - 1)).convert_to<double>(), wide_rounding);
  }
}

TEST_P(FreeRotationProperty, DoesNotDependOnNamesOfAxesOrOnTheSpaceFrame) {
  for (int i = 0; i < body_count; ++i) {
    const Case c = bodies.any();
    const WideState x = wide(c).at(Wide(c.t));
    const auto turned = [](const auto& v) {  // x -> y -> z -> x: a proper rotation of the axes
      return std::remove_cvref_t<decltype(v)>(v.z(), v.x(), v.y());
    };
    Case other = c;
    other.moments = turned(c.moments);
    other.w0 = turned(c.w0);
    const Vec3 u = turned(Vec3(c.q0.vec()));
    other.q0 = Quaternion(c.q0.w(), u.x(), u.y(), u.z());
    const WideState y = wide(other).at(Wide(c.t));
    const WideVec v = turned(WideVec(x.q.vec()));
    EXPECT_LT(gap(WideQuaternion(x.q.w(), v.x(), v.y(), v.z()), y.q), wide_rounding);
    EXPECT_LT(gap(turned(x.w_B), y.w_B), wide_rounding * c.w0.norm());

    const WideQuaternion frame = normalised<Wide>(bodies.quaternion().cast<Wide>());
    const FreeRotation<Wide> seen(c.moments, frame * normalised<Wide>(c.q0.cast<Wide>()), c.w0.cast<Wide>());
    EXPECT_LT(gap(frame * x.q, seen.at(Wide(c.t)).q), wide_rounding);
  }
}

TEST_P(FreeRotationProperty, FlowsCompose) {
  for (int i = 0; i < body_count; ++i) {
    const Case c = bodies.any();
    const Wide first(c.t * bodies.between(0, 1)), rest = Wide(c.t) - first;
    const WideState between = wide(c).at(first), x = wide(c).at(Wide(c.t));
    const WideState y = FreeRotation<Wide>(c.moments, between.q, between.w_B).at(rest);
    EXPECT_LT(gap(x.q, y.q), wide_rounding);
    EXPECT_LT(gap(x.w_B, y.w_B), wide_rounding * c.w0.norm());
    // And back: to the start in negative time, and by turning round.
    const WideState home = FreeRotation<Wide>(c.moments, x.q, x.w_B).at(Wide(-c.t));
    EXPECT_LT(gap(home.q, normalised<Wide>(c.q0.cast<Wide>())), wide_rounding);
    const WideState reversed = FreeRotation<Wide>(c.moments, x.q, WideVec(-x.w_B)).at(Wide(c.t));
    EXPECT_LT(gap(reversed.q, home.q), wide_rounding);
    EXPECT_LT(gap(reversed.w_B, WideVec(-home.w_B)), wide_rounding * c.w0.norm());
  }
}

INSTANTIATE_TEST_SUITE_P(TenThousandBodies, FreeRotationProperty, testing::Values(1u, 2u, 3u, 4u));

TEST(FreeRotation, ErrorOverTime) {
  // Three bodies on either side of the separatrix. A double's phases lose what rounding their rates costs, a
  // unit or two of 3 rad/s; the extended ones hardly anything before t = 1e4.
  constexpr double ulp = std::numeric_limits<double>::epsilon();
  const Quaternion q0(1, 0, 0, 0);
  for (const auto& [moments, w0] :
       {std::pair(Vec3(0.6, 0.8, 1), Vec3(3, 0.5, -0.9)), std::pair(Vec3(0.8, 0.6, 1), Vec3(2.5, 0.3, -0.1)),
        std::pair(Vec3(0.6, 0.8, 1), Vec3(0.3, 2.5, -0.1))}) {
    const FreeRotation<Wide> truth(moments, q0.cast<Wide>(), w0.cast<Wide>());
    const FreeRotation<double> plain(moments, q0, w0);
    const ExtendedFreeRotation extended(moments, q0, w0);
    const double spin = w0.norm();
    for (const double end : {10.0, 1000.0, 1e4})
      for (int i = 1; i <= 50; ++i) {
        const double t = end * i / 50;
        const auto x = truth.at(Wide(t));
        EXPECT_LT(gap(x.q, plain.at(t).q.cast<Wide>()), 8 * ulp + 2 * ulp / 2 * spin * t) << "t = " << t;
        EXPECT_LT(gap(x.q, extended.at(t).q.cast<Wide>()), 2 * ulp + 4 * ulp / 2048 * spin * t)
            << "t = " << t;
      }
  }
}

TEST(FreeRotation, StaysOnItsBranch) {
  // q(t) is continuous: between samples a twentieth of a radian apart, q and not -q is the near one.
  Bodies bodies(15);
  for (int i = 0; i < 200; ++i) {
    Case c = bodies.any();
    c.moments = bodies.shuffled({bodies.between(0.3, 0.6), bodies.between(0.6, 0.8), 0.9});
    if (i % 3 == 0) c.w0[i % 2] *= 1e-6;
    const FreeRotation<double> motion(c.moments, c.q0, c.w0);
    const auto extended = ExtendedFreeRotation(c.moments, c.q0, c.w0);
    Quaternion last = motion.at(0).q, last_extended = extended.at(0).q;
    EXPECT_GT(last.dot(c.q0), 0);
    for (int k = 1; k <= 2000; ++k) {
      const double t = 0.05 / c.w0.norm() * k;
      const Quaternion q = motion.at(t).q, e = extended.at(t).q;
      ASSERT_GT(q.dot(last), 0.9);
      ASSERT_GT(e.dot(last_extended), 0.9);
      last = q;
      last_extended = e;
    }
  }
}

// ---- corners, where trials of others and ours went wrong

TEST(FreeRotationCorner, NearEachPrincipalAxis) {
  Bodies bodies(21);
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 200; ++i) {
      Vec3 w = bodies.log_between(1e-17, 1) * bodies.vector();
      w[axis] = bodies.between(1, 5);
      expect_eight_ulp({Vec3(0.6, 0.8, 1), w, bodies.quaternion(), bodies.between(-10, 10)}, "near an axis");
    }
}
TEST(FreeRotationCorner, EqualMomentsNearlyAndExactly) {
  Bodies bodies(22);
  for (int i = 0; i < 300; ++i) {
    const double e = i % 5 == 0 ? 0 : bodies.log_between(1e-17, 1e-1);
    const double other = bodies.between(0.3, 1.9);
    expect_eight_ulp({bodies.shuffled({1, 1 + e, other}), 3 * bodies.vector(), bodies.quaternion(),
                      bodies.between(-10, 10)},
                     "nearly symmetric");
    expect_eight_ulp({Vec3(1, 1 + e * bodies.between(-1, 1), 1 + e * bodies.between(-1, 1)),
                      3 * bodies.vector(), bodies.quaternion(), bodies.between(-10, 10)},
                     "nearly a sphere");
  }
}
TEST(FreeRotationCorner, NeedleAndDisc) {
  Bodies bodies(23);
  for (int i = 0; i < 300; ++i) {
    const double e = bodies.log_between(1e-12, 1);
    expect_eight_ulp({bodies.shuffled({1, 1 - e * bodies.between(0, 1), e}), 3 * bodies.vector(),
                      bodies.quaternion(), bodies.between(-10, 10)},
                     "needle");
    expect_eight_ulp({bodies.shuffled({1, bodies.between(0.4, 0.6), 0.5 + e}), 3 * bodies.vector(),
                      bodies.quaternion(), bodies.between(-10, 10)},
                     "disc");
  }
}
TEST(FreeRotationCorner, NearTheSeparatrixOnBothSides) {
  Bodies bodies(24);
  double nearest = 1;
  for (int i = 0; i < 400; ++i) {
    const Vec3 I(bodies.between(0.4, 0.7), bodies.between(0.75, 0.9), 1);
    const double w3 = bodies.between(-3, 3),
                 w1 = w3 * std::sqrt(I[2] * (I[2] - I[1]) / (I[0] * (I[1] - I[0])));
    const double e = bodies.log_between(1e-17, 1e-2) * (i % 2 ? 1 : -1);
    const Case c{I, Vec3(w1 * (1 + e), bodies.between(-3, 3), w3), bodies.quaternion(),
                 bodies.between(-10, 10)};
    expect_eight_ulp(c, "near the separatrix");
    nearest = std::min(nearest, FreeRotation<double>(c.moments, c.q0, c.w0).complementary_parameter());
  }
  EXPECT_LT(nearest, 1e-15);
}
TEST(FreeRotationCorner, OnTheSeparatrixAndFarBelowRounding) {
  // I = (3, 4, 6), w = (2, x, 1): L^2 - 2 E I_2 = 6 * 2 * 1 - 3 * 1 * 4 = 0 exactly.
  for (const double x : {0.0, 0.5, -2.0}) {
    const Case on{Vec3(3, 4, 6), Vec3(2, x, 1), Quaternion(0.5, -0.1, 0.7, 0.3), 7.25};
    const FreeRotation<Wide> motion = wide(on);
    EXPECT_EQ(motion.complementary_parameter(), 0);
    expect_eight_ulp(on, "on the separatrix");
    // Towards the rotation about the middle axis, for ever: I2 (I3 - I2) w2^2 -> the same plus I1 (I3 - I1)
    // w1^2.
    const WideState late = motion.at(Wide(100));
    EXPECT_NEAR(abs(late.w_B.y()).convert_to<double>(), std::sqrt(4.5 + x * x), 1e-15);
    const double far = 1e4;
    const auto later = FreeRotation<double>(on.moments, on.q0, on.w0).at(far);
    EXPECT_TRUE(later.q.coeffs().allFinite() && later.w_B.allFinite());
  }
  // 1 - k^2 down to 1e-25 and below: a disturbance of the rate in 50 digits, as no double could state it.
  for (const char* e : {"1e-13", "1e-25", "-1e-25", "1e-33"}) {
    const WideVec w(Wide(2) * (Wide(1) + Wide(e)), Wide("0.5"), Wide(1));
    const FreeRotation<Wide> motion(Vec3(3, 4, 6), WideQuaternion(Wide(1), Wide(0), Wide(0), Wide(0)), w);
    // 1 - k^2 = 3 * 24 e/38 to first order.
    EXPECT_NEAR((motion.complementary_parameter() / abs(Wide(e))).convert_to<double>(), 36.0 / 19, 1e-12)
        << e;
    // Once round: the rates are back after a period of 4 K/lambda, of which no digit is lost beyond those of
    // 1 - k^2 itself.
    const WideState round = motion.at(motion.period());
    EXPECT_LT(gap(round.w_B, w), 1e-48 / std::abs(Wide(e).convert_to<double>())) << e;
    // Between turns it leans on the middle axis, at rest there for ln(16/(1 - k^2)) radians.
    EXPECT_GT(motion.period().convert_to<double>(), -std::log(std::abs(Wide(e).convert_to<double>()))) << e;
  }
}
TEST(FreeRotationCorner, HugeAndTinyNumbers) {
  for (const double scale : {0x1p-60, 0x1p60}) {
    // Units do not matter: powers of two change no digit.
    const Case c{Vec3(0.6, 0.8, 1), Vec3(3, 0.5, -0.9), Quaternion(1, 0, 0, 0), 7};
    const auto a = FreeRotation<double>(c.moments, c.q0, c.w0).at(c.t);
    const auto b = FreeRotation<double>(scale * c.moments, c.q0, c.w0 * scale).at(c.t / scale);
    EXPECT_EQ(a.q.coeffs(), b.q.coeffs());
    EXPECT_EQ(Vec3(scale * a.w_B), b.w_B);
  }
  for (const Vec3& w : {Vec3(1e-200, 1, 1e-200), Vec3(1, 1e-200, 1e-300), Vec3(0, 0, 0), Vec3(0, 2, 0),
                        Vec3(5e-324, 0, 3), Vec3(1e-170, 1e-170, 1e-170)}) {
    const auto x = FreeRotation<double>(Vec3(0.6, 0.8, 1), Quaternion(1, 2, 3, 4), w).at(10);
    EXPECT_TRUE(x.q.coeffs().allFinite() && x.w_B.allFinite()) << w.transpose();
    EXPECT_NEAR(x.w_B.norm(), w.norm(), 1e-15 * w.norm()) << w.transpose();
  }
}

// ---- published

TEST(FreeRotationPublished, PrincipiaDzhanibekovPeriod) {
  const WideVec w(Wide(0), Wide(2) / 5, Wide("0.01") / 9);
  const FreeRotation<Wide> motion(Vec3(3, 5, 9), WideQuaternion(Wide(1), Wide(0), Wide(0), Wide(0)), w);
  EXPECT_NEAR(Wide(motion.period() - Wide("118.110887046385744")).convert_to<double>(), 0, 0.5e-15);
  EXPECT_LT(gap(motion.at(motion.period()).w_B, w), wide_rounding);
}
TEST(FreeRotationPublished, SimbodyDzhanibekovPeriod) {
  // Moments (919, 967, 83)/15000; a free motion does not know their unit.
  const WideVec w(Wide(10), Wide(0), Wide("1e-10"));
  const FreeRotation<Wide> motion(Vec3(919, 967, 83), WideQuaternion(Wide(1), Wide(0), Wide(0), Wide(0)), w);
  EXPECT_NEAR(Wide(motion.period() - Wide("14.9686865148128")).convert_to<double>(), 0, 0.5e-13);
  EXPECT_NEAR((motion.complementary_parameter() / Wide("1.66e-22")).convert_to<double>(), 1, 0.005 / 1.66);
}

// Rates, moments and times in other units, by powers of two up to where squares would vanish or overflow: the
// same motion to the last bit.
TEST(FreeRotationUnits, DoNotMatter) {
  const Vec3 I(0.6, 0.8, 1), w(3, 0.5, -0.9);
  const Quaternion q0(0.8, 0, 0.6, 0);
  const auto plain = FreeRotation<double>(I, q0, w).at(7.0);
  const auto extended = ExtendedFreeRotation(I, q0, w).at(7.0);
  for (const int rate : {-1000, -600, -20, 20, 600, 1000})
    for (const int moment : {-1000, -400, 400, 1000}) {
      const double unit = std::ldexp(1.0, rate);
      const Vec3 I2 = I * std::ldexp(1.0, moment), w2 = w * unit;
      const auto scaled = FreeRotation<double>(I2, q0, w2).at(7.0 / unit);
      EXPECT_EQ(scaled.q.coeffs(), plain.q.coeffs()) << rate << " " << moment;
      EXPECT_EQ(scaled.w_B, Vec3(plain.w_B * unit)) << rate << " " << moment;
      const auto scaled_extended = ExtendedFreeRotation(I2, q0, w2).at(7.0 / unit);
      EXPECT_EQ(scaled_extended.q.coeffs(), extended.q.coeffs()) << rate << " " << moment;
      EXPECT_EQ(scaled_extended.w_B, Vec3(extended.w_B * unit)) << rate << " " << moment;
    }
}

}  // namespace
}  // namespace polhode
