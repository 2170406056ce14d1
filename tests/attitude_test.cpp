// Attitude algebra and the equations of motion, in the modern form and as the lecture notes state them.
#include <cmath>
#include <random>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include "models/model.hpp"
#include "models/newton_euler.hpp"
#include "models/taylor_series.hpp"
#include "models/wide.hpp"

namespace polhode {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

class Random {
 public:
  double number(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  Vec3 vector(double size) { return Vec3(number(-size, size), number(-size, size), number(-size, size)); }
  Quaternion attitude() {
    std::normal_distribution<double> n;
    return normalised(Quaternion(n(engine_), n(engine_), n(engine_), n(engine_)));
  }

 private:
  std::mt19937_64 engine_{20260101};
};

TEST(Attitude, HatIsTheCrossProductAndVeeItsInverse) {
  Random random;
  for (int i = 0; i < 100; ++i) {
    const Vec3 a = random.vector(3), b = random.vector(3);
    EXPECT_LT((hat<double>(a) * b - a.cross(b)).norm(), 8 * eps * a.norm() * b.norm());
    EXPECT_EQ(vee<double>(hat<double>(a)), a);
  }
}

TEST(Attitude, QuaternionMatrixAndExponentialAgree) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Vec3 v = random.vector(1.8);
    const Quaternion q = exp_rotation<double>(v);
    // exp(hat v) by its Taylor series: |v| < 3.2, 3.2^60/60! < 1e-51
    Mat3 series = Mat3::Identity(), term = series;
    for (int k = 1; k < 60; ++k) series += term = term * hat<double>(v) / k;
    EXPECT_LT((rotation_matrix(q) - series).norm(),
              300 * eps);  // the series' terms reach 3.2^3/6 = 5 and cancel
    EXPECT_LT((exp_rotation_matrix<double>(v) - series).norm(), 300 * eps);
    EXPECT_LT((log_rotation(q) - v).norm(), 20 * eps);
    const Vec3 a = random.vector(2);
    EXPECT_LT((to_space<double>(q, to_body<double>(q, a)) - a).norm(), 20 * eps);
    // q of any length is the same attitude
    const Quaternion longer(q.w() * 3, q.x() * 3, q.y() * 3, q.z() * 3);
    EXPECT_LT((to_space<double>(longer, a) - to_space<double>(q, a)).norm(), 20 * eps);
    EXPECT_LT(attitude_error(longer, q), 8 * eps);
  }
}

TEST(Attitude, SmallAnglesKeepTheirDigits) {
  // acos would read 0 or 1.5e-8 here, and (1 - cos a)/a^2 has no digit left.
  for (double angle = 1e-3; angle > 1e-15; angle /= 10) {
    const Vec3 v(angle, 0, 0);
    EXPECT_NEAR(attitude_error<double>(Quaternion(1, 0, 0, 0), exp_rotation<double>(v)) / angle, 1, 4 * eps);
    EXPECT_NEAR(log_rotation(exp_rotation<double>(v)).x() / angle, 1, 4 * eps);
    EXPECT_NEAR(exp_rotation_matrix<double>(v)(2, 1) / angle, std::sin(angle) / angle, 4 * eps);
  }
  EXPECT_EQ(exp_rotation<double>(Vec3::Zero()).w(), 1);
  EXPECT_EQ(log_rotation(Quaternion(1, 0, 0, 0)).norm(), 0);
  EXPECT_NEAR(attitude_error(Quaternion(1, 0, 0, 0), Quaternion(-1, 0, 0, 0)), 0, eps);
}

TEST(Attitude, NearestRotationIsProperAndAFixedPoint) {
  Random random;
  for (int i = 0; i < 50; ++i) {
    const Mat3 R = rotation_matrix(random.attitude());
    EXPECT_LT((nearest_rotation(R) - R).norm(), 30 * eps);
    const Mat3 near = nearest_rotation(R + 0.1 * Mat3::Random());
    EXPECT_LT((near.transpose() * near - Mat3::Identity()).norm(), 30 * eps);
    EXPECT_NEAR(near.determinant(), 1, 30 * eps);
  }
  EXPECT_NEAR(nearest_rotation(-Mat3::Identity()).determinant(), 1, 30 * eps);
}

TEST(NewtonEuler, TheBlockSystemEqualsTheReducedForm) {
  Random random;
  for (int i = 0; i < 200; ++i) {
    const Vec3 moments(random.number(0.5, 1), random.number(0.5, 1), random.number(0.5, 1));
    const Quaternion q = random.attitude();
    const Mat3 R = rotation_matrix(q), I = inertia_S(R, moments);
    const Vec3 w_B = random.vector(3), F = random.vector(5), r = random.vector(1);
    const double mass = random.number(0.5, 5);
    const Vec3 tau = torque_of_force(r, F);
    const Acceleration a = newton_euler(mass, I, R * w_B, F, tau);
    EXPECT_LT((a.linear - F / mass).norm(), 30 * eps * F.norm() / mass);
    // Reduced: I w' = (I w) x w + tau_B in the body; w' in space is R of it, since w x w = 0.
    const Vec3 reduced =
        ((moments.cwiseProduct(w_B)).cross(w_B) + R.transpose() * tau).cwiseQuotient(moments);
    // condition number of I at most 2, a dozen rounded operations on numbers of size ~50
    EXPECT_LT((a.angular - R * reduced).norm(), 100 * eps * 50);
    EXPECT_LT((angular_acceleration_S(I, R * w_B, tau) - a.angular).norm(), 100 * eps * 50);
    // L = I w is R times the body momentum, and v_i = v + w x r_i is the derivative of p + R r
    EXPECT_LT((angular_momentum_S(I, R * w_B) - R * moments.cwiseProduct(w_B)).norm(), 50 * eps);
    EXPECT_LT((point_velocity(F, R * w_B, r) - (F + hat<double>(R * w_B) * r)).norm(), 50 * eps);
    EXPECT_EQ(linear_momentum(mass, F), mass * F);
  }
}

Scene with_load(AnyTorque<double> load) {
  Scene s;
  s.duration = 1;
  s.rotation.emplace();
  s.rotation->moments = Vec3(0.3, 0.45, 0.6);
  s.rotation->q0 = Quaternion(0.96, 0.1, 0.28, -0.2);
  s.rotation->w0 = Vec3(1, 0.4, 2);
  s.rotation->loads.push_back(std::move(load));
  return s;
}

std::vector<AnyTorque<double>> one_of_each() {
  Mat3 drag = Vec3(0.3, 0.2, 0.1).asDiagonal();
  drag(0, 1) = drag(1, 0) = 0.05;
  return {GravityAboutPivot<double>{0.9, Vec3(0, 1, -9.81), Vec3(0.05, 0.08, 0.2)},
          AngularDrag<double>{drag},
          AttitudeSpring<double>{5, 0.4, Quaternion(0.8, 0, 0.6, 0)},
          ConstantTorque<double, Frame::body>{Vec3(0.1, -0.2, 0.3)},
          ConstantTorque<double, Frame::space>{Vec3(0.1, -0.2, 0.3)},
          GravityGradient<double>{0.7, Vec3(0.3, 0.45, 0.6)}};
}

TEST(Loads, BothFormsOfATorqueAgree) {
  Random random;
  for (const auto& load : one_of_each())
    for (int i = 0; i < 50; ++i) {
      const Quaternion q = random.attitude();
      const Mat3 R = rotation_matrix(q);
      const Vec3 w = random.vector(2);
      const double t = random.number(0, 10);
      const Vec3 body = std::visit([&](const auto& l) { return l.template torque_B<double>(t, q, w); }, load);
      const Vec3 space = std::visit([&](const auto& l) { return l.torque_S(t, R, R * w); }, load);
      EXPECT_LT((R * body - space).norm(), 100 * eps * (1 + 10 * body.norm())) << "load " << load.index();
    }
}

TEST(Loads, EnergyChangesAtTheStatedRate) {
  // dE/dt along the exact motion, from its Taylor series in 50 digits: E is recorded as a Jet on the series
  // itself.
  for (const auto& load : one_of_each()) {
    const Scene scene = with_load(load);
    with_general_model<Wide>(scene, [&](const auto& m) {
      TaylorSeries series(m, 30);
      series.expand(Wide(0.3), m.initial);
      const Wide h("1e-12");
      const Wide before = m.total_energy(Wide(0.3) - h, series.at(-h).data());
      const Wide after = m.total_energy(Wide(0.3) + h, series.at(h).data());
      // Central difference: error h^2 E'''/6 ~ 1e-24 times the third derivative, here below 1e4.
      const double measured = Wide((after - before) / (2 * h)).template convert_to<double>();
      const double stated = m.energy_rate(Wide(0.3), m.initial.data()).template convert_to<double>();
      EXPECT_NEAR(measured, stated, 1e-14 * (1 + std::abs(stated))) << "load " << load.index();
    });
  }
}

TEST(Loads, TheSmallestModelHasTheSameEquationsAsTheGeneralOne) {
  for (const auto& load : one_of_each()) {
    const Scene scene = with_load(load);
    std::array<double, 7> general{}, small{};
    with_general_model<double>(scene, [&](const auto& m) {
      if constexpr (std::remove_cvref_t<decltype(m)>::size == 7) m.rhs(0.4, m.initial.data(), general.data());
    });
    with_model(scene, [&](const auto& m) {
      if constexpr (std::remove_cvref_t<decltype(m)>::size == 7) m.rhs(0.4, m.initial.data(), small.data());
    });
    for (std::size_t i = 0; i < 7; ++i)
      EXPECT_NEAR(general[i], small[i], 20 * eps * (1 + std::abs(small[i])));
  }
}

TEST(TaylorSeriesOfASolution, SatisfiesItsEquation) {
  for (const auto& load : one_of_each()) {
    const Scene scene = with_load(load);
    with_general_model<Wide>(scene, [&](const auto& m) {
      using M = std::remove_cvref_t<decltype(m)>;
      TaylorSeries<M> series(m, 40);
      ASSERT_LT(abs(Wide(m.initial[0] * m.initial[0] + m.initial[1] * m.initial[1] +
                         m.initial[2] * m.initial[2] + m.initial[3] * m.initial[3] - 1)),
                Wide(1e-45));  // as a series takes it for granted
      series.settle_signs(Wide(0), m.initial);
      series.expand(Wide(0), m.initial);
      const Wide h("0.01"), d("1e-15");
      const auto low = series.at(h - d), high = series.at(h + d), y = series.at(h);
      typename M::State slope;
      m.rhs(h, y.data(), slope.data());
      // Truncation (0.01 x ~50)^40 < 1e-11 ... of coefficients that fall like 30^k: below 1e-20; difference
      // 1e-30 y'''.
      for (std::size_t i = 0; i < y.size(); ++i)
        EXPECT_LT(Wide(abs((high[i] - low[i]) / (2 * d) - slope[i])).template convert_to<double>(), 1e-20)
            << "load " << load.index() << ", coordinate " << i;
    });
  }
}

}  // namespace
}  // namespace polhode
