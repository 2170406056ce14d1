// The reference cases of tests/reference: a JSON case as a scene, as a scene file, and the numbers beside it.
//
// Every number there is a decimal string of up to 40 digits. A scene takes the double nearest to each; the
// block `binary64_inputs` of a case is the solution of exactly that problem.
#pragma once
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "models/scene.hpp"
#include "models/wide.hpp"

namespace polhode::reference_cases {

using Json = nlohmann::json;

/// The double nearest to a decimal string; the whole of it must be a number.
inline double nearest_double(const std::string& text) {
  double x = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (error != std::errc() || end != text.data() + text.size())
    throw std::invalid_argument("not a number: '" + text + "'");
  return x;
}
inline double number(const Json& j) { return nearest_double(j.get<std::string>()); }
inline Vec3 vector(const Json& j) { return {number(j.at(0)), number(j.at(1)), number(j.at(2))}; }
inline Quaternion quaternion(const Json& j) {
  return {number(j.at(0)), number(j.at(1)), number(j.at(2)), number(j.at(3))};
}
inline Mat3 matrix(const Json& j) {
  Mat3 m;
  for (int i = 0; i < 3; ++i) m.row(i) = vector(j.at(static_cast<std::size_t>(i)));
  return m;
}
inline Wide wide_number(const Json& j) { return Wide(j.get<std::string>()); }
inline Vec3T<Wide> wide_vector(const Json& j) {
  return {wide_number(j.at(0)), wide_number(j.at(1)), wide_number(j.at(2))};
}
inline QuaternionT<Wide> wide_quaternion(const Json& j) {
  return {wide_number(j.at(0)), wide_number(j.at(1)), wide_number(j.at(2)), wide_number(j.at(3))};
}
inline std::vector<double> numbers(const Json& j) {
  std::vector<double> all;
  for (const auto& x : j) all.push_back(number(x));
  return all;
}

inline Json read_json(const std::string& name) {
  const std::string path = std::string(POLHODE_TESTS "/reference/") + name + ".json";
  std::ifstream file(path);
  if (!file) throw std::runtime_error("cannot read " + path);
  return Json::parse(file);
}

/// Names of the cases, sorted: every file of the folder but the fingerprints of one-step methods.
inline std::vector<std::string> case_names() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(POLHODE_TESTS "/reference"))
    if (entry.path().extension() == ".json" && !entry.path().stem().string().starts_with("fingerprints"))
      names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Does the case integrate a translation of its own? (A pivot's and an orbit's p, v follow from elsewhere.)
inline bool moves(const Json& inputs) {
  return inputs.contains("force") &&
         (inputs.at("force").at("model") != "none" || vector(inputs.at("v0")).norm() > 0);
}

/// The scene of a block `inputs`, without passing through a file.
inline Scene scene_of(const Json& inputs, const std::string& id, double duration) {
  Scene scene;
  scene.id = id;
  scene.duration = duration;
  RotationData r;
  r.moments = vector(inputs.at("inertia_body"));
  r.q0 = quaternion(inputs.at("q0"));
  r.w0 = vector(inputs.at("omega_body0"));
  const Json& torque = inputs.at("torque");
  const std::string model = torque.at("model");
  if (model == "linear_drag_body") {
    r.loads.push_back(AngularDrag<double>{vector(torque.at("c")).asDiagonal()});
  } else if (model == "pd_to_identity") {
    r.loads.push_back(AttitudeSpring<double>{number(torque.at("k")), number(torque.at("c"))});
  } else if (model == "constant_body") {
    r.loads.push_back(ConstantTorque<double, Frame::body>{vector(torque.at("tau"))});
  } else if (model == "constant_world") {
    r.loads.push_back(ConstantTorque<double, Frame::space>{vector(torque.at("tau"))});
  } else if (model == "heavy_top_pivot") {
    r.about_pivot = true;
    r.loads.push_back(GravityAboutPivot<double>{number(inputs.at("mass")), vector(torque.at("gravity_world")),
                                                vector(torque.at("r_com_body"))});
  } else if (model == "gravity_gradient") {
    r.loads.push_back(GravityGradient<double>{number(torque.at("n")), r.moments});
  } else if (model != "none") {
    throw std::invalid_argument("unknown torque model '" + model + "'");
  }
  scene.rotation = r;
  if (moves(inputs)) {
    TranslationData t;
    t.mass = number(inputs.at("mass"));
    t.p0 = vector(inputs.at("p0"));
    t.v0 = vector(inputs.at("v0"));
    const Json& force = inputs.at("force");
    t.has_force = force.at("model") != "none";
    if (force.contains("gravity_world")) t.acceleration = vector(force.at("gravity_world"));
    if (force.contains("b")) t.drag = number(force.at("b"));
    scene.translation = t;
  }
  return scene;
}

/// The same as the text of a scene file, its numbers digit by digit as they stand in the case.
inline std::string toml_of(const Json& inputs, const std::string& duration) {
  const auto list = [](const Json& j) {
    std::string text = "[";
    for (const auto& x : j) text += (text.size() > 1 ? ", " : "") + x.get<std::string>();
    return text + "]";
  };
  std::string text = "title = \"reference case\"\nduration = " + duration + "\n\n[body]\n";
  text += "mass = " + inputs.at("mass").get<std::string>() + "\n";
  text += "inertia = " + list(inputs.at("inertia_body")) + "\n";
  // One case of the set (two thirds beside 1 and 2) is meant as mathematics.
  const Vec3 moments = vector(inputs.at("inertia_body"));
  if (2 * moments.maxCoeff() > moments.sum()) text += "physical = false\n";
  text += "\n[initial]\n";
  text += "orientation = " + list(inputs.at("q0")) + "\n";
  text += "angular_velocity = " + list(inputs.at("omega_body0")) + "\n";
  if (moves(inputs))
    text += "position = " + list(inputs.at("p0")) + "\nvelocity = " + list(inputs.at("v0")) + "\n";
  const auto load = [&text](const std::string& type) { text += "\n[[load]]\ntype = \"" + type + "\"\n"; };
  const auto key = [&](const std::string& name, const Json& value) {
    text += name + " = " + (value.is_array() ? list(value) : value.get<std::string>()) + "\n";
  };
  const Json& torque = inputs.at("torque");
  const std::string model = torque.at("model");
  if (model == "linear_drag_body") {
    load("angular_drag");
    key("coefficients", torque.at("c"));
  } else if (model == "pd_to_identity") {
    load("attitude_spring");
    key("stiffness", torque.at("k"));
    key("damping", torque.at("c"));
  } else if (model == "constant_body" || model == "constant_world") {
    load("constant_torque");
    key("torque", torque.at("tau"));
    text += model == "constant_body" ? "frame = \"body\"\n" : "frame = \"space\"\n";
  } else if (model == "heavy_top_pivot") {
    load("gravity_about_pivot");
    key("acceleration", torque.at("gravity_world"));
    key("center_of_mass", torque.at("r_com_body"));
  } else if (model == "gravity_gradient") {
    load("gravity_gradient");
    key("mean_motion", torque.at("n"));
  }
  const Json& force = inputs.at("force");
  if (force.contains("gravity_world")) {
    load("gravity");
    key("acceleration", force.at("gravity_world"));
  }
  if (force.contains("b")) {
    load("linear_drag");
    key("coefficient", force.at("b"));
  }
  return text;
}

/// The columns of a CSV text by name, as the text in the cells (no cell of ours has a quote or a comma).
inline std::map<std::string, std::vector<std::string>> columns_of(const std::string& csv) {
  std::map<std::string, std::vector<std::string>> columns;
  std::vector<std::string> names;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream cells(line);
    std::size_t i = 0;
    const bool head = names.empty();
    for (std::string cell; std::getline(cells, cell, ','); ++i)
      if (head)
        names.push_back(cell);
      else
        columns[names.at(i)].push_back(cell);
  }
  return columns;
}

}  // namespace polhode::reference_cases
