// The wide number type of every truth: 50 decimal digits (168 bits), software arithmetic, correctly rounded.
// 113 bits would be enough for the arithmetic, but not for bodies near the separatrix, whose motion amplifies
// a rounding error by 1e10 and more: 30 digits of result then need more than 34 digits of arithmetic.
#pragma once
#include <Eigen/Core>
#include <boost/multiprecision/cpp_bin_float.hpp>

namespace polhode {
template <unsigned decimal_digits>
using Decimal = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<decimal_digits>,
                                              boost::multiprecision::et_off>;
using Wide = Decimal<50>;
using Narrower = Decimal<40>;  // what a closed form in Wide is checked against
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
