// The problem in 50 digits, and its content as text.
#include "models/exact_scene.hpp"

#include <cstdio>

#include "models/scene_content.hpp"

namespace polhode {
namespace {

class Writer {
 public:
  void add(double x) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%a ", x);
    text += digits;
  }
  void add(const Wide& x) { text += x.str(0, std::ios_base::scientific) + ' '; }
  template <class V>
  void add_all(const V& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) add(v.data()[i]);
    text += '\n';
  }
  template <class S>
  void add_load(const GravityAboutPivot<S>& l) {
    add(l.mass);
    add_all(l.acceleration_S);
    add_all(l.center_B);
  }
  template <class S>
  void add_load(const AngularDrag<S>& l) {
    add_all(l.coefficients_B);
  }
  template <class S>
  void add_load(const AttitudeSpring<S>& l) {
    add(l.stiffness);
    add(l.damping);
    add_all(l.principal_to_user.coeffs());
  }
  template <class S, Frame F>
  void add_load(const ConstantTorque<S, F>& l) {
    text += F == Frame::body ? "body " : "space ";
    add_all(l.torque);
  }
  template <class S>
  void add_load(const GravityGradient<S>& l) {
    add(l.mean_motion);
    add_all(l.moments_B);
  }
  template <class S>
  void add_rotation(const RotationDataT<S>& r) {
    text += r.attitude ? "rotation\n" : "rates\n";
    add_all(r.moments);
    add_all(r.principal_to_user.coeffs());
    add_all(r.q0.coeffs());
    add_all(r.w0);
    for (const auto& load : r.loads)
      std::visit(
          [this](const auto& l) {
            text += std::string(l.type) + ' ';
            add_load(l);
          },
          load);
  }
  template <class S>
  void add_translation(const TranslationDataT<S>& t) {
    text += "translation ";
    add(t.mass);
    add(t.drag);
    add_all(t.p0);
    add_all(t.v0);
    add_all(t.acceleration);
  }
  template <class SceneT>
  std::string of(const SceneT& scene) {
    if (scene.rotation) add_rotation(*scene.rotation);
    if (scene.translation) add_translation(*scene.translation);
    return text;
  }

  std::string text;
};

StatedLoad stated(const AnyTorque<Wide>& load) {
  struct Statement {
    using Kind = StatedLoad::Kind;
    StatedLoad operator()(const GravityAboutPivot<Wide>& l) const {
      StatedLoad s{.kind = Kind::gravity_about_pivot};
      s.vector = l.acceleration_S;
      s.center = l.center_B;
      s.number = l.mass;
      return s;
    }
    StatedLoad operator()(const AngularDrag<Wide>& l) const {
      StatedLoad s{.kind = Kind::drag};
      s.matrix = l.coefficients_B;
      return s;
    }
    StatedLoad operator()(const AttitudeSpring<Wide>& l) const {
      StatedLoad s{.kind = Kind::spring};
      s.number = l.stiffness;
      s.damping = l.damping;
      s.frame = l.principal_to_user;
      return s;
    }
    StatedLoad operator()(const ConstantTorque<Wide, Frame::body>& l) const {
      StatedLoad s{.kind = Kind::body_torque};
      s.vector = l.torque;
      return s;
    }
    StatedLoad operator()(const ConstantTorque<Wide, Frame::space>& l) const {
      StatedLoad s{.kind = Kind::space_torque};
      s.vector = l.torque;
      return s;
    }
    StatedLoad operator()(const GravityGradient<Wide>& l) const {
      StatedLoad s{.kind = Kind::gravity_gradient};
      s.number = l.mean_motion;
      return s;
    }
  };
  return std::visit(Statement{}, load);
}

}  // namespace

std::string content_of(const Scene& scene) { return Writer().of(exact_scene(scene)); }

ExactScene exact_scene(const Scene& scene) {
  if (scene.exact) {
    // The doubles may have been changed by a program since; then they are what is meant.
    struct {
      std::optional<RotationData> rotation;
      std::optional<TranslationData> translation;
    } rounded;
    if (scene.exact->rotation) rounded.rotation = cast_rotation<double>(*scene.exact->rotation);
    if (scene.exact->translation) rounded.translation = cast_translation<double>(*scene.exact->translation);
    if (Writer().of(rounded) == Writer().of(scene)) return *scene.exact;
  }
  ExactScene exact;
  if (scene.translation) exact.translation = cast_translation<Wide>(*scene.translation);
  if (!scene.rotation) return exact;
  exact.rotation = cast_rotation<Wide>(*scene.rotation);
  StatedRotation& s = exact.stated.emplace();
  const Vec3T<Resolved> moments = exact.rotation->moments.cast<Resolved>();
  s.inertia_U = moments.asDiagonal();
  s.inverse_inertia_U = moments.cwiseInverse().asDiagonal();
  s.q_SU = exact.rotation->q0;
  s.given = exact.rotation->w0;
  for (const auto& load : exact.rotation->loads) s.loads.push_back(stated(load));
  return exact;
}

bool starts_rounded(const Scene& scene) {
  const ExactScene exact = exact_scene(scene);
  if (!exact.rotation) return false;
  const RotationDataT<Wide> back = cast_rotation<Wide>(*scene.rotation);
  return Writer().of(ExactScene{back, {}, {}}) != Writer().of(ExactScene{exact.rotation, {}, {}});
}

}  // namespace polhode
