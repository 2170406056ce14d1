#include "solvers/second_method.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace polhode {
namespace {

using V = Vec3T<Checked>;
using Q = QuaternionT<Checked>;
using M = Mat3T<Checked>;

/// The rotation matrix of a quaternion of any length, by its nine products.
M matrix_of(const Q& q) {
  const Checked &w = q.w(), &x = q.x(), &y = q.y(), &z = q.z();
  const Checked s = 2 / (w * w + x * x + y * y + z * z);
  M R;
  R << 1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y), s * (x * y + w * z),
      1 - s * (x * x + z * z), s * (y * z - w * x), s * (x * z - w * y), s * (y * z + w * x),
      1 - s * (x * x + y * y);
  return R;
}

V cross(const V& a, const V& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Q q_of(const std::array<Checked, 13>& x) { return {x[0], x[1], x[2], x[3]}; }
V vector_at(const std::array<Checked, 13>& x, std::size_t i) { return {x[i], x[i + 1], x[i + 2]}; }

/// The attitude that a spring turns.
Q spring_attitude(const StatedLoad& load, const Q& q_SU) {
  return q_SU * load.frame.cast<Checked>().conjugate();
}

V local_vertical(const Checked& n, const Checked& t) { return {cos(Checked(n * t)), sin(Checked(n * t)), 0}; }

double norm_of(const V& v) { return v.norm().convert_to<double>(); }

}  // namespace

SecondMethod::SecondMethod(const ExactScene& exact)
    : rotates_(exact.stated.has_value()), moves_(exact.translation.has_value()) {
  if (rotates_) {
    oriented_ = exact.rotation->attitude;
    stated_ = *exact.stated;
    inertia_ = stated_.inertia_U.cast<Checked>();
    inverse_ = stated_.inverse_inertia_U.cast<Checked>();
    to_stated_ = stated_.principal_to_stated.cast<Checked>();
  }
  if (moves_) translation_ = cast_translation<Checked>(*exact.translation);
}

StatedState SecondMethod::start() const {
  StatedState s;
  s.x[0] = 1;
  if (rotates_) {
    const Q q = normalised<Checked>(stated_.q_SU.cast<Checked>());
    const V given = stated_.given.cast<Checked>();
    const M R = matrix_of(q);
    V w_U = given;
    if (stated_.form == StatedRates::space) w_U = R.transpose() * given;
    V L = R * (inertia_ * w_U);
    if (stated_.form == StatedRates::momentum) L = given;
    if (!oriented_) L = stated_.form == StatedRates::momentum ? V(R.transpose() * given) : V(inertia_ * w_U);
    if (oriented_) std::copy_n(std::array{q.w(), q.x(), q.y(), q.z()}.begin(), 4, s.x.begin());
    for (std::size_t i = 0; i < 3; ++i) s.x[4 + i] = L[static_cast<int>(i)];
  }
  if (moves_)
    for (std::size_t i = 0; i < 3; ++i) {
      s.x[7 + i] = translation_.p0[static_cast<int>(i)];
      s.x[10 + i] = translation_.v0[static_cast<int>(i)];
    }
  return s;
}

StatedState SecondMethod::stated(const WideSample& sample) const {
  StatedState s;
  s.x[0] = 1;
  if (rotates_) {
    const V w_U = matrix_of(to_stated_) * sample.w_B.cast<Checked>();
    V L = inertia_ * w_U;
    if (oriented_) {
      const Q q = sample.q.cast<Checked>() * to_stated_.conjugate();
      L = matrix_of(q) * L;
      std::copy_n(std::array{q.w(), q.x(), q.y(), q.z()}.begin(), 4, s.x.begin());
    }
    for (std::size_t i = 0; i < 3; ++i) s.x[4 + i] = L[static_cast<int>(i)];
  }
  if (moves_)
    for (std::size_t i = 0; i < 3; ++i) {
      s.x[7 + i] = sample.p[static_cast<int>(i)];
      s.x[10 + i] = sample.v[static_cast<int>(i)];
    }
  return s;
}

Vec3T<Checked> SecondMethod::rates_U(const StatedState& s) const {
  if (!rotates_) return V(0, 0, 0);
  return inverse_ * (oriented_ ? V(matrix_of(s.q()).transpose() * s.L()) : s.L());
}

Checked SecondMethod::rotational_energy(const StatedState& s) const {
  if (!rotates_) return 0;
  const V w = rates_U(s);
  return w.dot(V(inertia_ * w)) / 2;
}

Checked SecondMethod::potential_energy(const Checked& t, const StatedState& s) const {
  Checked sum = 0;
  for (const StatedLoad& load : stated_.loads) {
    const Checked number(load.number);
    if (load.kind == StatedLoad::Kind::gravity_about_pivot) {
      sum -= number * V(load.vector.cast<Checked>()).dot(V(matrix_of(s.q()) * load.center.cast<Checked>()));
    } else if (load.kind == StatedLoad::Kind::spring) {
      const Q q = spring_attitude(load, s.q());
      sum += 4 * number * (1 - abs(q.w()) / sqrt(squared_norm(q)));
    } else if (load.kind == StatedLoad::Kind::gravity_gradient) {
      const V r = matrix_of(s.q()).transpose() * local_vertical(number, t);
      sum += 3 * number * number / 2 * r.dot(V(inertia_ * r));
    }
  }
  return sum;
}

double SecondMethod::pace(const StatedState& s) const {
  double pace = 0;
  if (rotates_) {
    pace = norm_of(rates_U(s));
    const double least = 1 / inverse_.norm().convert_to<double>();  // about the least moment
    double largest = inertia_.norm().convert_to<double>();
    for (const StatedLoad& load : stated_.loads) {
      const double number = load.number.convert_to<double>(), damping = load.damping.convert_to<double>();
      double torque = norm_of(load.vector.cast<Checked>());
      if (load.kind == StatedLoad::Kind::gravity_about_pivot)
        torque *= number * norm_of(load.center.cast<Checked>());
      if (load.kind == StatedLoad::Kind::spring) torque = 2 * number;
      if (load.kind == StatedLoad::Kind::gravity_gradient) {
        torque = 3 * number * number * largest;
        pace += number;
      }
      pace += std::sqrt(torque / least) + (damping + load.matrix.norm().convert_to<double>()) / least;
    }
  }
  if (moves_) pace += Checked(translation_.drag / translation_.mass).convert_to<double>();
  return pace;
}

Vec3T<Checked> SecondMethod::torque_S(const Checked& t, const Values& x, const M& R, const V& w_U,
                                      int side) const {
  V sum(0, 0, 0);
  for (const StatedLoad& load : stated_.loads) {
    const V vector = load.vector.cast<Checked>();
    const Checked number(load.number);
    switch (load.kind) {
      case StatedLoad::Kind::gravity_about_pivot:  // r x F
        sum += cross(V(R * load.center.cast<Checked>()), V(number * vector));
        break;
      case StatedLoad::Kind::drag:
        sum -= R * (load.matrix.cast<Checked>() * w_U);
        break;
      case StatedLoad::Kind::spring: {
        const Q q = spring_attitude(load, q_of(x));
        const V u = matrix_of(load.frame.cast<Checked>()).transpose() * q.vec();
        sum -= R * V(2 * number * side / sqrt(squared_norm(q)) * u + Checked(load.damping) * w_U);
        break;
      }
      case StatedLoad::Kind::body_torque:
        sum += R * vector;
        break;
      case StatedLoad::Kind::space_torque:
        sum += vector;
        break;
      case StatedLoad::Kind::gravity_gradient: {
        const V r = local_vertical(number, t);
        sum += 3 * number * number * cross(r, V(R * (inertia_ * V(R.transpose() * r))));
        break;
      }
    }
  }
  return sum;
}

SecondMethod::Values SecondMethod::slope(const Checked& t, const Values& x, int side) const {
  Values d{};
  if (rotates_) {
    const M R = oriented_ ? matrix_of(q_of(x)) : M(M::Identity());
    const V L = vector_at(x, 4), w = inverse_ * V(R.transpose() * L);
    V change = torque_S(t, x, R, w, side);
    if (oriented_) {
      d[0] = -(x[1] * w[0] + x[2] * w[1] + x[3] * w[2]) / 2;
      d[1] = (x[0] * w[0] + x[2] * w[2] - x[3] * w[1]) / 2;
      d[2] = (x[0] * w[1] + x[3] * w[0] - x[1] * w[2]) / 2;
      d[3] = (x[0] * w[2] + x[1] * w[1] - x[2] * w[0]) / 2;
    } else {
      change += cross(L, w);
    }
    for (std::size_t i = 0; i < 3; ++i) d[4 + i] = change[static_cast<int>(i)];
  }
  if (moves_)
    for (std::size_t i = 0; i < 3; ++i) {
      const auto k = static_cast<int>(i);
      d[7 + i] = x[10 + i];
      d[10 + i] = translation_.acceleration[k] - translation_.drag / translation_.mass * x[10 + i];
    }
  return d;
}

int SecondMethod::side(const StatedState& s, bool backward) const {
  for (const StatedLoad& load : stated_.loads) {
    if (load.kind != StatedLoad::Kind::spring) continue;
    const Q q = spring_attitude(load, s.q());
    if (q.w() != 0) return q.w() < 0 ? -1 : 1;
    const V w = matrix_of(load.frame.cast<Checked>()) * rates_U(s);
    const Checked change = -q.vec().dot(w) * (backward ? -1 : 1);
    return change < 0 ? -1 : 1;
  }
  return 1;
}

double natural_rate(const ExactScene& exact) {
  const SecondMethod second(exact);
  return second.pace(second.start());
}

SecondMethod::Reached SecondMethod::reached(const Checked& t, const StatedState& from, const Checked& h,
                                            int rows) const {
  const int held = side(from, h < 0);
  const Values& x0 = from.x;
  const Values at_start = slope(t, x0, held);
  std::vector<Values> row;  // of the tableau; its last entry is the most extrapolated
  std::vector<Values> diagonal;
  for (int k = 1; k <= rows; ++k) {
    const int n = 2 * k;
    const Checked step = h / n;
    Values before = x0, now;
    for (std::size_t i = 0; i < x0.size(); ++i) now[i] = x0[i] + step * at_start[i];
    for (int m = 1; m < n; ++m) {
      const Values d = slope(Checked(t + m * step), now, held);
      for (std::size_t i = 0; i < x0.size(); ++i) {
        const Checked next = before[i] + 2 * step * d[i];
        before[i] = now[i];
        now[i] = next;
      }
    }
    const Values d = slope(Checked(t + h), now, held);
    std::vector<Values> next(1);
    for (std::size_t i = 0; i < x0.size(); ++i) next[0][i] = (now[i] + before[i] + step * d[i]) / 2;
    for (std::size_t j = 1; j < static_cast<std::size_t>(k); ++j) {
      const Checked ratio = Checked(k) / (k - static_cast<int>(j)), factor = 1 / (ratio * ratio - 1);
      next.emplace_back();
      for (std::size_t i = 0; i < x0.size(); ++i)
        next[j][i] = next[j - 1][i] + (next[j - 1][i] - row[j - 1][i]) * factor;
    }
    row = std::move(next);
    diagonal.push_back(row.back());
  }
  // Neighbours on the diagonal tell the error of the less extrapolated one; two such differences tell by what
  // each further row reduces it.
  const std::size_t last = diagonal.size() - 1;
  const auto state = [](const Values& x) { return StatedState{x}; };
  const auto gap = [&](std::size_t a, std::size_t b) {
    const StatedState s = state(diagonal[a]), r = state(diagonal[b]);
    const V w = rates_U(s), other = rates_U(r);
    const double size = norm_of(w), way = norm_of(s.p()) + norm_of(s.v());
    const double rate = norm_of(V(w - other)), off = norm_of(V(s.p() - r.p())) + norm_of(V(s.v() - r.v()));
    return std::array{attitude_error<Checked>(s.q(), r.q()).convert_to<double>(),
                      size > 0 ? rate / size : rate, way > 0 ? off / way : off};
  };
  const auto now = gap(last, last - 1), before = gap(last - 1, last - 2);
  const auto error = [&](std::size_t i) {
    return before[i] > 0 ? now[i] * std::min(1.0, 100 * now[i] / before[i]) : now[i];
  };
  return {state(diagonal.back()), error(0), error(1), error(2)};
}

}  // namespace polhode
