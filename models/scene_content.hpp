// What a scene says, without its names: two scenes of one content have one truth.
#pragma once
#include <string>

#include "models/scene.hpp"

namespace polhode {

/// Every number that the motion depends on, digit by digit, as text. Not id, file, title, duration or dial.
std::string content_of(const Scene& scene);

}  // namespace polhode
