// Variants of SUNDIALS CVODE: other states, other vectors, other options. Compare each with cvode-adams or
// cvode-bdf.
//
// cvode-adams-renormalised: what is sampled has q/|q|; the integration is not touched. It shows how much of
// the error is along q, which a rotation does not see.
//
// cvode-adams-norm-feedback: q' = 1/2 q w + k (1 - |q|^2) q. The sphere |q| = 1 attracts at the rate 2k, so
// that the defect is that of the last 1/(2k) and does not add up; on the sphere nothing changes. k = |w| at
// the start (of a body at rest 10/duration): a rate that the motion has anyway, so that nothing becomes
// stiff. After 1000 s of tumbling at rtol 1e-7 the defect is 3.1e-7, and 1.4e-4 without. Known as
// orthogonality control in flight simulation and, for constraints at large, as Baumgarte's stabilisation.
//
// cvode-adams-matrix: twelve numbers, R by columns and w_S, R' = [w]x R. It may leave SO(3) in six ways
// instead of one, and a matrix that has left it carries another inertia, R I R^T: the defect turns into an
// error of the motion. On a tumbling body that error is 100 to 14 000 times the tolerance; with q 8 to 170.
//
// cvode-bdf-stability-limit: BDF with CVodeSetStabLimDet, which lowers the order where the steps of orders 3
// to 5 come near the region of oscillating modes in which those orders are not stable. On an undamped stiff
// spring 4 % of the energy is lost in 10 s in place of 10 %, for a sixth more steps.
//
// cvode-bdf-differences: BDF with the Jacobian that CVODE makes by difference quotients, one right-hand side
// for each column; they are counted.
//
// cvode-adams-fixed-vector, cvode-bdf-fixed-vector: the same run to the last bit on vectors of fixed length
// (solvers/sundials_vector.hpp). The rest of a step is CVODE's own bookkeeping.
//
// None keeps energy or momentum. Source: Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005); feedback: Corbett &
// Wright, WADC TR 57-425 (1957), after Phillips, Hailey & Gebert, J. Aircraft 38 (2001), 718, and Baumgarte,
// Comput. Methods Appl. Mech. Eng. 1 (1972), 1; stability limit: Hindmarsh, LLNL UCRL-JC-118465 (1995).
#include <cassert>

#include "models/model.hpp"
#include "solvers/matrix_form.hpp"
#include "solvers/sundials_cvode.hpp"

namespace polhode {
namespace {

using namespace sundials;
using Formula = CvodeChoice::Formula;

/// A model with something changed; it begins with q.
class Changed : public ErasedModel {
 public:
  explicit Changed(std::unique_ptr<ErasedModel> model) : model_(std::move(model)) {}
  bool has_attitude() const override { return model_->has_attitude(); }
  std::span<const double> initial() const override { return model_->initial(); }
  void rhs(double t, const double* y, double* d) const override { model_->rhs(t, y, d); }
  void jacobian(double t, const double* y, double* J) const override { model_->jacobian(t, y, J); }
  Sample sample(double t, const double* y) const override { return model_->sample(t, y); }

 protected:
  static double squared_length(const double* q) {
    return q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  }

 private:
  std::unique_ptr<ErasedModel> model_;
};

class SampledOnTheSphere final : public Changed {
 public:
  using Changed::Changed;
  Sample sample(double t, const double* y) const override {
    std::vector<double> unit(y, y + size());
    const double scale = 1 / std::sqrt(squared_length(y));
    for (std::size_t i = 0; i < 4; ++i) unit[i] *= scale;
    return Changed::sample(t, unit.data());
  }
};

class DrawnToTheSphere final : public Changed {
 public:
  DrawnToTheSphere(std::unique_ptr<ErasedModel> model, double rate) : Changed(std::move(model)), k_(rate) {}
  void rhs(double t, const double* y, double* d) const override {
    Changed::rhs(t, y, d);
    const double draw = k_ * (1 - squared_length(y));
    for (std::size_t i = 0; i < 4; ++i) d[i] += draw * y[i];
  }
  void jacobian(double t, const double* y, double* J) const override {
    Changed::jacobian(t, y, J);
    const double draw = k_ * (1 - squared_length(y));
    const auto n = static_cast<std::size_t>(size());
    for (std::size_t row = 0; row < 4; ++row)
      for (std::size_t column = 0; column < 4; ++column)
        J[column * n + row] += (row == column ? draw : 0) - 2 * k_ * y[row] * y[column];
  }

 private:
  double k_;  // 1/s
};

/// The scene in the lecture notes' state.
template <WithAttitude M>
class MatrixModel final : public ErasedModel {
 public:
  using State = MatrixForm::State<M>;
  explicit MatrixModel(M model) : model_(std::move(model)), initial_(MatrixForm::start(model_)) {}
  bool has_attitude() const override { return false; }  // no q at the head of its state
  std::span<const double> initial() const override { return initial_; }
  void rhs(double t, const double* y, double* d) const override { MatrixForm::rhs(model_, t, y, d); }
  void jacobian(double, const double*, double*) const override { assert(false); }  // Adams asks for none
  Sample sample(double t, const double* y) const override {
    State state;
    std::copy_n(y, state.size(), state.begin());
    return MatrixForm::sample(model_, t, state);
  }

 private:
  M model_;
  State initial_;
};

Prepared adams_renormalised(const Scene& scene, const Setting& setting) {
  auto model = erased_model(scene);
  if (!model->has_attitude()) return {{}, "needs an attitude to renormalise"};
  return run_cvode(std::make_unique<SampledOnTheSphere>(std::move(model)), setting, {});
}

Prepared adams_norm_feedback(const Scene& scene, const Setting& setting) {
  auto model = erased_model(scene);
  if (!model->has_attitude()) return {{}, "needs an attitude to keep of unit length"};
  const double spin = scene.rotation->w0.norm();
  const double rate = spin > 0 ? spin : 10 / scene.duration;
  return run_cvode(std::make_unique<DrawnToTheSphere>(std::move(model), rate), setting, {});
}

Prepared adams_matrix(const Scene& scene, const Setting& setting) {
  auto model = with_general_model<double>(scene, [](auto m) -> std::unique_ptr<ErasedModel> {
    using M = decltype(m);
    if constexpr (WithAttitude<M>)
      return std::make_unique<MatrixModel<M>>(std::move(m));
    else
      return nullptr;
  });
  if (!model) return {{}, std::string(MatrixForm::needs)};
  return run_cvode(std::move(model), setting, {});
}

constexpr CvodeChoice stability_limit = {.formula = Formula::bdf, .stability_limit = true},
                      differences = {.formula = Formula::bdf, .difference_quotients = true},
                      adams_fixed_vector = {.fixed_length_vectors = true},
                      bdf_fixed_vector = {.formula = Formula::bdf, .fixed_length_vectors = true};
template <const CvodeChoice& choice>
Prepared chosen(const Scene& scene, const Setting& setting) {
  return run_cvode(erased_model(scene), setting, choice);
}

constexpr Claims on_the_sphere = [] {
  Claims c = keeps_nothing;
  c.unit_attitude = Claim::yes;
  return c;
}();

constexpr Method row(std::string_view id, std::string_view summary, std::string_view source,
                     Prepared (*prepare)(const Scene&, const Setting&),
                     const Claims& claims = keeps_nothing) {
  return {.id = id,
          .family = "SUNDIALS CVODE",
          .summary = summary,
          .source = source,
          .version = sundials_version,
          .by_tolerance = true,
          .in_studies = false,
          .claims = claims,
          .prepare = prepare};
}

constinit const Method rows[] = {
    row("cvode-adams-renormalised", "Adams-Moulton on (q, w_B), q of each sample divided by its length",
        cvode_source, adams_renormalised, on_the_sphere),
    row("cvode-adams-norm-feedback", "Adams-Moulton on (q, w_B) with q' = q w/2 + k (1 - |q|^2) q",
        "Corbett & Wright, WADC TR 57-425 (1957); Phillips, Hailey & Gebert, J. Aircraft 38 (2001), 718",
        adams_norm_feedback),
    row("cvode-adams-matrix", "Adams-Moulton on (R, w_S), twelve numbers", cvode_source, adams_matrix),
    row("cvode-bdf-stability-limit", "cvode-bdf with CVODE's detection of stability limits",
        "Hindmarsh, LLNL UCRL-JC-118465 (1995)", chosen<stability_limit>),
    row("cvode-bdf-differences", "cvode-bdf with the Jacobian from difference quotients", cvode_source,
        chosen<differences>),
    row("cvode-adams-fixed-vector", "cvode-adams on vectors of fixed length: same results, its cost",
        cvode_source, chosen<adams_fixed_vector>),
    row("cvode-bdf-fixed-vector", "cvode-bdf on vectors of fixed length: same results, its cost",
        cvode_source, chosen<bdf_fixed_vector>),
};

}  // namespace
extern const MethodRows cvode_variants;
const MethodRows cvode_variants = rows;
}  // namespace polhode
