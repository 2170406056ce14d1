#include "solvers/erased_model.hpp"

#include "models/model.hpp"
#include "solvers/observe.hpp"

namespace polhode {
namespace {

template <AnyModel M>
class ErasedModelOf final : public ErasedModel {
 public:
  explicit ErasedModelOf(M model) : model_(std::move(model)) {}
  bool has_attitude() const override { return M::has_attitude; }
  std::span<const double> initial() const override { return model_.initial; }
  void rhs(double t, const double* y, double* d) const override { model_.rhs(t, y, d); }
  void jacobian(double t, const double* y, double* J) const override {
    model_.jacobian(t, y, Eigen::Map<Eigen::Matrix<double, M::size, M::size>>(J));
  }
  Sample sample(double t, const double* y) const override { return observe(model_, t, y); }

 private:
  M model_;
};

}  // namespace

std::unique_ptr<ErasedModel> erased_model(const Scene& scene) {
  return with_model(scene, [](auto model) -> std::unique_ptr<ErasedModel> {
    return std::make_unique<ErasedModelOf<decltype(model)>>(std::move(model));
  });
}

}  // namespace polhode
