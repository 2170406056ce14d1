// The plane pendulum phi'' = -Omega^2 sin phi, in any number type: phi/2 is the amplitude of a Jacobi
// function.
//
//   libration   sin(phi/2) = k sn(Omega t + u0, k),  k^2 = sin^2(phi_0/2) + (phi_0'/(2 Omega))^2 < 1
//   rotation    phi/2 = am(k Omega t + u0, 1/k),     k^2 > 1
//
// Source: DLMF 22.19(i).
#pragma once
#include <optional>

#include "models/jacobi.hpp"

namespace polhode {

template <class S>
class Pendulum {
 public:
  struct State {
    S sine, cosine;  // of phi/2
    S rate;          // phi'
  };

  /// omega        Omega > 0 [1/s]
  /// sine, cosine of phi/2 at t = 0;   rate   phi' at t = 0
  Pendulum(const S& omega, const S& sine, const S& cosine, const S& rate) : omega_(omega) {
    using std::sqrt;
    const S half = rate / (S(2) * omega), m = sine * sine + half * half;
    energy_gap_ = cosine * cosine - half * half;  // 1 - k^2, from terms that are squares of data
    k_ = sqrt(m);
    if (librates()) {
      direction_ =
          S(cosine < S(0) ? -1 : 1);  // phi and phi + 2 pi have opposite signs of sin and cos of half
      if (!(k_ > S(0))) return;       // at rest
      functions_.emplace(m, energy_gap_);
      start_ = functions_->argument(S(direction_ * sine), half);
    } else if (rotates()) {
      direction_ = S(rate < S(0) ? -1 : 1);
      functions_.emplace(S(S(1) / m), S(-energy_gap_ / m));
      start_ = functions_->argument(S(direction_ * sine), cosine);
    }
  }

  bool librates() const { return energy_gap_ > S(0); }
  bool rotates() const { return energy_gap_ < S(0); }

  State at(const S& t) const {
    if (librates()) {
      if (!(k_ > S(0))) return {S(0), direction_, S(0)};
      const auto x = functions_->at(S(omega_ * t + start_));
      return {direction_ * k_ * x.sn, direction_ * x.dn, S(2) * k_ * omega_ * x.cn};
    }
    const auto x = functions_->at(S(k_ * omega_ * t + start_));
    return {direction_ * x.sn, x.cn, direction_ * S(2) * k_ * omega_ * x.dn};
  }

 private:
  S omega_, k_, energy_gap_, start_{0}, direction_{1};
  std::optional<JacobiFunctions<S>> functions_;
};

}  // namespace polhode
