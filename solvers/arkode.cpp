// SUNDIALS ARKODE: the Runge-Kutta tables that the library ships, each a row of its own.
//
//   arkode-NAME            explicit tables by ARKStep, diagonally implicit ones by ARKStep with Newton's
//                          method; NAME is the library's own, NAME_S_P_Q: S stages, order Q, embedded P
//   arkode-erkstep-NAME    the same explicit table by ERKStep
//   arkode-NAME-fixed-vector   the same run to the last bit on vectors of fixed length
//                              (solvers/sundials_vector.hpp)
//   arkode-NAME-relaxation     steps scaled so that each keeps the energy; SUNDIALS 6.6 and later
//   arkode-sprk-NAME           the same version's symplectic partitioned tables by SPRKStep, NAME_P_S: order
//   P
//
// y <- y + h sum b_i k_i,  k_i = f(t + c_i h, y + h sum a_ij k_j), a_ij = 0 for j > i, and for the explicit
// ones for j = i. Fixed steps, or steps by the tolerance from the difference to the embedded formula. All
// implicit tables but SDIRK_2_1_2 and BILLINGTON_3_3_2 are stiffly accurate. None keeps an invariant.
//
// The library has the coefficients of CASH_5_2_4 and CASH_5_3_4 with twelve digits: their b_i sum up to 1 +
// 8e-12, and the error on a body of a turn or two stays above 7e-11 however small the step.
//
// ERKStep of SUNDIALS below 6.7 is wrong for tables whose last node is 1 and whose last stage is not the
// result of the step: it takes the slope of that stage for the first slope of the next step, as if stage and
// result were the same point. Of a table of order 6 (VERNER_8_5_6) order 3 is left. The defect is the
// library's, not the table's: ARKStep has the order. It was mended in 6.7.0 (its change log: "incorrectly
// treated as having the first same as last property").
//
// Relaxation (Ketcheson, SIAM J. Numer. Anal. 57 (2019), 2850): y <- y + g h sum b_i k_i with the g near 1
// for which the energy is that of the start, and the step ends at t + g h. It serves scenes whose loads keep
// the energy, and tables whose weights b_i are not negative: Dormand & Prince's is none.
//
// SPRKStep: w <- w + a^_i h w'(q), q <- q + a_i h q'(w), and v, p likewise, through the stages. Its tables
// are symplectic and have their order where the energy is a sum of T(velocity) and V(position). A translation
// is so; a rotation is not (q' holds q, w' holds w, and each is stepped by Euler's method): there order 1 is
// left of every table, and the energy drifts. The rows are here to be measured, not to be recommended.
//
// Source: Reynolds et al., ARKODE: a flexible IVP solver infrastructure for one-step methods, ACM TOMS 49
// (2023); of each table in the list below.
#include <algorithm>
#include <array>
#include <deque>
#include <utility>

#include "solvers/stability_function.hpp"
#include "solvers/sundials_arkode.hpp"

namespace polhode {
namespace {

using namespace sundials;

/// One table: who carries it, the library's number and name of it, and what it is.
struct Table {
  CarriedBy by;
  int id;
  std::string_view name;
  int stages, order, embedded;  // embedded 0: no second formula, thus no tolerance
  std::string_view source;
  bool in_studies = false;
  unsigned exceptions = 0;
  Way way = Way::plain;
};

/// What of the usual claims does not hold for a table, or cannot be measured in double precision.
enum Exception : unsigned {
  order_unseen = 1,         // still above its own where it meets rounding (6.4 down to 6.2 for order 6)
  energy_order_unseen = 2,  // the same, of the energy alone
  rate_order_unseen = 4,    // ends at coefficients of twelve digits
  drift_unseen = 8,   // the energy error at rtol 1e-6 grows by 5 or less in ten times the time; relaxed: it
                      // is that of the branches to the asked times
  order_2_left = 16,  // of the defect of ERKStep
  order_3_left = 32
};
constexpr bool erkstep_is_wrong =
    SUNDIALS_VERSION_MAJOR < 6 || (SUNDIALS_VERSION_MAJOR == 6 && SUNDIALS_VERSION_MINOR < 7);

#define ERK(name) CarriedBy::arkstep_explicit, ARKODE_##name, #name
#define DIRK(name) CarriedBy::arkstep_implicit, ARKODE_##name, #name
#define BY_ERKSTEP(name) CarriedBy::erkstep, ARKODE_##name, #name
#define SPRK(name) CarriedBy::sprkstep, ARKODE_SPRK_##name, "SPRK_" #name
constexpr std::string_view kennedy_carpenter_2003 = "Kennedy & Carpenter, Appl. Numer. Math. 44 (2003), 139";
constexpr std::string_view kennedy_carpenter_2016 = "Kennedy & Carpenter, NASA/TM-2016-219173";
constexpr std::string_view kennedy_carpenter_2019 = "Kennedy & Carpenter, Appl. Numer. Math. 136 (2019), 183";
constexpr std::string_view kennedy_carpenter_2019b =
    "Kennedy & Carpenter, Appl. Numer. Math. 146 (2019), 221";
[[maybe_unused]] constexpr std::string_view relaxation = "Ketcheson, SIAM J. Numer. Anal. 57 (2019), 2850";
[[maybe_unused]] constexpr std::string_view mclachlan_atela = "McLachlan & Atela, Nonlinearity 5 (1992), 541";
constexpr Table tables[] = {
    {ERK(HEUN_EULER_2_1_2), 2, 2, 1, "Heun, Z. Math. Phys. 45 (1900), 23"},
    {ERK(BOGACKI_SHAMPINE_4_2_3), 4, 3, 2, "Bogacki & Shampine, Appl. Math. Lett. 2 (1989), 321"},
    {ERK(KNOTH_WOLKE_3_3), 3, 3, 0, "Knoth & Wolke, Appl. Numer. Math. 28 (1998), 327"},
    {ERK(ARK324L2SA_ERK_4_2_3), 4, 3, 2, kennedy_carpenter_2003},
    {ERK(ZONNEVELD_5_3_4), 5, 4, 3,
     "Zonneveld, Automatic integration of ordinary differential equations (1963)"},
    {ERK(ARK436L2SA_ERK_6_3_4), 6, 4, 3, kennedy_carpenter_2003, false, drift_unseen},
    {ERK(ARK437L2SA_ERK_7_3_4), 7, 4, 3, kennedy_carpenter_2019, false, drift_unseen},
    {ERK(SAYFY_ABURUB_6_3_4), 6, 4, 3, "Sayfy & Aburub, Int. J. Comput. Math. 79 (2002), 945"},
    {ERK(CASH_KARP_6_4_5), 6, 5, 4, "Cash & Karp, ACM TOMS 16 (1990), 201"},
    {ERK(FEHLBERG_6_4_5), 6, 5, 4, "Fehlberg, NASA TR R-315 (1969)"},
    {ERK(DORMAND_PRINCE_7_4_5), 7, 5, 4, "Dormand & Prince, J. Comput. Appl. Math. 6 (1980), 19", true},
    {ERK(ARK548L2SA_ERK_8_4_5), 8, 5, 4, kennedy_carpenter_2003},
    {ERK(ARK548L2SAb_ERK_8_4_5), 8, 5, 4, kennedy_carpenter_2019},
    {ERK(VERNER_8_5_6), 8, 6, 5, "Verner, SIAM J. Numer. Anal. 15 (1978), 772", false,
     order_unseen | drift_unseen},
    {ERK(FEHLBERG_13_7_8), 13, 8, 7, "Fehlberg, NASA TR R-287 (1968)", true, energy_order_unseen},
    {DIRK(SDIRK_2_1_2), 2, 2, 1, "Reynolds et al., ACM TOMS 49 (2023)"},
    {DIRK(BILLINGTON_3_3_2), 3, 2, 3, "Billington, MSc thesis, University of Manchester (1983)", false,
     drift_unseen},
    {DIRK(TRBDF2_3_3_2), 3, 2, 3, "Bank et al., IEEE Trans. Comput.-Aided Design 4 (1985), 436", false,
     drift_unseen},
    {DIRK(KVAERNO_4_2_3), 4, 3, 2, "Kvaerno, BIT 44 (2004), 489"},
    {DIRK(ARK324L2SA_DIRK_4_2_3), 4, 3, 2, kennedy_carpenter_2003},
    {DIRK(ESDIRK324L2SA_4_2_3), 4, 3, 2, kennedy_carpenter_2016},
    {DIRK(ESDIRK325L2SA_5_2_3), 5, 3, 2, kennedy_carpenter_2016},
    {DIRK(ESDIRK32I5L2SA_5_2_3), 5, 3, 2, kennedy_carpenter_2016},
    {DIRK(CASH_5_2_4), 5, 4, 2, "Cash, IMA J. Appl. Math. 24 (1979), 293", false, rate_order_unseen},
    {DIRK(CASH_5_3_4), 5, 4, 3, "Cash, IMA J. Appl. Math. 24 (1979), 293", false, rate_order_unseen},
    {DIRK(SDIRK_5_3_4), 5, 4, 3, "Hairer & Wanner, Solving ODEs II (1996), IV.6", true},
    {DIRK(KVAERNO_5_3_4), 5, 4, 3, "Kvaerno, BIT 44 (2004), 489"},
    {DIRK(ARK436L2SA_DIRK_6_3_4), 6, 4, 3, kennedy_carpenter_2003, false, drift_unseen},
    {DIRK(ESDIRK436L2SA_6_3_4), 6, 4, 3, kennedy_carpenter_2016, false, drift_unseen},
    {DIRK(ESDIRK43I6L2SA_6_3_4), 6, 4, 3, kennedy_carpenter_2016, false, drift_unseen},
    {DIRK(QESDIRK436L2SA_6_3_4), 6, 4, 3, kennedy_carpenter_2016},
    {DIRK(ARK437L2SA_DIRK_7_3_4), 7, 4, 3, kennedy_carpenter_2019, false, drift_unseen},
    {DIRK(ESDIRK437L2SA_7_3_4), 7, 4, 3, kennedy_carpenter_2019b, false,
     drift_unseen | (SUNDIALS_VERSION_MAJOR >= 7 ? energy_order_unseen : 0U)},
    {DIRK(KVAERNO_7_4_5), 7, 5, 4, "Kvaerno, BIT 44 (2004), 489"},
    {DIRK(ESDIRK547L2SA_7_4_5), 7, 5, 4, kennedy_carpenter_2016},
    {DIRK(ESDIRK547L2SA2_7_4_5), 7, 5, 4, kennedy_carpenter_2019b},
    {DIRK(ARK548L2SA_DIRK_8_4_5), 8, 5, 4, kennedy_carpenter_2003},
    {DIRK(ARK548L2SAb_DIRK_8_4_5), 8, 5, 4, kennedy_carpenter_2019},
    {BY_ERKSTEP(CASH_KARP_6_4_5), 6, 5, 4, "Cash & Karp, ACM TOMS 16 (1990), 201"},
    {BY_ERKSTEP(DORMAND_PRINCE_7_4_5), 7, 5, 4, "Dormand & Prince, J. Comput. Appl. Math. 6 (1980), 19"},
    {BY_ERKSTEP(SAYFY_ABURUB_6_3_4), 6, 4, 3, "Sayfy & Aburub, Int. J. Comput. Math. 79 (2002), 945", false,
     order_2_left},
    {BY_ERKSTEP(VERNER_8_5_6), 8, 6, 5, "Verner, SIAM J. Numer. Anal. 15 (1978), 772", false,
     order_unseen | order_3_left},
    {ERK(DORMAND_PRINCE_7_4_5), 7, 5, 4, "Dormand & Prince, J. Comput. Appl. Math. 6 (1980), 19", false, 0,
     Way::fixed_length_vectors},
    {DIRK(SDIRK_5_3_4), 5, 4, 3, "Hairer & Wanner, Solving ODEs II (1996), IV.6", false, 0,
     Way::fixed_length_vectors},
#ifdef POLHODE_SPRKSTEP
    {ERK(BOGACKI_SHAMPINE_4_2_3), 4, 3, 2, relaxation, false, 0, Way::relaxed},
    {ERK(ZONNEVELD_5_3_4), 5, 4, 3, relaxation, false, 0, Way::relaxed},
    {ERK(CASH_KARP_6_4_5), 6, 5, 4, relaxation, false, 0, Way::relaxed},
    {ERK(FEHLBERG_13_7_8), 13, 8, 7, relaxation, false, drift_unseen, Way::relaxed},
    {DIRK(TRBDF2_3_3_2), 3, 2, 3, relaxation, false, 0, Way::relaxed},
    {SPRK(EULER_1_1), 1, 1, 0, "Ruth, IEEE Trans. Nucl. Sci. 30 (1983), 2669"},
    {SPRK(LEAPFROG_2_2), 2, 2, 0, "Ruth, IEEE Trans. Nucl. Sci. 30 (1983), 2669"},
    {SPRK(PSEUDO_LEAPFROG_2_2), 2, 2, 0, "Ruth, IEEE Trans. Nucl. Sci. 30 (1983), 2669"},
    {SPRK(RUTH_3_3), 3, 3, 0, "Ruth, IEEE Trans. Nucl. Sci. 30 (1983), 2669"},
    {SPRK(CANDY_ROZMUS_4_4), 4, 4, 0, "Candy & Rozmus, J. Comput. Phys. 92 (1991), 230"},
    {SPRK(MCLACHLAN_2_2), 2, 2, 0, mclachlan_atela},
    {SPRK(MCLACHLAN_3_3), 3, 3, 0, mclachlan_atela},
    {SPRK(MCLACHLAN_4_4), 4, 4, 0, mclachlan_atela},
    {SPRK(MCLACHLAN_5_6), 6, 5, 0, mclachlan_atela},
    {SPRK(YOSHIDA_6_8), 8, 6, 0, "Yoshida, Phys. Lett. A 150 (1990), 262"},
    {SPRK(SUZUKI_UMENO_8_16), 16, 8, 0, "Suzuki & Umeno, Springer Proc. Phys. 76 (1993), 74"},
    {SPRK(SOFRONIOU_10_36), 36, 10, 0, "Sofroniou & Spaletta, Optim. Methods Softw. 20 (2005), 597"},
#endif
};
#undef ERK
#undef DIRK
#undef BY_ERKSTEP
#undef SPRK

/// Do all loads of a scene have a potential that does not change, and nothing else?
bool keeps_energy(const Scene& scene) {
  if (scene.translation && scene.translation->drag != 0) return false;
  return !scene.rotation || std::ranges::all_of(scene.rotation->loads, [](const AnyTorque<double>& load) {
    const auto* spring = std::get_if<AttitudeSpring<double>>(&load);
    return spring ? spring->damping == 0 : std::holds_alternative<GravityAboutPivot<double>>(load);
  });
}

template <std::size_t i>
Prepared prepare(const Scene& scene, const Setting& setting) {
  constexpr const Table& table = tables[i];
  if (setting.knob == Knob::tolerance && table.embedded == 0)
    return {{}, "has no tolerance, only a fixed step size"};
  if (table.way == Way::relaxed && !keeps_energy(scene))
    return {{}, "keeps the energy, which a load of this scene changes"};
  KeptEnergy kept;
  if (scene.rotation) kept.moments = scene.rotation->moments;
  if (scene.translation) kept.mass = scene.translation->mass;
  return {
      [arkode = std::make_shared<Arkode>(erased_model(scene), setting, table.by, table.id, table.way, kept)](
          const Grid& grid, Trajectory& out) { arkode->integrate(grid, out); },
      {}};
}

/// Of a table, from the library's own coefficients.
StabilityFunction stability_of(const Table& table) {
  if (table.by == CarriedBy::sprkstep) return {};  // no function of h lambda alone: it depends on the parts
  const bool implicit = table.by == CarriedBy::arkstep_implicit;
  const ARKodeButcherTable T = implicit
                                   ? ARKodeButcherTable_LoadDIRK(static_cast<ARKODE_DIRKTableID>(table.id))
                                   : ARKodeButcherTable_LoadERK(static_cast<ARKODE_ERKTableID>(table.id));
  if (T == nullptr) return {};
  Eigen::MatrixXd A(T->stages, T->stages);
  Eigen::VectorXd b(T->stages);
  for (int i = 0; i < T->stages; ++i) {
    b[i] = T->b[i];
    for (int j = 0; j < T->stages; ++j) A(i, j) = T->A[i][j];
  }
  ARKodeButcherTable_Free(T);
  return stability_function(A, b);
}

/// What a row refers to, kept for as long as the program runs.
struct Text {
  std::string id, summary;
  StabilityFunction stability;
};

/// The order that the installed library makes of a table.
int order_of(const Table& table) {
  if (table.by == CarriedBy::sprkstep) return 1;  // of a rotation
  if (!erkstep_is_wrong) return table.order;
  return table.exceptions & order_2_left ? 2 : table.exceptions & order_3_left ? 3 : table.order;
}

Claims claims_of(const Table& table) {
  const unsigned e = table.exceptions;
  const int order = order_of(table);
  // No knob of a relaxed run is a step size to measure an order by.
  const bool unseen = table.way == Way::relaxed || (e & order_unseen && order == table.order);
  const double seen = unseen ? Claims::none : order;
  return {.attitude_order = seen,
          .rate_order = e & rate_order_unseen ? Claims::none : seen,
          .energy_order = e & energy_order_unseen ? Claims::none : seen,
          .momentum_order = seen,
          .unit_attitude = Claim::no,
          .momentum_magnitude = Claim::no,
          .space_momentum = Claim::no,
          .energy_bounded = e & drift_unseen            ? Claim::unknown
                            : table.way == Way::relaxed ? Claim::yes
                                                        : Claim::no,
          // The test takes its step from the claimed order; without one it is too fine to see anything.
          .reversible = seen < 0 ? Claim::unknown : Claim::no};
}

Text text_of(const Table& table) {
  Text text;
  text.id = table.by == CarriedBy::erkstep ? "arkode-erkstep-" : "arkode-";
  for (const char c : table.name)
    text.id += c == '_' ? '-' : c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (table.way == Way::fixed_length_vectors) text.id += "-fixed-vector";
  if (table.way == Way::relaxed) text.id += "-relaxation";
  const std::string order = std::to_string(table.order) +
                            (table.embedded > 0 ? "(" + std::to_string(table.embedded) + ")" : std::string());
  text.summary =
      std::string(table.by == CarriedBy::arkstep_implicit ? "diagonally implicit"
                  : table.by == CarriedBy::sprkstep       ? "symplectic partitioned"
                                                          : "explicit") +
      " Runge-Kutta method of order " + order + " in " + std::to_string(table.stages) +
      " stages on (q, w_B), " +
      (table.by == CarriedBy::erkstep    ? "ERKStep"
       : table.by == CarriedBy::sprkstep ? "SPRKStep: of order 1, and not symplectic, where a body turns"
                                         : "ARKStep");
  if (table.way == Way::fixed_length_vectors) text.summary += ", vectors of fixed length";
  if (table.way == Way::relaxed) text.summary += ", relaxed: each step keeps the energy";
  if (table.by == CarriedBy::sprkstep) return text;
  if (order_of(table) != table.order)
    text.summary += ", whose defect in this version leaves order " + std::to_string(order_of(table));
  // The defect makes a step depend on the one before: no function of z says what it does.
  if (order_of(table) == table.order && table.way != Way::relaxed) text.stability = stability_of(table);
  return text;
}

template <std::size_t... i>
std::array<Prepared (*)(const Scene&, const Setting&), sizeof...(i)> prepares(std::index_sequence<i...>) {
  return {prepare<i>...};
}

MethodRows rows() {
  static const std::deque<Text> texts = [] {
    std::deque<Text> all;
    for (const Table& table : tables) all.push_back(text_of(table));
    return all;
  }();
  static const std::vector<Method> methods = [] {
    const auto prepare_of = prepares(std::make_index_sequence<std::size(tables)>());
    std::vector<Method> all;
    for (std::size_t i = 0; i < std::size(tables); ++i) {
      const Table& table = tables[i];
      all.push_back({.id = texts[i].id,
                     .family = "SUNDIALS ARKODE",
                     .summary = texts[i].summary,
                     .source = table.source,
                     .version = "SUNDIALS " SUNDIALS_VERSION,
                     .by_steps = table.way != Way::relaxed,  // its steps end where the energy says
                     .by_tolerance = table.embedded > 0,
                     .in_studies = table.in_studies,
                     .claims = claims_of(table),
                     .stability_polynomial = texts[i].stability.numerator,
                     .stability_denominator = texts[i].stability.denominator,
                     .prepare = prepare_of[i]});
    }
    return all;
  }();
  return methods;
}

}  // namespace
extern const MethodRows arkode;
const MethodRows arkode = rows();
}  // namespace polhode
