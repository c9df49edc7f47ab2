#include <gelenk/kinematics/io/urdf.h>
#include <gelenk/skinning/io/gltf.h>
#include <gelenk/solvers/problem/ik_solver.h>

#include <cstdio>

/// The optional parts link: a robot of two links from URDF text, through glTF and back; a solver of Ceres.
int main() {
  const gelenk::UrdfRobot robot = gelenk::parseUrdf(
      "<robot name='two'><link name='a'/><link name='b'/>"
      "<joint name='j' type='continuous'><parent link='a'/><child link='b'/>"
      "<origin xyz='0 0 0.5'/><axis xyz='0 1 0'/></joint></robot>",
      "two.urdf");
  const std::string bytes = gelenk::formatGlb(robot.skeleton, nullptr, {});
  const gelenk::GltfModel back = gelenk::parseGltf(bytes, "two.glb");
  const bool fine = robot.skeleton.nv() == 1 && back.skeleton.jointCount() == robot.skeleton.jointCount() &&
                    gelenk::makeSolver("ceres-lm") != nullptr;
  if (!fine) std::printf("the optional parts do not do what they should\n");
  return fine ? 0 : 1;
}
