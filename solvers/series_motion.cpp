// The truth of any scene by Taylor series (solvers/taylor_run.hpp): order 48 with local terms below 1e-43 of
// the state, against order 40 and 1e-36.
//
// What is kept is the state at the beginning of each step: the series about it, made again, gives every time
// of the step.
#include "solvers/second_method.hpp"
#include "solvers/taylor_run.hpp"
#include "solvers/wide_sample.hpp"

namespace polhode {
namespace {

template <class M>
class SeriesMotion final : public ExactMotion {
 public:
  static constexpr int order = 48;
  static constexpr std::int64_t step_limit = 300'000;

  SeriesMotion(M model, double natural) : model_(std::move(model)), natural_rate_(natural) {}

  void run(double until, const Allowance& allowance) {
    const Wide end[] = {Wide(until)};
    TaylorSeries<M> series(model_, order);
    Wide t(0);
    State y = model_.initial;
    const auto keep = [&](const Wide& at) { steps_.push_back({at, y, series.held_signs(), {}}); };
    const std::int64_t taken = taylor_run(
        series, t, y, std::span<const Wide>(end), -143, step_limit,
        [](const Wide&, const State&) {},  // 1e-43
        [&] {
          allowance.spend();
          keep(t);
        });
    refuse_endless(taken, t);
    if (steps_.empty()) keep(t);
    compare(Wide(until), y, allowance);
  }

  std::vector<WideSample> at(std::span<const Wide> times, const Allowance& allowance) const override {
    std::vector<WideSample> samples;
    samples.reserve(times.size());
    TaylorSeries<M> series(model_, order);
    const Step* expanded = nullptr;
    for (const Wide& t : times) {
      const Step& step = step_of(t);
      if (&step != expanded) {
        allowance.spend();
        series.hold_signs(step.signs);
        series.expand(step.t, step.y);
        expanded = &step;
      }
      samples.push_back(wide_sample(model_, t, series.at(Wide(t - step.t))));
    }
    return samples;
  }

  Uncertainty uncertainty(std::span<const WideSample> samples, const Allowance&) const override {
    return samples.empty() ? Uncertainty() : step_of(samples.back().t).until;
  }
  std::string kind() const override { return "Taylor series of order 48 in 50 digits, against order 40"; }
  std::int64_t steps() const override { return static_cast<std::int64_t>(steps_.size()); }

  std::string saved() const override {
    Words words;
    words.add("series");
    words.add(steps());
    for (const Step& s : steps_) {
      words.add(s.t);
      for (const Wide& x : s.y) words.add(x);
      words.add("s" + s.signs);
      words.add(Wide(s.until.attitude));
      words.add(Wide(s.until.rate));
    }
    return words.text;
  }
  bool read(std::string_view bytes) {
    WordReader words(bytes);
    if (words.word() != "series") return false;
    for (std::int64_t n = words.integer(); n > 0; --n) {
      Step s;
      s.t = words.number();
      for (Wide& x : s.y) x = words.number();
      s.signs = words.word().substr(1);
      s.until.attitude = words.number().template convert_to<double>();
      s.until.rate = words.number().template convert_to<double>();
      steps_.push_back(std::move(s));
    }
    return !steps_.empty();
  }

 private:
  using State = typename M::State;
  struct Step {
    Wide t;
    State y;
    std::string signs;
    Uncertainty until;  // the largest difference of the two runs until the end of the step
  };

  static void refuse_endless(std::int64_t taken, const Wide& t) {
    if (taken < 0)
      throw Refused("its series takes more than " + std::to_string(step_limit) +
                    " steps to t = " + std::to_string(t.convert_to<double>()) + " s");
  }

  /// The coarser run at the ends of all steps.
  void compare(const Wide& until, const State& at_end, const Allowance& allowance) {
    std::vector<Wide> ends;
    std::vector<WideSample> samples;
    for (std::size_t i = 1; i < steps_.size(); ++i) {
      ends.push_back(steps_[i].t);
      samples.push_back(wide_sample(model_, steps_[i].t, steps_[i].y));
    }
    ends.push_back(until);
    samples.push_back(wide_sample(model_, until, at_end));
    TaylorSeries<M> series(model_, 40);
    Wide t(0);
    State y = model_.initial;
    Uncertainty u;
    std::size_t i = 0;
    Wide fastest(natural_rate_);
    const std::int64_t taken = taylor_run(
        series, t, y, std::span<const Wide>(ends), -120, step_limit,  // 2^-120 = 1e-36
        [&](const Wide& at, const State& state) {
          if constexpr (M::has_rotation) {
            const WideSample other = wide_sample(model_, at, state);
            // The rates are relative to the fastest so far, once they have died out.
            fastest = std::max(fastest, Wide(samples[i].w_B.norm()));
            widen(u, samples[i], other.q, other.w_B, Wide(fastest * Wide(1e-30)));
          }
          steps_[i++].until = u;
        },
        [&] { allowance.spend(); });
    refuse_endless(taken, t);
  }

  const Step& step_of(const Wide& t) const {
    auto after = std::upper_bound(steps_.begin(), steps_.end(), t,
                                  [](const Wide& x, const Step& s) { return x < s.t; });
    return after == steps_.begin() ? *after : *std::prev(after);
  }

  M model_;
  double natural_rate_;  // rad/s
  std::vector<Step> steps_;
};

}  // namespace

std::unique_ptr<ExactMotion> series_motion(const ExactScene& exact, double until,
                                           const Allowance& allowance) {
  return with_general_model<Wide>(exact, [&](const auto& m) -> std::unique_ptr<ExactMotion> {
    auto motion = std::make_unique<SeriesMotion<std::remove_cvref_t<decltype(m)>>>(m, natural_rate(exact));
    motion->run(until, allowance);
    return motion;
  });
}

std::unique_ptr<ExactMotion> restored_series(const ExactScene& exact, std::string_view bytes) {
  return with_general_model<Wide>(exact, [&](const auto& m) -> std::unique_ptr<ExactMotion> {
    auto motion = std::make_unique<SeriesMotion<std::remove_cvref_t<decltype(m)>>>(m, natural_rate(exact));
    if (!motion->read(bytes)) return nullptr;
    return motion;
  });
}

}  // namespace polhode
