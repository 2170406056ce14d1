// What a scene file means: mass properties resolved to principal axes, initial values and loads turned into
// them.
//
// A body given by three moments is in its principal frame already, and its doubles stay exactly as written.
// Otherwise the tensor is diagonalised, I = R diag(I1, I2, I3) R^T with R from principal to user components,
// and
//   q_SP = q_SU q_UP,   w_P = R^T w_U,   tau_P = R^T tau_U,   C_P = R^T diag(c) R   with q_UP =
//   principal_to_user.
// All of that in 200 digits, rounded to the 50 of the truth and then to the doubles of the solvers.
#include "models/scene.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "models/errors.hpp"
#include "models/exact_scene.hpp"
#include "models/scene_body.hpp"

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

using WideVec = Vec3T<Resolved>;

/// After a turn to axes that are no doubles: what 200 digits leave of a component that is zero.
template <class V>
void drop_rounding(V&& v) {
  const Resolved floor = Resolved(1e-150) * v.cwiseAbs().maxCoeff();
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (abs(v(i)) <= floor) v(i) = Resolved(0);
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
    scene_.exact = exact_;
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

  Resolved required_mass(const SceneTable& body, const std::string& why) const {
    if (!body_.mass) body.fail("mass", "a number > 0, the mass in kg: " + why);
    return *body_.mass;
  }

  // From the pivot to the centre of mass, in user axes. All loads about the pivot speak of the same body.
  WideVec center_from_pivot() const {
    std::optional<WideVec> center;
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      if (types_[i] != about_pivot) continue;
      const bool compound = body_.form == "part" || body_.form == "particle";
      const bool origin_is_pivot = compound && !loads_[i].has("center_of_mass");
      const WideVec here =
          origin_is_pivot ? body_.center : WideVec(loads_[i].vec3("center_of_mass").cast<Resolved>());
      if (center && *center != here) loads_[i].fail("center_of_mass", "the same as in the loads before it");
      center = here;
    }
    return center.value_or(WideVec::Zero());
  }

  void resolve_rotation(const SceneTable& body, const SceneTable& initial) {
    Mat3T<Resolved> inertia = body_.inertia;
    if (held_) {
      const Resolved mass = required_mass(body, "gravity pulls at the body");
      center_ = center_from_pivot();
      const MassPropertiesT<Resolved> own{mass, center_, body_.inertia};
      if (body_.form != "inertia")
        inertia = inertia_about(own, center_);
      else
        note_impossible_center(own);
    }
    const PrincipalAxesT<Resolved> axes = principal_axes<Resolved>(inertia);
    if (const InertiaFault fault = inertia_fault<Resolved>(axes.moments, body_.physical)) {
      std::string need = "three positive moments";
      if (fault.only_unphysical)
        need = "a body that can exist (or physical = false, if it is meant as mathematics)";
      else if (body_.form != "inertia")
        need = "a body with mass off every line";
      else if (!inertia.isDiagonal(Resolved(0)))
        need += " (six numbers are xx, yy, zz, xy, xz, yz, in this order)";
      body.fail(body_.form, fault.text, need);
    }

    RotationDataT<Resolved>& r = rotation_.emplace();
    r.moments = axes.moments;
    r.principal_to_user = axes.principal_to_given;
    turned_ = !r.principal_to_user.vec().isZero(0);
    if (turned_) drop_rounding(r.principal_to_user.coeffs());
    r.attitude = attitude_;
    r.about_pivot = held_;
    StatedRotation& s = exact_->stated.emplace();
    s.inertia_U = inertia;
    s.inverse_inertia_U = inertia.inverse();
    s.principal_to_stated = r.principal_to_user.cast<Wide>();
    const Quaternion q_SU =
        initial.has("orientation") ? initial.quaternion("orientation") : Quaternion(1, 0, 0, 0);
    s.q_SU = q_SU.cast<Wide>();
    r.q0 = q_SU.cast<Resolved>() * r.principal_to_user;
    if (turned_) drop_rounding(r.q0.coeffs());
    resolve_rates(initial);
    for (std::size_t i = 0; i < loads_.size(); ++i) add_load(i);
    exact_->rotation = cast_rotation<Wide>(r);
    scene_.rotation = cast_rotation<double>(*exact_->rotation);
    const Vec3& w = scene_.rotation->w0;
    if (!w.allFinite() || !std::isfinite(w.squaredNorm()))
      initial.fail(initial.one_of(rotation_keys), "a rate that can be computed with");
  }

  // An inertia about the pivot smaller than what the mass alone has there. The motion is that of the numbers
  // as given, so it is said and not refused.
  void note_impossible_center(const MassPropertiesT<Resolved>& about_pivot_given) {
    const WideVec& d = about_pivot_given.center;
    const MassPropertiesT<Resolved> point{about_pivot_given.mass, d, Mat3T<Resolved>::Zero()};
    const Mat3T<Resolved> rest = about_pivot_given.inertia - inertia_about(point, d);
    const Vec3 own = principal_axes<Resolved>(rest).moments.cast<double>();
    // As in inertia_fault.
    const double slack = 1e-6 * about_pivot_given.inertia.diagonal().maxCoeff().convert_to<double>();
    for (int i = 0; i < 3 && body_.physical; ++i)
      if (own[i] < -slack || own[(i + 1) % 3] + own[(i + 2) % 3] < own[i] - slack) {
        scene_.notes.push_back(
            "no real body has this inertia about its pivot: about the centre of mass it would be " +
            number_text(own[0]) + ", " + number_text(own[1]) + ", " + number_text(own[2]));
        return;
      }
  }

  // w0 in principal components.
  void resolve_rates(const SceneTable& initial) {
    RotationDataT<Resolved>& r = *rotation_;
    const std::string key = initial.one_of(rotation_keys);
    if (key.empty())
      initial.fail("angular_velocity",
                   "one of " + name_list(rotation_keys) + " ([0, 0, 0] for a body at rest)");
    const Vec3 given = initial.vec3(key);
    exact_->stated->given = given.cast<Wide>();
    if (key == "angular_velocity") {
      exact_->stated->form = StatedRates::body;
      r.w0 = to_principal(given.cast<Resolved>());
    } else {
      // With q as it is: of doubles, 200 digits hold each product.
      r.w0 = to_body<Resolved>(r.q0, given.cast<Resolved>());
      if (turned_) drop_rounding(r.w0);
      exact_->stated->form = StatedRates::space;
      if (key == "angular_momentum") {
        exact_->stated->form = StatedRates::momentum;
        r.w0 = r.w0.cwiseQuotient(r.moments).eval();
      }
    }
  }

  WideVec to_principal(const WideVec& a_user) const {
    if (!turned_) return a_user;
    WideVec a = to_body<Resolved>(rotation_->principal_to_user, a_user);
    drop_rounding(a);
    return a;
  }

  void add_load(std::size_t i) {
    const SceneTable& load = loads_[i];
    const std::string& type = types_[i];
    RotationDataT<Resolved>& r = *rotation_;
    std::optional<AnyTorque<Resolved>> torque;
    StatedLoad stated;
    using Kind = StatedLoad::Kind;
    bool zero = false, needs_attitude = true;
    if (type == about_pivot) {
      const Vec3 g = load.vec3("acceleration");
      torque = GravityAboutPivot<Resolved>{*body_.mass, g.cast<Resolved>(), to_principal(center_)};
      stated.kind = Kind::gravity_about_pivot;
      stated.vector = g.cast<Wide>();
      stated.center = center_.cast<Wide>();
      stated.number = Wide(*body_.mass);
      zero = g.isZero(0) || center_.isZero(0);
    } else if (type == angular_drag) {
      const Vec3 c = load.vec3("coefficients", Sign::not_negative);
      torque = AngularDrag<Resolved>{in_principal_axes(c)};
      stated.kind = Kind::drag;
      stated.matrix = c.cast<Wide>().asDiagonal();
      zero = c.isZero(0);
      needs_attitude = false;
    } else if (type == attitude_spring) {
      const double k = load.number("stiffness", Sign::not_negative),
                   c = load.number("damping", Sign::not_negative);
      torque = AttitudeSpring<Resolved>{k, c, r.principal_to_user};
      stated.kind = Kind::spring;
      stated.number = k;
      stated.damping = c;
      zero = k == 0 && c == 0;
    } else if (type == constant_torque) {
      const Vec3 tau = load.vec3("torque");
      needs_attitude = load.choice("frame", {"body", "space"}) == "space";
      stated.kind = needs_attitude ? Kind::space_torque : Kind::body_torque;
      stated.vector = tau.cast<Wide>();
      if (needs_attitude)
        torque = ConstantTorque<Resolved, Frame::space>{tau.cast<Resolved>()};
      else
        torque = ConstantTorque<Resolved, Frame::body>{to_principal(tau.cast<Resolved>())};
      zero = tau.isZero(0);
    } else if (type == gravity_gradient) {
      const double n = load.number("mean_motion", Sign::positive);
      torque = GravityGradient<Resolved>{n, r.moments};
      stated.kind = Kind::gravity_gradient;
      stated.number = n;
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
    exact_->stated->loads.push_back(stated);
  }

  Mat3T<Resolved> in_principal_axes(const Vec3& c_user) const {
    const Mat3T<Resolved> C = c_user.cast<Resolved>().asDiagonal();
    if (!turned_) return C;
    const Mat3T<Resolved> R = rotation_matrix<Resolved>(rotation_->principal_to_user);
    Mat3T<Resolved> turned = R.transpose() * C * R;
    drop_rounding(turned);
    return turned;
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
    TranslationDataT<Resolved> t;
    for (std::size_t i = 0; i < loads_.size(); ++i) {
      if (types_[i] == gravity) t.acceleration += loads_[i].vec3("acceleration").cast<Resolved>();
      if (types_[i] == linear_drag) t.drag += loads_[i].number("coefficient", Sign::not_negative);
    }
    const bool moves = pushed_ || !v0.isZero(0);
    if (body_.form.empty() && !moves)
      initial.fail("velocity", "a velocity, or a [[load]] that pushes: the particle never moves");
    if (!moves || (scene_.rotation && !attitude_)) return;
    t.mass = required_mass(body, "the centre of mass moves");
    t.p0 = p0.cast<Resolved>();
    t.v0 = v0.cast<Resolved>();
    t.has_force = !t.acceleration.isZero(0) || t.drag > 0;
    exact_->translation = cast_translation<Wide>(t);
    scene_.translation = cast_translation<double>(*exact_->translation);
    if (!scene_.translation->acceleration.allFinite() || !std::isfinite(scene_.translation->drag))
      top_.fail("load", "loads that can be added up");
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
  std::shared_ptr<ExactScene> exact_ = std::make_shared<ExactScene>();
  std::optional<RotationDataT<Resolved>> rotation_;
  WideVec center_ = WideVec::Zero();  // of mass, from the pivot, in user axes
  Body body_;
  bool attitude_ = true, held_ = false, pushed_ = false, turned_ = false;
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

bool depends_on_time(const Scene& scene) {
  if (!scene.rotation) return false;
  const auto& loads = scene.rotation->loads;
  return std::any_of(loads.begin(), loads.end(),
                     [](const auto& load) { return std::holds_alternative<GravityGradient<double>>(load); });
}

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
