#include "models/closed_form.hpp"

#include <cmath>
#include <functional>
#include <optional>

#include "models/exact_scene.hpp"
#include "models/extended_free_rotation.hpp"
#include "models/pendulum.hpp"

namespace polhode {
namespace {

// ---- which one it is

enum class Kind { none, free, proportional_drag, principal_axis, spring, gravity_gradient };

using WideRotation = RotationDataT<Wide>;

/// The only axis with a component, or -1. A zero vector has axis `otherwise`.
template <class V>
int only_axis(const V& v, int otherwise) {
  int axis = otherwise, count = 0;
  for (int i = 0; i < 3; ++i)
    if (v[i] != 0) {
      axis = i;
      ++count;
    }
  return count > 1 ? -1 : axis;
}

template <class S>
bool is_diagonal(const Mat3T<S>& m) {
  return Mat3T<S>(m.diagonal().asDiagonal()) == m;
}

/// c = kappa I exactly? Products of two doubles have 106 bits.
bool is_proportional(const Vec3T<Wide>& c, const Vec3T<Wide>& I) {
  return c.x() * I.y() == c.y() * I.x() && c.y() * I.z() == c.z() * I.y();
}

/// The principal axis about which the body turns for good under drag and body torques; -1 if it does not.
template <class S>
int principal_axis(const RotationDataT<S>& r) {
  int axis = only_axis(r.w0, -2);
  if (axis == -1) return -1;
  for (const auto& load : r.loads) {
    if (const auto* drag = std::get_if<AngularDrag<S>>(&load)) {
      if (!is_diagonal(drag->coefficients_B)) return -1;
    } else if (const auto* constant = std::get_if<ConstantTorque<S, Frame::body>>(&load)) {
      const int along = only_axis(constant->torque, axis);
      if (along == -1 || (axis >= 0 && along != axis)) return -1;
      axis = along;
    } else {
      return -1;
    }
  }
  return axis == -2 ? 0 : axis;  // at rest, with drag alone: any
}

/// An undamped spring that turns the body about one axis and never as far as half a turn, beyond which it
/// pulls the other way.
bool is_planar_spring(const WideRotation& r, const AttitudeSpring<Wide>& spring) {
  const int turned = only_axis(r.q0.vec(), -2), axis = only_axis(r.w0, turned);
  if (spring.damping != 0 || spring.principal_to_user.vec().norm() > 0 || turned == -1 || axis < 0 ||
      (turned >= 0 && turned != axis) || r.q0.w() == 0 || !(spring.stiffness > 0))
    return false;
  const Wide cosine = abs(r.q0.w()) / sqrt(squared_norm(r.q0)), rate = r.w0[axis] / 2;
  const Wide gap = 2 * spring.stiffness / r.moments[axis] * cosine - rate * rate;
  return gap > Wide(1e-30) * rate * rate;  // what grazes half a turn is left to the series
}

Kind kind_of(const std::optional<WideRotation>& rotation) {
  if (!rotation) return Kind::free;
  const WideRotation& r = *rotation;
  if (r.loads.empty()) return Kind::free;
  if (principal_axis(r) >= 0) return Kind::principal_axis;
  if (r.loads.size() > 1) return Kind::none;
  if (const auto* drag = std::get_if<AngularDrag<Wide>>(&r.loads.front()))
    return is_diagonal(drag->coefficients_B) && is_proportional(drag->coefficients_B.diagonal(), r.moments)
               ? Kind::proportional_drag
               : Kind::none;
  if (const auto* spring = std::get_if<AttitudeSpring<Wide>>(&r.loads.front()))
    return is_planar_spring(r, *spring) ? Kind::spring : Kind::none;
  if (std::holds_alternative<GravityGradient<Wide>>(r.loads.front())) {
    const bool planar = r.q0.x() == 0 && r.q0.y() == 0 && r.w0.x() == 0 && r.w0.y() == 0;
    return planar && r.moments.x() != r.moments.y() ? Kind::gravity_gradient : Kind::none;
  }
  return Kind::none;
}

// ---- rotations

template <class S>
using Turning = typename FreeRotation<S>::State;

template <class S>
class Rotating {
 public:
  virtual ~Rotating() = default;
  virtual void set_up() = 0;
  virtual Turning<S> at(const S& t) const = 0;
};

/// Motion: FreeRotation<S>, or the extended one.
template <class S, class Motion = FreeRotation<S>>
class Freely final : public Rotating<S> {
 public:
  explicit Freely(const RotationDataT<S>& r) : r_(r) { Freely::set_up(); }
  void set_up() override { motion_.emplace(r_.moments, r_.q0, r_.w0); }
  Turning<S> at(const S& t) const override { return motion_->at(t); }

 private:
  RotationDataT<S> r_;
  std::optional<Motion> motion_;
};

/// (1 - exp(-rate t))/rate, down to t itself for no rate.
template <class S>
S delayed_time(const S& rate, const S& t) {
  using std::expm1;
  return rate == S(0) ? t : S(-expm1(S(-rate * t)) / rate);
}

/// (t - delayed_time)/rate: the way that a unit acceleration takes against drag.
template <class S>
S delayed_square(const S& rate, const S& t) {
  using std::abs;
  const S x = rate * t;
  if (abs(x) > S(0.5)) return (t - delayed_time(rate, t)) / rate;
  // t^2 (1/2 - x/6 + x^2/24 - ...): the difference above would cancel.
  S sum(0), term = S(1) / S(2);
  for (int n = 3; abs(term) > std::numeric_limits<S>::epsilon() / S(8); ++n) {
    sum += term;
    term *= -x / S(n);
  }
  return t * t * sum;
}

template <class S>
class ProportionalDrag final : public Rotating<S> {
 public:
  explicit ProportionalDrag(const RotationDataT<S>& r) : free_(r) {
    const auto& drag = std::get<AngularDrag<S>>(r.loads.front());
    rate_ = drag.coefficients_B(0, 0) / r.moments.x();
  }
  void set_up() override { free_.set_up(); }
  Turning<S> at(const S& t) const override {
    using std::exp;
    Turning<S> s = free_.at(delayed_time(rate_, t));
    s.w_B *= S(exp(S(-rate_ * t)));
    return s;
  }

 private:
  Freely<S> free_;
  S rate_;
};

template <class S>
class AboutPrincipalAxis final : public Rotating<S> {
 public:
  explicit AboutPrincipalAxis(const RotationDataT<S>& r)
      : axis_(principal_axis(r)), q0_(normalised<S>(r.q0)), w0_(r.w0[axis_]) {
    S drag(0), torque(0);
    for (const auto& load : r.loads) {
      if (const auto* d = std::get_if<AngularDrag<S>>(&load)) drag += d->coefficients_B(axis_, axis_);
      if (const auto* c = std::get_if<ConstantTorque<S, Frame::body>>(&load)) torque += c->torque[axis_];
    }
    rate_ = drag / r.moments[axis_];
    push_ = torque / r.moments[axis_];
  }
  void set_up() override {}
  Turning<S> at(const S& t) const override {
    using std::exp;
    const S later = delayed_time(rate_, t);
    Vec3T<S> angle(S(0), S(0), S(0)), w = angle;
    angle[axis_] = w0_ * later + push_ * delayed_square(rate_, t);
    w[axis_] = w0_ * S(exp(S(-rate_ * t))) + push_ * later;
    return {q0_ * exp_rotation<S>(angle), w};
  }

 private:
  int axis_;
  QuaternionT<S> q0_;
  S w0_, rate_, push_;
};

template <class S>
class PlanarSpring final : public Rotating<S> {
 public:
  explicit PlanarSpring(const RotationDataT<S>& r) : axis_(only_axis(r.w0, only_axis(r.q0.vec(), 0))), r_(r) {
    set_up();
  }
  void set_up() override {
    using std::sqrt;
    // phi = theta/2, and the pendulum is stated in phi/2 = theta/4.
    const QuaternionT<S> q = normalised<S>(r_.q0);
    const S side(q.w() < S(0) ? -1 : 1), c = side * q.w(), s = side * q.vec()[axis_];
    const S half_c = sqrt(S((S(1) + c) / S(2))), half_s = s / (S(2) * half_c);
    const S& stiffness = std::get<AttitudeSpring<S>>(r_.loads.front()).stiffness;
    motion_.emplace(S(sqrt(S(stiffness / r_.moments[axis_]))), half_s, half_c, S(r_.w0[axis_] / S(2)));
  }
  Turning<S> at(const S& t) const override {
    const auto s = motion_->at(t);
    Vec3T<S> u(S(0), S(0), S(0)), w = u;
    u[axis_] = S(2) * s.sine * s.cosine;
    w[axis_] = S(2) * s.rate;
    return {QuaternionT<S>(S(1) - S(2) * s.sine * s.sine, u.x(), u.y(), u.z()), w};
  }

 private:
  int axis_;
  RotationDataT<S> r_;
  std::optional<Pendulum<S>> motion_;
};

template <class S>
class PlanarGravityGradient final : public Rotating<S> {
 public:
  explicit PlanarGravityGradient(const RotationDataT<S>& r) : r_(r) { set_up(); }
  void set_up() override {
    using std::abs;
    using std::sqrt;
    // theta: the turn about z. phi = 2 (theta - n t), or 2 (theta - n t) + pi if the x axis is the one that
    // settles across; the pendulum is stated in phi/2.
    const QuaternionT<S> q = normalised<S>(r_.q0);
    n_ = std::get<GravityGradient<S>>(r_.loads.front()).mean_motion;
    across_ = r_.moments.y() < r_.moments.x();
    const S c = q.w() * q.w() - q.z() * q.z(), s = S(2) * q.w() * q.z();
    const S stiffness = S(3) * n_ * n_ * S(abs(S(r_.moments.y() - r_.moments.x()))) / r_.moments.z();
    motion_.emplace(S(sqrt(stiffness)), across_ ? c : s, across_ ? S(-s) : c, S(S(2) * (r_.w0.z() - n_)));
  }
  bool can_be_told() const { return motion_->librates() || motion_->rotates(); }
  Turning<S> at(const S& t) const override {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const auto m = motion_->at(t);
    const S s = across_ ? S(-m.cosine) : m.sine, c = across_ ? m.sine : m.cosine;  // of theta - n t
    // Half of it, without loss; which of the two roots it is does not matter to an attitude.
    const bool near = c >= S(0);
    const S root = sqrt(S((S(1) + (near ? c : S(-c))) / S(2)));
    const QuaternionT<S> from_vertical = near ? QuaternionT<S>(root, S(0), S(0), s / (S(2) * root))
                                              : QuaternionT<S>(s / (S(2) * root), S(0), S(0), root);
    const S half = n_ * t / S(2);
    return {QuaternionT<S>(S(cos(half)), S(0), S(0), S(sin(half))) * from_vertical,
            Vec3T<S>(S(0), S(0), n_ + m.rate / S(2))};
  }

 private:
  RotationDataT<S> r_;
  S n_;
  bool across_ = false;
  std::optional<Pendulum<S>> motion_;
};

/// A motion in doubles whose constants doubles cannot hold: found in 50 digits each time, and rounded.
class InWide final : public Rotating<double> {
 public:
  explicit InWide(std::unique_ptr<Rotating<Wide>> motion) : motion_(std::move(motion)) {}
  void set_up() override { motion_->set_up(); }
  Turning<double> at(const double& t) const override {
    const Turning<Wide> x = motion_->at(Wide(t));
    return {x.q.cast<double>(), x.w_B.cast<double>()};
  }

 private:
  std::unique_ptr<Rotating<Wide>> motion_;
};

/// Can the closed form be set up in doubles? Squares of small components must not vanish, and next to a
/// symmetric body the turn about L is a difference of two that are nearly alike.
bool doubles_suffice(const RotationData& r, Kind kind) {
  constexpr double small = 1e-60, alike = 1e-8;
  double largest = 0, least = 1;
  const bool pendulum = kind == Kind::spring || kind == Kind::gravity_gradient;
  for (int i = 0; i < 3; ++i) largest = std::max(largest, std::abs(r.w0[i]));
  for (int i = 0; i < 3; ++i) {
    if (r.w0[i] != 0) least = std::min(least, std::abs(r.w0[i]) / (pendulum ? 1 : largest));
    if (pendulum && r.q0.vec()[i] != 0) least = std::min(least, std::abs(r.q0.vec()[i]));
    const double a = r.moments[i], b = r.moments[(i + 1) % 3];
    if (a != b && std::abs(a - b) < alike * std::max(a, b)) return false;
  }
  return least > small;
}

template <class S>
std::unique_ptr<Rotating<S>> rotating(const RotationDataT<S>& r, Kind kind, [[maybe_unused]] bool extended) {
  if constexpr (std::is_same_v<S, double>)
    if (kind != Kind::principal_axis && kind != Kind::none && !doubles_suffice(r, kind)) {
      auto motion = rotating<Wide>(cast_rotation<Wide>(r), kind, false);
      if (!motion) return nullptr;
      return std::make_unique<InWide>(std::move(motion));
    }
  switch (kind) {
    case Kind::none:
      return nullptr;
    case Kind::free:
      if constexpr (std::is_same_v<S, double>)
        if (extended) return std::make_unique<Freely<S, ExtendedFreeRotation>>(r);
      return std::make_unique<Freely<S>>(r);
    case Kind::proportional_drag:
      return std::make_unique<ProportionalDrag<S>>(r);
    case Kind::principal_axis:
      return std::make_unique<AboutPrincipalAxis<S>>(r);
    case Kind::spring:
      return std::make_unique<PlanarSpring<S>>(r);
    case Kind::gravity_gradient: {
      auto planar = std::make_unique<PlanarGravityGradient<S>>(r);
      if (!planar->can_be_told()) return nullptr;  // exactly on the separatrix of its pendulum
      return planar;
    }
  }
  return nullptr;
}

// ---- the centre of mass

template <class S>
void translate(const TranslationDataT<S>& d, const S& t, ExactState<S>& x) {
  using std::exp;
  const S rate = d.drag / d.mass, later = delayed_time(rate, t);
  x.v = d.v0 * S(exp(S(-rate * t))) + d.acceleration * later;
  x.p = d.p0 + d.v0 * later + d.acceleration * delayed_square(rate, t);
}

template <class S>
class SceneMotion final : public ClosedForm<S> {
 public:
  SceneMotion(std::optional<TranslationDataT<S>> translation, std::unique_ptr<Rotating<S>> rotation)
      : translation_(std::move(translation)), rotation_(std::move(rotation)) {}
  void set_up() override {
    if (rotation_) rotation_->set_up();
  }
  ExactState<S> at(const S& t) const override {
    ExactState<S> x;
    if (rotation_) {
      const Turning<S> s = rotation_->at(t);
      x.q = s.q;
      x.w_B = s.w_B;
    }
    if (translation_) translate(*translation_, t, x);
    return x;
  }

 private:
  std::optional<TranslationDataT<S>> translation_;
  std::unique_ptr<Rotating<S>> rotation_;
};

template <class S>
std::unique_ptr<ClosedForm<S>> made(const std::optional<RotationDataT<S>>& r,
                                    const std::optional<TranslationDataT<S>>& t, Kind kind, bool extended) {
  if (kind == Kind::none) return nullptr;
  std::unique_ptr<Rotating<S>> rotation;
  if (r) {
    rotation = rotating<S>(*r, kind, extended);
    if (!rotation) return nullptr;
  }
  return std::make_unique<SceneMotion<S>>(t, std::move(rotation));
}

std::unique_ptr<ClosedForm<double>> made_in_doubles(const Scene& scene, bool extended) {
  std::optional<WideRotation> wide;
  if (scene.rotation) wide = cast_rotation<Wide>(*scene.rotation);
  return made<double>(scene.rotation, scene.translation, kind_of(wide), extended);
}

}  // namespace

std::string closed_form_kind(const Scene& scene) {
  switch (kind_of(exact_scene(scene).rotation)) {
    case Kind::none:
      return "";
    case Kind::free:
      return scene.rotation ? "free rotation by theta functions" : "motion of a particle";
    case Kind::proportional_drag:
      return "free rotation by theta functions, in the time of drag proportional to inertia";
    case Kind::principal_axis:
      return "turn about a principal axis";
    case Kind::spring:
      return "plane pendulum of the half-angle by Jacobi functions";
    case Kind::gravity_gradient:
      return "plane libration by Jacobi functions";
  }
  return "";
}

template <>
std::unique_ptr<ClosedForm<double>> closed_form(const Scene& scene) {
  return made_in_doubles(scene, false);
}

std::unique_ptr<ClosedForm<double>> closed_form_extended(const Scene& scene) {
  return made_in_doubles(scene, true);
}

/// In a wide type of what the file says. Which one it is, its 50 digits decide for the narrower type, too.
template <class S>
std::unique_ptr<ClosedForm<S>> closed_form(const Scene& scene) {
  const ExactScene exact = exact_scene(scene);
  std::optional<RotationDataT<S>> r;
  std::optional<TranslationDataT<S>> t;
  if (exact.rotation) r = cast_rotation<S>(*exact.rotation);
  if (exact.translation) t = cast_translation<S>(*exact.translation);
  return made<S>(r, t, kind_of(exact.rotation), false);
}
template std::unique_ptr<ClosedForm<Wide>> closed_form(const Scene&);
template std::unique_ptr<ClosedForm<Narrower>> closed_form(const Scene&);

}  // namespace polhode
