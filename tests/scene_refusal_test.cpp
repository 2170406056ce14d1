// What is refused of scene files, with the line, the key and the reason that the message must give.
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "tests/scene_file.hpp"

namespace polhode {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using SceneRefusal = SceneFile;

struct Malformed {
  int line;  // that the message names
  std::string text;
  std::vector<std::string> fragments;
};

const std::string top = "title = 'x'\nduration = 1\n";                 // lines 1 and 2
const std::string body = "[body]\nmass = 1\ninertia = [1, 2, 2.5]\n";  // lines 3 to 5
const std::string spin = "[initial]\nangular_velocity = [1, 2, 3]\n";  // lines 6 and 7, after body
const std::string good = top + body + spin;                            // what follows starts at line 8

const std::vector<Malformed>& malformed() {
  static const std::vector<Malformed> table = {
      // top level
      {1, "title = 'x'\n" + body + spin, {"duration", "got nothing", "number > 0"}},
      {2, "title = 'x'\nduration = 0\n" + body + spin, {"duration", "got 0", "> 0"}},
      {2, "title = 'x'\nduration = -2.5\n" + body + spin, {"duration", "got -2.5"}},
      {2, "title = 'x'\nduration = 'long'\n" + body + spin, {"duration", "got \"long\"", "finite number"}},
      {2, "title = 'x'\nduration = nan\n" + body + spin, {"duration", "got nan"}},
      {2, "title = 'x'\nduration = inf\n" + body + spin, {"duration", "got inf"}},
      {2, "title = 'x'\nduration = 2020-01-01\n" + body + spin, {"duration", "a date or time"}},
      {1, "title = 3\nduration = 1\n" + body + spin, {"title", "got 3", "a text"}},
      {3, top + "durration = 2\n" + body + spin, {"durration", "unknown key", "perhaps \"duration\""}},
      {3, top + "attitude = 'no'\n" + body + spin, {"attitude", "true or false"}},
      {3, top + "zzzzzzzzzz = 2\n" + body + spin, {"zzzzzzzzzz", "unknown key", "one of title, source"}},
      {1, top + "[initial]\n", {"body", "got nothing", "[body]"}},
      {1, "body = 3\nduration = 1\n", {"body", "got 3", "a table"}},
      // body
      {3, top + "[body]\n" + spin, {"body.mass", "got nothing", "particle"}},
      {4, top + "[body]\nmass = 0\n", {"body.mass", "got 0", "> 0"}},
      {5, top + "[body]\nmass = 1\nmas = 2\n", {"body.mas:", "unknown key", "perhaps \"mass\""}},
      {4, top + "[body]\ninertia = [1, 2]\n" + spin, {"body.inertia", "[1, 2]", "2 elements", "3 or 6"}},
      {4, top + "[body]\ninertia = [1, 2, 'x']\n" + spin, {"body.inertia", "[1, 2, \"x\"]"}},
      {4, top + "[body]\ninertia = [1, 2, inf]\n" + spin, {"body.inertia", "inf", "finite"}},
      {4, top + "[body]\ninertia = 1\n" + spin, {"body.inertia", "got 1", "array"}},
      {4,
       top + "[body]\ninertia = [0.5, 2, 3]\n" + spin,
       {"body.inertia", "I1 + I2 >= I3", "I1 = 0.5, I2 = 2, I3 = 3", "physical = false"}},
      {4, top + "[body]\ninertia = [1, 1, 0]\n" + spin, {"body.inertia", "I3 > 0"}},
      {4, top + "[body]\ninertia = [1, -1, 1]\n" + spin, {"body.inertia", "I2 > 0"}},
      {4,
       top + "[body]\ninertia = [1, 1, 1, 2, 0, 0]\n" + spin,
       {"body.inertia", "> 0", "principal moments"}},
      {4,
       top + "[body]\ninertia = [1, 2, 0]\nphysical = false\n" + spin,
       {"body.inertia", "three positive moments"}},
      {5,
       top + "[body]\ninertia = [1, 2, 2.5]\nshape = 'box'\n" + spin,
       {"\"shape\" beside \"inertia\"", "only one"}},
      {5, top + "[body]\ninertia = [1, 2, 2.5]\ndensity = 2\n" + spin, {"body.density", "unknown key"}},
      {5,
       top + "[body]\nmass = 1\nphysical = false\n[initial]\nvelocity = [1, 0, 0]",
       {"body.physical", "particle"}},
      {4, top + "[body]\nshape = 'bxo'\n" + spin, {"body.shape", "\"bxo\"", "perhaps \"box\"", "sphere"}},
      {3,
       top + "[body]\nshape = 'box'\nmass = 1\n" + spin,
       {"body.size", "got nothing", "3 finite numbers > 0"}},
      {5,
       top + "[body]\nshape = 'box'\nsize = [1, 0, 1]\nmass = 1\n" + spin,
       {"body.size", "[1, 0, 1]", "> 0"}},
      {3, top + "[body]\nshape = 'sphere'\nradius = 1\n" + spin, {"body.mass", "got nothing", "density"}},
      {7,
       top + "[body]\nshape = 'sphere'\nradius = 1\nmass = 1\ndensity = 1\n" + spin,
       {"body.density", "only one"}},
      {5,
       top + "[body]\nshape = 'sphere'\nradii = 1\nmass = 1\n" + spin,
       {"body.radii", "perhaps \"radius\""}},
      {6,
       top + "[body]\nshape = 'hollow_sphere'\nradius = 1\ninner_radius = 2\nmass = 1\n" + spin,
       {"body.inner_radius", "inner_radius 2 is not less than its radius 1"}},
      {4, top + "[body]\npart = 3\n" + spin, {"body.part", "got 3", "[[body.part]]"}},
      {4, top + "[body]\npart = []\n" + spin, {"body.part", "[[body.part]]"}},
      {5,
       top + "[[body.part]]\nshape = 'sphere'\ncolour = 'red'\nradius = 1\nmass = 1\n" + spin,
       {"body.part[0].colour", "unknown key"}},
      {10,
       top +
           "[[body.part]]\nshape = 'sphere'\nradius = 1\nmass = 1\n[[body.part]]\nshape = 'sphere'\nradius = "
           "1\n" +
           "mass = -1\n" + spin,
       {"body.part[1].mass", "got -1"}},
      {7,
       top + "[[body.part]]\nshape = 'sphere'\nradius = 1\nmass = 1\norientation = [0, 0, 0, 0]\n" + spin,
       {"body.part[0].orientation", "[0, 0, 0, 0]"}},
      {4,
       top + "[body]\nmass = 2\n[[body.particle]]\nmass = 1\nposition = [1, 0, 0]\n" + spin,
       {"body.mass", "unknown key"}},
      {3, top + "[[body.particle]]\nmass = 1\n" + spin, {"body.particle[0].position", "got nothing"}},
      {3,
       top +
           "[[body.particle]]\nmass = 1\nposition = [1, 0, 0]\n[[body.particle]]\nmass = 1\nposition = [0, "
           "0, 0]\n" +
           spin,
       {"body.particle", "I1 > 0"}},
      // initial values
      {6, top + body + "[initial]\n", {"initial.angular_velocity", "got nothing", "at rest"}},
      {1, top + body, {"initial.angular_velocity", "got nothing"}},
      {8, good + "angular_momentum = [1, 2, 3]\n", {"initial.angular_momentum", "only one of"}},
      {8, good + "velocity = [1, 2]\n", {"initial.velocity", "[1, 2] (2 elements)", "3 finite numbers"}},
      {8, good + "velocity = [1, 2, true]\n", {"initial.velocity", "true"}},
      {8, good + "orientation = [0, 0, 0, 0]\n", {"initial.orientation", "not zero"}},
      {8, good + "orientation = [1e200, 0, 0, 0]\n", {"initial.orientation", "1e+200"}},
      {8, good + "orientation = [1e-200, 0, 0, 0]\n", {"initial.orientation", "1e-200"}},
      {8, good + "orientation = [1, 0, 0]\n", {"initial.orientation", "3 elements", "4"}},
      {8, good + "velocty = [1, 2, 3]\n", {"initial.velocty", "perhaps \"velocity\""}},
      {6,
       top + "[body]\nmass = 1\n[initial]\norientation = [1, 0, 0, 0]\n",
       {"initial.orientation", "particle"}},
      {6,
       top + "[body]\nmass = 1\n[initial]\nangular_velocity = [1, 0, 0]\n",
       {"angular_velocity", "particle"}},
      {6, top + "[body]\nmass = 1\n[initial]\nvelocity = [0, 0, 0]\n", {"initial.velocity", "never moves"}},
      {3,
       top + "attitude = false\n[body]\nmass = 1\n[initial]\nvelocity = [1, 0, 0]\n",
       {"attitude", "particle"}},
      {3,
       top + "[body]\ninertia = [1, 2, 2.5]\n" + spin + "velocity = [1, 0, 0]\n",
       {"body.mass", "got nothing"}},
      // loads
      {8, good + "[load]\ntype = 'gravity'\n", {"load", "a table", "[[load]]"}},
      {8, good + "[[load]]\nacceleration = [0, 0, 1]\n", {"load[0].type", "got nothing", "gravity_gradient"}},
      {9, good + "[[load]]\ntype = 'gravty'\n", {"load[0].type", "\"gravty\"", "perhaps \"gravity\""}},
      {9, good + "[[load]]\ntype = 7\n", {"load[0].type", "got 7"}},
      {8, good + "[[load]]\ntype = 'gravity'\n", {"load[0].acceleration", "got nothing"}},
      {10, good + "[[load]]\ntype = 'gravity'\naccelaration = [0, 0, 1]\n", {"perhaps \"acceleration\""}},
      {10,
       good + "[[load]]\ntype = 'linear_drag'\ncoefficient = -1\n",
       {"load[0].coefficient", "got -1", ">= 0"}},
      {10, good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, -1, 1]\n", {"coefficients", ">= 0"}},
      {10, good + "[[load]]\ntype = 'angular_drag'\ncoefficient = [1, 1, 1]\n", {"perhaps \"coefficients\""}},
      {8, good + "[[load]]\ntype = 'attitude_spring'\nstiffness = 1\n", {"load[0].damping", "got nothing"}},
      {11,
       good + "[[load]]\ntype = 'constant_torque'\ntorque = [1, 0, 0]\nframe = 'world'\n",
       {"load[0].frame", "\"world\"", "body, space"}},
      {10, good + "[[load]]\ntype = 'gravity_gradient'\nmean_motion = 0\n", {"mean_motion", "got 0", "> 0"}},
      {8,
       good + "[[load]]\ntype = 'gravity_about_pivot'\nacceleration = [0, 0, 1]\n",
       {"center_of_mass", "got nothing"}},
      {13,
       good +
           "[[load]]\ntype = 'gravity_about_pivot'\nacceleration = [0, 0, 1]\ncenter_of_mass = [0, 0, 1]\n" +
           "[[load]]\ntype = 'gravity'\nacceleration = [0, 0, 1]\n",
       {"load[1].type", "\"gravity\"", "holds the body"}},
      {8,
       good + "velocity = [1, 0, 0]\n[[load]]\ntype = 'gravity_about_pivot'\nacceleration = [0, 0, 1]\n" +
           "center_of_mass = [0, 0, 1]\n",
       {"initial.velocity", "holds the body"}},
      {3,
       top + "[body]\ninertia = [1, 2, 2.5]\n" + spin + "[[load]]\ntype = 'gravity_about_pivot'\n" +
           "acceleration = [0, 0, 1]\ncenter_of_mass = [0, 0, 1]\n",
       {"body.mass", "got nothing"}},
      {10,
       top + "attitude = false\n" + body + spin +
           "[[load]]\ntype = 'attitude_spring'\nstiffness = 1\ndamping = 1\n",
       {"load[0].type", "attitude = false"}},
      {8,
       top + "[body]\nmass = 1\n[initial]\nvelocity = [1, 0, 0]\n[[load]]\ntype = 'angular_drag'\n" +
           "coefficients = [1, 1, 1]\n",
       {"load[0].type", "particle"}},
      // the stiff table
      {9,
       good + "[stiff]\ndial = 'load[0].stiffness'\nvalues = [1]\n",
       {"load[0].stiffness", "nothing there"}},
      {12,
       good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n[stiff]\ndial = "
              "'load[0].type'\nvalues = [1]\n",
       {"load[0].type", "something else", "place of a number"}},
      {12,
       good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n[stiff]\n" +
           "dial = 'load[0].coefficients[3]'\nvalues = [1]\n",
       {"coefficients[3]", "nothing there"}},
      {12,
       good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n[stiff]\n" +
           "dial = 'load[0].coefficients'\nvalues = [1]\nalso = [{ dial = 'load[0]x', power = 1 }]\n",
       {"load[0]x", "no '.' before a name"}},
      {13,
       good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n[stiff]\n" +
           "dial = 'load[0].coefficients'\nvalues = [3, 2]\n",
       {"stiff.values", "[3, 2]", "increasing"}},
      {12,
       good + "[[load]]\ntype = 'angular_drag'\ncoefficients = [1, 1, 1]\n[stiff]\nload = 1\n",
       {"stiff.load", "unknown key", "dial"}},
      // not TOML
      {2, "title = 'x'\nduration = \n", {"invalid TOML"}},
      {3, "title = 'x'\nduration = 1\nduration = 2\n", {"invalid TOML"}},
      {1, "title = 'x\n", {"invalid TOML"}},
      {2, "title = 'x'\nduration = 99999999999999999999\n", {"invalid TOML"}},
      {1, "title = '\xff\xfe'\n", {"invalid TOML", "UTF-8"}},
      {1, std::string("a\0b = 1\n", 8), {"invalid TOML"}},
      {1,
       "\x7f"
       "ELF",
       {"invalid TOML"}},
      {1, "a = " + std::string(5000, '['), {"invalid TOML"}},
      {1, "", {"duration", "got nothing"}},
  };
  return table;
}

TEST_F(SceneRefusal, NamesFileLineKeyWhatItGotAndWhatItNeeds) {
  EXPECT_GE(malformed().size(), 80u);
  for (const auto& m : malformed()) {
    SCOPED_TRACE(m.text.substr(0, 400));
    const std::string message = refusal(m.text);
    EXPECT_THAT(message, HasSubstr((folder_ / "scene.toml").string() + ":" + std::to_string(m.line) + ": "));
    EXPECT_THAT(message, HasSubstr("got "));
    EXPECT_THAT(message, HasSubstr("need "));
    for (const auto& fragment : m.fragments) EXPECT_THAT(message, HasSubstr(fragment));
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_LT(message.size(), 600u);
  }
}

TEST_F(SceneRefusal, WhatIsNotAFileOfReasonableSizeIsNotRead) {
  EXPECT_THAT(refusal_of(folder_ / "missing.toml"), HasSubstr("no such file"));
  EXPECT_THAT(refusal_of(folder_), HasSubstr("a folder"));
  EXPECT_THAT(refusal_of(write("duration = 1") / "below.toml"), HasSubstr("need a scene file"));
  const fs::path pipe = folder_ / "pipe.toml";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THAT(refusal_of(pipe), HasSubstr("not a regular file"));  // and does not wait for a writer
  EXPECT_THAT(refusal_of("/dev/zero"), HasSubstr("not a regular file"));
  const fs::path large = write("duration = 1\n", "large.toml");
  fs::resize_file(large, 100'000'000);
  EXPECT_THAT(refusal_of(large), HasSubstr("100000000 bytes"));
  fs::create_symlink(folder_ / "nowhere", folder_ / "dangling.toml");
  EXPECT_THAT(refusal_of(folder_ / "dangling.toml"), HasSubstr("no such file"));
}

}  // namespace
}  // namespace polhode
