// The closed form of a scene in doubles: no steps, each asked time costs the same.
//
// exact             set up in doubles; phases lose what rounding their rate costs, an ulp or two times t
// exact-extended    the triaxial free body set up in long double, with phases kept in two words: an error
//                   that does not grow before 1e4 periods, for three times the set-up
//
// A run sets the closed form up anew, so that its time is that of set-up and evaluations. Which scenes have
// one, and sources: models/closed_form.hpp.
#include "models/closed_form.hpp"
#include "solvers/erased_model.hpp"
#include "solvers/record.hpp"

namespace polhode {
namespace {

/// [q][w_B][p v] of the parts that the scene has.
class Flat {
 public:
  explicit Flat(const Scene& scene) : scene_(scene) {}
  const double* operator()(const ExactState<double>& x) {
    double* at = numbers_.data();
    if (scene_.rotation && scene_.rotation->attitude) {
      const double q[] = {x.q.w(), x.q.x(), x.q.y(), x.q.z()};
      at = std::copy(q, q + 4, at);
    }
    if (scene_.rotation) at = std::copy(x.w_B.data(), x.w_B.data() + 3, at);
    if (scene_.translation) {
      at = std::copy(x.p.data(), x.p.data() + 3, at);
      std::copy(x.v.data(), x.v.data() + 3, at);
    }
    return numbers_.data();
  }

 private:
  Scene scene_;
  std::array<double, 13> numbers_{};
};

Prepared evaluate(const Scene& scene, const Setting& setting, std::shared_ptr<ClosedForm<double>> form) {
  if (!form) return {{}, "the scene has no closed form that is known here"};
  std::shared_ptr<ErasedModel> model = erased_model(scene);
  const Sample start = model->sample(0.0, model->initial().data());
  return {[form = std::move(form), model = std::move(model), start, flat = Flat(scene), setting](
              const Grid& grid, Trajectory& out) mutable {
            Record record(setting, grid, out);
            form->set_up();
            record.start(start);
            for (const auto& stretch : grid.stretches) {
              ++out.work.steps;
              if (!record.keep(model->sample(stretch.t_end, flat(form->at(stretch.t_end))))) return;
            }
          },
          {}};
}

Prepared prepare_exact(const Scene& scene, const Setting& setting) {
  return evaluate(scene, setting, closed_form<double>(scene));
}
Prepared prepare_extended(const Scene& scene, const Setting& setting) {
  return evaluate(scene, setting, closed_form_extended(scene));
}

constexpr Claims claims = {.unit_attitude = Claim::yes,
                           .momentum_magnitude = Claim::yes,
                           .space_momentum = Claim::yes,
                           .energy_bounded = Claim::yes};
constexpr std::string_view source =
    "Jacobi (1850); van Zon & Schofield, J. Comput. Phys. 225 (2007); Celledoni, Fasso, Safstrom & Zanna, "
    "SIAM "
    "J. Sci. Comput. 30 (2008)";

constinit const Method rows[] = {
    {.id = "exact",
     .family = "closed form",
     .summary =
         "the closed form of the scene in doubles: attitude by theta functions, pendulum, exponentials",
     .source = source,
     .claims = claims,
     .prepare = prepare_exact},
    {.id = "exact-extended",
     .family = "closed form",
     .summary = "the same, the free body set up in long double with phases in two words",
     .source = source,
     .claims = claims,
     .prepare = prepare_extended},
};

}  // namespace
extern const MethodRows exact;
const MethodRows exact = rows;
}  // namespace polhode
