// The wide number types of every truth: software arithmetic of a fixed number of decimal digits, correctly
// rounded (MPFR).
//
// Wide has 50 digits (168 bits). 113 bits would be enough for the arithmetic, but not for bodies near the
// separatrix, whose motion amplifies a rounding error by 1e10 and more: 30 digits of result then need more
// than 34 digits of arithmetic. Exponents have 31 bits and more, so that no square of a double's range
// vanishes or overflows. A number without a value is not a number, not zero.
#pragma once
#include <limits>

#include <Eigen/Core>
#include <boost/multiprecision/mpfr.hpp>

#include "models/convolution.hpp"
#include "models/limb_sum.hpp"
#include "models/momentum_excess.hpp"

namespace polhode {
template <unsigned decimal_digits>
using Decimal = boost::multiprecision::number<
    boost::multiprecision::mpfr_float_backend<decimal_digits, boost::multiprecision::allocate_stack>,
    boost::multiprecision::et_off>;
using Wide = Decimal<50>;
using Narrower = Decimal<40>;   // what a closed form in Wide is checked against
using Resolved = Decimal<200>;  // in which a scene file is resolved, before it is rounded to Wide

/// MPFR keeps constants, pi say, for each thread. To be called by one that computes in these types: its
/// constants go when it ends.
inline void give_back_wide_constants() {
  struct Constants {
    ~Constants() { mpfr_free_cache(); }
  };
  thread_local const Constants constants;
  static_cast<void>(constants);
}

/// A sum of products of five numbers, exactly.
template <unsigned decimal_digits>
struct ExactProducts<Decimal<decimal_digits>> {
  using Type = Decimal<6 * decimal_digits>;
};

template <unsigned decimal_digits>
struct Convolution<Decimal<decimal_digits>> {
  using S = Decimal<decimal_digits>;
  static constexpr bool in_limbs =
      std::numeric_limits<S>::digits <= 192 && std::numeric_limits<S>::digits > 128 && GMP_NUMB_BITS == 64;
  void operator()(S& sum, const S* a, const S* b, int k, int first, int last) {
    if constexpr (in_limbs) {
      sum_.add_all(sum.backend().data(), a, b, k, first, last);
    } else {
      mpfr_ptr total = sum.backend().data(), product = product_.backend().data();
      mpfr_set_zero(total, 1);
      for (int j = first; j <= last; ++j) {
        mpfr_mul(product, a[j].backend().data(), b[k - j].backend().data(), MPFR_RNDN);
        mpfr_add(total, total, product, MPFR_RNDN);
      }
    }
  }

 private:
  S product_{0};
  LimbSum sum_;
};
}  // namespace polhode

namespace Eigen {
template <unsigned decimal_digits>
struct NumTraits<polhode::Decimal<decimal_digits>> : GenericNumTraits<polhode::Decimal<decimal_digits>> {
  using Real = polhode::Decimal<decimal_digits>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = double;
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
