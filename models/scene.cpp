// What a scene file means: mass properties resolved to principal axes, initial values and loads turned into
// them.
//
// A body given by three moments is in its principal frame already, and its doubles stay exactly as written.
// Otherwise the tensor is diagonalised, I = R diag(I1, I2, I3) R^T with R from principal to user components,
// and
//   q_SP = q_SU q_UP,   w_P = R^T w_U,   tau_P = R^T tau_U,   C_P = R^T diag(c) R   with q_UP =
//   principal_to_user.
#include "models/scene.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "models/errors.hpp"
#include "models/mass_properties.hpp"
#include "models/scene_reader.hpp"

namespace polhode {
namespace {

const std::vector<std::string> rotation_keys = {"angular_velocity", "angular_velocity_space",
                                                "angular_momentum"};
const std::string gravity = "gravity", linear_drag = "linear_drag", about_pivot = "gravity_about_pivot",
                  angular_drag = "angular_drag", attitude_spring = "attitude_spring",
                  constant_torque = "constant_torque", gravity_gradient = "gravity_gradient";

// The keys of each type of load, beside "type".
const std::map<std::string, std::vector<std::string>>& load_keys() {
  static const std::map<std::string, std::vector<std::string>> keys = {
      {gravity, {"acceleration"}},
      {linear_drag, {"coefficient"}},
      {about_pivot, {"acceleration", "center_of_mass"}},
      {angular_drag, {"coefficients"}},
      {attitude_spring, {"stiffness", "damping"}},
      {constant_torque, {"torque", "frame"}},
      {gravity_gradient, {"mean_motion"}},
  };
  return keys;
}

std::vector<std::string> operator+(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Vec3 vec3_or_zero(const SceneTable& table, const std::string& key) {
  return table.has(key) ? table.vec3(key) : Vec3::Zero();
}

// What [body] says, in the user's axes.
struct Body {
  std::string form;  // the key that gives the inertia: inertia, shape, part, particle; "" for a mass point
  std::optional<double> mass;
  Vec3 center = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();  // about the centre of mass, or as given: then about a pivot, if there is one
  bool physical = true;
};

// A shape with its lengths and its mass or density: [body] itself or one [[body.part]].
MassProperties read_primitive(const SceneTable& table, const std::vector<std::string>& beside) {
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
  const double mass = by == "mass" ? given : given * primitive_volume(shape, lengths);
  if (!std::isnormal(mass)) table.fail(by, "a mass within the range of double precision");
  return primitive(shape, lengths, mass);
}

MassProperties read_part(const SceneTable& part) {
  const MassProperties own = read_primitive(part, {"position", "orientation"});
  const Quaternion q = part.has("orientation") ? part.quaternion("orientation") : Quaternion(1, 0, 0, 0);
  return placed(own, normalised<double>(q), vec3_or_zero(part, "position"));
}

Mat3 read_tensor(const SceneTable& table) {
  const auto v = table.numbers("inertia", {3, 6}, Sign::any);
  Mat3 I = Vec3(v[0], v[1], v[2]).asDiagonal();
  if (v.size() == 6) I << v[0], v[3], v[4], v[3], v[1], v[5], v[4], v[5], v[2];
  return I;
}

Body read_body(const SceneTable& table) {
  Body body;
  body.form = table.one_of({"inertia", "shape", "part", "particle"});
  if (table.has("physical")) body.physical = table.flag("physical");
  if (body.form.empty() || body.form == "inertia") {
    table.allow({"mass", "inertia", "shape", "part", "particle", "physical"});
    if (table.has("mass")) body.mass = table.number("mass", Sign::positive);
    if (!body.form.empty()) {
      body.inertia = read_tensor(table);
    } else {
      if (!body.mass)
        table.fail("mass",
                   "a mass (then it is a particle), or inertia, shape, [[body.part]], [[body.particle]]");
      if (table.has("physical")) table.fail("physical", "no such key: a particle has no inertia to check");
    }
    return body;
  }
  MassProperties whole;
  if (body.form == "shape") {
    whole = read_primitive(table, {"physical"});
  } else if (body.form == "part") {
    table.allow({"part", "physical"});  // each part has a mass of its own
    std::vector<MassProperties> parts;
    for (const auto& part : table.tables("part")) parts.push_back(read_part(part));
    whole = joined(parts);
  } else {
    table.allow({"particle", "physical"});
    std::vector<PointMass> particles;
    for (const auto& particle : table.tables("particle")) {
      particle.allow({"mass", "position"});
      const double mass = particle.number("mass", Sign::positive);
      particles.push_back({mass, particle.vec3("position")});
    }
    whole = mass_properties(particles);
  }
  body.mass = whole.mass;
  body.center = whole.center;
  body.inertia = whole.inertia;
  return body;
}

// Reads one scene; a class, because the tables of a file refer to one another.
class Resolver {
 public:
  Resolver(const SceneTable& top, Scene& scene) : top_(top), scene_(scene) {}

  void resolve() {
    top_.allow({"title", "source", "duration", "attitude", "body", "initial", "load", "stiff"});
    scene_.title = top_.has("title") ? top_.text("title") : scene_.id;
    if (top_.has("source")) scene_.source = top_.text("source");
    scene_.duration = top_.number("duration", Sign::positive);
    if (top_.has("attitude")) attitude_ = top_.flag("attitude");

    const SceneTable body = top_.table("body");
    body_ = read_body(body);
    if (top_.has("load")) loads_ = top_.tables("load");
    check_loads();
    const SceneTable initial = top_.table_or_empty("initial");
    initial.allow(std::vector<std::string>{"position", "velocity", "orientation"} + rotation_keys);
    if (top_.has("stiff")) read_dial(top_.table("stiff"));
    if (body_.form.empty())
      refuse_rotation(initial);
    else
      resolve_rotation(body, initial);
    resolve_translation(body, initial);
    describe();
  }

 private:
  // Types and keys, and which loads go together.
  void check_loads() {
    std::vector<std::string> all;
    for (const auto& [type, keys] : load_keys()) all.push_back(type);
    for (const auto& load : loads_) {
      types_.push_back(load.choice("type", all));
      load.allow(std::vector<std::string>{"type"} + load_keys().at(types_.back()));
      held_ = held_ || types_.back() == about_pivot;
    }
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      const bool force = types_[i] == gravity || types_[i] == linear_drag;
      if (held_ && force)
        loads_[i].fail("type",
                       "no force on the centre of mass beside gravity_about_pivot, which holds the body");
      if (body_.form.empty() && !force)
        loads_[i].fail("type", "gravity or linear_drag: [body] has only a mass, a particle does not rotate");
      pushed_ = pushed_ || force;
    }
  }

  void refuse_rotation(const SceneTable& initial) const {
    for (const auto& key : std::vector<std::string>{"orientation"} + rotation_keys)
      if (initial.has(key))
        initial.fail(key, "no such key: [body] has only a mass, a particle does not rotate");
    if (top_.has("attitude"))
      top_.fail("attitude", "no such key: [body] has only a mass, a particle has none");
  }

  double required_mass(const SceneTable& body, const std::string& why) const {
    if (!body_.mass) body.fail("mass", "a number > 0, the mass in kg: " + why);
    return *body_.mass;
  }

  // From the pivot to the centre of mass, in user axes. All loads about the pivot speak of the same body.
  Vec3 center_from_pivot() const {
    std::optional<Vec3> center;
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      if (types_[i] != about_pivot) continue;
      const bool compound = body_.form == "part" || body_.form == "particle";
      const bool origin_is_pivot = compound && !loads_[i].has("center_of_mass");
      const Vec3 here = origin_is_pivot ? body_.center : loads_[i].vec3("center_of_mass");
      if (center && *center != here) loads_[i].fail("center_of_mass", "the same as in the loads before it");
      center = here;
    }
    return center.value_or(Vec3::Zero());
  }

  void resolve_rotation(const SceneTable& body, const SceneTable& initial) {
    Mat3 inertia = body_.inertia;
    Vec3 center = Vec3::Zero();
    if (held_) {
      const double mass = required_mass(body, "gravity pulls at the body");
      center = center_from_pivot();
      const MassProperties own{mass, center, body_.inertia};
      if (body_.form != "inertia")
        inertia = inertia_about(own, center);
      else
        note_impossible_center(own);
    }
    const PrincipalAxes axes = principal_axes(inertia);
    if (const std::string fault = inertia_fault(axes.moments, body_.physical); !fault.empty())
      body.fail(body_.form, fault,
                body_.physical ? "a body that can exist (or physical = false, if it is meant as mathematics)"
                               : "three positive moments");

    RotationData& r = scene_.rotation.emplace();
    r.moments = axes.moments;
    r.principal_to_user = axes.principal_to_given;
    r.attitude = attitude_;
    r.about_pivot = held_;
    const Quaternion q_SU =
        initial.has("orientation") ? initial.quaternion("orientation") : Quaternion(1, 0, 0, 0);
    r.q0 = q_SU * r.principal_to_user;
    r.w0 = initial_rates(initial, normalised<double>(r.q0));
    for (std::size_t i = 0; i < loads_.size(); ++i) add_load(i, center);
  }

  // An inertia about the pivot smaller than what the mass alone has there. The motion is that of the numbers
  // as given, so it is said and not refused.
  void note_impossible_center(const MassProperties& about_pivot_given) {
    const Vec3& d = about_pivot_given.center;
    const Mat3 steiner = inertia_about({about_pivot_given.mass, d, Mat3::Zero()}, d);
    const Vec3 own = principal_axes(about_pivot_given.inertia - steiner).moments;
    const double slack = 1e-6 * about_pivot_given.inertia.diagonal().maxCoeff();  // as in inertia_fault
    for (int i = 0; i < 3 && body_.physical; ++i)
      if (own[i] < -slack || own[(i + 1) % 3] + own[(i + 2) % 3] < own[i] - slack) {
        scene_.notes.push_back(
            "no real body has this inertia about its pivot: about the centre of mass it would be " +
            number_text(own[0]) + ", " + number_text(own[1]) + ", " + number_text(own[2]));
        return;
      }
  }

  // w0 in principal components.
  Vec3 initial_rates(const SceneTable& initial, const Quaternion& q_SP) const {
    const RotationData& r = *scene_.rotation;
    const std::string key = initial.one_of(rotation_keys);
    if (key.empty())
      initial.fail("angular_velocity",
                   "one of " + name_list(rotation_keys) + " ([0, 0, 0] for a body at rest)");
    const Vec3 given = initial.vec3(key);
    Vec3 w = key == "angular_velocity" ? to_principal(given) : to_body<double>(q_SP, given);
    if (key == "angular_momentum") w = w.cwiseQuotient(r.moments);
    if (!w.allFinite() || !std::isfinite(w.squaredNorm()))
      initial.fail(key, "a rate that can be computed with");
    return w;
  }

  Vec3 to_principal(const Vec3& a_user) const {
    return to_body<double>(scene_.rotation->principal_to_user, a_user);
  }

  void add_load(std::size_t i, const Vec3& center) {
    const SceneTable& load = loads_[i];
    const std::string& type = types_[i];
    RotationData& r = *scene_.rotation;
    std::optional<AnyTorque<double>> torque;
    bool zero = false, needs_attitude = true;
    if (type == about_pivot) {
      const Vec3 g = load.vec3("acceleration");
      torque = GravityAboutPivot<double>{*body_.mass, g, to_principal(center)};
      zero = g.isZero(0) || center.isZero(0);
    } else if (type == angular_drag) {
      const Vec3 c = load.vec3("coefficients", Sign::not_negative);
      torque = AngularDrag<double>{in_principal_axes(c, r)};
      zero = c.isZero(0);
      needs_attitude = false;
    } else if (type == attitude_spring) {
      const double k = load.number("stiffness", Sign::not_negative),
                   c = load.number("damping", Sign::not_negative);
      torque = AttitudeSpring<double>{k, c, r.principal_to_user};
      zero = k == 0 && c == 0;
    } else if (type == constant_torque) {
      const Vec3 tau = load.vec3("torque");
      needs_attitude = load.choice("frame", {"body", "space"}) == "space";
      if (needs_attitude)
        torque = ConstantTorque<double, Frame::space>{tau};
      else
        torque = ConstantTorque<double, Frame::body>{to_principal(tau)};
      zero = tau.isZero(0);
    } else if (type == gravity_gradient) {
      torque = GravityGradient<double>{load.number("mean_motion", Sign::positive), r.moments};
    }
    if (!torque) return;  // a force on the centre of mass
    if (needs_attitude && !attitude_)
      load.fail("type",
                "a load that does not depend on the attitude, because of attitude = false at the top");
    if (zero) {
      scene_.left_out.push_back("no load " + std::to_string(i + 1) + ": it is zero");
      return;
    }
    r.loads.push_back(*torque);
  }

  static Mat3 in_principal_axes(const Vec3& c_user, const RotationData& r) {
    const Mat3 R = rotation_matrix<double>(r.principal_to_user);
    return R.transpose() * c_user.asDiagonal() * R;
  }

  // Whether its places are numbers is asked when it is turned.
  void read_dial(const SceneTable& table) {
    table.allow({"dial", "values", "also"});
    Dial dial;
    dial.place = table.text("dial");
    dial.values = table.numbers("values", {}, Sign::positive);
    const auto& v = dial.values;
    if (v.empty() || std::adjacent_find(v.begin(), v.end(), std::greater_equal<>()) != v.end())
      table.fail("values", "increasing numbers > 0");
    if (table.has("also"))
      for (const SceneTable& follower : table.tables("also")) {
        follower.allow({"dial", "power"});
        dial.followers.push_back({follower.text("dial"), follower.number("power", Sign::any)});
      }
    scene_.dial = dial;
  }

  void resolve_translation(const SceneTable& body, const SceneTable& initial) {
    for (const char* key : {"position", "velocity"})
      if (held_ && initial.has(key)) initial.fail(key, "no such key: gravity_about_pivot holds the body");
    const Vec3 p0 = vec3_or_zero(initial, "position"), v0 = vec3_or_zero(initial, "velocity");
    TranslationData t;
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      if (types_[i] == gravity) t.acceleration += loads_[i].vec3("acceleration");
      if (types_[i] == linear_drag) t.drag += loads_[i].number("coefficient", Sign::not_negative);
    }
    const bool moves = pushed_ || !v0.isZero(0);
    if (body_.form.empty() && !moves)
      initial.fail("velocity", "a velocity, or a [[load]] that pushes: the particle never moves");
    if (!moves || (scene_.rotation && !attitude_)) return;
    if (!t.acceleration.allFinite() || !std::isfinite(t.drag))
      top_.fail("load", "loads that can be added up");
    t.mass = required_mass(body, "the centre of mass moves");
    t.p0 = p0;
    t.v0 = v0;
    t.has_force = !t.acceleration.isZero(0) || t.drag > 0;
    scene_.translation = t;
  }

  void describe() {
    auto& out = scene_.left_out;
    const bool rates_only = scene_.rotation && !attitude_;
    if (!scene_.rotation) out.push_back("no rotation: a particle");
    if (rates_only) out.push_back("no attitude: only the rates are asked for");
    if (!scene_.translation)
      out.push_back(rates_only ? "no translation: only the rates are asked for"
                    : held_    ? "no translation: the body is held at its pivot"
                               : "no translation: nothing moves or pushes the centre of mass");
    else if (!scene_.translation->has_force)
      out.push_back("no force: the centre of mass moves on a straight line");
    if (scene_.rotation) {
      const Vec3& I = scene_.rotation->moments;
      if (I.x() == I.y() && I.y() == I.z() && !rates_only)
        out.push_back("no gyroscopic term: all moments are equal");
      if (scene_.rotation->loads.empty()) out.push_back("no load evaluation: free motion");
      scene_.unknowns += attitude_ ? 7 : 3;
    }
    if (scene_.translation) scene_.unknowns += 6;
  }

  const SceneTable& top_;
  Scene& scene_;
  Body body_;
  bool attitude_ = true, held_ = false, pushed_ = false;
  std::vector<SceneTable> loads_;
  std::vector<std::string> types_;
};

}  // namespace

namespace {

Scene resolved(const toml::table& document, const std::filesystem::path& file) {
  Scene scene;
  scene.file = file;
  scene.id = file.stem().string();
  Resolver(SceneTable(document, file.string(), "", 1), scene).resolve();
  if (scene.dial) {  // a place that is not there is found now, not when a study turns to it
    toml::table copy = document;
    const auto line = std::to_string((*document["stiff"].as_table()->get("dial")).source().begin.line);
    turn_dial(copy, file.string() + ":" + line, *scene.dial, scene.dial->values.front());
  }
  return scene;
}

}  // namespace

Scene read_scene(const std::filesystem::path& file) { return resolved(parse_scene_file(file), file); }

Scene Scene::with_dial(double value) const {
  if (!dial) throw InputError(file.string() + ": stiff: got nothing, need a table [stiff]");
  toml::table document = parse_scene_file(file);
  const double as_read = resolved(document, file).duration;
  turn_dial(document, file.string(), *dial, value);
  Scene turned = resolved(document, file);
  turned.duration *= duration / as_read;  // of a scene whose duration was changed, too
  turned.dial = dial;
  turned.variant = dial->place + " = " + number_text(value);
  return turned;
}

Scene find_scene(const std::string& id_or_path) {
  if (id_or_path.find('/') != std::string::npos || id_or_path.ends_with(".toml"))
    return read_scene(id_or_path);
  const auto ids = builtin_scene_ids();
  if (std::find(ids.begin(), ids.end(), id_or_path) == ids.end()) {
    const std::string near = nearest_name(id_or_path, ids);
    throw UsageError("scene: got \"" + id_or_path + "\", need a built-in scene" +
                     (near.empty() ? "" : " (perhaps \"" + near + "\")") +
                     " or a path to a TOML file; the built-in ones are " + name_list(ids));
  }
  return read_scene(data_folder("scenes") / (id_or_path + ".toml"));
}

std::vector<std::string> builtin_scene_ids() {
  std::vector<std::string> ids;
  for (const auto& entry : std::filesystem::directory_iterator(data_folder("scenes")))
    if (entry.path().extension() == ".toml") ids.push_back(entry.path().stem().string());
  std::sort(ids.begin(), ids.end());
  return ids;
}

std::filesystem::path data_folder(const std::string& name) {
  std::error_code error;
  const auto binary = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto folder = (binary.parent_path() / ".." / "share" / "polhode" / name).lexically_normal();
  if (error || !std::filesystem::is_directory(folder, error))
    throw MissingError("data folder: got nothing at " + folder.string() + ", need it as it was installed");
  return folder;
}

std::string nearest_name(const std::string& name, const std::vector<std::string>& valid) {
  // Levenshtein distance, a swap of neighbours counting once; '-' and '_' and the case of letters are the
  // same.
  const auto plain = [](std::string s) {
    for (char& c : s) c = c == '-' ? '_' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return s;
  };
  const std::string a = plain(name.substr(0, 100));
  std::size_t best = a.size() / 3 + 2;  // farther than this is another word
  std::string nearest;
  for (const auto& candidate : valid) {
    const std::string b = plain(candidate);
    std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
      row[0] = i;
      for (std::size_t j = 1; j <= b.size(); ++j) {
        row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
        if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
          row[j] = std::min(row[j], before[j - 2] + 1);
      }
      before = std::exchange(last, row);
    }
    if (last[b.size()] < best && last[b.size()] < std::max(a.size(), b.size())) {
      best = last[b.size()];
      nearest = candidate;
    }
  }
  return nearest;
}

}  // namespace polhode
