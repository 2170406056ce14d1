// A truth proves itself: right ones pass, wrong ones of every kind do not, and what is stated of them holds
// beside a second integration of the file as it stands.
#include "solvers/proof.hpp"

#include <cmath>
#include <cstdlib>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "solvers/second_method.hpp"
#include "tests/drawn_scenes.hpp"
#include "tests/sanitized.hpp"
#include "tests/scene_file.hpp"

namespace polhode {
namespace {

using testing::HasSubstr;

/// How many scenes: so many here, and as many times more as POLHODE_MANY says by hand.
int many(int here) {
  const char* more = std::getenv("POLHODE_MANY");
  return (more ? std::atoi(more) : 1) * (sanitized ? std::max(1, here / 20) : here);
}

class Proof : public SceneFile {
 protected:
  /// The second method all the way to t, in stretches of at most a quarter of a radian or so.
  static StatedState far_reached(const SecondMethod& second, double end) {
    StatedState s = second.start();
    Wide t(0);
    while (t < end) {
      const double pace = std::max(second.pace(s), 1e-3);
      Wide h = std::min(Wide(0.25 / pace), Wide(end - t));
      for (;; h /= 4) {
        const auto there = second.reached(Checked(t), s, Checked(h), 14);
        // A spring that changes sides is followed up to its change.
        const bool crossed = second.side(s, false) != second.side(there.state, false);
        if (crossed && h > Wide(1e-44)) continue;
        if (!crossed && !(there.attitude_error < 1e-38 && there.rate_error < 1e-38) && h > Wide(1e-12))
          continue;
        s = there.state;
        t += h;
        break;
      }
    }
    return s;
  }

  struct Missed {
    double attitude, rate;
  };
  static Missed missed(const SecondMethod& second, const StatedState& s, const WideSample& truth) {
    const StatedState own = second.stated(truth);
    const Vec3T<Checked> w = second.rates_U(s);
    const double size = Checked(w.norm()).convert_to<double>();
    const double gap = Checked((w - second.rates_U(own)).norm()).convert_to<double>();
    return {attitude_error<Checked>(s.q(), own.q()).convert_to<double>(), size > 0 ? gap / size : gap};
  }

  /// What a scene's truth says of itself is true at three times; `text` names it where it is not.
  void holds(const std::string& text, double end) {
    const Scene scene = read(text);
    const std::vector<double> times{0, end / 3, end};
    Truth truth;
    try {
      truth = reference_solution(scene, times, Allowance(60, {}));
    } catch (const std::exception& e) {
      FAIL() << e.what() << '\n' << text;
    }
    const SecondMethod second(exact_scene(scene));
    const Missed at_start = missed(second, second.start(), truth.samples[0]);
    EXPECT_LE(at_start.attitude, truth.attitude_uncertainty) << text;
    EXPECT_LE(at_start.rate, truth.rate_uncertainty) << text;
    const Missed at_end = missed(second, far_reached(second, end), truth.samples[2]);
    // What the second method itself misses: 1e-38 a stretch, some tens of them.
    EXPECT_LE(at_end.attitude, truth.attitude_uncertainty + 1e-36) << text;
    EXPECT_LE(at_end.rate, truth.rate_uncertainty + 1e-36) << text;
  }
};

TEST_F(Proof, OfManySimpleNumbers) {
  // The proof alone: start, what is conserved, and the second method over short stretches.
  DrawnScenes drawn(31);
  for (int i = 0; i < many(500) && !HasFailure(); ++i) {
    const std::string text = drawn.simple();
    const std::vector<double> times{0, 0.7, 2.5};
    EXPECT_NO_THROW(reference_solution(read(text), times)) << text;
  }
}

TEST_F(Proof, SimpleNumbers) {
  DrawnScenes drawn(20261128);
  for (int i = 0; i < many(100) && !HasFailure(); ++i) {
    const std::string text = drawn.simple();
    holds(text, i % 3 ? 1 : 2.5);
  }
}

TEST_F(Proof, AxesThatAreNotPrincipal) {
  DrawnScenes drawn(7);
  for (int i = 0; i < many(30) && !HasFailure(); ++i) holds(drawn.not_principal(), 0.5);
}

TEST_F(Proof, LoadsAndPairsOfLoads) {
  DrawnScenes drawn(11);
  for (int i = 0; i < many(12) && !HasFailure(); ++i) holds(drawn.loaded(), 0.5);
}

/// A motion made wrong in one way.
class Wrong final : public ExactMotion {
 public:
  using Change = std::function<void(WideSample&)>;
  Wrong(const ExactMotion& right, Change change) : right_(right), change_(std::move(change)) {}
  std::vector<WideSample> at(std::span<const Wide> times, const Allowance& allowance) const override {
    auto samples = right_.at(times, allowance);
    for (auto& s : samples) change_(s);
    return samples;
  }
  Uncertainty uncertainty(std::span<const WideSample> samples, const Allowance& a) const override {
    return right_.uncertainty(samples, a);
  }
  std::string kind() const override { return right_.kind(); }
  std::int64_t steps() const override { return right_.steps(); }

 private:
  const ExactMotion& right_;
  Change change_;
};

class ProofOfWrong : public Proof {
 protected:
  /// "" where the motion passes, else what the proof says.
  std::string found(const std::string& text, const Wrong::Change& change, int count = 8) {
    const Scene scene = read(text);
    const ExactScene exact = exact_scene(scene);
    auto right = closed_motion(scene);
    if (!right) right = series_motion(exact, scene.duration, {});
    // What is stated is that of the right motion: the wrong one must not widen its own allowance.
    ExactMotion::Uncertainty stated;
    const Wrong wrong(*right, change);
    std::vector<Wide> times;
    for (int i = 0; i <= count; ++i) times.push_back(Wide(scene.duration) * i / count);
    stated = right->uncertainty(right->at(times, {}), {});
    const auto samples = wrong.at(times, {});
    try {
      prove("drawn", exact, wrong, scene.duration, samples, stated, {});
    } catch (const Error& e) {
      EXPECT_EQ(e.exit_code, 70);
      return e.what();
    }
    return "";
  }
  const std::string free_ =
      "duration = 5\n[body]\ninertia = [4, 3, 2]\n[initial]\nangular_velocity = [3, 0.7, 0]\n";
  const std::string top_ =
      "duration = 1\n[body]\nmass = 2\ninertia = [4, 3, 2]\n[initial]\nangular_velocity = [1, 0.7, 4]\n"
      "[[load]]\ntype = \"gravity_about_pivot\"\nacceleration = [0, 0, -9.81]\ncenter_of_mass = [0.1, 0, "
      "0.3]\n";
};

TEST_F(ProofOfWrong, NothingIsFoundInWhatIsRight) {
  EXPECT_EQ(found(free_, [](WideSample&) {}), "");
  EXPECT_EQ(found(top_, [](WideSample&) {}), "");
}

TEST_F(ProofOfWrong, AMirroredRate) {  // the fault that the first version had
  for (const auto& text : {free_, top_}) {
    const std::string said = found(text, [](WideSample& s) { s.w_B.y() = -s.w_B.y(); });
    EXPECT_THAT(said, HasSubstr("the start that the file gives"));
    EXPECT_THAT(said, HasSubstr("-6.9999999999999995559"));  // both values, as the double 0.7 has them
    EXPECT_THAT(said, HasSubstr(" 6.9999999999999995559"));
  }
}

TEST_F(ProofOfWrong, ATurnOfTheWholeMotion) {  // energy and |L| would not see it
  const QuaternionT<Wide> turn = exp_rotation<Wide>(Vec3T<Wide>(Wide(1e-30), Wide(0), Wide(0)));
  EXPECT_THAT(found(free_, [&](WideSample& s) { s.q = turn * s.q; }), HasSubstr("the start"));
}

TEST_F(ProofOfWrong, AMotionThatIsTooFastByNextToNothing) {
  // Right at the start, of the right energy and momentum, but in another time: the residual alone sees it.
  const Scene scene = read(free_);
  const auto right = closed_motion(scene);
  const std::string said = found(free_, [&](WideSample& s) {
    const Wide t = s.t, later = t * (1 + Wide(1e-25));
    s = right->at(std::span(&later, 1), {}).front();
    s.t = t;
  });
  EXPECT_THAT(said, HasSubstr("a second method"));
}

TEST_F(ProofOfWrong, AJumpAtASingleTime) {
  for (const auto& text : {free_, top_})
    EXPECT_THAT(found(text,
                      [](WideSample& s) {
                        if ((s.t > 2.4 && s.t < 2.6) || (s.t > 0.4 && s.t < 0.6))
                          s.w_B *= Wide(1) + Wide(1e-20);
                      }),
                testing::AnyOf(HasSubstr("energy"), HasSubstr("momentum")));
}

TEST_F(ProofOfWrong, WhatIsNotANumber) {
  EXPECT_NE(found(free_, [](WideSample& s) { s.q.w() = std::nan(""); }), "");
  EXPECT_NE(found(top_, [](WideSample& s) { s.w_B.x() = std::nan(""); }), "");
}

}  // namespace
}  // namespace polhode
