#include "solvers/sensitivity.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "models/closed_form.hpp"
#include "models/model.hpp"
#include "solvers/radau_run.hpp"
#include "solvers/taylor_run.hpp"

namespace polhode {
namespace {

// Rates of a tumbling body have poles at a distance of about 1.5/|w| in complex time: at the end of half a
// radian, a polynomial through 7 Radau nodes errs by 12^-13.
constexpr double radians_a_stretch = 0.5;
constexpr int order = 20;
constexpr double log2_tolerance = -62;
constexpr int implicit_stages = 11;
constexpr double implicit_tolerance = 1e-17;
constexpr std::int64_t step_limit = 1000;  // from one asked time, or mark, to the next

// Decays that are so many times faster than the motion are stepped over: an explicit series goes 2.4 decay
// times a step.
constexpr double stiff_ratio = 30;

Sensitivity::Path closed_path(std::shared_ptr<ClosedForm<double>> form, const ErasedModel& model) {
  const bool attitude = model.has_attitude();
  const std::vector<double> initial(model.initial().begin(), model.initial().end());
  // Where the centre of mass is does not matter to a disturbance of the rotation.
  return [form, attitude, initial](std::span<const double> times, auto& states) {
    for (std::size_t i = 0; i < times.size(); ++i) {
      const ExactState<double> x = form->at(times[i]);
      auto y = states.col(static_cast<int>(i));
      y = Eigen::Map<const Eigen::VectorXd>(initial.data(), static_cast<Eigen::Index>(initial.size()));
      if (attitude) y.template head<4>() << x.q.w(), x.q.x(), x.q.y(), x.q.z();
      y.template segment<3>(attitude ? 4 : 0) = x.w_B;
    }
    return states.allFinite();
  };
}

/// By Taylor series: the times of several stretches are read off one step.
template <class M>
class SeriesPath {
 public:
  using S = typename M::Scalar;
  explicit SeriesPath(const M& m) : series_(m, order), y_(m.initial) {
    series_.settle_signs(t_, y_);
    expand();
  }

  bool follow(std::span<const double> times, Eigen::MatrixXd& states) {
    int steps = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
      for (; S(times[i]) > t_ + h_; expand()) {
        if (++steps > step_limit || !(t_ + h_ > t_)) return false;
        y_ = series_.at(h_);
        t_ += h_;
        if (crossed_ >= 0) series_.flip_sign(crossed_);
      }
      const typename M::State y = series_.at(S(times[i]) - t_);
      for (std::size_t k = 0; k < y.size(); ++k)
        states(static_cast<int>(k), static_cast<int>(i)) = static_cast<double>(y[k]);
    }
    return states.allFinite();
  }

 private:
  void expand() {
    series_.expand(t_, y_);
    h_ = series_.first_sign_change(S(series_step(series_, log2_tolerance)), crossed_);
  }

  TaylorSeries<M> series_;
  S t_{0}, h_{0};
  typename M::State y_;
  int crossed_ = -1;
};

/// By Radau IIA.
template <class M>
class ImplicitPath {
 public:
  using S = typename M::Scalar;
  ImplicitPath(const M& m, const Scene& scene)
      : m_(m), doubles_(erased_model(scene)), run_(m_, *doubles_, implicit_stages), y_(m.initial) {}

  bool follow(std::span<const double> times, Eigen::MatrixXd& states) {
    int i = 0;
    const auto keep = [&](const S&, std::span<const S> y) {
      for (std::size_t k = 0; k < y.size(); ++k) states(static_cast<int>(k), i) = static_cast<double>(y[k]);
      ++i;
    };
    return run_.run(t_, y_, times, implicit_tolerance, step_limit, keep) >= 0 && states.allFinite();
  }

 private:
  M m_;
  std::unique_ptr<ErasedModel> doubles_;
  RadauRun<S> run_;
  S t_{0};
  typename M::State y_;
};

Sensitivity::Path stepped_path(const Scene& scene, bool stiff) {
  return with_general_model<long double>(scene, [&](const auto& m) -> Sensitivity::Path {
    using M = std::remove_cvref_t<decltype(m)>;
    if constexpr (M::has_rotation) {
      const auto by = [](auto path) -> Sensitivity::Path {
        return [path](auto times, auto& states) { return path->follow(times, states); };
      };
      if (stiff) return by(std::make_shared<ImplicitPath<M>>(m, scene));
      return by(std::make_shared<SeriesPath<M>>(m));
    } else {
      return {};
    }
  });
}

/// The 6x6 matrix of the equations of disturbances.
DisturbanceMap jacobian(const ErasedModel& model, double t, const double* y) {
  const bool attitude = model.has_attitude();
  const int w_at = attitude ? 4 : 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 13, 13> J(model.size(), model.size());
  model.jacobian(t, y, J.data());
  DisturbanceMap all = DisturbanceMap::Zero();
  all.bottomRightCorner<3, 3>() = J.block<3, 3>(w_at, w_at);
  if (attitude) {
    // dq = 1/2 q (0, theta)
    Eigen::Matrix<double, 4, 3> turn;
    turn << -y[1], -y[2], -y[3], y[0], -y[3], y[2], y[3], y[0], -y[1], -y[2], y[1], y[0];
    all.topLeftCorner<3, 3>() = -hat<double>(Vec3(y[4], y[5], y[6]));
    all.topRightCorner<3, 3>().setIdentity();
    all.bottomLeftCorner<3, 3>() = J.block<3, 4>(4, 0) * (0.5 * turn);
  }
  return all;
}

/// How fast the motion is and its disturbances oscillate or grow, and how fast they die out, 1/s.
struct Speeds {
  double motion, decay;
};
Speeds speeds(const ErasedModel& model, double t, const Eigen::VectorXd& y) {
  const int w_at = model.has_attitude() ? 4 : 0;
  Eigen::VectorXd slope(y.size());
  model.rhs(t, y.data(), slope.data());
  // From rest there is no rate yet, only its change.
  Speeds s{std::max(y.segment<3>(w_at).norm(), std::sqrt(slope.segment<3>(w_at).norm())), 0};
  for (const auto& lambda : jacobian(model, t, y.data()).eigenvalues()) {
    s.motion = std::max({s.motion, std::abs(lambda.imag()), lambda.real()});
    s.decay = std::max(s.decay, -lambda.real());
  }
  return s;
}

Eigen::VectorXd start_of(const ErasedModel& model) {
  return Eigen::Map<const Eigen::VectorXd>(model.initial().data(), model.size());
}

Sensitivity::Path path_of(const Scene& scene, std::shared_ptr<ClosedForm<double>> form,
                          const ErasedModel& model) {
  if (form) return closed_path(std::move(form), model);
  const Speeds s = speeds(model, 0, start_of(model));
  return stepped_path(scene, s.decay > stiff_ratio * s.motion);
}

/// Weights of Lagrange's interpolation at t.
template <class Times>
Times interpolation(const Times& times, double t) {
  Times weights;
  for (std::size_t i = 0; i < times.size(); ++i) {
    weights[i] = 1;
    for (std::size_t j = 0; j < times.size(); ++j)
      if (j != i) weights[i] *= (t - times[j]) / (times[i] - times[j]);
  }
  return weights;
}

}  // namespace

DisturbanceMap Stretch::map_to(double t) const {
  const auto weights = interpolation(times, t);
  DisturbanceMap sum = DisturbanceMap::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * maps[i];
  return sum;
}

Vec3 Stretch::rates_at(double t) const {
  const auto weights = interpolation(times, t);
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < weights.size(); ++i) sum += weights[i] * rates[i];
  return sum;
}

Sensitivity::Sensitivity(const Scene& scene)
    : model_(erased_model(scene)),
      path_(path_of(scene, closed_form<double>(scene), *model_)),
      table_(Stretch::stages),
      y_(start_of(*model_)) {
  // A first stretch as short as the fastest decay; each later one is at most twice as long as that before it.
  const Speeds s = speeds(*model_, 0, y_);
  const double fastest = std::max(s.decay, s.motion);
  h_ = fastest > 0 ? radians_a_stretch / fastest : 1;
}

std::optional<Stretch> Sensitivity::next(double latest) {
  Stretch s;
  s.begin = s.times[0] = t_;
  const double h = t_ > 0 ? std::min(2 * h_, radians_a_stretch / speeds(*model_, t_, y_).motion) : h_;
  s.end = std::min(t_ + h, latest);
  if (!(s.end > t_)) return {};
  for (std::size_t i = 0; i < Stretch::stages; ++i) s.times[i + 1] = t_ + table_.c[i] * (s.end - t_);
  s.times.back() = s.end;
  Eigen::MatrixXd states(model_->size(), Stretch::stages + 1);
  states.col(0) = y_;
  Eigen::MatrixXd later(model_->size(), Stretch::stages);
  if (!path_(std::span(s.times).subspan(1), later)) return {};
  states.rightCols<Stretch::stages>() = later;
  solve(s, states);
  t_ = s.end;
  h_ = h;
  y_ = later.rightCols<1>();
  return s;
}

void Sensitivity::solve(Stretch& s, const Eigen::MatrixXd& states) const {
  constexpr int n = Stretch::stages;
  // In units of the stretch: rates in radians a stretch, so that all entries are comparable.
  const double h = s.end - s.begin;
  Eigen::Matrix<double, 6, 1> unit;
  unit << 1, 1, 1, h, h, h;
  const int w_at = model_->has_attitude() ? 4 : 0;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(6 * n, 6 * n), maps(6 * n, 6);
  for (int j = 0; j < n; ++j) {
    const DisturbanceMap J = h * unit.asDiagonal() *
                             jacobian(*model_, s.times[std::size_t(j + 1)], states.col(j + 1).data()) *
                             unit.cwiseInverse().asDiagonal();
    for (int i = 0; i < n; ++i) matrix.block<6, 6>(6 * i, 6 * j) -= table_.a(i, j) * J;
    maps.block<6, 6>(6 * j, 0).setIdentity();
  }
  maps = matrix.partialPivLu().solve(maps).eval();
  s.maps[0].setIdentity();
  for (int j = 0; j < n; ++j)
    s.maps[std::size_t(j + 1)] =
        unit.cwiseInverse().asDiagonal() * maps.block<6, 6>(6 * j, 0) * unit.asDiagonal();
  for (int j = 0; j <= n; ++j) s.rates[std::size_t(j)] = states.col(j).segment<3>(w_at);
}

std::optional<std::vector<Turning>> motion_of_doubles(const Scene& scene, std::span<const double> times) {
  const auto model = erased_model(scene);
  const int w_at = model->has_attitude() ? 4 : 0;
  const Sensitivity::Path path = path_of(scene, closed_form_extended(scene), *model);
  std::vector<Turning> all;
  Eigen::MatrixXd state(model->size(), 1);
  for (const double& t : times) {
    if (!path(std::span(&t, 1), state)) return {};
    Turning& x = all.emplace_back();
    if (w_at > 0) x.q = Quaternion(state(0), state(1), state(2), state(3));
    x.w_B = Vec3(state(w_at), state(w_at + 1), state(w_at + 2));
  }
  return all;
}

}  // namespace polhode
