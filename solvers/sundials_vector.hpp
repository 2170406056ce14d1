// A serial N_Vector of fixed length: the library's own vector with operations that know how many numbers they
// work on.
//
// Storage, cloning and the names of the data stay those of N_VNew_Serial; replaced are the functions that
// compute, all those that CVODE and ARKODE call in a step, the fused ones and those on arrays of vectors
// included. The compiler unrolls their loops and uses SIMD; a sum of many vectors keeps its partial sums in
// registers. Each element is computed by the same operations in the same order as the library does it, so
// that results are the same to the last bit: for that, a x + b y is a (x + y) or a (x - y) where b is a or
// -a, and norms add one element after the other.
//
// What it saves, on a free body of 7 numbers (CPU time of a step by the library's vector, and ratios in the
// same run, of two runs): CVODE Adams 1610 ns, 0.41 and 0.47; BDF 1510 ns, 0.52 and 0.57; ARKODE's
// Dormand-Prince 1500 ns, 0.47 and 0.49; Fehlberg 8(7) 2990 ns, 0.41; SDIRK_5_3_4 9400 ns, 0.59 and 0.64. The
// library's vector is made for long ones: its loops do not know that there are seven numbers, and each call
// finds out anew which of its cases it is.
#pragma once
#include <cmath>

#include "solvers/sundials.hpp"

namespace polhode::sundials {

/// Operations on serial vectors of n numbers. Names and arguments: the table of operations of an N_Vector.
template <int n>
struct FixedLength {
  static double* of(N_Vector x) { return static_cast<N_VectorContent_Serial>(x->content)->data; }

  /// z = g(i) element by element; z may be one of the vectors that g reads.
  template <class G>
  [[gnu::always_inline]] static void each(N_Vector z, const G& g) {
    double* const out = of(z);
    double r[n];
    for (int i = 0; i < n; ++i) r[i] = g(i);
    for (int i = 0; i < n; ++i) out[i] = r[i];
  }

  static void linear_sum(sunrealtype a, N_Vector X, sunrealtype b, N_Vector Y, N_Vector Z) {
    const double *const x = of(X), *const y = of(Y);
    if (a == b)
      each(Z, [=](int i) { return a * (x[i] + y[i]); });
    else if (a == -b)
      each(Z, [=](int i) { return a * (x[i] - y[i]); });
    else
      each(Z, [=](int i) { return a * x[i] + b * y[i]; });
  }
  static void constant(sunrealtype c, N_Vector Z) {
    each(Z, [=](int) { return c; });
  }
  static void product(N_Vector X, N_Vector Y, N_Vector Z) {
    const double *const x = of(X), *const y = of(Y);
    each(Z, [=](int i) { return x[i] * y[i]; });
  }
  static void quotient(N_Vector X, N_Vector Y, N_Vector Z) {
    const double *const x = of(X), *const y = of(Y);
    each(Z, [=](int i) { return x[i] / y[i]; });
  }
  static void scale(sunrealtype c, N_Vector X, N_Vector Z) {
    const double* const x = of(X);
    each(Z, [=](int i) { return c * x[i]; });
  }
  static void absolute(N_Vector X, N_Vector Z) {
    const double* const x = of(X);
    each(Z, [=](int i) { return std::abs(x[i]); });
  }
  static void inverse(N_Vector X, N_Vector Z) {
    const double* const x = of(X);
    each(Z, [=](int i) { return 1 / x[i]; });
  }
  static void add_constant(N_Vector X, sunrealtype b, N_Vector Z) {
    const double* const x = of(X);
    each(Z, [=](int i) { return x[i] + b; });
  }
  static sunrealtype dot(N_Vector X, N_Vector Y) {
    const double *const x = of(X), *const y = of(Y);
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += x[i] * y[i];
    return sum;
  }
  static sunrealtype weighted_norm(N_Vector X, N_Vector W) {
    const double *const x = of(X), *const w = of(W);
    double sum = 0;
    for (int i = 0; i < n; ++i) {
      const double p = x[i] * w[i];
      sum += p * p;
    }
    return std::sqrt(sum / n);
  }
  // The two below let a number that is not finite pass as the library does: it compares, too.
  static sunrealtype max_norm(N_Vector X) {
    const double* const x = of(X);
    double max = 0;
    for (int i = 0; i < n; ++i)
      if (std::abs(x[i]) > max) max = std::abs(x[i]);
    return max;
  }
  static sunrealtype minimum(N_Vector X) {
    const double* const x = of(X);
    double min = x[0];
    for (int i = 1; i < n; ++i)
      if (x[i] < min) min = x[i];
    return min;
  }

  /// z = sum c_j x_j; z may be x_0.
  static int combination(int count, sunrealtype* c, N_Vector* X, N_Vector Z) {
    if (count == 2) {
      linear_sum(c[0], X[0], c[1], X[1], Z);
      return 0;
    }
    double r[n];
    const double* x = of(X[0]);
    for (int i = 0; i < n; ++i) r[i] = c[0] * x[i];
    for (int j = 1; j < count; ++j) {
      x = of(X[j]);
      const double cj = c[j];
      for (int i = 0; i < n; ++i) r[i] += cj * x[i];
    }
    double* const z = of(Z);
    for (int i = 0; i < n; ++i) z[i] = r[i];
    return 0;
  }
  /// z_j = a_j x + y_j
  static int scale_add(int count, sunrealtype* a, N_Vector X, N_Vector* Y, N_Vector* Z) {
    const double* const x = of(X);
    for (int j = 0; j < count; ++j) {
      const double* const y = of(Y[j]);
      const double aj = a[j];
      each(Z[j], [=](int i) { return aj * x[i] + y[i]; });
    }
    return 0;
  }
  static int linear_sums(int count, sunrealtype a, N_Vector* X, sunrealtype b, N_Vector* Y, N_Vector* Z) {
    for (int j = 0; j < count; ++j) linear_sum(a, X[j], b, Y[j], Z[j]);
    return 0;
  }
  static int scales(int count, sunrealtype* c, N_Vector* X, N_Vector* Z) {
    for (int j = 0; j < count; ++j) scale(c[j], X[j], Z[j]);
    return 0;
  }
  static int constants(int count, sunrealtype c, N_Vector* Z) {
    for (int j = 0; j < count; ++j) constant(c, Z[j]);
    return 0;
  }

  /// Puts these operations into a serial vector of n numbers; clones of it inherit them.
  static void install(N_Vector v) {
    auto& ops = *v->ops;
    ops.nvlinearsum = linear_sum;
    ops.nvconst = constant;
    ops.nvprod = product;
    ops.nvdiv = quotient;
    ops.nvscale = scale;
    ops.nvabs = absolute;
    ops.nvinv = inverse;
    ops.nvaddconst = add_constant;
    ops.nvdotprod = dot;
    ops.nvwrmsnorm = weighted_norm;
    ops.nvmaxnorm = max_norm;
    ops.nvmin = minimum;
    ops.nvlinearcombination = combination;
    ops.nvscaleaddmulti = scale_add;
    ops.nvlinearsumvectorarray = linear_sums;
    ops.nvscalevectorarray = scales;
    ops.nvconstvectorarray = constants;
  }
};

/// A serial vector with its operations fused; of fixed length if that is asked and the length is that of a
/// model.
inline Owned<N_Vector> serial_vector(int size, SUNContext context, bool fixed_length) {
  auto v = owned<Owned<N_Vector>>(N_VNew_Serial(size, context));
  N_VEnableFusedOps_Serial(v.get(),
                           SUNTRUE);  // before the integrator clones it: its history sums in one pass
  if (!fixed_length) return v;
  switch (size) {
    case 3:  // rates alone
      FixedLength<3>::install(v.get());
      break;
    case 6:  // a particle
      FixedLength<6>::install(v.get());
      break;
    case 7:  // attitude and rates
      FixedLength<7>::install(v.get());
      break;
    case 13:  // all of them
      FixedLength<13>::install(v.get());
      break;
    default:
      break;
  }
  return v;
}

}  // namespace polhode::sundials
