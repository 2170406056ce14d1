// What [body] of a scene file says, in the user's axes, in wide arithmetic: the numbers of the file are exact
// until everything that follows from them is known.
#pragma once
#include <optional>
#include <string>

#include "models/mass_properties.hpp"
#include "models/scene_reader.hpp"
#include "models/wide.hpp"

namespace polhode {

struct Body {
  std::string form;  // the key that gives the inertia: inertia, shape, part, particle; "" for a mass point
  std::optional<Resolved> mass;
  Vec3T<Resolved> center = Vec3T<Resolved>::Zero();
  // About the centre of mass, or as given: then about a pivot, if there is one.
  Mat3T<Resolved> inertia = Mat3T<Resolved>::Zero();
  bool physical = true;
};

Body read_body(const SceneTable& table);

/// A vector that may be absent.
Vec3 vec3_or_zero(const SceneTable& table, const std::string& key);

}  // namespace polhode
