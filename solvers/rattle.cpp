// RATTLE on SO(3): the rotation matrix as nine coordinates held together by Q^T Q = 1.
//   P_1/2 = P_0 + h/2 F(Q_0) - h/2 Q_0 S,  Q_1 = Q_0 + h P_1/2 D^-1,  S symmetric such that Q_1^T Q_1 = 1
//   P_1   = P_1/2 + h/2 F(Q_1) - h/2 Q_1 S',                          S' such that Q_1^T P_1 D^-1 is skew
// with D = diag(d_i), I_i = d_j + d_k: the body as masses on its axes. In the body, with A = Q_0^T Q_1 and m
// the momentum after the half-kick, the multipliers drop out:
//   A D - D A^T = h hat(m),   A^T A = 1;   m <- A^T m
// which is the discrete Moser-Veselov equation: RATTLE takes dmv's steps, up to rounding. SHAKE, the same
// without P_1, has the same Q and, its momentum made tangent, the same m: it is no row of its own.
//
// Nine equations for Q_1, solved to rounding by Newton's method: symmetric corrections (1 - A^T A)/2 for the
// constraint and turns by (tr(D A) 1 - D A)^-1 A^T (h m - vee(A D - D A^T)) for the motion, a division by the
// moments where A = 1, so flat bodies (a d_i of zero) need no care. Where there is no solution (h |w| beyond
// about one) the run ends with solver_failed.
//
// Order 2, symplectic, symmetric and so reversible. R is orthogonal to rounding after any number of steps,
// because the constraint is solved anew in each. The momentum is the state, in space: of the free body it
// stays as it is, and the energy is kept as well. Source: McLachlan & Scovel, J. Nonlinear Sci. 5 (1995),
// 233; Reich, Physica D 76 (1994), 375; Hairer, Lubich & Wanner, Geometric Numerical Integration (2006),
// VII.5.3.
#include <Eigen/LU>

#include "solvers/matrix_form.hpp"
#include "solvers/momentum_form.hpp"

namespace polhode {
namespace {

/// Q_1 = Q A with A D - D A^T = h hat(m) and Q_1^T Q_1 = 1, the solution near to turning on; false if none is
/// found.
bool solve_constraint(Mat3& Q, const Vec3& moments, const Vec3& m, double h, std::int64_t& calls) {
  const Vec3 D = Vec3::Constant(0.5 * moments.sum()) - moments;
  const Mat3 metric = Q.transpose() * Q;  // one, to rounding: not assumed, so that rounding has no memory
  Mat3 A = exp_rotation_matrix<double>(h * m.cwiseQuotient(moments));
  Settling settling(2.2e-16);
  for (int i = 0; i < 40; ++i) {
    A += 0.5 * A * (Mat3::Identity() - A.transpose() * metric * A);
    const Vec3 missing = h * m - 2 * vee<double>(A * D.asDiagonal());
    const Mat3 DA = D.asDiagonal() * A;
    const Vec3 turn = (DA.trace() * Mat3::Identity() - DA).inverse() * (A.transpose() * missing);
    ++calls;
    const double change = turn.cwiseAbs().maxCoeff();
    if (!(change < 2)) return false;
    A += A * hat<double>(turn);
    if (settling.at_rest(change)) {
      Q = Q * A;
      return true;
    }
  }
  return false;
}

/// Torque in space of a model whose type is no longer seen, at matrix R and momentum L: a step is compiled
/// once for all.
using Torque = Vec3 (*)(const void* model, double t, const Mat3& R, const Vec3& L);

/// One step of (Q, L); torque may be null. Adds torques and iterates to `calls`; returns why it failed, or
/// null.
const char* rattle_step(Mat3& Q, Vec3& L, const Vec3& moments, double t, double h, const void* model,
                        Torque torque, std::int64_t& calls) {
  if (torque != nullptr) L += 0.5 * h * torque(model, t, Q, L);
  if (!solve_constraint(Q, moments, Q.transpose() * L, h, calls))
    return "the constraint Q^T Q = 1 has no solution that Newton's method finds";
  if (torque != nullptr) {
    // The adjoint of the first kick: a torque that depends on the rates makes it implicit.
    const Vec3 before = L;
    ++calls;
    if (!iterate_to_rounding(L, calls, [&](const Vec3& end) -> Vec3 {
          return before + 0.5 * h * torque(model, t + h, Q, end);
        }))
      return kick_failure;
  }
  return nullptr;
}

struct Rattle : MatrixForm {
  std::int64_t rhs_evals = 0;  // torques, and iterates of the constraint
  const char* failure = nullptr;

  // The state is the matrix form's, with L_S in the place of w_S.
  template <WithAttitude M>
  static State<M> start(const M& m) {
    State<M> y = MatrixForm::start(m);
    put(y, matrix_of(y.data()) * m.rotation.momentum_B(m.rotation.w_of(m.initial.data())));
    return y;
  }
  template <WithAttitude M>
  static Sample sample(const M& m, double t, State<M> y) {
    const Vec3 L = w_of(y.data());
    put(y, rates_S(matrix_of(y.data()), m.rotation.inverse_moments(), L));
    Sample s = MatrixForm::sample(m, t, y);
    s.L = L;
    return s;
  }

  template <WithAttitude M>
  State<M> step(const M& m, double t, double h, const State<M>& y) {
    Torque torque = nullptr;
    if constexpr (M::Rotating::has_load)
      torque = [](const void* model, double time, const Mat3& R, const Vec3& L) -> Vec3 {
        const auto& rotation = static_cast<const M*>(model)->rotation;
        return rotation.load.torque_S(time, R, rates_S(R, rotation.inverse_moments(), L));
      };
    Mat3 Q = matrix_of(y.data());
    Vec3 L = w_of(y.data());
    failure = rattle_step(Q, L, m.rotation.moments(), t, h, &m, torque, rhs_evals);
    State<M> next;
    Eigen::Map<Mat3>(next.data()) = Q;
    put(next, L);
    move_translation<4>(m, h, y.data() + 12, next.data() + 12);
    return next;
  }

 private:
  [[gnu::noinline]] static Vec3 rates_S(const Mat3& R, const Vec3& inverse_moments, const Vec3& L) {
    return R * inverse_moments.cwiseProduct(R.transpose() * L);
  }
  template <class State>
  static void put(State& y, const Vec3& v) {
    for (int i = 0; i < 3; ++i) y[static_cast<std::size_t>(9 + i)] = v[i];
  }
};

constinit const Method rows[] = {
    {.id = "rattle",
     .family = "constrained",
     .summary = "RATTLE: nine coordinates of R, Q^T Q = 1 solved to rounding each step, torque as kicks",
     .source = "McLachlan & Scovel, J. Nonlinear Sci. 5 (1995), 233; Reich, Physica D 76 (1994), 375",
     .by_steps = true,
     .claims = {.attitude_order = 2,
                .rate_order = 2,
                .energy_order = 2,
                .momentum_order = 2,
                .unit_attitude = Claim::yes,
                .momentum_magnitude = Claim::yes,
                .space_momentum = Claim::yes,
                .energy_bounded = Claim::yes,
                .reversible = Claim::yes},
     .prepare = run_fixed_step<Rattle>},
};

}  // namespace
extern const MethodRows rattle;
const MethodRows rattle = rows;
}  // namespace polhode
