// Scene files: what they resolve to, checked against the laws in the user's own axes.
#include "models/scene.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "models/errors.hpp"
#include "models/mass_properties.hpp"
#include "models/model.hpp"
#include "models/wide.hpp"
#include "tests/scene_file.hpp"

namespace polhode {
namespace {

using testing::Contains;
using testing::HasSubstr;

using SceneMeaning = SceneFile;

// ---------------------------------------------------------------------------- built-in scenes

TEST(BuiltInScenes, AllReadAndAreSane) {
  const auto ids = builtin_scene_ids();
  EXPECT_TRUE(std::is_sorted(ids.begin(), ids.end()));
  EXPECT_GE(ids.size(), 15u);
  for (const auto& id : ids) {
    SCOPED_TRACE(id);
    const Scene scene = find_scene(id);
    EXPECT_EQ(scene.id, id);
    EXPECT_NE(scene.title, id) << "a built-in scene has a title";
    EXPECT_GT(scene.duration, 0);
    EXPECT_THAT(scene.notes, testing::IsEmpty());
    EXPECT_TRUE(scene.rotation || scene.translation);
    with_model(scene, [&](const auto& m) {
      EXPECT_EQ(m.size, scene.unknowns);
      EXPECT_TRUE(std::isfinite(m.total_energy(0, m.initial.data())));
      auto derivative = m.initial;
      m.rhs(0.0, m.initial.data(), derivative.data());
      double speed = 0;
      for (const double x : derivative) speed += std::abs(x);
      EXPECT_GT(speed, 0) << "something moves";
      EXPECT_TRUE(std::isfinite(speed));
    });
    if (scene.rotation) {
      EXPECT_EQ(inertia_fault(scene.rotation->moments, id != "euler-equations").text, "");
      EXPECT_NEAR(squared_norm(scene.rotation->principal_to_user), 1, 1e-15);
    }
    if (scene.dial) {
      EXPECT_GE(scene.dial->values.back() / scene.dial->values.front(), 100);
      for (const double value : scene.dial->values)
        EXPECT_EQ(scene.with_dial(value).rotation->loads.size(), scene.rotation->loads.size());
    }
  }
}

TEST(BuiltInScenes, KeepTheDoublesThatAreWritten) {
  const Scene box = find_scene("tumbling-box");
  EXPECT_EQ(box.rotation->moments, Vec3(0.80833333, 0.68333333, 0.14166667));
  EXPECT_EQ(box.rotation->w0, Vec3(0.1, 5.0, 0.1));
  EXPECT_EQ(box.rotation->principal_to_user.coeffs(), Quaternion(1, 0, 0, 0).coeffs());
  EXPECT_EQ(box.translation->v0, Vec3(-2, 2, 8));
  EXPECT_EQ(box.translation->acceleration, Vec3(0, 0, -9.8));
  EXPECT_EQ(box.translation->mass, 10);
  EXPECT_EQ(box.unknowns, 13);
  EXPECT_THAT(box.left_out, testing::ElementsAre("no load evaluation: free motion"));

  // The published body momentum (1.8, 0.4, -0.9): the rates are exact, I w is theirs to a rounding.
  const Scene body = find_scene("hairer-vilmart");
  const Vec3 m = body.rotation->moments.cwiseProduct(body.rotation->w0);
  EXPECT_LT((m - Vec3(1.8, 0.4, -0.9)).cwiseAbs().maxCoeff(), 2.3e-16);  // one unit in the last place of 1.8
}

TEST(BuiltInScenes, SpringsNeverTurnFarEnoughToJump) {
  // 4 k (1 - |q_w|) <= E(0), for the energy only falls: |q_w| >= 1 - E(0)/(4 k).
  for (const char* id : {"attitude-spring", "undamped-spring", "critical-spring", "overdamped-spring"}) {
    const Scene scene = find_scene(id);
    for (const double k : scene.dial->values)
      with_model(scene.with_dial(k), [&](const auto& m) {
        EXPECT_GT(1 - m.total_energy(0, m.initial.data()) / (4 * k), 0.5) << id << " " << k;
      });
  }
}

TEST(BuiltInScenes, FollowersOfADialKeepTheDampingRatioAndTheNumberOfPeriods) {
  const Scene scene = find_scene("attitude-spring"), stiff = scene.with_dial(5e4);
  const auto& soft_spring = std::get<AttitudeSpring<double>>(scene.rotation->loads[0]);
  const auto& stiff_spring = std::get<AttitudeSpring<double>>(stiff.rotation->loads[0]);
  EXPECT_EQ(stiff_spring.stiffness, 5e4);
  // c / sqrt(k) and T sqrt(k): a power, a product and a quotient, each rounded once.
  const double ratio = std::sqrt(5e4 / soft_spring.stiffness);
  EXPECT_NEAR(stiff_spring.damping, soft_spring.damping * ratio, 4e-16 * stiff_spring.damping);
  EXPECT_NEAR(stiff.duration, scene.duration / ratio, 4e-16 * stiff.duration);
  EXPECT_EQ(stiff.variant, "load[0].stiffness = 50000");
}

TEST(BuiltInScenes, TheHandleTurnsAboutItsMiddleAxis) {
  const Scene scene = find_scene("t-handle");
  const Vec3& I = scene.rotation->moments;
  EXPECT_LT(I.x(), I.y());
  EXPECT_LT(I.y(), I.z());
}

TEST(BuiltInScenes, AreFoundByIdAndMissedWithTheNearestName) {
  try {
    find_scene("tumbling_bocks");
    ADD_FAILURE() << "found";
  } catch (const UsageError& e) {
    EXPECT_EQ(e.exit_code, 2);
    EXPECT_THAT(e.what(), HasSubstr("perhaps \"tumbling-box\""));
  }
  EXPECT_THROW(find_scene("./tumbling-box"), InputError);  // a path: no such file here
  EXPECT_THROW(find_scene("tumbling-box.toml"), InputError);
  EXPECT_THROW(data_folder("no-such-folder"), MissingError);
}

TEST(NearestName, CountsEditsAndSwapsAndKnowsWhenNothingIsNear) {
  const std::vector<std::string> keys = {"acceleration", "angular_velocity", "mass", "inertia", "duration"};
  EXPECT_EQ(nearest_name("accelaration", keys), "acceleration");
  EXPECT_EQ(nearest_name("msas", keys), "mass");
  EXPECT_EQ(nearest_name("Angular-Velocity", keys), "angular_velocity");
  EXPECT_EQ(nearest_name("zzzzzzzz", keys), "");
  EXPECT_EQ(nearest_name("", keys), "");
  EXPECT_EQ(nearest_name("x", {}), "");
  EXPECT_EQ(nearest_name(std::string(1'000'000, 'x'), keys), "");
}

// ---------------------------------------------------------------------------- what a scene means

// A body in axes that are not principal: I_U = U diag(1, 2, 2.5) U^T, and the laws in those axes.
const Vec3 moments(1, 2, 2.5);
const Quaternion user_axes = normalised(Quaternion(0.8, 0.3, -0.4, 0.5));  // principal -> user
const Quaternion q_SU = normalised(Quaternion(0.6, -0.2, 0.5, 0.3));
const Vec3 w_U(0.7, -1.1, 0.4);

Mat3 user_inertia() {
  const Mat3 U = rotation_matrix<double>(user_axes);
  return U * moments.asDiagonal() * U.transpose();
}

std::string number(double x) { return number_text(x); }
std::string list(std::initializer_list<double> values) {
  std::string text;
  for (const double x : values) text += (text.empty() ? "[" : ", ") + number(x);
  return text + "]";
}

std::string user_scene(const std::string& load) {
  const Mat3 I = user_inertia();
  return "duration = 1\n[body]\nmass = 0.5\ninertia = " +
         list({I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}) +
         "\n[initial]\norientation = " + list({q_SU.w(), q_SU.x(), q_SU.y(), q_SU.z()}) +
         "\nangular_velocity = " + list({w_U[0], w_U[1], w_U[2]}) + "\n" + load;
}

// 1e-14: thirty operations on numbers of order one to ten, each rounded to 1e-16 of it.
constexpr double rounding = 1e-14;

struct LoadCase {
  std::string toml;
  std::function<Vec3()> torque_U;  // by the law, in user components, at t = 0
};

TEST_F(SceneMeaning, LoadsInUserAxesActAsTheirLawsSayThere) {
  const Mat3 I = user_inertia(), R = rotation_matrix<double>(q_SU);
  const Vec3 g(1, -2, -9), r(0.1, 0.2, -0.3), tau(0.3, 0.1, -0.2);
  const std::vector<LoadCase> cases = {
      {"", [&] { return Vec3(0, 0, 0); }},
      {"type = 'gravity_about_pivot'\nacceleration = [1, -2, -9]\ncenter_of_mass = [0.1, 0.2, -0.3]",
       [&] { return Vec3(0.5 * r.cross(R.transpose() * g)); }},
      {"type = 'angular_drag'\ncoefficients = [0.5, 0, 0.02]",
       [&] { return Vec3(-0.5 * w_U[0], 0, -0.02 * w_U[2]); }},
      {"type = 'attitude_spring'\nstiffness = 3\ndamping = 0.25",
       [&] { return Vec3(-6 * q_SU.vec() - 0.25 * w_U); }},
      {"type = 'constant_torque'\nframe = 'body'\ntorque = [0.3, 0.1, -0.2]", [&] { return tau; }},
      {"type = 'constant_torque'\nframe = 'space'\ntorque = [0.3, 0.1, -0.2]",
       [&] { return Vec3(R.transpose() * tau); }},
      {"type = 'gravity_gradient'\nmean_motion = 0.7",
       [&] {
         const Vec3 r_U = R.transpose() * Vec3(1, 0, 0);
         return Vec3(3 * 0.49 * r_U.cross(I * r_U));
       }},
  };
  for (const auto& c : cases) {
    SCOPED_TRACE(c.toml);
    const Scene scene = read(user_scene(c.toml.empty() ? "" : "[[load]]\n" + c.toml + "\n"));
    ASSERT_EQ(scene.rotation->loads.size(), c.toml.empty() ? 0u : 1u);
    const Quaternion& turn = scene.rotation->principal_to_user;
    EXPECT_GT(attitude_error(turn, Quaternion(1, 0, 0, 0)), 0.1);
    EXPECT_NEAR(scene.rotation->moments.sum(), moments.sum(), rounding);
    EXPECT_NEAR(scene.rotation->moments.prod(), moments.prod(), rounding);
    const Vec3 acceleration = I.inverse() * ((I * w_U).cross(w_U) + c.torque_U());
    with_model(scene, [&](const auto& m) {
      using M = std::decay_t<decltype(m)>;
      if constexpr (M::has_attitude) {
        const double* y = m.initial.data();
        EXPECT_NEAR(m.rotational_energy(y), 0.5 * w_U.dot(I * w_U), rounding);
        EXPECT_LT((m.angular_momentum(y) - R * I * w_U).norm(), rounding);
        auto d = m.initial;
        m.rhs(0.0, y, d.data());
        EXPECT_LT((to_space<double>(turn, m.rotation.w_of(d.data())) - acceleration).norm(), 10 * rounding);
      }
    });
  }
}

TEST_F(SceneMeaning, RatesMayBeGivenInSpaceOrAsMomentum) {
  const Mat3 I = user_inertia(), R = rotation_matrix<double>(q_SU);
  const Vec3 w_S = R * w_U, L_S = R * I * w_U;
  const std::string body_rate = user_scene("");
  const Scene by_body = read(body_rate);
  for (const auto& [key, v] :
       {std::pair<std::string, Vec3>{"angular_velocity_space", w_S}, {"angular_momentum", L_S}}) {
    std::string text = body_rate.substr(0, body_rate.find("angular_velocity"));
    text += key + " = " + list({v[0], v[1], v[2]}) + "\n";
    EXPECT_LT((read(text).rotation->w0 - by_body.rotation->w0).norm(), rounding) << key;
    // An orientation of another length is the same attitude.
    const auto at = text.find("orientation = ");
    const Quaternion q(q_SU.w() * 4, q_SU.x() * 4, q_SU.y() * 4, q_SU.z() * 4);
    text.replace(at, text.find('\n', at) - at, "orientation = " + list({q.w(), q.x(), q.y(), q.z()}));
    const Scene longer = read(text);
    EXPECT_LT((longer.rotation->w0 - by_body.rotation->w0).norm(), rounding) << key;
    EXPECT_NEAR(std::sqrt(squared_norm(longer.rotation->q0)), 4, rounding) << "not normalised by the reader";
  }
}

TEST_F(SceneMeaning, AFileIsReadWithIntegersAndFloatsAlikeAndKeepsEveryDigit) {
  const Scene s = read(
      "duration = 3\n[body]\ninertia = [1, 2.0, 2.9999999999999996]\n[initial]\n"
      "angular_velocity = [1e-3, -0.1, 0.30000000000000004]\norientation = [2, 0, 0, 0]");
  EXPECT_EQ(s.duration, 3);
  EXPECT_EQ(s.title, "scene");  // without a title: the name of the file
  EXPECT_EQ(s.rotation->moments, Vec3(1, 2, 2.9999999999999996));
  EXPECT_EQ(s.rotation->w0, Vec3(1e-3, -0.1, 0.30000000000000004));
  EXPECT_EQ(s.rotation->q0.w(), 2);
  // Six numbers whose products are zero are three: no axes are turned.
  EXPECT_EQ(
      read("duration = 3\n[body]\ninertia = [3, 1, 2.5, 0, 0, 0]\n[initial]\nangular_velocity = [1, 2, 3]")
          .rotation->moments,
      Vec3(3, 1, 2.5));
}

TEST_F(SceneMeaning, TranslationIsThereWhenSomethingMovesOrPushes) {
  const auto scene = [&](const std::string& initial, const std::string& load) {
    return read(
        "duration = 1\n[body]\nmass = 2\ninertia = [1, 2, 2.5]\n[initial]\nangular_velocity = [1, 0, 0]\n" +
        initial + load);
  };
  const std::string pull = "\n[[load]]\ntype = 'gravity'\nacceleration = [0, 0, -1]";
  EXPECT_FALSE(scene("", "").translation);
  EXPECT_FALSE(scene("position = [1, 2, 3]\nvelocity = [0, 0, 0]", "").translation);
  EXPECT_THAT(scene("", "").left_out, Contains("no translation: nothing moves or pushes the centre of mass"));
  EXPECT_EQ(scene("", "").unknowns, 7);

  const Scene moving = scene("velocity = [0, 0, 1]", "");
  EXPECT_FALSE(moving.translation->has_force);
  EXPECT_THAT(moving.left_out, Contains("no force: the centre of mass moves on a straight line"));

  // Forces of the same kind add up.
  const Scene pulled =
      scene("position = [1, 2, 3]", pull + pull + "\n[[load]]\ntype = 'linear_drag'\ncoefficient = 0.5" +
                                        "\n[[load]]\ntype = 'linear_drag'\ncoefficient = 0.25");
  EXPECT_EQ(pulled.translation->acceleration, Vec3(0, 0, -2));
  EXPECT_EQ(pulled.translation->drag, 0.75);
  EXPECT_EQ(pulled.translation->p0, Vec3(1, 2, 3));
  EXPECT_TRUE(pulled.translation->has_force);
  EXPECT_EQ(pulled.unknowns, 13);

  const Scene rates = read(
      "duration = 1\nattitude = false\n[body]\nmass = 2\ninertia = [1, 1, 1]\n[initial]\nangular_velocity = "
      "[1, 0, 0]" +
      pull);
  EXPECT_FALSE(rates.translation);
  EXPECT_EQ(rates.unknowns, 3);
  EXPECT_THAT(rates.left_out, Contains("no attitude: only the rates are asked for"));
}

TEST_F(SceneMeaning, ALoadThatIsZeroIsLeftOutUnlessAStudyVariesIt) {
  const std::string text =
      "duration = 1\n[body]\ninertia = [1, 2, 2.5]\n[initial]\nangular_velocity = [1, 0, 0]\n"
      "[[load]]\ntype = 'constant_torque'\ntorque = [0, 0, 0]\nframe = 'body'\n"
      "[[load]]\ntype = 'angular_drag'\ncoefficients = [0, 0, 0]\n";
  EXPECT_TRUE(read(text).rotation->loads.empty());
  EXPECT_THAT(read(text).left_out, Contains("no load 1: it is zero"));
  const Scene varied = read(text + "[stiff]\ndial = 'load[1].coefficients[2]'\nvalues = [1, 10]\n");
  const Scene ten = varied.with_dial(10);
  ASSERT_EQ(ten.rotation->loads.size(), 1u);
  const auto& drag = std::get<AngularDrag<double>>(ten.rotation->loads[0]);
  EXPECT_EQ(drag.coefficients_B, Mat3(Vec3(0, 0, 10).asDiagonal()));
}

TEST_F(SceneMeaning, AStiffCoefficientBelongsToTheUsersAxes) {
  const std::string with = "[[load]]\ntype = 'angular_drag'\ncoefficients = ",
                    stiff = "[stiff]\ndial = 'load[0].coefficients[1]'\nvalues = [7]\n";
  const Scene changed = read(user_scene(with + "[0.1, 0.2, 0.3]\n" + stiff)).with_dial(7);
  const Scene written = read(user_scene(with + "[0.1, 7, 0.3]\n"));
  const auto& a = std::get<AngularDrag<double>>(changed.rotation->loads[0]).coefficients_B;
  const auto& b = std::get<AngularDrag<double>>(written.rotation->loads[0]).coefficients_B;
  EXPECT_LT((a - b).norm(), rounding);

  const std::string spring = "[[load]]\ntype = 'attitude_spring'\nstiffness = 1\ndamping = 2\n[stiff]\n";
  const Scene damped = read(user_scene(spring + "dial = 'load[0].damping'\nvalues = [3, 4]")).with_dial(4);
  EXPECT_EQ(std::get<AttitudeSpring<double>>(damped.rotation->loads[0]).damping, 4);
  EXPECT_EQ(std::get<AttitudeSpring<double>>(damped.rotation->loads[0]).stiffness, 1);
  EXPECT_THROW(written.with_dial(1), InputError);
}

TEST_F(SceneMeaning, ABodyOfPartsIsHeldAtItsOriginOrWhereItsCenterIsSaidToBe) {
  // A bar of 2 kg and length 3 along z, its end at the origin: I = m l^2/3 there, its centre 1.5 away.
  const std::string text =
      "duration = 1\n[[body.part]]\nshape = 'box'\nsize = [0.3, 0.4, 3]\nmass = 2\nposition = [0, 0, 1.5]\n"
      "[initial]\nangular_velocity = [1, 0, 0]\n"
      "[[load]]\ntype = 'gravity_about_pivot'\nacceleration = [0, 0, -9.81]\n";
  const Vec3 end(2 * (0.16 / 12 + 3), 2 * (0.09 / 12 + 3), 2 * 0.25 / 12);
  const Scene held = read(text);
  EXPECT_TRUE(held.rotation->about_pivot);
  EXPECT_LT((held.rotation->moments - end).norm(), rounding);
  EXPECT_EQ(std::get<GravityAboutPivot<double>>(held.rotation->loads[0]).center_B, Vec3(0, 0, 1.5));
  EXPECT_THAT(held.left_out, Contains("no translation: the body is held at its pivot"));
  const Scene elsewhere = read(text + "center_of_mass = [0, 0, 1]\n");
  EXPECT_NEAR(elsewhere.rotation->moments.x(), 2 * (9.16 / 12 + 1), rounding);

  // Given moments are about the pivot already; a mass that alone would have more there is pointed out.
  const std::string given =
      "duration = 1\n[body]\nmass = 1\ninertia = [0.2, 0.2, 0.1]\n[initial]\nangular_velocity = [0, 0, 9]\n"
      "[[load]]\ntype = 'gravity_about_pivot'\nacceleration = [0, 0, -9.81]\ncenter_of_mass = ";
  EXPECT_EQ(read(given + "[0, 0, 0.25]").rotation->moments, Vec3(0.2, 0.2, 0.1));
  EXPECT_TRUE(read(given + "[0, 0, 0.25]").notes.empty());
  EXPECT_THAT(read(given + "[0, 0, 0.6]").notes, Contains(HasSubstr("no real body")));
}

TEST_F(SceneMeaning, EveryShapeIsABodyByMassAndByDensity) {
  for (const auto& shape : primitive_shapes()) {
    SCOPED_TRACE(shape);
    std::string text = "duration = 1\n[body]\nshape = '" + shape + "'\n";
    std::vector<double> lengths;
    double next = 2.0;
    for (const auto& key : primitive_needs(shape)) {
      const bool three = key == "size" || key == "inner_size" || key == "radii";
      text += key + " = " + (three ? list({next, next * 1.1, next * 1.2}) : number(next)) + "\n";
      if (three)
        lengths.insert(lengths.end(), {next, next * 1.1, next * 1.2});
      else
        lengths.push_back(next);
      next /= 2;
    }
    const std::string initial = "\n[initial]\nangular_velocity = [1, 2, 3]\n";
    const Scene by_mass = read(text + "mass = 3" + initial),
                by_density = read(text + "density = 3" + initial);
    // Correctly rounded.
    EXPECT_EQ(by_mass.rotation->moments,
              Vec3(primitive<Resolved>(shape, lengths, 3).inertia.diagonal().cast<double>()));
    const double volume = primitive_volume(shape, lengths);
    EXPECT_LT((by_density.rotation->moments / volume - by_mass.rotation->moments / 3 * 3).norm(),
              rounding * by_mass.rotation->moments.norm());
  }
}

TEST_F(SceneMeaning, ABrokenOffFileIsReadOrRefusedButNothingElse) {
  const std::string whole =
      user_scene("velocity = [1, 2, 3]\n[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n") +
      "[stiff]\ndial = 'load[0].coefficients[0]'\nvalues = [1, 10]\n";
  int refused = 0;
  for (std::size_t n = 0; n <= whole.size(); ++n) refused += refusal(whole.substr(0, n)).front() != '(';
  EXPECT_GT(refused, static_cast<int>(whole.size() / 2));
  EXPECT_EQ(refusal(whole), "(read without complaint)");
}

}  // namespace
}  // namespace polhode
