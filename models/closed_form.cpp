#include "models/closed_form.hpp"

#include <cmath>
#include <functional>
#include <optional>

#include "models/extended_free_rotation.hpp"
#include "models/pendulum.hpp"
#include "models/wide.hpp"

namespace polhode {
namespace {

// ---- which one it is

enum class Kind { none, free, proportional_drag, principal_axis, spring, gravity_gradient };

/// The only axis with a component, or -1. A zero vector has axis `otherwise`.
int only_axis(const Vec3& v, int otherwise) {
  int axis = otherwise, count = 0;
  for (int i = 0; i < 3; ++i)
    if (v[i] != 0) {
      axis = i;
      ++count;
    }
  return count > 1 ? -1 : axis;
}

bool is_diagonal(const Mat3& m) { return Mat3(m.diagonal().asDiagonal()) == m; }

/// c = kappa I exactly? Products of two doubles have 106 bits.
bool is_proportional(const Vec3& c, const Vec3& I) {
  const auto same = [](double a, double b, double x, double y) {
    return Wide(a) * Wide(b) == Wide(x) * Wide(y);
  };
  return same(c.x(), I.y(), c.y(), I.x()) && same(c.y(), I.z(), c.z(), I.y());
}

/// The principal axis about which the body turns for good under drag and body torques; -1 if it does not.
int principal_axis(const RotationData& r) {
  int axis = only_axis(r.w0, -2);
  if (axis == -1) return -1;
  for (const auto& load : r.loads) {
    if (const auto* drag = std::get_if<AngularDrag<double>>(&load)) {
      if (!is_diagonal(drag->coefficients_B)) return -1;
    } else if (const auto* constant = std::get_if<ConstantTorque<double, Frame::body>>(&load)) {
      const int along = only_axis(constant->torque, axis);
      if (along == -1 || (axis >= 0 && along != axis)) return -1;
      axis = along;
    } else {
      return -1;
    }
  }
  return axis == -2 ? 0 : axis;  // at rest, with drag alone: any
}

Kind kind_of(const Scene& scene) {
  if (!scene.rotation) return Kind::free;
  const RotationData& r = *scene.rotation;
  if (r.loads.empty()) return Kind::free;
  if (principal_axis(r) >= 0) return Kind::principal_axis;
  if (r.loads.size() > 1) return Kind::none;
  if (const auto* drag = std::get_if<AngularDrag<double>>(&r.loads.front()))
    return is_diagonal(drag->coefficients_B) && is_proportional(drag->coefficients_B.diagonal(), r.moments)
               ? Kind::proportional_drag
               : Kind::none;
  if (const auto* spring = std::get_if<AttitudeSpring<double>>(&r.loads.front())) {
    const int turned = only_axis(r.q0.vec(), -2), axis = only_axis(r.w0, turned);
    if (spring->damping != 0 || spring->principal_to_user.vec().norm() > 0 || turned == -1 || axis < 0 ||
        (turned >= 0 && turned != axis) || r.q0.w() == 0)
      return Kind::none;
    // Beyond half a turn the spring pulls the other way.
    const double sine = std::abs(r.q0.vec()[axis]), cosine = std::abs(r.q0.w()), n = std::hypot(sine, cosine);
    const double rate = r.w0[axis] / 2;
    return rate * rate < 2 * spring->stiffness / r.moments[axis] * (cosine / n) ? Kind::spring : Kind::none;
  }
  if (std::holds_alternative<GravityGradient<double>>(r.loads.front())) {
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
  explicit Freely(const RotationData& r) : r_(r) { Freely::set_up(); }
  void set_up() override { motion_.emplace(r_.moments, r_.q0.template cast<S>(), r_.w0.template cast<S>()); }
  Turning<S> at(const S& t) const override { return motion_->at(t); }

 private:
  RotationData r_;
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
  explicit ProportionalDrag(const RotationData& r) : free_(r) {
    const auto& drag = std::get<AngularDrag<double>>(r.loads.front());
    rate_ = S(drag.coefficients_B(0, 0)) / S(r.moments.x());
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
  explicit AboutPrincipalAxis(const RotationData& r)
      : axis_(principal_axis(r)), q0_(normalised<S>(r.q0.template cast<S>())), w0_(r.w0[axis_]) {
    S drag(0), torque(0);
    for (const auto& load : r.loads) {
      if (const auto* d = std::get_if<AngularDrag<double>>(&load)) drag += S(d->coefficients_B(axis_, axis_));
      if (const auto* c = std::get_if<ConstantTorque<double, Frame::body>>(&load))
        torque += S(c->torque[axis_]);
    }
    rate_ = drag / S(r.moments[axis_]);
    push_ = torque / S(r.moments[axis_]);
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
  explicit PlanarSpring(const RotationData& r) : axis_(only_axis(r.w0, only_axis(r.q0.vec(), 0))), r_(r) {
    set_up();
  }
  void set_up() override {
    using std::sqrt;
    // phi = theta/2, and the pendulum is stated in phi/2 = theta/4.
    const QuaternionT<S> q = normalised<S>(r_.q0.template cast<S>());
    const S side(q.w() < S(0) ? -1 : 1), c = side * q.w(), s = side * q.vec()[axis_];
    const S half_c = sqrt(S((S(1) + c) / S(2))), half_s = s / (S(2) * half_c);
    const S stiffness(std::get<AttitudeSpring<double>>(r_.loads.front()).stiffness);
    motion_.emplace(S(sqrt(S(stiffness / S(r_.moments[axis_])))), half_s, half_c, S(S(r_.w0[axis_]) / S(2)));
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
  RotationData r_;
  std::optional<Pendulum<S>> motion_;
};

template <class S>
class PlanarGravityGradient final : public Rotating<S> {
 public:
  explicit PlanarGravityGradient(const RotationData& r) : r_(r) { set_up(); }
  void set_up() override {
    using std::abs;
    using std::sqrt;
    // theta: the turn about z. phi = 2 (theta - n t), or 2 (theta - n t) + pi if the x axis is the one that
    // settles across; the pendulum is stated in phi/2.
    const QuaternionT<S> q = normalised<S>(r_.q0.template cast<S>());
    n_ = S(std::get<GravityGradient<double>>(r_.loads.front()).mean_motion);
    across_ = r_.moments.y() < r_.moments.x();
    const S c = q.w() * q.w() - q.z() * q.z(), s = S(2) * q.w() * q.z();
    const S stiffness = S(3) * n_ * n_ * S(abs(S(r_.moments.y()) - S(r_.moments.x()))) / S(r_.moments.z());
    motion_.emplace(S(sqrt(stiffness)), across_ ? c : s, across_ ? S(-s) : c, S(S(2) * (S(r_.w0.z()) - n_)));
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
  RotationData r_;
  S n_;
  bool across_ = false;
  std::optional<Pendulum<S>> motion_;
};

template <class S>
std::unique_ptr<Rotating<S>> rotating(const Scene& scene, Kind kind, [[maybe_unused]] bool extended) {
  const RotationData& r = *scene.rotation;
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
void translate(const TranslationData& d, const S& t, ExactState<S>& x) {
  using std::exp;
  const S rate = S(d.drag) / S(d.mass), later = delayed_time(rate, t);
  const Vec3T<S> v0 = d.v0.template cast<S>(), g = d.acceleration.template cast<S>();
  x.v = v0 * S(exp(S(-rate * t))) + g * later;
  x.p = d.p0.template cast<S>() + v0 * later + g * delayed_square(rate, t);
}

template <class S>
class SceneMotion final : public ClosedForm<S> {
 public:
  SceneMotion(const Scene& scene, std::unique_ptr<Rotating<S>> rotation)
      : translation_(scene.translation), rotation_(std::move(rotation)) {}
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
  std::optional<TranslationData> translation_;
  std::unique_ptr<Rotating<S>> rotation_;
};

template <class S>
std::unique_ptr<ClosedForm<S>> made(const Scene& scene, bool extended) {
  const Kind kind = kind_of(scene);
  if (kind == Kind::none) return nullptr;
  std::unique_ptr<Rotating<S>> rotation;
  if (scene.rotation) {
    rotation = rotating<S>(scene, kind, extended);
    if (!rotation) return nullptr;
  }
  return std::make_unique<SceneMotion<S>>(scene, std::move(rotation));
}

}  // namespace

std::string closed_form_kind(const Scene& scene) {
  switch (kind_of(scene)) {
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

template <class S>
std::unique_ptr<ClosedForm<S>> closed_form(const Scene& scene) {
  return made<S>(scene, false);
}
template std::unique_ptr<ClosedForm<double>> closed_form(const Scene&);
template std::unique_ptr<ClosedForm<Wide>> closed_form(const Scene&);
template std::unique_ptr<ClosedForm<Narrower>> closed_form(const Scene&);

std::unique_ptr<ClosedForm<double>> closed_form_extended(const Scene& scene) {
  return made<double>(scene, true);
}

}  // namespace polhode
