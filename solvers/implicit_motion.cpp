// The truth of stiff scenes: Radau IIA of high order in 50 digits, 23 stages with steps that miss 1e-33 of
// the state, against 19 and 1e-28. What is kept is the collocation polynomial of each step.
#include <Eigen/Eigenvalues>

#include "models/errors.hpp"
#include "solvers/radau_run.hpp"
#include "solvers/second_method.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {
namespace {

class ImplicitMotion final : public ExactMotion {
 public:
  static constexpr int stages = 23, fewer_stages = 19;
  static constexpr std::int64_t step_limit = 20'000;

  explicit ImplicitMotion(const Scene& scene) : exact_(exact_scene(scene)), doubles_(erased_model(scene)) {
    with_general_model<Wide>(exact_, [this](const auto& m) { open(m); });
  }

  void run(double until, const Allowance& allowance) {
    const Wide end[] = {Wide(until)};
    Run::State y = initial_;
    go(
        *run_, y, end, 1e-33, allowance, [](const Wide&, std::span<const Wide>) {},
        [this](const Run::Step& step) {
          steps_.push_back({step, {}});
        });
    // The coarser run at the ends of all steps.
    std::vector<Wide> ends;
    std::vector<WideSample> samples;
    for (const Kept& kept : steps_) {
      ends.push_back(kept.step.t + kept.step.h);
      Run::State at_end = kept.step.y;
      for (std::size_t i = 0; i < at_end.size(); ++i)
        at_end[i] += kept.step.z(static_cast<int>(i), stages - 1);
      samples.push_back(sample_(ends.back(), at_end));
    }
    const Wide least = least_rate(samples, natural_rate(exact_));
    Uncertainty u;
    std::size_t i = 0;
    y = initial_;
    const auto coarse = with_general_model<Wide>(
        exact_, [this](const auto& m) { return std::make_unique<Run>(m, *doubles_, fewer_stages); });
    go(*coarse, y, ends, 1e-28, allowance,
       [&](const Wide& at, std::span<const Wide> state) {
         const WideSample other = sample_(at, Run::State(state.begin(), state.end()));
         widen(u, samples[i], other.q, other.w_B, least);
         steps_[i++].until = u;
       },
       {});
  }

  std::vector<WideSample> at(std::span<const Wide> times, const Allowance& allowance) const override {
    std::vector<WideSample> samples;
    for (const Wide& t : times) {
      allowance.spend();
      const Run::Step& s = step_of(t).step;
      samples.push_back(sample_(t, t == s.t ? s.y : run_->inside(s.y, s.z, Wide((t - s.t) / s.h))));
    }
    return samples;
  }
  Uncertainty uncertainty(std::span<const WideSample> samples, const Allowance&) const override {
    return samples.empty() ? Uncertainty() : step_of(samples.back().t).until;
  }
  std::string kind() const override { return "Radau IIA of 23 stages in 50 digits, against 19"; }
  std::int64_t steps() const override { return static_cast<std::int64_t>(steps_.size()); }

  std::string saved() const override {
    Words words;
    words.add("implicit");
    words.add(steps());
    for (const Kept& kept : steps_) {
      words.add(kept.step.t);
      words.add(kept.step.h);
      for (const Wide& x : kept.step.y) words.add(x);
      for (Eigen::Index i = 0; i < kept.step.z.size(); ++i) words.add(kept.step.z.data()[i]);
      words.add(Wide(kept.until.attitude));
      words.add(Wide(kept.until.rate));
    }
    return words.text;
  }
  bool read(std::string_view bytes) {
    WordReader words(bytes);
    if (words.word() != "implicit") return false;
    for (std::int64_t n = words.integer(); n > 0; --n) {
      Kept kept;
      kept.step.t = words.number();
      kept.step.h = words.number();
      kept.step.y = initial_;
      for (Wide& x : kept.step.y) x = words.number();
      kept.step.z.resize(static_cast<Eigen::Index>(initial_.size()), stages);
      for (Eigen::Index i = 0; i < kept.step.z.size(); ++i) kept.step.z.data()[i] = words.number();
      kept.until.attitude = words.number().convert_to<double>();
      kept.until.rate = words.number().convert_to<double>();
      steps_.push_back(std::move(kept));
    }
    return !steps_.empty();
  }

 private:
  using Run = RadauRun<Wide>;
  struct Kept {
    Run::Step step;
    Uncertainty until;  // the largest difference of the two runs until its end
  };

  template <class M>
  void open(const M& m) {
    initial_.assign(m.initial.begin(), m.initial.end());
    run_ = std::make_unique<Run>(m, *doubles_, stages);
    sample_ = [m](const Wide& t, const Run::State& y) {
      typename M::State state;
      std::copy(y.begin(), y.end(), state.begin());
      return wide_sample(m, t, state);
    };
  }

  static void go(Run& run, Run::State& y, std::span<const Wide> times, double tolerance,
                 const Allowance& allowance,
                 const std::function<void(const Wide&, std::span<const Wide>)>& visit,
                 const std::function<void(const Run::Step&)>& took) {
    Wide t(0);
    if (run.run(t, std::span(y), times, tolerance, step_limit, visit, took, [&] { allowance.spend(); }) < 0)
      throw Error(70, "the implicit reference solution found no acceptable step at t = " +
                          std::to_string(t.convert_to<double>()) + " s");
  }

  const Kept& step_of(const Wide& t) const {
    auto after = std::upper_bound(steps_.begin(), steps_.end(), t,
                                  [](const Wide& x, const Kept& s) { return x < s.step.t; });
    return after == steps_.begin() ? *after : *std::prev(after);
  }

  ExactScene exact_;
  std::unique_ptr<ErasedModel> doubles_;
  std::unique_ptr<Run> run_;
  Run::State initial_;
  std::function<WideSample(const Wide&, const Run::State&)> sample_;
  std::vector<Kept> steps_;
};

}  // namespace

bool is_stiff(const Scene& scene, double until) {
  if (!scene.rotation || scene.rotation->loads.empty()) return false;
  const auto model = erased_model(scene);
  Eigen::MatrixXd J(model->size(), model->size());
  model->jacobian(0.0, model->initial().data(), J.data());
  const Eigen::VectorXcd lambda = J.eigenvalues();
  // A series goes 2.4 decay times a step; beyond a few thousand steps of them the implicit method is cheaper.
  for (const auto& l : lambda)
    if (-l.real() > std::abs(l.imag()) && -l.real() * until > 2.4 * 2000) return true;
  return false;
}

std::unique_ptr<ExactMotion> implicit_motion(const Scene& scene, double until, const Allowance& allowance) {
  auto motion = std::make_unique<ImplicitMotion>(scene);
  motion->run(until, allowance);
  return motion;
}

std::unique_ptr<ExactMotion> restored_implicit(const Scene& scene, std::string_view bytes) {
  auto motion = std::make_unique<ImplicitMotion>(scene);
  if (!motion->read(bytes)) return nullptr;
  return motion;
}

}  // namespace polhode
