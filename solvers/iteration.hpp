// Fixed-point iteration to rounding: how the implicit steps that contract are solved.
#pragma once
#include <cstdint>
#include <limits>

namespace polhode {

/// Has an iteration come to rest? To be told of each change.
class Settling {
 public:
  /// rounding: the change that means nothing, an ulp of what is iterated
  /// finest: the change at which to stop, if that is less
  explicit Settling(double rounding) : Settling(rounding, rounding) {}
  Settling(double rounding, double finest) : rounding_(rounding), finest_(finest) {}

  /// True when the last change is at most the finest, or a few ulp and no longer shrinking.
  bool at_rest(double change) {
    ++changes_;
    const bool rest = change <= finest_ || (changes_ > 4 && change < 8 * rounding_ && change >= last_);
    contraction_ = change / last_;
    last_ = change;
    return rest;
  }
  /// The last change over the one before it: an estimate of the contraction factor once a few were seen.
  bool slower_than(double factor) const { return changes_ > 3 && !(contraction_ < factor); }

 private:
  double rounding_, finest_, last_ = std::numeric_limits<double>::infinity(), contraction_ = 0;
  int changes_ = 0;
};

/// An ulp of the largest component of x, and not zero.
template <class Vector>
double ulp_of(const Vector& x) {
  return 2.2e-16 * (x.cwiseAbs().maxCoeff() + 1e-300);
}

/// x <- map(x) until it rests; false if 200 times are not enough. Adds the calls to `calls`.
template <class Vector, class Map>
bool iterate_to_rounding(Vector& x, std::int64_t& calls, const Map& map) {
  Settling settling(ulp_of(x));
  for (int i = 0; i < 200; ++i) {
    const Vector next = map(x);
    ++calls;
    const double change = (next - x).cwiseAbs().maxCoeff();
    x = next;
    if (settling.at_rest(change)) return true;
  }
  return false;
}

}  // namespace polhode
