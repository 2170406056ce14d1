// The Taylor series of a model's solution about a state, of any order, in any number type.
#pragma once
#include <cmath>
#include <string>
#include <vector>

#include "models/body.hpp"
#include "models/jet.hpp"

namespace polhode {

/// Records the equations of a model once; `expand` then gives the series about any state.
template <class M>
class TaylorSeries {
 public:
  using S = typename M::Scalar;
  using State = typename M::State;
  static constexpr int size = M::size;

  TaylorSeries(const M& m, int order) : order_(order) {
    using J = Jet<S>;
    using Op = typename Tape<S>::Op;
    std::array<J, size> y, d;
    for (J& x : y) x = J(&tape_, tape_.record(Op::input));
    const J t(&tape_, tape_.record(Op::input));
    m.rhs(t, y.data(), d.data());
    for (const J& x : d) rhs_.push_back(x);
    for (std::size_t i = 0; i < tape_.nodes().size(); ++i)
      if (tape_.nodes()[i].op == Op::sign) signs_.push_back(static_cast<int>(i));
    tape_.prepare(order);
  }

  /// Coefficients 0..order of the solution through (t, y).
  void expand(const S& t, const State& y) {
    for (int i = 0; i < size; ++i) tape_.at(i, 0) = y[static_cast<std::size_t>(i)];
    tape_.at(size, 0) = t;
    if (order_ > 0) tape_.at(size, 1) = S(1);
    for (int k = 0; k < order_; ++k) {
      tape_.play(k);
      for (int i = 0; i < size; ++i) {
        const Jet<S>& d = rhs_[static_cast<std::size_t>(i)];
        const S slope = d.is_constant() ? (k == 0 ? d.value() : S(0)) : tape_.at(d.node(), k);
        tape_.at(i, k + 1) = slope / S(k + 1);
      }
    }
  }

  const S* coefficients(int i) const { return tape_.series(i); }
  int order() const { return order_; }
  Tape<S>& tape() { return tape_; }

  /// The state at a distance h from the point of expansion.
  State at(const S& h) const {
    State y;
    for (int i = 0; i < size; ++i) y[static_cast<std::size_t>(i)] = horner(i, h);
    return y;
  }

  /// The state there less the state at the point of expansion.
  State change(const S& h) const {
    State y;
    for (int i = 0; i < size; ++i) {
      const S* c = tape_.series(i);
      S sum = c[order_];
      for (int k = order_ - 1; k >= 1; --k) sum = sum * h + c[k];
      y[static_cast<std::size_t>(i)] = sum * h;
    }
    return y;
  }

  /// Sets every held sign to that of its argument at (t, y): at the start of a run.
  void settle_signs(const S& t, const State& y) {
    if (signs_.empty()) return;
    expand(t, y);
    for (const int s : signs_) {
      auto& node = tape_.nodes()[static_cast<std::size_t>(s)];
      node.constant = tape_.at(node.a, 0) < S(0) ? S(-1) : S(1);
    }
  }

  /// Distance in (0, h] at which the first held sign changes, or h if none does; `crossed` receives its node.
  S first_sign_change(const S& h, int& crossed) const {
    S until = h;
    crossed = -1;
    for (const int s : signs_) {
      const auto& node = const_cast<Tape<S>&>(tape_).nodes()[static_cast<std::size_t>(s)];
      if (!(horner(node.a, until) * node.constant < S(0))) continue;
      S low(0), high = until;
      for (int i = 0; i < 200; ++i) {
        const S middle = (low + high) / S(2);
        (horner(node.a, middle) * node.constant < S(0) ? high : low) = middle;
      }
      until = high;
      crossed = s;
    }
    return until;
  }
  /// The held signs, one character each, and back: what a step needs besides t and y.
  std::string held_signs() {
    std::string held;
    for (const int s : signs_) held += tape_.nodes()[static_cast<std::size_t>(s)].constant < S(0) ? '-' : '+';
    return held;
  }
  void hold_signs(const std::string& held) {
    for (std::size_t i = 0; i < signs_.size() && i < held.size(); ++i)
      tape_.nodes()[static_cast<std::size_t>(signs_[i])].constant = S(held[i] == '-' ? -1 : 1);
  }
  void flip_sign(int node) {
    auto& n = tape_.nodes()[static_cast<std::size_t>(node)];
    n.constant = -n.constant;
  }

 private:
  S horner(int node, const S& h) const {
    const S* c = tape_.series(node);
    // Nodes that are not state have one coefficient less.
    S sum = c[order_];
    for (int k = order_ - 1; k >= 0; --k) sum = sum * h + c[k];
    return sum;
  }

  int order_;
  Tape<S> tape_;
  std::vector<Jet<S>> rhs_;
  std::vector<int> signs_;
};

}  // namespace polhode
