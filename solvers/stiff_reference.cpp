// The truth of stiff scenes: Radau IIA of high order in 50 digits, run twice.
#include <Eigen/Eigenvalues>

#include "models/errors.hpp"
#include "solvers/radau_run.hpp"
#include "solvers/reference.hpp"
#include "solvers/thread_time.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {

bool is_stiff(const Scene& scene, std::span<const double> times) {
  if (!scene.rotation || scene.rotation->loads.empty() || times.empty()) return false;
  const auto model = erased_model(scene);
  Eigen::MatrixXd J(model->size(), model->size());
  model->jacobian(0.0, model->initial().data(), J.data());
  const Eigen::VectorXcd lambda = J.eigenvalues();
  // A series goes 2.4 decay times a step; beyond a few thousand steps of them the implicit method is cheaper.
  for (const auto& l : lambda)
    if (-l.real() > std::abs(l.imag()) && -l.real() * times.back() > 2.4 * 2000) return true;
  return false;
}

Truth implicit_solution(const Scene& scene, std::span<const double> times) {
  constexpr std::int64_t step_limit = 20'000;
  const double began = thread_seconds();
  const auto doubles = erased_model(scene);
  Truth truth;
  truth.kind = "Radau IIA of 23 stages in 50 digits, against 19";
  with_general_model<Wide>(scene, [&](const auto& m) {
    using M = std::remove_cvref_t<decltype(m)>;
    const auto run = [&](int stages, double tolerance, std::vector<WideSample>& samples) {
      Wide t(0);
      typename M::State y = m.initial, there;
      const std::int64_t steps =
          RadauRun<Wide>(m, *doubles, stages)
              .run(t, y, times, tolerance, step_limit, [&](const Wide& at, auto state) {
                std::copy(state.begin(), state.end(), there.begin());
                samples.push_back(wide_sample(m, at, there));
              });
      if (steps < 0)
        throw Error(70, "the implicit reference solution found no acceptable step at t = " +
                            std::to_string(t.convert_to<double>()) + " s");
      return steps;
    };
    truth.steps = run(23, 1e-33, truth.samples);
    std::vector<WideSample> coarse;
    run(19, 1e-28, coarse);
    for (std::size_t i = 0; i < truth.samples.size(); ++i)
      widen_uncertainty(truth, i, coarse[i].q, coarse[i].w_B);
  });
  truth.cost_s = thread_seconds() - began;
  return truth;
}

}  // namespace polhode
