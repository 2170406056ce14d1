// SUNDIALS CVODE: linear multistep methods of variable order and step on the flat state of a model.
//
// cvode-adams: Adams-Moulton, orders 1 to 12, functional iteration; no Jacobian and no linear solver is made.
//
// cvode-bdf: BDF, orders 1 to 5, Newton with the model's own Jacobian and dense LU.
//
// cvode-bdf-projected: BDF that projects q to unit length after each step by CVodeSetProjFn and takes the
// part of the error estimate along q out of the error test. |q| is one to rounding where a step ends, thus at
// the end of the run; at an asked time inside a step the interpolant leaves the sphere by less than the
// tolerance.
//
// None keeps energy or momentum. The attitude error of a tumbling body is some 30 to 200 times the tolerance.
//
// Source: Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Cohen & Hindmarsh, CVODE, Computers in Physics 10
// (1996); projection: Eich, SIAM J. Numer. Anal. 30 (1993).
#include "solvers/sundials_cvode.hpp"

namespace polhode {
namespace {

using namespace sundials;
using Formula = CvodeChoice::Formula;

Prepared adams(const Scene& scene, const Setting& setting) {
  return run_cvode(erased_model(scene), setting, {.formula = Formula::adams});
}
Prepared bdf(const Scene& scene, const Setting& setting) {
  return run_cvode(erased_model(scene), setting, {.formula = Formula::bdf});
}
Prepared bdf_projected(const Scene& scene, const Setting& setting) {
  auto model = erased_model(scene);
  if (!model->has_attitude()) return {{}, "needs an attitude to project"};
  return run_cvode(std::move(model), setting, {.formula = Formula::bdf, .projected = true});
}

constinit const Method rows[] = {
    {.id = "cvode-adams",
     .family = "SUNDIALS CVODE",
     .summary = "Adams-Moulton of variable order on (q, w_B), functional iteration",
     .source = cvode_source,
     .version = sundials_version,
     .by_tolerance = true,
     .claims = keeps_nothing,
     .prepare = adams},
    {.id = "cvode-bdf",
     .family = "SUNDIALS CVODE",
     .summary = "BDF of variable order on (q, w_B), Newton with analytic Jacobian",
     .source = cvode_source,
     .version = sundials_version,
     .by_tolerance = true,
     .claims = keeps_nothing,
     .prepare = bdf},
    {.id = "cvode-bdf-projected",
     .family = "SUNDIALS CVODE",
     .summary = "BDF with q projected to unit length after each step by CVODE's own projection",
     .source = "Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); Eich, SIAM J. Numer. Anal. 30 (1993)",
     .version = sundials_version,
     .by_tolerance = true,
     .claims = keeps_nothing,
     .prepare = bdf_projected},
};

}  // namespace
extern const MethodRows cvode;
const MethodRows cvode = rows;
}  // namespace polhode
