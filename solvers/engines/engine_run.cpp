#include "solvers/engines/engine_run.hpp"

namespace polhode {

bool is_served(const Scene& scene) { return !scene.rotation || scene.rotation->attitude; }

EngineBody engine_body(const Scene& scene) {
  EngineBody body;
  body.rotates = scene.rotation.has_value();
  body.moves = scene.translation.has_value();
  if (scene.rotation) {
    const RotationData& r = *scene.rotation;
    body.moments = r.moments;
    body.q0 = normalised(r.q0);
    body.w0_B = r.w0;
    if (!r.loads.empty())
      body.torque_S = [torques = SeveralTorques<double>{r.loads}](double t, const Mat3& R, const Vec3& w_S) {
        return torques.torque_S(t, R, w_S);
      };
  }
  if (scene.translation) {
    const TranslationData& t = *scene.translation;
    body.mass = t.mass;
    body.gravity_S = t.acceleration;
    body.drag = t.drag;
    body.p0_S = t.p0;
    body.v0_S = t.v0;
  }
  return body;
}

Observe observe_engine(const Scene& scene) {
  return with_general_model<double>(scene, [](auto model) -> Observe {
    using M = decltype(model);
    if constexpr (M::has_attitude || !M::has_rotation)
      return [m = std::move(model)](double t, const EngineState& state) {
        typename M::State y{};
        [[maybe_unused]] const auto put = [&y](int at, const Vec3& v) {
          for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(at + i)] = v[i];
        };
        if constexpr (M::has_rotation) {
          y[0] = state.q.w();
          put(1, state.q.vec());
          put(4, state.w_B);
        }
        if constexpr (M::has_translation) {
          put(M::rotation_size, state.p_S);
          put(M::rotation_size + 3, state.v_S);
        }
        Sample s = observe(m, t, y.data());
        if constexpr (M::has_rotation) s.unit_defect = state.unit_defect;
        return s;
      };
    else
      return {};
  });
}

}  // namespace polhode
