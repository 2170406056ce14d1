// What every truth does with its states: samples, the difference of two runs as uncertainty, words to keep.
#pragma once
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <string_view>

#include "models/model.hpp"
#include "solvers/exact_motion.hpp"

namespace polhode {

template <class M>
WideSample wide_sample(const M& m, const Wide& t, const typename M::State& y) {
  WideSample s;
  s.t = t;
  if constexpr (M::has_attitude) s.q = normalised<Wide>(m.rotation.attitude_of(y.data()));
  if constexpr (M::has_rotation) {
    s.w_B = m.rotation.w_of(y.data());
    s.L = m.angular_momentum(y.data());
  }
  if constexpr (M::has_translation) {
    s.p = m.position(y.data());
    s.v = m.velocity(y.data());
  }
  s.rotational_energy = m.rotational_energy(y.data());
  s.total_energy = m.total_energy(t, y.data());
  return s;
}

/// The difference of a sample to (q, w_B), where that is larger than what u says. Rates slower than `least`
/// count as zero.
inline void widen(ExactMotion::Uncertainty& u, const WideSample& s, const QuaternionT<Wide>& q,
                  const Vec3T<Wide>& w_B, const Wide& least) {
  // Not std::max: what is not a number stays, and is refused.
  const auto larger = [](double a, double b) { return std::isnan(a) || a >= b ? a : b; };
  u.attitude = larger(u.attitude, attitude_error<Wide>(s.q, q).convert_to<double>());
  const Wide scale = std::max(Wide(s.w_B.norm()), least);
  if (scale != 0) u.rate = larger(u.rate, Wide((s.w_B - w_B).norm() / scale).convert_to<double>());
}

/// Below it a rate has died out, or is what rounding leaves of rest: 1e-30 of the fastest, or of what the
/// loads could bring about (solvers/second_method.hpp).
inline Wide least_rate(std::span<const WideSample> samples, double natural) {
  Wide fastest(natural);
  for (const WideSample& s : samples) fastest = std::max(fastest, Wide(s.w_B.norm()));
  return Wide(1e-30) * fastest;
}

/// Numbers of a saved motion as words, digit by digit, and back.
class Words {
 public:
  void add(const Wide& x) { text += x.str(0, std::ios_base::scientific) + ' '; }
  void add(std::int64_t n) { text += std::to_string(n) + ' '; }
  void add(const std::string& word) { text += word + ' '; }

  std::string text;
};
class WordReader {
 public:
  explicit WordReader(std::string_view text) : text_(text) {}
  std::string word() {
    const std::size_t end = std::min(text_.find(' '), text_.size());
    std::string w(text_.substr(0, end));
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (w.empty()) throw std::invalid_argument("a saved motion ends early");
    return w;
  }
  Wide number() { return Wide(word()); }
  std::int64_t integer() { return std::stoll(word()); }

 private:
  std::string_view text_;
};

}  // namespace polhode
