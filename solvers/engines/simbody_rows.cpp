// Simbody: minimal coordinates, a quaternion and the angular velocity in space components, and integrators
// that choose their steps from an error estimate; the knob is Simbody's `accuracy`, the relative size of the
// error that a step may make. It is local: what adds up over a run is ten to ten thousand times as large.
//   rk-merson             Runge-Kutta-Merson, order 4 with an estimate of order 3 (Simbody's recommendation)
//   cpodes                CPODES, CVODE's BDF with projection onto constraints
//   verlet                velocity Verlet, order 2, with a loop for velocity-dependent forces
//   semi-explicit-euler2  semi-explicit Euler, order 1, extrapolated from one step and two of half its size
// Nothing is kept but what the accuracy keeps; Simbody projects the quaternion back to unit length where the
// defect exceeds a tenth of the accuracy. Asked times within a step are interpolated by Simbody.
//
// CPODES writes to standard error when it meets its own limit of steps, and has the names of SUNDIALS'
// functions: the program must not export those (it links SUNDIALS statically).
//
// Loads are a Force::Custom, gravity a Force::UniformGravity. No damping, sleep or limit on speed. A
// right-hand side costs some microseconds: Simbody is made for trees of many bodies with constraints, and
// does for one body all that such a tree needs.
//
// Source: Simbody 3.7; Sherman, Seth & Delp, Simbody: multibody dynamics for biomedical research, Procedia
// IUTAM 2 (2011); Hairer, Norsett & Wanner, Solving ODEs I (1993), II.4 (Merson).
#include <algorithm>
#include <string>

#include "solvers/engines/engine_run.hpp"
#include "solvers/engines/simbody.hpp"

namespace polhode {
namespace {

constexpr int steps_per_look = 1024;  // at the clock

struct Simbody {
  Simbody(const Scene& scene, SimbodyIntegrator integrator, double accuracy)
      : body(engine_body(scene)),
        observe(observe_engine(scene)),
        run(make_simbody(body, integrator, accuracy)) {}
  EngineBody body;
  Observe observe;
  std::unique_ptr<SimbodyRun> run;
};

void integrate(Simbody& s, const Setting& setting, const Grid& grid, Trajectory& out) {
  Record record(setting, grid, out);
  s.run->restart(grid.end());
  record.start(s.observe(0, s.run->state()));
  const auto count = [&] {
    const SimbodyCounts c = s.run->counts();
    out.work = {c.steps, c.rejected, c.realizations, 0};
  };
  for (const auto& asked : grid.stretches) {
    while (s.run->time() < asked.t_end) {
      const std::int64_t left = setting.step_limit - s.run->counts().steps;
      if (left <= 0) {
        record.end(Outcome::step_limit, "gave up after " + std::to_string(setting.step_limit) + " steps",
                   s.run->time());
        return;
      }
      const double before = s.run->time();
      const std::string fault =
          s.run->advance(asked.t_end, static_cast<int>(std::min<std::int64_t>(left, steps_per_look)));
      count();
      if (!fault.empty()) {
        record.end(Outcome::solver_failed, "Simbody: " + fault.substr(0, fault.find('\n')), s.run->time());
        return;
      }
      if (!(s.run->time() > before) && s.run->counts().steps == 0) {
        record.end(Outcome::solver_failed, "Simbody took no step", s.run->time());
        return;
      }
      if (!record.in_time(s.run->time())) return;
    }
    if (!record.keep(s.observe(asked.t_end, s.run->state()))) return;
  }
}

template <SimbodyIntegrator integrator>
Prepared prepare(const Scene& scene, const Setting& setting) {
  if (!is_served(scene)) return {{}, engines_need_an_attitude};
  if (setting.knob != Knob::tolerance) return {{}, "Simbody chooses its steps: it needs a tolerance"};
  try {
    return {[s = std::make_shared<Simbody>(scene, integrator, setting.rtol), setting](
                const Grid& grid, Trajectory& out) { integrate(*s, setting, grid, out); },
            {}};
  } catch (const std::exception& e) {
    return {{}, std::string("Simbody refuses the body: ") + e.what()};
  }
}

// At an accuracy of 1e-6. Whether the energy of the others stays bounded would take minutes to see.
constexpr Claims momentum_lost = {.momentum_magnitude = Claim::no, .space_momentum = Claim::no};
constexpr Claims nothing_kept = [] {
  Claims c = momentum_lost;
  c.energy_bounded = Claim::no;
  return c;
}();

constexpr const char* settings =
    "accuracy = rtol; quaternion projected when off by a tenth of it; times within a step interpolated by "
    "Simbody";

}  // namespace
}  // namespace polhode

const std::size_t polhode_engine_stamp = polhode::engine_stamp;

const polhode::MethodRows* polhode_engine_rows() {
  using namespace polhode;
  static const std::string version = "Simbody " + simbody_version();
  static const auto row = [](const char* id, const char* summary, const char* source, const Claims& claims,
                             decltype(Method::prepare) run) {
    return Method{.id = id,
                  .family = "engine",
                  .summary = summary,
                  .source = source,
                  .version = version,
                  .settings = settings,
                  .by_tolerance = true,
                  .in_studies = false,
                  .claims = claims,
                  .prepare = run};
  };
  static const Method methods[] = {
      row("simbody-rk-merson", "Simbody's Runge-Kutta-Merson, order 4, error-controlled: its recommendation",
          "Simbody, RungeKuttaMersonIntegrator; Hairer, Norsett & Wanner, Solving ODEs I (1993), II.4",
          nothing_kept, prepare<SimbodyIntegrator::rk_merson>),
      row("simbody-cpodes", "Simbody's CPODES: BDF of variable order with projection, error-controlled",
          "Simbody, CPodesIntegrator; Hindmarsh et al., SUNDIALS, ACM TOMS 31 (2005)", momentum_lost,
          prepare<SimbodyIntegrator::cpodes>),
      row("simbody-verlet", "Simbody's velocity Verlet, order 2, error-controlled",
          "Simbody, VerletIntegrator; Swope, Andersen, Berens & Wilson, J. Chem. Phys. 76 (1982)",
          momentum_lost, prepare<SimbodyIntegrator::verlet>),
      row("simbody-semi-explicit-euler2",
          "Simbody's semi-explicit Euler of two half steps against one, error-controlled",
          "Simbody, SemiExplicitEuler2Integrator", momentum_lost,
          prepare<SimbodyIntegrator::semi_explicit_euler2>),
  };
  static const MethodRows rows = methods;
  return &rows;
}
