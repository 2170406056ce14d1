// Simbody's side of the Simbody module; C++17, which its headers need. What the rows are is said in
// simbody_rows.cpp.
#include "solvers/engines/simbody.hpp"

#include <Simbody.h>

namespace polhode {
namespace {

SimTK::Vec3 to_simbody(const Vec3& a) { return {a.x(), a.y(), a.z()}; }
Vec3 from_simbody(const SimTK::Vec3& a) { return {a[0], a[1], a[2]}; }

/// The loads of the scene, asked by Simbody whenever it computes accelerations.
class Loads : public SimTK::Force::Custom::Implementation {
 public:
  Loads(const EngineBody& b, const SimTK::MobilizedBody& mobilized) : b_(b), mobilized_(mobilized) {}
  void calcForce(const SimTK::State& s, SimTK::Vector_<SimTK::SpatialVec>& forces,
                 SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const override {
    SimTK::SpatialVec& f = forces[mobilized_.getMobilizedBodyIndex()];
    if (b_.torque_S) {
      const SimTK::Rotation& R = mobilized_.getBodyRotation(s);
      Mat3 R_SB;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) R_SB(i, j) = R[i][j];
      f[0] += to_simbody(b_.torque_S(s.getTime(), R_SB, from_simbody(mobilized_.getBodyAngularVelocity(s))));
    }
    f[1] -= b_.drag * mobilized_.getBodyOriginVelocity(s);
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }

 private:
  const EngineBody& b_;
  SimTK::MobilizedBody mobilized_;
};

class Run final : public SimbodyRun {
 public:
  Run(const EngineBody& b, SimbodyIntegrator integrator, double accuracy)
      : b_(b), matter_(system_), forces_(system_), gravity_(forces_, matter_, to_simbody(b.gravity_S)) {
    const SimTK::Body::Rigid rigid(
        SimTK::MassProperties(b.mass, SimTK::Vec3(0), SimTK::Inertia(to_simbody(b.moments))));
    if (!b.rotates)
      mobilized_ = SimTK::MobilizedBody::Translation(matter_.updGround(), rigid);
    else if (!b.moves)
      mobilized_ = SimTK::MobilizedBody::Ball(matter_.updGround(), rigid);
    else
      mobilized_ = SimTK::MobilizedBody::Free(matter_.updGround(), rigid);
    if (b.torque_S || b.drag != 0) SimTK::Force::Custom(forces_, new Loads(b, mobilized_));
    start_ = system_.realizeTopology();
    system_.realizeModel(start_);
    if (b.rotates) {
      const Quaternion& q = b.q0;
      mobilized_.setQToFitRotation(
          start_, SimTK::Rotation(SimTK::Quaternion(SimTK::Vec4(q.w(), q.x(), q.y(), q.z()), true)));
      mobilized_.setUToFitAngularVelocity(start_, to_simbody(to_space<double>(q, b.w0_B)));
    }
    if (b.moves) {
      mobilized_.setQToFitTranslation(start_, to_simbody(b.p0_S));
      mobilized_.setUToFitLinearVelocity(start_, to_simbody(b.v0_S));
    }
    integrator_ = make(integrator);
    integrator_->setAccuracy(accuracy);
    restart(1);
  }

  void restart(double t_end) override {
    integrator_->setFinalTime(t_end);
    integrator_->initialize(start_);
    integrator_->resetAllStatistics();
  }
  std::string advance(double t, int most) override {
    try {
      integrator_->setInternalStepLimit(most);
      const auto before = integrator_->getNumStepsTaken();
      // The first call after `initialize` returns at once, and one that ends at a time may stop short of the
      // next.
      while (integrator_->getTime() < t && !integrator_->isSimulationOver() &&
             integrator_->getNumStepsTaken() - before < most)
        integrator_->stepTo(t);
      system_.realize(integrator_->getState(), SimTK::Stage::Velocity);
      return {};
    } catch (const std::exception& e) {
      return e.what();
    }
  }
  double time() const override { return integrator_->getTime(); }

  EngineState state() const override {
    const SimTK::State& s = integrator_->getState();
    system_.realize(s, SimTK::Stage::Velocity);
    EngineState out;
    if (b_.rotates) {
      const SimTK::Vector q = mobilized_.getQAsVector(s);  // what is integrated, of the length that it has
      out.q = Quaternion(q[0], q[1], q[2], q[3]);
      out.unit_defect = std::abs(std::sqrt(squared_norm(out.q)) - 1);
      out.w_B = to_body<double>(out.q, from_simbody(mobilized_.getBodyAngularVelocity(s)));
    }
    if (b_.moves) {
      out.p_S = from_simbody(mobilized_.getBodyOriginLocation(s));
      out.v_S = from_simbody(mobilized_.getBodyOriginVelocity(s));
    }
    return out;
  }
  SimbodyCounts counts() const override {
    const auto& i = *integrator_;
    return {i.getNumStepsTaken(), i.getNumStepsAttempted() - i.getNumStepsTaken(), i.getNumRealizations()};
  }

 private:
  std::unique_ptr<SimTK::Integrator> make(SimbodyIntegrator integrator) const {
    switch (integrator) {
      case SimbodyIntegrator::rk_merson:
        return std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
      case SimbodyIntegrator::cpodes:
        return std::make_unique<SimTK::CPodesIntegrator>(system_);
      case SimbodyIntegrator::verlet:
        return std::make_unique<SimTK::VerletIntegrator>(system_);
      case SimbodyIntegrator::semi_explicit_euler2:
        return std::make_unique<SimTK::SemiExplicitEuler2Integrator>(system_);
    }
    return nullptr;
  }

  const EngineBody& b_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::UniformGravity gravity_;
  SimTK::MobilizedBody mobilized_;
  SimTK::State start_;
  std::unique_ptr<SimTK::Integrator> integrator_;
};

}  // namespace

std::unique_ptr<SimbodyRun> make_simbody(const EngineBody& body, SimbodyIntegrator integrator,
                                         double accuracy) {
  return std::make_unique<Run>(body, integrator, accuracy);
}

std::string simbody_version() {
  int major = 0, minor = 0, patch = 0;
  SimTK_version_simbody(&major, &minor, &patch);
  return std::to_string(major) + "." + std::to_string(minor) + (patch > 0 ? "." + std::to_string(patch) : "");
}

}  // namespace polhode
