// Taylor series of a solution, from the equations as they are written once.
//
// Calling a model's right-hand side with `Jet` numbers records its operations on a tape. The tape is then
// played order by order: coefficient k of every node follows from coefficients 0..k of its operands, and the
// state's own coefficient k + 1 is the right-hand side's coefficient k over k + 1. Nothing is derived by
// hand, so a new load needs no recurrence of its own.
//
//   (ab)_k = sum a_j b_{k-j};  r = 1/a: r_k = -(sum_{j>=1} a_j r_{k-j})/a_0;
//   s = sqrt a: s_k = (a_k - sum_{0<j<k} s_j s_{k-j})/(2 s_0);
//   s = sin a, c = cos a: k s_k = sum j a_j c_{k-j}, k c_k = -sum j a_j s_{k-j}
//
// Source: Jorba & Zou, A software package for the numerical integration of ODEs by means of high-order Taylor
// methods, Exp. Math. 14 (2005), section 2.
#pragma once
#include <cassert>
#include <cmath>
#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "models/attitude.hpp"
#include "models/convolution.hpp"

namespace polhode {

/// The recorded operations and, once played, the coefficients of every node.
template <class S>
class Tape {
 public:
  enum class Op { input, add, add_constant, scale, multiply, reciprocal, square_root, sine, cosine, sign };
  struct Node {
    Op op;
    int a = -1, b = -1;  // operands
    S constant{};        // of add_constant and scale; the held value of sign
  };

  int record(Op op, int a = -1, int b = -1, const S& constant = S(0)) {
    nodes_.push_back({op, a, b, constant});
    return static_cast<int>(nodes_.size()) - 1;
  }

  /// Room for coefficients 0..order of every node.
  void prepare(int order) {
    stride_ = static_cast<std::size_t>(order) + 1;
    coefficients_.assign(nodes_.size() * stride_, S(0));
  }

  S& at(int node, int k) {
    return coefficients_[static_cast<std::size_t>(node) * stride_ + static_cast<std::size_t>(k)];
  }
  const S* series(int node) const { return &coefficients_[static_cast<std::size_t>(node) * stride_]; }

  /// Coefficient k of every node but the inputs, whose coefficients up to k the caller has set.
  void play(int k) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const Node& n = nodes_[i];
      if (n.op == Op::input) continue;
      S* const r = &coefficients_[i * stride_];
      const S* const a = series(n.a);
      switch (n.op) {
        case Op::input:
          break;
        case Op::add:
          r[k] = a[k] + series(n.b)[k];
          break;
        case Op::add_constant:
          r[k] = k == 0 ? S(a[0] + n.constant) : a[k];
          break;
        case Op::scale:
          r[k] = a[k] * n.constant;
          break;
        case Op::multiply: {
          if (n.a == n.b) {  // each product of two different coefficients occurs twice
            convolve_(r[k], a, a, k, 0, (k + 1) / 2 - 1);
            r[k] += r[k];
            if (k % 2 == 0) r[k] += a[k / 2] * a[k / 2];
          } else {
            convolve_(r[k], a, series(n.b), k, 0, k);
          }
          break;
        }
        case Op::reciprocal: {
          if (k == 0) {
            r[0] = S(1) / a[0];
            break;
          }
          convolve_(sum_, a, r, k, 1, k);
          r[k] = -sum_ * r[0];
          break;
        }
        case Op::square_root: {
          using std::sqrt;
          if (k == 0) {
            r[0] = sqrt(a[0]);
            break;
          }
          convolve_(sum_, r, r, k, 1, k - 1);
          r[k] = (a[k] - sum_) / (S(2) * r[0]);
          break;
        }
        case Op::sine:
        case Op::cosine: {  // n.b is the partner, cosine of a sine and sine of a cosine
          using std::cos;
          using std::sin;
          if (k == 0) {
            r[0] = n.op == Op::sine ? S(sin(a[0])) : S(cos(a[0]));
            break;
          }
          const S* const partner = series(n.b);
          S sum(0);
          for (int j = 1; j <= k; ++j) sum += S(j) * a[j] * partner[k - j];
          r[k] = (n.op == Op::sine ? sum : S(-sum)) / S(k);
          break;
        }
        case Op::sign:
          r[k] = k == 0 ? n.constant : S(0);
          break;
      }
    }
  }

  std::vector<Node>& nodes() { return nodes_; }

 private:
  std::vector<Node> nodes_;
  Convolution<S> convolve_;
  S sum_{0};
  std::size_t stride_ = 0;
  std::vector<S> coefficients_;
};

/// A number while a right-hand side is recorded: a constant, or a node of the tape.
template <class S>
class Jet {
 public:
  using Number = S;
  Jet() = default;
  template <class C>
  requires std::is_convertible_v<C, S> Jet(const C& constant)
      : value_(constant) {}  // NOLINT(google-explicit-constructor): numbers convert
  Jet(Tape<S>* tape, int node) : tape_(tape), node_(node) {}

  bool is_constant() const { return tape_ == nullptr; }
  int node() const { return node_; }
  Tape<S>* tape() const { return tape_; }
  const S& value() const { return value_; }

  friend Jet operator+(const Jet& a, const Jet& b) {
    if (a.is_constant() && b.is_constant()) return Jet(S(a.value_ + b.value_));
    if (a.is_constant()) return b + a;
    if (b.is_constant())
      return b.value_ == S(0)
                 ? a
                 : Jet(a.tape_, a.tape_->record(Tape<S>::Op::add_constant, a.node_, -1, b.value_));
    return Jet(a.tape_, a.tape_->record(Tape<S>::Op::add, a.node_, b.node_));
  }
  friend Jet operator*(const Jet& a, const Jet& b) {
    if (a.is_constant() && b.is_constant()) return Jet(S(a.value_ * b.value_));
    if (a.is_constant()) return b * a;
    if (b.is_constant()) {
      if (b.value_ == S(0)) return Jet(S(0));
      if (b.value_ == S(1)) return a;
      return Jet(a.tape_, a.tape_->record(Tape<S>::Op::scale, a.node_, -1, b.value_));
    }
    return Jet(a.tape_, a.tape_->record(Tape<S>::Op::multiply, a.node_, b.node_));
  }
  friend Jet operator/(const Jet& a, const Jet& b) {
    if (b.is_constant()) return a * Jet(S(S(1) / b.value_));
    return a * Jet(b.tape_, b.tape_->record(Tape<S>::Op::reciprocal, b.node_));
  }
  friend Jet operator-(const Jet& a) { return a * Jet(S(-1)); }
  friend Jet operator-(const Jet& a, const Jet& b) { return a + (-b); }
  Jet& operator+=(const Jet& b) { return *this = *this + b; }
  Jet& operator-=(const Jet& b) { return *this = *this - b; }
  Jet& operator*=(const Jet& b) { return *this = *this * b; }

  friend Jet sqrt(const Jet& a) {
    using std::sqrt;
    if (a.is_constant()) return Jet(S(sqrt(a.value_)));
    return Jet(a.tape_, a.tape_->record(Tape<S>::Op::square_root, a.node_));
  }
  friend Jet sin(const Jet& a) { return circular(a, Tape<S>::Op::sine); }
  friend Jet cos(const Jet& a) { return circular(a, Tape<S>::Op::cosine); }
  /// +1 or -1, held until the integrator says that its argument has crossed zero.
  friend Jet sign_of(const Jet& a) {
    if (a.is_constant()) return Jet(S(a.value_ < S(0) ? -1 : 1));
    return Jet(a.tape_, a.tape_->record(Tape<S>::Op::sign, a.node_, -1, S(1)));
  }

 private:
  static Jet circular(const Jet& a, typename Tape<S>::Op wanted) {
    using std::cos;
    using std::sin;
    using Op = typename Tape<S>::Op;
    if (a.is_constant()) return Jet(wanted == Op::sine ? S(sin(a.value_)) : S(cos(a.value_)));
    const int sine = a.tape_->record(Op::sine, a.node_), cosine = a.tape_->record(Op::cosine, a.node_, sine);
    a.tape_->nodes()[static_cast<std::size_t>(sine)].b = cosine;
    return Jet(a.tape_, wanted == Op::sine ? sine : cosine);
  }

  Tape<S>* tape_ = nullptr;
  int node_ = -1;
  S value_ = S(0);
};

/// R(q)^T a_S of a unit quaternion: a - w t + u x t, t = 2 u x a. A series knows that |q| = 1 of its own
/// state, to what its steps leave of it, and does without the reciprocal and seven products that any other q
/// needs.
template <class J>
requires std::is_same_v<J, Jet<typename J::Number>> Vec3T<J> to_body(const QuaternionT<J>& q,
                                                                     const Vec3T<J>& a_S) {
  const Vec3T<J> u(q.x(), q.y(), q.z());
  const bool constant =
      q.w().is_constant() && u.x().is_constant() && u.y().is_constant() && u.z().is_constant();
  const J twice = constant ? J(2) / squared_norm(q) : J(2);
  Vec3T<J> t = u.cross(a_S);
  for (int i = 0; i < 3; ++i) t[i] = t[i] * twice;
  const Vec3T<J> c = u.cross(t);
  return Vec3T<J>(a_S.x() - q.w() * t.x() + c.x(), a_S.y() - q.w() * t.y() + c.y(),
                  a_S.z() - q.w() * t.z() + c.z());
}

}  // namespace polhode

namespace Eigen {
template <class S>
struct NumTraits<polhode::Jet<S>> : GenericNumTraits<polhode::Jet<S>> {
  using Real = polhode::Jet<S>;
  using NonInteger = polhode::Jet<S>;
  using Nested = polhode::Jet<S>;
  using Literal = polhode::Jet<S>;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 4,
    AddCost = 20,
    MulCost = 40
  };
};
}  // namespace Eigen
