// The inner loop of every series: a sum of products of coefficients. Wide types have one of their own
// (models/wide.hpp), which makes no temporary numbers.
#pragma once

namespace polhode {

template <class S>
struct Convolution {
  /// Sum of a[j] b[k - j], j = first ... last; zero if there are none.
  void operator()(S& sum, const S* a, const S* b, int k, int first, int last) const {
    sum = S(0);
    for (int j = first; j <= last; ++j) sum += a[j] * b[k - j];
  }
};

}  // namespace polhode
