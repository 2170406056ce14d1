// A scene: what is to be simulated, as run-time data resolved to the doubles that every solver receives.
//
// A scene is a particle part and a rotation part, each optional. It is read from a TOML file (format:
// README); the built-in ones are files of the same format in models/scenes. Mass properties are reduced to
// principal axes in wide arithmetic: the truth solves what the numbers of the file say
// (models/exact_scene.hpp), and solvers start from the doubles nearest to it.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "models/attitude.hpp"
#include "models/loads.hpp"

namespace polhode {

/// The rotation of the body, in its principal frame ("_B" below).
template <class S>
struct RotationDataT {
  Vec3T<S> moments;  // principal moments [kg m^2], about the pivot if about_pivot
  // Turns principal into user body components; identity if given principal.
  QuaternionT<S> principal_to_user{S(1), S(0), S(0), S(0)};
  QuaternionT<S> q0{S(1), S(0), S(0), S(0)};  // principal -> space, as given: not normalised
  Vec3T<S> w0 = Vec3T<S>::Zero();             // rad/s, principal components
  std::vector<AnyTorque<S>> loads;            // in principal components
  bool attitude = true;                       // false: body rates alone
  bool about_pivot = false;                   // held at the space origin
};
using RotationData = RotationDataT<double>;

/// The motion of the centre of mass, in space components.
template <class S>
struct TranslationDataT {
  S mass = S(1);  // kg
  Vec3T<S> p0 = Vec3T<S>::Zero(), v0 = Vec3T<S>::Zero();
  Vec3T<S> acceleration = Vec3T<S>::Zero();  // sum of the gravity loads, m/s^2
  S drag = S(0);                             // sum of the linear drag coefficients b, kg/s
  bool has_force = false;
};
using TranslationData = TranslationDataT<double>;

/// What the file says before it is rounded to doubles: models/exact_scene.hpp.
struct ExactScene;

/// A number of the scene file that a stability study varies: the file with another value there.
struct Dial {
  std::string place;  // "load[0].stiffness", "initial.angular_velocity[1]": tables and keys of the file
  std::vector<double> values;  // to be tried, > 0 and increasing
  struct Follower {
    std::string place;
    double power;  // value in the file times (dial/dial in the file)^power
  };
  std::vector<Follower> followers;  // numbers that change with it
};

struct Scene {
  std::string id;              // file name without ".toml"
  std::filesystem::path file;  // where it was read
  std::string title, source;
  std::string variant;  // "" as read; "PLACE = VALUE" after with_dial
  double duration = 0;  // s
  std::optional<RotationData> rotation;
  std::optional<TranslationData> translation;
  std::shared_ptr<const ExactScene> exact;  // ask exact_scene(scene); null where a program made the scene
  std::optional<Dial> dial;
  std::vector<std::string> notes;     // what its reader should know, a sentence each; usually none
  std::vector<std::string> left_out;  // what the equations do without, a phrase each ("no translation: ...")
  int unknowns = 0;                   // of the smallest model: length of the state vector

  /// The scene that its file describes with the number at dial->place set to a value. A vector there keeps
  /// its direction, and its largest component is set. Needs `dial`; throws InputError if there is no such
  /// number or the scene cannot be.
  Scene with_dial(double value) const;
};

/// Does a load of the scene depend on time, beside the state?
bool depends_on_time(const Scene& scene);

/// Reads and checks a scene file. Throws InputError with file, line, key, what was found and what is needed.
Scene read_scene(const std::filesystem::path& file);

/// A built-in scene by id, or a scene file by path (anything with a '/' or ending in ".toml"). An id that
/// does not exist throws UsageError with the nearest one; a path that cannot be read throws InputError.
Scene find_scene(const std::string& id_or_path);

/// Ids of the built-in scenes, sorted.
std::vector<std::string> builtin_scene_ids();

/// Folder of files that belong to the program: `share/polhode/NAME` beside the folder of the binary, as
/// installed and as built alike. Throws MissingError if there is none.
std::filesystem::path data_folder(const std::string& name);

/// The valid name nearest to a misspelt one (edit distance), or "" if none is near.
std::string nearest_name(const std::string& name, const std::vector<std::string>& valid);

}  // namespace polhode
