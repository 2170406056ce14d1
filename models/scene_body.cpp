#include "models/scene_body.hpp"

#include <cmath>

namespace polhode {
namespace {

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// A shape with its lengths and its mass or density: [body] itself or one [[body.part]].
MassPropertiesT<Resolved> read_primitive(const SceneTable& table, const std::vector<std::string>& beside) {
  const std::string shape = table.choice("shape", primitive_shapes());
  const auto needs = primitive_needs(shape);
  table.allow(std::vector<std::string>{"shape", "mass", "density"} + needs + beside);
  std::vector<double> lengths;
  for (const auto& key : needs) {
    const bool three = key == "size" || key == "inner_size" || key == "radii";
    const auto values = three ? table.numbers(key, {3}, Sign::positive)
                              : std::vector<double>{table.number(key, Sign::positive)};
    lengths.insert(lengths.end(), values.begin(), values.end());
  }
  const std::string by = table.one_of({"mass", "density"});
  if (by.empty()) table.fail("mass", "a mass (kg) or a density (kg/m^3, of shells and discs kg/m^2)");
  const double given = table.number(by, Sign::positive);
  const std::string fault = primitive_fault(shape, lengths);
  if (!fault.empty()) table.fail(needs.size() > 1 ? needs[1] : needs[0], fault, "lengths that leave a body");
  Resolved mass(given);
  if (by == "density") mass *= primitive_volume<Resolved>(shape, lengths);
  if (!std::isnormal(static_cast<double>(mass)))
    table.fail(by, "a mass within the range of double precision");
  return primitive<Resolved>(shape, lengths, mass);
}

MassPropertiesT<Resolved> read_part(const SceneTable& part) {
  const MassPropertiesT<Resolved> own = read_primitive(part, {"position", "orientation"});
  const Quaternion q = part.has("orientation") ? part.quaternion("orientation") : Quaternion(1, 0, 0, 0);
  return placed(own, normalised<Resolved>(q.cast<Resolved>()),
                vec3_or_zero(part, "position").cast<Resolved>());
}

Mat3 read_tensor(const SceneTable& table) {
  const auto v = table.numbers("inertia", {3, 6}, Sign::any);
  Mat3 I = Vec3(v[0], v[1], v[2]).asDiagonal();
  if (v.size() == 6) I << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  return I;
}

}  // namespace

Body read_body(const SceneTable& table) {
  Body body;
  body.form = table.one_of({"inertia", "shape", "part", "particle"});
  if (table.has("physical")) body.physical = table.flag("physical");
  if (body.form.empty() || body.form == "inertia") {
    table.allow({"mass", "inertia", "shape", "part", "particle", "physical"});
    if (table.has("mass")) body.mass = Resolved(table.number("mass", Sign::positive));
    if (!body.form.empty()) {
      body.inertia = read_tensor(table).cast<Resolved>();
    } else {
      if (!body.mass)
        table.fail("mass",
                   "a mass (then it is a particle), or inertia, shape, [[body.part]], [[body.particle]]");
      if (table.has("physical")) table.fail("physical", "no such key: a particle has no inertia to check");
    }
    return body;
  }
  MassPropertiesT<Resolved> whole;
  if (body.form == "shape") {
    whole = read_primitive(table, {"physical"});
  } else if (body.form == "part") {
    table.allow({"part", "physical"});  // each part has a mass of its own
    std::vector<MassPropertiesT<Resolved>> parts;
    for (const auto& part : table.tables("part")) parts.push_back(read_part(part));
    whole = joined<Resolved>(parts);
  } else {
    table.allow({"particle", "physical"});
    std::vector<PointMass> particles;
    for (const auto& particle : table.tables("particle")) {
      particle.allow({"mass", "position"});
      const double mass = particle.number("mass", Sign::positive);
      particles.push_back({mass, particle.vec3("position")});
    }
    whole = mass_properties<Resolved>(particles);
  }
  body.mass = whole.mass;
  body.center = whole.center;
  body.inertia = whole.inertia;
  return body;
}

Vec3 vec3_or_zero(const SceneTable& table, const std::string& key) {
  return table.has(key) ? table.vec3(key) : Vec3::Zero();
}

}  // namespace polhode
