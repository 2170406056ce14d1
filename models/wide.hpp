// The wide number type of every truth: 50 decimal digits (168 bits), software arithmetic, correctly rounded.
// 113 bits would be enough for the arithmetic, but not for bodies near the separatrix, whose motion amplifies
// a rounding error by 1e10 and more: 30 digits of result then need more than 34 digits of arithmetic.
#pragma once
#include <Eigen/Core>
#include <boost/multiprecision/cpp_bin_float.hpp>

namespace polhode {
using Wide =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>, boost::multiprecision::et_off>;
}  // namespace polhode

namespace Eigen {
template <>
struct NumTraits<polhode::Wide> : GenericNumTraits<polhode::Wide> {
  using Real = polhode::Wide;
  using NonInteger = polhode::Wide;
  using Nested = polhode::Wide;
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
