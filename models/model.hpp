// From a scene (run-time data) to a model (a type that holds only what the scene has): the one place where
// the decision is made. `with_model(scene, f)` calls f with the smallest model of the scene.
#pragma once
#include <utility>

#include "models/body.hpp"
#include "models/scene.hpp"

namespace polhode {

namespace model_parts {

template <class S, class Load, class From>
auto make_load(const RotationDataT<From>& r) {
  if constexpr (std::is_same_v<Load, Free<S>>) {
    return Load{};
  } else if constexpr (std::is_same_v<Load, SeveralTorques<S>>) {
    Load load;
    for (const auto& l : r.loads) load.loads.push_back(cast_load<S>(l));
    return load;
  } else {
    return std::get<Load>(cast_load<S>(r.loads.front()));
  }
}

template <class S, template <class> class LoadT, Shape shape = Shape::triaxial,
          AttitudePart attitude = AttitudePart::integrated, class From>
Rotation<S, LoadT, shape, attitude> make_rotation(const RotationDataT<From>& r) {
  return {r.moments.template cast<S>(), make_load<S, LoadT<S>>(r)};
}

template <class S, class From>
Translation<S, Forces> make_forced(const TranslationDataT<From>& t) {
  return {static_cast<S>(t.mass),
          {t.acceleration.template cast<S>(), static_cast<S>(t.drag) / static_cast<S>(t.mass)}};
}
template <class S, class From>
Translation<S, NoForce> make_unforced(const TranslationDataT<From>& t) {
  return {static_cast<S>(t.mass), {}};
}

template <class S, class SceneT, class R, class T>
Model<S, R, T> make_model(const SceneT& scene, R rotation, T translation) {
  Model<S, R, T> m{std::move(rotation), std::move(translation), {}};
  if constexpr (R::has_attitude) {
    // Normalised in S: the doubles of the scene are the problem, their norm is part of reading it.
    const QuaternionT<S> q = normalised<S>(scene.rotation->q0.template cast<S>());
    m.initial[0] = q.w();
    m.initial[1] = q.x();
    m.initial[2] = q.y();
    m.initial[3] = q.z();
  }
  if constexpr (R::present)
    for (int i = 0; i < 3; ++i)
      m.initial[static_cast<std::size_t>(R::w_at + i)] = static_cast<S>(scene.rotation->w0[i]);
  if constexpr (T::present)
    for (int i = 0; i < 3; ++i) {
      m.initial[static_cast<std::size_t>(R::size + i)] = static_cast<S>(scene.translation->p0[i]);
      m.initial[static_cast<std::size_t>(R::size + 3 + i)] = static_cast<S>(scene.translation->v0[i]);
    }
  return m;
}

}  // namespace model_parts

/// The rotation of a scene in its general form: any shape, any number of loads, asked at run time.
template <class S, AttitudePart attitude = AttitudePart::integrated, class From>
auto make_general_rotation(const RotationDataT<From>& r) {
  return model_parts::make_rotation<S, SeveralTorques, Shape::any, attitude>(r);
}

/// Has what most scenes are a type of its own? Sanitizer builds, which take twice as long, do without.
#ifdef POLHODE_FEW_TYPES
inline constexpr bool every_type = false;
#else
inline constexpr bool every_type = true;
#endif

/// Calls f(model) with the smallest model of the scene and returns what f returns.
///
/// What most scenes are has a type of its own: the free body, the sphere, one load alone. The rest shares the
/// general rotation, whose predictable branches cost a nanosecond: each type is compiled into every solver.
template <class F>
decltype(auto) with_model(const Scene& scene, F&& f) {
  using namespace model_parts;
  using S = double;
  const auto call = [&](auto rotation, auto translation) -> decltype(auto) {
    return f(make_model<S>(scene, std::move(rotation), std::move(translation)));
  };
  const auto& t = scene.translation;
  if constexpr (every_type)
    if (t && !t->has_force && !scene.rotation) return call(NoRotation{}, make_unforced<S>(*t));
  if (!scene.rotation) return call(NoRotation{}, make_forced<S>(*t));

  const RotationData& r = *scene.rotation;
  const bool round = r.moments.x() == r.moments.y() && r.moments.y() == r.moments.z();
  const bool free = r.loads.empty();
  if (!r.attitude)
    return free ? call(make_rotation<S, Free, Shape::triaxial, AttitudePart::absent>(r), NoTranslation{})
                : call(make_general_rotation<S, AttitudePart::absent>(r), NoTranslation{});
  if (t) {
    if (!free || round) return call(make_general_rotation<S>(r), make_forced<S>(*t));
    if constexpr (every_type)
      if (!t->has_force) return call(make_rotation<S, Free>(r), make_unforced<S>(*t));
    return call(make_rotation<S, Free>(r), make_forced<S>(*t));
  }
  if constexpr (every_type) {
    if (free && round) return call(make_rotation<S, Free, Shape::spherical>(r), NoTranslation{});
    if (!round && r.loads.size() == 1) {
      if (std::holds_alternative<GravityAboutPivot<S>>(r.loads.front()))
        return call(make_rotation<S, GravityAboutPivot>(r), NoTranslation{});
      if (std::holds_alternative<AngularDrag<S>>(r.loads.front()))
        return call(make_rotation<S, AngularDrag>(r), NoTranslation{});
      if (std::holds_alternative<AttitudeSpring<S>>(r.loads.front()))
        return call(make_rotation<S, AttitudeSpring>(r), NoTranslation{});
    }
  }
  if (free) return call(make_rotation<S, Free>(r), NoTranslation{});
  return call(make_general_rotation<S>(r), NoTranslation{});
}

/// The same scene in number type S with the general types alone: fewer instances where speed is not the
/// matter. SceneT: a Scene, whose numbers are doubles, or an ExactScene.
template <class S, class SceneT, class F>
decltype(auto) with_general_model(const SceneT& scene, F&& f) {
  using namespace model_parts;
  const auto& t = scene.translation;
  const auto call = [&](auto rotation, auto translation) -> decltype(auto) {
    return f(make_model<S>(scene, std::move(rotation), std::move(translation)));
  };
  if (!scene.rotation) return call(NoRotation{}, make_forced<S>(*t));
  const auto& r = *scene.rotation;
  if (!r.attitude) return call(make_general_rotation<S, AttitudePart::absent>(r), NoTranslation{});
  return t ? call(make_general_rotation<S>(r), make_forced<S>(*t))
           : call(make_general_rotation<S>(r), NoTranslation{});
}

}  // namespace polhode
