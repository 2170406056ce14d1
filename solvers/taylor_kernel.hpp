// The Taylor series of a turning body, and steps by it: the one loop that is compiled for each instruction
// set and chosen at run time (solvers/taylor.cpp). Plain types only: a function of the standard library
// compiled here for a newer processor could be the copy that the linker keeps for everybody.
//
// With the state's coefficients scaled by powers of the step, x_k = h^k x^(k)/k!,
//   q_{k+1}     = h/(2 (k + 1)) sum q_{k-j} (0, w_j)
//   w_{k+1}     = h/(k + 1) (sum g * (w_j)_yzx * (w_{k-j})_zxy + I^-1 (c x m gamma_k))
//   gamma_{k+1} = h/(k + 1) sum gamma_{k-j} x w_j
// where gamma is the acceleration of gravity in body components, m c the first moment of the mass about the
// pivot, and g = ((I2 - I3)/I1, ...): the body of gravity about a pivot, or free without the second line's
// end. All other loads make the slope of w by sums of the same kind: a matrix times w (drag, damping), times
// q (the attitude spring, whose |q| is constant), times vectors carried from space like gamma (torques
// constant in space), products of two components of one (the gravity gradient; its vector turns in space, and
// so has a partner). The centre of mass falls against linear drag by v' = a - b v. Source: Jorba & Zou, Exp.
// Math. 14 (2005); the quadratic recurrences are those of any product of series.
#pragma once
#include <cstdint>

namespace polhode {

/// A vector that is given in space and enters in body components: u' = u x w + rate * partner.
struct alignas(32) CarriedVector {
  double space[4] = {};   // at t = 0
  double map[3][4] = {};  // columns: its part of w'
  double rate = 0;        // 1/s: turns about the third axis of space; the vector after it is its partner
};

/// What the series needs to know of a body. Vectors in body components, their fourth number zero; matrices by
/// columns.
struct alignas(64) TaylorBody {
  static constexpr int most_carried = 6;
  enum class Load { none, gravity, any };
  Load load = Load::none;
  int order = 16;  // even, at most TaylorLine::most
  double rtol = 1e-6, atol = 1e-6;
  double gyro[4] = {};             // ((I2 - I3)/I1, ...)
  double inverse_moments[4] = {};  // 1/(kg m^2)

  // Load::gravity
  double lever[4] = {};      // m c, kg m
  double gravity_S[4] = {};  // m/s^2, space

  // Load::any
  double constant[4] = {};                   // rad/s^2
  double damping[3][4] = {};                 // of w, 1/s
  bool has_spring = false;                   // of q/|q| times the sign of turned . q
  double spring[4][4] = {}, turned[4] = {};  // 1/s^2
  int carried_count = 0;
  CarriedVector carried[most_carried];
  double gradient[4] = {};        // 1/s^2, of (u_y u_z, u_z u_x, u_x u_y), u = carried[0]
  bool has_course = false;        // a centre of mass that moves
  double fall[4] = {}, drag = 0;  // m/s^2; 1/s
};

/// A run: where it is, and the series of its last step.
struct alignas(64) TaylorLine {
  static constexpr int most = 32;
  double series[most + 1][8] = {};  // coefficient k of (q, w), times step^k; the eighth number is zero
  double course[most + 1][8] = {};  // and of (p, v), each with a zero behind it
  double q[4] = {}, w[4] = {}, p[4] = {}, v[4] = {};  // state at t
  double low[16] = {};                                // what its rounding took away
  double t = 0, h = 0;                                // s; h: the next step
  double start = 0, step = 0;                         // s, of the series
  double side = 1;                                    // the spring's sign
  std::int64_t steps = 0;
  bool fresh = true;  // no step was taken: h is a guess
};

/// The loops for one instruction set. All give the same numbers to the last bit.
struct TaylorKernel {
  const char* instructions;
  /// Steps while t + h < t_stop and there are fewer than `limit` steps in all.
  void (*cruise)(const TaylorBody&, TaylorLine&, double t_stop, std::int64_t limit);
  /// One step to the time `end`, or to where its series holds if that is less. The first step of a run has to
  /// be this one: line.h is a guess at it.
  void (*step)(const TaylorBody&, TaylorLine&, double end);
};

}  // namespace polhode
