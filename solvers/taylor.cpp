// The solution's own Taylor series, of high order: its coefficients follow from the equations one after the
// other, the step is as long as the last two terms stay below the tolerance, and the order goes with the
// tolerance.
//
// A body with an attitude has recurrences by hand, whose loops (solvers/taylor_kernel.cpp) are compiled for
// three instruction sets and give the same bits in each. Other scenes (particles, rates alone, two springs)
// play the tape that their right-hand side was recorded on (models/taylor_series.hpp), ten times slower. A
// torque that jumps (an attitude spring through q_w = 0) ends a step at its jump. Asked times are read off
// the series of the step that they lie in: they cost no step and lose no accuracy. A step that its series
// finds too long is shortened, not repeated.
//
// Keeps no invariant but by accuracy. The state is added up in two words, so that rounding enters only with
// the derivatives. Explicit: a decay of rate r allows steps of a few 1/r. The order p costs p^2; an expansion
// is counted as p right-hand sides.
//
// Source: Jorba & Zou, Exp. Math. 14 (2005); optimal order: Barton, Willers & Zahar, Comput. J. 14 (1971).
#include <cstring>

#include "models/taylor_series.hpp"
#include "solvers/adaptive_step.hpp"
#include "solvers/erased_model.hpp"
#include "solvers/observe.hpp"
#include "solvers/taylor_kernels.hpp"
#include "solvers/taylor_run.hpp"

namespace polhode {

extern const TaylorKernel taylor_baseline;
#ifdef POLHODE_X86
extern const TaylorKernel taylor_avx2, taylor_avx512;
#endif

std::vector<const TaylorKernel*> taylor_kernels() {
  std::vector<const TaylorKernel*> usable = {&taylor_baseline};
#ifdef POLHODE_X86
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2")) usable.push_back(&taylor_avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq"))
    usable.push_back(&taylor_avx512);
#endif
  return usable;
}

namespace {

using Numbers = double[4];
void set(Numbers& to, const Vec3& from) { std::copy(from.data(), from.data() + 3, to); }
void add(Numbers& to, const Vec3& from) {
  for (int i = 0; i < 3; ++i) to[i] += from[i];
}

/// Adds a load to the general form of the slope of w; false if there is no room for it.
class AddLoad {
 public:
  AddLoad(TaylorBody& body, const Vec3& moments) : body_(body), inverse_(moments.cwiseInverse()) {}

  bool operator()(const GravityAboutPivot<double>& l) {
    return add_carried(l.acceleration_S, 0, hat<double>(l.mass * l.center_B));
  }
  bool operator()(const ConstantTorque<double, Frame::space>& l) {
    return add_carried(l.torque, 0, Mat3::Identity());
  }
  bool operator()(const ConstantTorque<double, Frame::body>& l) {
    add(body_.constant, inverse_.cwiseProduct(l.torque));
    return true;
  }
  bool operator()(const AngularDrag<double>& l) {
    add_damping(l.coefficients_B);
    return true;
  }
  bool operator()(const AttitudeSpring<double>& l) {
    if (body_.has_spring) return false;
    body_.has_spring = true;
    add_damping(l.damping * Mat3::Identity());
    // The torque is linear in q but for its sign and length: columns by units.
    const Quaternion back = l.principal_to_user.conjugate();
    for (int i = 0; i < 4; ++i) {
      const Quaternion unit(i == 0, i == 1, i == 2, i == 3), q = unit * back;
      set(body_.spring[i],
          inverse_.cwiseProduct(-2 * l.stiffness * to_body<double>(l.principal_to_user, Vec3(q.vec()))));
      body_.turned[i] = q.w();
    }
    return true;
  }
  bool operator()(const GravityGradient<double>& l) {
    if (body_.carried_count != 0) return false;  // its vectors have to be the first
    const Vec3& I = l.moments_B;
    const double k = 3 * l.mean_motion * l.mean_motion;
    set(body_.gradient, k * inverse_.cwiseProduct(Vec3(I.z() - I.y(), I.x() - I.z(), I.y() - I.x())));
    if (l.mean_motion == 0) return true;
    return add_carried(Vec3::UnitX(), std::abs(l.mean_motion), Mat3::Zero()) &&
           add_carried(Vec3::UnitY(), -std::abs(l.mean_motion), Mat3::Zero());
  }

 private:
  bool add_carried(const Vec3& space, double rate, const Mat3& torque) {
    if (body_.carried_count == TaylorBody::most_carried) return false;
    CarriedVector& u = body_.carried[body_.carried_count++];
    set(u.space, space);
    u.rate = rate;
    for (int i = 0; i < 3; ++i) set(u.map[i], inverse_.cwiseProduct(torque.col(i)));
    return true;
  }
  void add_damping(const Mat3& coefficients) {
    for (int i = 0; i < 3; ++i) add(body_.damping[i], -inverse_.cwiseProduct(coefficients.col(i)));
  }

  TaylorBody& body_;
  Vec3 inverse_;
};

}  // namespace

std::optional<TaylorBody> taylor_body(const Scene& scene) {
  if (!scene.rotation || !scene.rotation->attitude) return {};
  const RotationData& r = *scene.rotation;
  TaylorBody body;
  const Vec3& I = r.moments;
  set(body.gyro, Vec3((I.y() - I.z()) / I.x(), (I.z() - I.x()) / I.y(), (I.x() - I.y()) / I.z()));
  set(body.inverse_moments, I.cwiseInverse());
  if (r.loads.empty() && !scene.translation) return body;
  if (r.loads.size() == 1 && !scene.translation)
    if (const auto* gravity = std::get_if<GravityAboutPivot<double>>(&r.loads.front())) {
      body.load = TaylorBody::Load::gravity;
      set(body.lever, gravity->mass * gravity->center_B);
      set(body.gravity_S, gravity->acceleration_S);
      return body;
    }
  body.load = TaylorBody::Load::any;
  AddLoad add_load(body, I);
  // Those that must be the first of the carried vectors come first.
  for (const bool gradient : {true, false})
    for (const auto& load : r.loads)
      if (std::holds_alternative<GravityGradient<double>>(load) == gradient && !std::visit(add_load, load))
        return {};
  if (const auto& t = scene.translation) {
    body.has_course = true;
    set(body.fall, t->acceleration);
    body.drag = t->drag / t->mass;
  }
  return body;
}

namespace {

/// The order at which a run costs least: measured, and within 5 % of that over a factor of 100 in tolerance.
int order_for(double tolerance, int most) {
  return std::clamp(2 * static_cast<int>(std::lround(0.5 * (6 - std::log10(tolerance)))), 6, most);
}

/// By the recurrences written by hand.
class TaylorByHand final : public AdaptiveSteps {
 public:
  TaylorByHand(const Scene& scene, const TaylorBody& body, const Setting& setting)
      : body_(body), kernel_(*taylor_kernels().back()), model_(erased_model(scene)) {
    body_.rtol = setting.rtol;
    body_.atol = setting.absolute_tolerance();
    body_.order = order_for(setting.rtol, TaylorLine::most);
    const double spin = scene.rotation->w0.norm();
    first_ = 1 / (spin + 1);
    back_to_start();
  }

  void restart(double t_end, Progress& p) override {
    back_to_start();
    line_.h = first_;
    p.h = t_end;  // so that the first step is an attempt, which goes as far as its series holds
  }
  void cruise(double t_stop, std::int64_t limit, Progress& p) override {
    if (line_.fresh) return;
    kernel_.cruise(body_, line_, t_stop, limit);
    tell(p);
  }
  bool attempt(Progress& p) override {
    kernel_.step(body_, line_, p.t + p.h);
    tell(p);
    return true;
  }
  Sample sample(double t) const override {
    return model_->sample(t, flat(line_.q, line_.w, line_.p, line_.v).data());
  }
  bool sample_within(double, double t, Sample& out) override {
    const double part = (t - line_.start) / line_.step;
    double turn[8] = {}, course[8] = {};
    for (int k = body_.order; k >= 0; --k)
      for (int i = 0; i < 8; ++i) {
        turn[i] = turn[i] * part + line_.series[k][i];
        course[i] = course[i] * part + line_.course[k][i];
      }
    out = model_->sample(t, flat(turn, turn + 4, course, course + 4).data());
    return true;
  }
  bool is_finite() const override {
    return all_finite(line_.q) && all_finite(line_.w) && all_finite(line_.p) && all_finite(line_.v);
  }

 private:
  static std::array<double, 13> flat(const double* q, const double* w, const double* p, const double* v) {
    std::array<double, 13> y;
    std::copy(q, q + 4, y.begin());
    std::copy(w, w + 3, y.begin() + 4);
    std::copy(p, p + 3, y.begin() + 7);
    std::copy(v, v + 3, y.begin() + 10);
    return y;
  }
  void back_to_start() {
    const auto y = model_->initial();
    std::copy(y.begin(), y.begin() + 4, line_.q);
    std::copy(y.begin() + 4, y.begin() + 7, line_.w);
    if (body_.has_course) {
      std::copy(y.begin() + 7, y.begin() + 10, line_.p);
      std::copy(y.begin() + 10, y.end(), line_.v);
    }
    std::fill(std::begin(line_.low), std::end(line_.low), 0);
    double turned = 0;
    for (int i = 0; i < 4; ++i) turned += body_.turned[i] * line_.q[i];
    line_.side = turned < 0 ? -1 : 1;
    line_.t = 0;
    line_.steps = 0;
    line_.fresh = true;
  }
  void tell(Progress& p) const {
    p.t = line_.t;
    p.h = line_.h;
    p.accepted = p.attempts = line_.steps;
    p.rhs_evals = line_.steps * body_.order;
    p.stuck = !(line_.t + line_.h > line_.t) && is_finite();
  }

  TaylorBody body_;
  const TaylorKernel& kernel_;
  std::unique_ptr<ErasedModel> model_;
  double first_ = 1;  // s
  TaylorLine line_;
};

/// By the tape of the right-hand side.
template <class M>
class TaylorByTape final : public AdaptiveSteps {
 public:
  TaylorByTape(M model, const Setting& setting)
      : model_(std::move(model)),
        series_(model_, order_for(setting.rtol, 30)),
        log2_tolerance_(std::log2(setting.rtol)) {}

  void restart(double t_end, Progress& p) override {
    y_ = model_.initial;
    low_ = {};
    series_.settle_signs(0.0, y_);
    p.h = t_end;  // until the first series says how far it holds
    expand(0, p);
    p.h = std::min(step_, t_end);
  }
  void cruise(double t_stop, std::int64_t limit, Progress& p) override {
    while (p.t + p.h < t_stop && p.attempts < limit && !p.stuck) take(p);
  }
  bool attempt(Progress& p) override {
    take(p);
    return true;
  }
  Sample sample(double t) const override { return observe(model_, t, y_.data()); }
  bool sample_within(double t_start, double t, Sample& out) override {
    out = observe(model_, t, before_.at(t - t_start).data());
    return true;
  }
  bool is_finite() const override { return all_finite(y_); }

 private:
  using State = typename M::State;

  /// The series about the state at t, and the step that it allows.
  void expand(double t, Progress& p) {
    series_.expand(t, y_);
    step_ = series_step(series_, log2_tolerance_);
    crossed_ = -1;
    step_ = series_.first_sign_change(step_, crossed_);
    p.rhs_evals += series_.order();
  }
  /// A step of p.h, at most what the series holds for, then the next series.
  void take(Progress& p) {
    const double t = p.t;
    const bool whole = p.h < step_;  // cut short by the end: no sign changes there
    const double end = t + p.h;
    const State change = series_.change(end - t);
    for (std::size_t i = 0; i < change.size(); ++i) {
      const double sum = change[i] + low_[i], after = y_[i] + sum;
      low_[i] = sum - (after - y_[i]);
      y_[i] = after;
    }
    if (!whole && crossed_ >= 0) series_.flip_sign(crossed_);
    before_.keep(series_);
    p.t = end;
    p.tell(t, p.h, true);
    expand(end, p);
    p.h = step_;
    p.stuck = !(end + p.h > end) && all_finite(y_);
  }

  M model_;
  TaylorSeries<M> series_;
  double log2_tolerance_, step_ = 0;
  int crossed_ = -1;
  State y_{}, low_{};
  struct Kept {
    std::vector<double> c;
    int order = 0;
    void keep(const TaylorSeries<M>& s) {
      order = s.order();
      c.resize(static_cast<std::size_t>((order + 1) * M::size));
      for (int i = 0; i < M::size; ++i)
        std::copy(s.coefficients(i), s.coefficients(i) + order + 1, c.begin() + i * (order + 1));
    }
    State at(double h) const {
      State y;
      for (int i = 0; i < M::size; ++i) {
        const double* a = &c[static_cast<std::size_t>(i * (order + 1))];
        double sum = a[order];
        for (int k = order - 1; k >= 0; --k) sum = sum * h + a[k];
        y[static_cast<std::size_t>(i)] = sum;
      }
      return y;
    }
  } before_;
};

Prepared prepare(const Scene& scene, const Setting& setting) {
  if (const auto body = taylor_body(scene))
    return run_adaptive_steps(std::make_shared<TaylorByHand>(scene, *body, setting), setting);
  return with_general_model<double>(scene, [&](auto model) {
    using M = decltype(model);
    return run_adaptive_steps(std::make_shared<TaylorByTape<M>>(std::move(model), setting), setting);
  });
}

constinit const Method rows[] = {
    {.id = "taylor",
     .family = "Taylor series",
     .summary = "Taylor series of the solution, order and step by the tolerance",
     .source = "Jorba & Zou, Exp. Math. 14 (2005)",
     .by_tolerance = true,
     .claims = {.unit_attitude = Claim::no,
                .momentum_magnitude = Claim::no,
                .space_momentum = Claim::no,
                .energy_bounded = Claim::no},
     .prepare = prepare},
};

}  // namespace
extern const MethodRows taylor;
const MethodRows taylor = rows;
}  // namespace polhode
