// A program that uses Bullet as its manual shows, and nothing of polhode: the body of the scene
// hairer-vilmart (0.6, 0.8, 1 kg m^2, body momentum 1.8, 0.4, -0.9) turning for 10 s, written as CSV with
// rates in space, as Bullet has them.
//
//   bare_bullet STEPS ROWS
#include <cstdio>
#include <cstdlib>

#include <btBulletDynamicsCommon.h>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const int steps = std::atoi(argv[1]), rows = std::atoi(argv[2]);
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher(&configuration);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &configuration);
  world.setGravity({0, 0, 0});
  btEmptyShape shape;
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, {0.6, 0.8, 1}));
  body.setAngularVelocity({1.8 / 0.6, 0.4 / 0.8, -0.9});
  body.setDamping(0, 0);
  body.setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(&body);
  std::puts("time,qx,qy,qz,qw,wx_space,wy_space,wz_space");
  for (int i = 0; i <= steps; ++i) {
    if (i > 0) world.stepSimulation(10.0 / steps, 0, 10.0 / steps);
    if (i % (steps / rows) != 0) continue;
    const btQuaternion q = body.getWorldTransform().getRotation();
    const btVector3& w = body.getAngularVelocity();
    std::printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", i == steps ? 10.0 : 10.0 * i / steps,
                q.x(), q.y(), q.z(), q.w(), w.x(), w.y(), w.z());
  }
  world.removeRigidBody(&body);
  return 0;
}
