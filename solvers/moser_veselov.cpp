// Discrete Moser-Veselov: the discrete free rigid body that is integrable like the continuous one.
//
// With (rho_0, rho) the unit quaternion of a step and Ih_i the moments that the step is told,
//   h m_i = 2 Ih_i rho_0 rho_i + 2 (Ih_k - Ih_j) rho_j rho_k   (i, j, k cyclic)
// and q <- q rho, m <- rho* m rho. Energy and momentum of the free body, both, are kept to rounding; |q| = 1,
// symmetric, reversible.
//
//   dmv2            Ih = I: order 2
//   dmv4 ... 10     1/Ih = (1 + sigma)/I + delta, two scalars, series in h^2 of the energy H and C = |m|^2/2
//   dmv-exact       the same from the closed form: no truncation error
//
// Why two scalars are enough: step and flow keep H and C, so both move m along the same closed curve, on
// which both are translations of its uniform (elliptic) parameter, and turn the body about L by a phase that
// the curve alone decides. Two scalars, functions of h, H and C, match the two. The series were found by
// putting the exact turn rho(h) of a rational body, as a power series with rational coefficients, in the
// equations above, which are linear in Ih: three equations, whose solution has the form 1/Ih = (1 + sigma)/I
// + delta with even powers of h alone, exactly; their coefficients are polynomials in H, C and the symmetric
// functions of the moments. Those of order 4 agree with the paper. dmv-exact solves the same equations for Ih
// at a finite h, at the point of the curve where the momentum about the middle axis vanishes: the step about
// it has rho_mid = 0, and two quotients remain, Ih_i = h m_i/(2 rho_0 rho_i).
//
// The equation for rho has a solution that begins at h = 0 while h |w| stays below about one (dmv2), or the
// turn of a step below about a right angle (dmv-exact): Newton's method, and solver_failed where the
// determinant of the equation is near zero or the iteration does not end. The truncated series lose their
// meaning there too. The free body's sums are compensated. A torque is a kick (solvers/kicks.hpp) at both
// ends of the step and makes the order 2 in all rows; the scalars are then found anew at each step. Sources:
// Moser & Veselov, Commun. Math. Phys. 139 (1991), 217; Hairer & Vilmart, J. Phys. A 39 (2006), 13225.
#include "models/free_rotation.hpp"
#include "solvers/kicks.hpp"

namespace polhode {
namespace {

// ---- the moments that a step is told

/// value/denominator[k] * H^(k - C) C^C s1^first s2^second, of moments scaled to a product of one.
struct Term {
  int k, C, first, second, value;
};
constexpr double denominator[] = {1, 6, 60, 2520, 45360};
constexpr Term sigma_terms[] = {
    {1, 0, 0, 1, -2},   {1, 1, 1, 0, 1},    {2, 0, 0, 2, 2},    {2, 0, 1, 0, -1},    {2, 1, 0, 0, 8},
    {2, 1, 1, 1, -2},   {2, 2, 0, 1, -6},   {2, 2, 2, 0, 2},    {3, 0, 0, 0, 72},    {3, 0, 0, 3, -4},
    {3, 0, 1, 1, 4},    {3, 1, 0, 1, -212}, {3, 1, 1, 2, 6},    {3, 1, 2, 0, 41},    {3, 2, 0, 2, 132},
    {3, 2, 1, 0, -30},  {3, 2, 2, 1, -36},  {3, 3, 0, 0, 100},  {3, 3, 1, 1, -66},   {3, 3, 3, 0, 17},
    {4, 0, 0, 1, -486}, {4, 0, 0, 4, 2},    {4, 0, 1, 2, -3},   {4, 0, 2, 0, 153},   {4, 1, 0, 2, 1104},
    {4, 1, 1, 0, -828}, {4, 1, 1, 3, -4},   {4, 1, 2, 1, -264}, {4, 2, 0, 0, 1908},  {4, 2, 0, 3, -612},
    {4, 2, 1, 1, 180},  {4, 2, 2, 2, 156},  {4, 2, 3, 0, 18},   {4, 3, 0, 1, -2256}, {4, 3, 1, 2, 612},
    {4, 3, 2, 0, 282},  {4, 3, 3, 1, -154}, {4, 4, 0, 2, 378},  {4, 4, 1, 0, 291},   {4, 4, 2, 1, -342},
    {4, 4, 4, 0, 62}};
constexpr Term delta_terms[] = {
    {1, 0, 1, 0, 1},    {1, 1, 0, 0, -2},   {2, 0, 0, 0, -6},    {2, 0, 1, 1, -1},   {2, 1, 0, 1, 8},
    {2, 1, 2, 0, -1},   {2, 2, 1, 0, -1},   {3, 0, 0, 1, 60},    {3, 0, 1, 2, 2},    {3, 0, 2, 0, -26},
    {3, 1, 0, 2, -64},  {3, 1, 1, 0, 110},  {3, 1, 2, 1, 13},    {3, 2, 0, 0, -176}, {3, 2, 1, 1, -2},
    {3, 2, 3, 0, 2},    {3, 3, 0, 1, 72},   {3, 3, 2, 0, -19},   {4, 0, 0, 2, -126}, {4, 0, 1, 0, 459},
    {4, 0, 1, 3, -1},   {4, 0, 2, 1, -6},   {4, 1, 0, 0, -1296}, {4, 1, 0, 3, 128},  {4, 1, 1, 1, -552},
    {4, 1, 2, 2, -30},  {4, 1, 3, 0, 194},  {4, 2, 0, 1, 2136},  {4, 2, 1, 2, 114},  {4, 2, 2, 0, -798},
    {4, 2, 3, 1, -30},  {4, 3, 0, 2, -864}, {4, 3, 1, 0, 684},   {4, 3, 2, 1, 222},  {4, 3, 4, 0, -1},
    {4, 4, 0, 0, -610}, {4, 4, 1, 1, 243},  {4, 4, 3, 0, -61}};
constexpr int most_powers = 4;  // of h^2

/// The polynomials of a body in H and C.
class Series {
 public:
  Series() = default;
  Series(const Vec3& moments, int powers)
      : powers_(powers), scale_(1 / std::cbrt(moments.x() * moments.y() * moments.z())) {
    const Vec3 i = scale_ * moments;
    const double s1 = i.sum(), s2 = i.x() * i.y() + i.y() * i.z() + i.z() * i.x();
    const auto add = [&](std::span<const Term> terms, Table& table) {
      for (const Term& t : terms)
        table[static_cast<std::size_t>(t.k)][static_cast<std::size_t>(t.C)] +=
            t.value / denominator[t.k] * std::pow(s1, t.first) * std::pow(s2, t.second);
    };
    add(sigma_terms, sigma_);
    add(delta_terms, delta_);
  }
  /// 1/Ih
  Vec3 inverse(const Vec3& inverse_moments, double H, double C, double h) const {
    const double x = h * h * scale_ * H, y = h * h * scale_ * scale_ * C;
    double sigma = 0, delta = 0;
    std::array<double, most_powers + 1> x_powers{1}, y_powers{1};
    for (std::size_t k = 1; k <= static_cast<std::size_t>(powers_); ++k) {
      x_powers[k] = x_powers[k - 1] * x;
      y_powers[k] = y_powers[k - 1] * y;
      for (std::size_t j = 0; j <= k; ++j) {
        const double power = x_powers[k - j] * y_powers[j];
        sigma += sigma_[k][j] * power;
        delta += delta_[k][j] * power;
      }
    }
    return inverse_moments + sigma * inverse_moments + Vec3::Constant(delta * scale_);
  }

 private:
  using Table = std::array<std::array<double, most_powers + 1>, most_powers + 1>;  // power of h^2; of C
  int powers_ = 0;
  double scale_ = 1;
  Table sigma_{}, delta_{};
};

// ---- the step

/// The moments of steps of one length on one curve.
struct Told {
  Vec3 inverse, moments;    // 1/Ih, Ih
  double over_product = 1;  // 1/(Ih_1 Ih_2 Ih_3)
  double bend = 0;  // how far the equation for c is from linear: Newton's error e becomes about bend e^2

  Told() = default;
  Told(const Vec3& inverse_moments, const Vec3& given, double h, const Vec3& m)
      : inverse(inverse_moments), moments(given), over_product(1 / given.prod()) {
    bend = ((moments.maxCoeff() - moments.minCoeff()) + 2 * std::abs(h) * m.norm()) / moments.minCoeff();
  }
};

/// The equation of a step for c = rho/rho_0,
///   F_i = Ih_i c_i + (Ih_k - Ih_j) c_j c_k - (1 + |c|^2) h m_i/2,
/// and Newton's correction at c.
struct StepEquation {
  Vec3 moments, differences, hm;

  StepEquation(const Vec3& I, const Vec3& m, double h)
      : moments(I), differences(I.z() - I.y(), I.x() - I.z(), I.y() - I.x()), hm(h * m) {}

  /// Returns the determinant of the derivative: the product of the moments for a small step, zero where the
  /// solution ends.
  [[gnu::always_inline]] double correction(const Vec3& c, Vec3& change) const {
    const Vec3 &I = moments, &d = differences;
    const double half = 0.5 * (1 + c.squaredNorm());
    const Vec3 F(I.x() * c.x() + (d.x() * (c.y() * c.z()) - half * hm.x()),
                 I.y() * c.y() + (d.y() * (c.z() * c.x()) - half * hm.y()),
                 I.z() * c.z() + (d.z() * (c.x() * c.y()) - half * hm.z()));
    const Vec3 r0(I.x() - hm.x() * c.x(), d.x() * c.z() - hm.x() * c.y(), d.x() * c.y() - hm.x() * c.z());
    const Vec3 r1(d.y() * c.z() - hm.y() * c.x(), I.y() - hm.y() * c.y(), d.y() * c.x() - hm.y() * c.z());
    const Vec3 r2(d.z() * c.y() - hm.z() * c.x(), d.z() * c.x() - hm.z() * c.y(), I.z() - hm.z() * c.z());
    const Vec3 a = r1.cross(r2), b = r2.cross(r0), e = r0.cross(r1);
    const double determinant = r0.x() * a.x() + (r0.y() * a.y() + r0.z() * a.z());
    const double scale = 1 / determinant;
    change = Vec3(scale * (F.x() * a.x() + (F.y() * b.x() + F.z() * e.x())),
                  scale * (F.x() * a.y() + (F.y() * b.y() + F.z() * e.y())),
                  scale * (F.x() * a.z() + (F.y() * b.z() + F.z() * e.z())));
    return determinant;
  }
};

/// Below this determinant the step is called unsolvable: rounding would be multiplied by its inverse.
constexpr double least_determinant = 0.05;

/// 1/Ih that makes the step exact; zero where there is none. In long double: the small angles of a small step
/// are divided by.
Vec3 exact_inverse(const Vec3& moments, const Vec3& m, double h) {
  using S = long double;
  std::array<int, 3> axis{0, 1, 2};
  for (const std::size_t i : {0u, 1u, 0u})
    if (moments[axis[i]] > moments[axis[i + 1]]) std::swap(axis[i], axis[i + 1]);
  const S a = moments[axis[0]], b = moments[axis[1]], c = moments[axis[2]];
  const S m_a = m[axis[0]], m_b = m[axis[1]], m_c = m[axis[2]];
  // Where the middle component is zero; of how far 1/b is from 1/a to 1/c the point knows as well.
  const S share = c > a ? (b - a) * c / (b * (c - a)) : S(0);
  const S n_a = std::sqrt(m_a * m_a + (1 - share) * m_b * m_b),
          n_c = std::sqrt(m_c * m_c + share * m_b * m_b);
  // Nowhere on the curve is the body faster than here: a turn of less than half a revolution is known by its
  // quaternion.
  if (!(std::abs(h) * std::hypot(n_a / a, n_c / c) < half_turn<S>())) return Vec3::Zero();
  const FreeRotation<S> body(Vec3(moments[axis[0]], moments[axis[1]], moments[axis[2]]), {1, 0, 0, 0},
                             {n_a / a, 0, n_c / c});
  const auto half = body.at(S(h) / 2);
  // From -h/2 to h/2: time reversal and half a turn about the middle axis map the motion onto itself.
  const QuaternionT<S>& g = half.q;
  const S r_0 = (g.w() * g.w() + g.y() * g.y()) - (g.x() * g.x() + g.z() * g.z());
  const S r_a = 2 * (g.w() * g.x() - g.y() * g.z()), r_c = 2 * (g.w() * g.z() + g.x() * g.y());
  // A momentum about an axis that is lost beside the other counts for nothing; then delta = 0.
  const S lost = 1e-17L * (n_a + n_c);
  S inverse_a = n_a > lost ? S(2 * r_0 * r_a / (h * a * half.w_B.x())) : S(0);
  S inverse_c = n_c > lost ? S(2 * r_0 * r_c / (h * c * half.w_B.z())) : S(inverse_a * a / c);
  if (!(n_a > lost)) inverse_a = inverse_c * c / a;
  const Vec3 sorted(static_cast<double>(inverse_a),
                    static_cast<double>(inverse_a + share * (inverse_c - inverse_a)),
                    static_cast<double>(inverse_c));
  // The turn solves the equation. Is it the solution that begins at h = 0? (Bodies that could not be built
  // leave it the other way, to large determinants.)
  if (!(sorted.minCoeff() > 0)) return Vec3::Zero();
  const Vec3 c_half(static_cast<double>(r_a / r_0), 0, static_cast<double>(r_c / r_0)),
      momentum(static_cast<double>(a * half.w_B.x()), -static_cast<double>(b * half.w_B.y()),
               static_cast<double>(c * half.w_B.z()));
  Vec3 unused;
  const double determinant =
      sorted.prod() * StepEquation(sorted.cwiseInverse(), momentum, h).correction(c_half, unused);
  if (!(determinant > least_determinant && determinant < 4)) return Vec3::Zero();
  Vec3 inverse;
  for (int i = 0; i < 3; ++i) inverse[axis[static_cast<std::size_t>(i)]] = sorted[i];
  return inverse;
}

/// What sums of many small changes have lost in rounding.
struct Lost {
  Quaternion q{0, 0, 0, 0};
  Vec3 m = Vec3::Zero();
};
/// sum += change, by Kahan.
[[gnu::always_inline]] inline void add(double& sum, double change, double& lost) {
  const double whole = change + lost, before = sum;
  sum = before + whole;
  lost = whole - (sum - before);
}

/// Solves for c and takes the step; false if there is no solution.
bool take_step(Spinning& x, Lost& lost, const Told& told, double h) {
  const Vec3& m = x.m;
  const StepEquation equation(told.moments, m, h);
  const Vec3& d = equation.differences;
  // rho_0 rho = h w/2 with w at the middle, 1/Ih (m + m_next)/2: a first guess, of order 3.
  const Vec3 ahead = m + 0.5 * h * m.cross(product(told.inverse, m));
  const Vec3 s = 0.5 * h * product(told.inverse, ahead);
  const double ss = s.x() * s.x() + (s.y() * s.y() + s.z() * s.z());
  Vec3 c = s * (ss < 0.01 ? 1 + ss : 2 / (1 + std::sqrt(std::max(0.0, 1 - 4 * ss))));
  for (int i = 0;; ++i) {
    Vec3 change;
    const double determinant = told.over_product * equation.correction(c, change);
    c -= change;
    const double size = change.cwiseAbs().maxCoeff(), scale = c.cwiseAbs().maxCoeff() + 1e-300;
    // The determinant is positive on the branch that begins at h = 0, and vanishes where that ends.
    if (told.bend * size * size <= 1e-19 * scale * determinant || (i > 5 && size <= 1e-14 * scale)) {
      if (!(determinant > least_determinant)) return false;
      break;
    }
    if (i == 20 || !(size < 1e3)) return false;
  }
  const double cc = c.squaredNorm(), root = std::sqrt(1 + cc), inverse_root = 1 / root;
  const Quaternion turn = change_of(
      x.q, {-cc / (root * (1 + root)), c.x() * inverse_root, c.y() * inverse_root, c.z() * inverse_root});
  add(x.q.w(), turn.w(), lost.q.w());
  add(x.q.x(), turn.x(), lost.q.x());
  add(x.q.y(), turn.y(), lost.q.y());
  add(x.q.z(), turn.z(), lost.q.z());
  const double factor = -4 / (h * (1 + cc));
  add(x.m.x(), factor * (d.x() * (c.y() * c.z())), lost.m.x());
  add(x.m.y(), factor * (d.y() * (c.z() * c.x())), lost.m.y());
  add(x.m.z(), factor * (d.z() * (c.x() * c.y())), lost.m.z());
  return true;
}

/// The free step, told once for as long as nothing changes the curve.
class FreeStep {
 public:
  /// Null, or why not.
  const char* take(Spinning& x, const Vec3& moments, const Vec3& inverse, double h, int powers, bool anew) {
    if (anew || h != h_) {
      if (const char* why = tell(moments, inverse, x.m, h, powers)) return why;
      h_ = h;
    }
    return take_step(x, lost_, told_, h) ? nullptr : no_solution;
  }

 private:
  static constexpr const char* no_solution =
      "the discrete Moser-Veselov equation has no solution for so long a step";

  const char* tell(const Vec3& moments, const Vec3& inverse, const Vec3& m, double h, int powers) {
    if (powers == 0) {
      told_ = Told(inverse, moments, h, m);
      return nullptr;
    }
    if (h_ == 0) series_ = Series(moments, powers > 0 ? powers : most_powers);
    const double C = 0.5 * m.squaredNorm(), H = 0.5 * m.dot(product(inverse, m));
    const double longest = std::abs(h) * std::sqrt(2 * C) * inverse.maxCoeff();
    // Below 0.02 the series of order 10 misses 1e-17, and small angles would cost the quotients their digits.
    const Vec3 told =
        powers > 0 || longest < 0.02 ? series_.inverse(inverse, H, C, h) : exact_inverse(moments, m, h);
    if (!(told.minCoeff() > 0) || !told.allFinite())
      return powers > 0 ? "the series of the preprocessed moments does not converge for so long a step"
                        : no_solution;
    told_ = Told(told, told.cwiseInverse(), h, m);
    return nullptr;
  }

  double h_ = 0;
  Told told_;
  Lost lost_;
  Series series_;
};

struct MoserVeselov : BodyMomentumForm {
  int choice = 0;  // powers of h^2 in the series of the scalars; -1: exact
  std::int64_t rhs_evals = 0;
  const char* failure = nullptr;
  Kicks kicks;
  FreeStep free_step;

  template <WithAttitude M>
  typename M::State step(const M& m, double t, double h, const typename M::State& y) {
    constexpr double half[] = {0.5};
    kicks.set_up(m, y, h, half);
    Spinning x = spinning_of(y);
    kicks.kick(m, t, x.q, x.m, 0, 0.5 * h);
    failure = free_step.take(x, m.rotation.moments(), m.rotation.inverse_moments(), h, choice,
                             M::Rotating::has_load);
    kicks.kick(m, t + h, x.q, x.m, 0, 0.5 * h);
    if constexpr (M::Rotating::has_load) rhs_evals += 2;
    return spun(m, h, y, x);
  }
};

template <int powers>
Prepared prepare(const Scene& scene, const Setting& setting) {
  return run_fixed_step<MoserVeselov>(scene, setting, powers);
}

constexpr std::string_view paper = "Hairer & Vilmart, J. Phys. A 39 (2006), 13225";

template <int powers>
constexpr Method row(std::string_view id, std::string_view summary, bool in_studies = true,
                     std::string_view source = paper) {
  return {.id = id,
          .family = "discrete Moser-Veselov",
          .summary = summary,
          .source = source,
          .by_steps = true,
          .in_studies = in_studies,
          .claims = {.attitude_order = 2,
                     .rate_order = 2,
                     .energy_order = 2,
                     .momentum_order = 2,
                     .unit_attitude = Claim::yes,
                     .momentum_magnitude = Claim::yes,
                     .space_momentum = Claim::yes,
                     .energy_bounded = Claim::yes,
                     .reversible = Claim::yes},
          .prepare = prepare<powers>};
}

constinit const Method rows[] = {
    row<0>("dmv2", "discrete Moser-Veselov with the body's own moments", true,
           "Moser & Veselov, Commun. Math. Phys. 139 (1991), 217"),
    row<1>("dmv4", "preprocessed moments: order 4 of the free body, 2 with torque", false),
    row<2>("dmv6", "preprocessed moments: order 6 of the free body, 2 with torque"),
    row<3>("dmv8", "preprocessed moments: order 8 of the free body, 2 with torque", false),
    row<4>("dmv10", "preprocessed moments: order 10 of the free body, 2 with torque", false),
    row<-1>("dmv-exact", "moments that make the step of the free body exact; order 2 with torque"),
};

}  // namespace
extern const MethodRows moser_veselov;
const MethodRows moser_veselov = rows;
}  // namespace polhode
