#include "models/scene_content.hpp"

#include <cstdio>

namespace polhode {
namespace {

class Writer {
 public:
  void add(double x) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%a ", x);
    text += digits;
  }
  template <class V>
  void add_all(const V& v) {
    for (Eigen::Index i = 0; i < v.size(); ++i) add(v.data()[i]);
    text += '\n';
  }
  void add_load(const GravityAboutPivot<double>& l) {
    add(l.mass);
    add_all(l.acceleration_S);
    add_all(l.center_B);
  }
  void add_load(const AngularDrag<double>& l) { add_all(l.coefficients_B); }
  void add_load(const AttitudeSpring<double>& l) {
    add(l.stiffness);
    add(l.damping);
    add_all(l.principal_to_user.coeffs());
  }
  template <Frame F>
  void add_load(const ConstantTorque<double, F>& l) {
    text += F == Frame::body ? "body " : "space ";
    add_all(l.torque);
  }
  void add_load(const GravityGradient<double>& l) {
    add(l.mean_motion);
    add_all(l.moments_B);
  }

  std::string text;
};

}  // namespace

std::string content_of(const Scene& scene) {
  Writer w;
  if (scene.rotation) {
    const RotationData& r = *scene.rotation;
    w.text += r.attitude ? "rotation\n" : "rates\n";
    w.add_all(r.moments);
    w.add_all(r.principal_to_user.coeffs());
    w.add_all(r.q0.coeffs());
    w.add_all(r.w0);
    for (const auto& load : r.loads)
      std::visit(
          [&w](const auto& l) {
            w.text += std::string(l.type) + ' ';
            w.add_load(l);
          },
          load);
  }
  if (scene.translation) {
    const TranslationData& t = *scene.translation;
    w.text += "translation ";
    w.add(t.mass);
    w.add(t.drag);
    w.add_all(t.p0);
    w.add_all(t.v0);
    w.add_all(t.acceleration);
  }
  return w.text;
}

}  // namespace polhode
