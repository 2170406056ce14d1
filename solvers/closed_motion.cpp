// The truth of scenes that have a closed form: in 50 digits, and in 40 to see what they leave.
#include "models/closed_form.hpp"
#include "solvers/second_method.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {
namespace {

class ClosedMotion final : public ExactMotion {
 public:
  ClosedMotion(const Scene& scene, std::unique_ptr<ClosedForm<Wide>> form)
      : exact_(exact_scene(scene)),
        form_(std::move(form)),
        narrower_(closed_form<Narrower>(scene)),
        kind_("closed form: " + closed_form_kind(scene) + ", in 50 digits against 40") {}

  std::vector<WideSample> at(std::span<const Wide> times, const Allowance& allowance) const override {
    std::vector<WideSample> samples;
    samples.reserve(times.size());
    with_general_model<Wide>(exact_, [&](const auto& m) {
      using M = std::remove_cvref_t<decltype(m)>;
      for (const Wide& t : times) {
        allowance.spend();
        const ExactState<Wide> x = form_->at(t);
        typename M::State y = m.initial;
        if constexpr (M::has_attitude) {
          const Wide q[] = {x.q.w(), x.q.x(), x.q.y(), x.q.z()};
          std::copy(q, q + 4, y.begin());
        }
        for (std::size_t i = 0; i < 3; ++i) {
          const auto k = static_cast<int>(i);
          if constexpr (M::has_rotation) y[std::size_t(M::Rotating::w_at) + i] = x.w_B[k];
          if constexpr (M::has_translation) {
            y[std::size_t(M::rotation_size) + i] = x.p[k];
            y[std::size_t(M::rotation_size) + 3 + i] = x.v[k];
          }
        }
        samples.push_back(wide_sample(m, t, y));
      }
    });
    return samples;
  }

  /// At up to 17 of the times, the last among them. What 40 digits miss is ten digits more than what 50 miss,
  /// so that no sample between them is worse than this says.
  Uncertainty uncertainty(std::span<const WideSample> samples, const Allowance& allowance) const override {
    Uncertainty u;
    if (!exact_.rotation) return u;
    const Wide least = least_rate(samples, natural_rate(exact_));
    const std::size_t every = std::max<std::size_t>(1, samples.size() / 16);
    for (std::size_t i = samples.empty() ? 0 : (samples.size() - 1) % every; i < samples.size(); i += every) {
      allowance.spend();
      if (samples[i].t == 0) continue;  // known without any rounding, and maybe at rest
      const ExactState<Narrower> x = narrower_->at(Narrower(samples[i].t));
      const QuaternionT<Wide> q = x.q.template cast<Wide>();
      widen(u, samples[i], exact_.rotation->attitude ? q : samples[i].q, x.w_B.template cast<Wide>(), least);
    }
    return u;
  }
  std::string kind() const override { return kind_; }

 private:
  ExactScene exact_;
  std::unique_ptr<ClosedForm<Wide>> form_;
  std::unique_ptr<ClosedForm<Narrower>> narrower_;
  std::string kind_;
};

}  // namespace

std::unique_ptr<ExactMotion> closed_motion(const Scene& scene) {
  auto form = closed_form<Wide>(scene);
  if (!form) return nullptr;
  return std::make_unique<ClosedMotion>(scene, std::move(form));
}

}  // namespace polhode
