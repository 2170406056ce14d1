#include "solvers/record.hpp"

#include <cmath>

namespace polhode {
namespace {

bool is_finite(const Sample& s) {
  return s.q.coeffs().allFinite() && s.w_B.allFinite() && s.p.allFinite() && s.v.allFinite();
}

}  // namespace

Record::Record(const Setting& setting, const Grid& grid, Trajectory& out)
    : setting_(setting), from_start_(grid.from_start), timed_(setting.timeout_s < 1e9), out_(out) {
  if (timed_) began_ = clock::now();
  out.samples.clear();
  out.samples.reserve(grid.stretches.size() + 1);
  out.work = {};
  out.outcome = Outcome::ok;
  out.reason.clear();
}

void Record::start(const Sample& sample) {
  start_energy_ = sample.rotational_energy + std::abs(sample.total_energy);
  if (from_start_) out_.samples.push_back(sample);
}

bool Record::keep(const Sample& s) {
  if (!is_finite(s)) return end(Outcome::not_finite, "a state that is not finite", s.t);
  // No scene here gains 1e12 times its energy; an unstable step size does within a few dozen steps. From rest
  // there is nothing to compare with.
  if (start_energy_ > 0 && s.rotational_energy > 1e12 * start_energy_)
    return end(Outcome::diverged, "kinetic energy beyond 1e12 times its start", s.t);
  out_.samples.push_back(s);
  return true;
}

bool Record::in_time(double t) {
  if (!timed_ || std::chrono::duration<double>(clock::now() - began_).count() <= setting_.timeout_s)
    return true;
  return end(Outcome::timeout, "still running after " + std::to_string(setting_.timeout_s) + " s", t);
}

bool Record::end(Outcome outcome, std::string reason, double t) {
  out_.outcome = outcome;
  out_.reason = std::move(reason) + " at t = " + std::to_string(t) + " s";
  return false;
}

}  // namespace polhode
