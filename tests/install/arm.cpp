#include <gelenk/kinematics/forward_kinematics.h>
#include <gelenk/kinematics/notation/dh_table.h>
#include <gelenk/kinematics/notation/mannequin.h>
#include <gelenk/kinematics/notation/robots.h>
#include <gelenk/skinning/blend/linear_blend.h>
#include <gelenk/solvers/problem/ik_solver.h>
#include <gelenk/solvers/problem/judge.h>
#include <gelenk/solvers/tree/drag_solver.h>

#include <cstdio>
#include <stdexcept>
#include <string>

namespace user {

/// Solves for a pose of the Panda that its own forward kinematics gave; true where the judge agrees.
bool posePanda(const std::string& solverName) {
  const gelenk::Skeleton arm = gelenk::toSkeleton(gelenk::robotTable("panda"));
  Eigen::VectorXd q = arm.rest();
  q[0] += 0.3;
  q[3] -= 0.4;
  q[5] += 0.2;
  const Eigen::Isometry3d tool = gelenk::forwardKinematics(arm, q).back();
  gelenk::Goal goal{
      .kind = gelenk::GoalKind::Pose, .joint = arm.jointCount() - 1, .target = tool.translation()};
  goal.orientation = Eigen::Quaterniond(tool.linear());
  const gelenk::IkProblem problem{.skeleton = &arm, .start = arm.rest(), .goals = {goal}};
  const auto solver = gelenk::makeSolver(solverName);
  solver->prepare(arm);
  return gelenk::judge(problem, solver->solve(problem, {}, gelenk::TraceLevel::Off).q).solved;
}

/// How far a hand of the figure stays from a target that is dragged 10 cm in 40 frames, metres.
double dragHand() {
  const gelenk::Skeleton figure = gelenk::mannequin();
  gelenk::DragSolver solver(figure);
  solver.reset(figure.rest());
  const int hand = *figure.findJoint("hand_l");
  const Eigen::Vector3d start = gelenk::restFrames(figure)[hand].translation();
  gelenk::Goal drag;
  drag.joint = hand;
  for (int i = 1; i <= 40; ++i) {
    drag.target = start + Eigen::Vector3d(0.0, 0.0, 0.1 * i / 40.0);
    solver.frame({&drag, 1});
  }
  return (gelenk::forwardKinematics(figure, solver.q())[hand].translation() - drag.target).norm();
}

/// A triangle rigidly bound to the Panda's second joint must follow it: the largest error, metres.
double skinTriangle() {
  const gelenk::Skeleton arm = gelenk::toSkeleton(gelenk::robotTable("panda"));
  gelenk::Mesh mesh;
  mesh.positions = {{0.0, 0.0, 0.0}, {0.1, 0.0, 0.0}, {0.0, 0.1, 0.2}};
  mesh.triangles = {{0, 1, 2}};
  gelenk::Influences second;
  second.joints[0] = 2;
  const gelenk::Frames rest = gelenk::restFrames(arm);
  const gelenk::Skin skin = gelenk::bindSkin(mesh, rest, {second, second, second});
  Eigen::VectorXd q = arm.rest();
  q[1] += 0.7;
  const gelenk::Frames frames = gelenk::forwardKinematics(arm, q);
  const auto moved = gelenk::linearBlendSkin(skin, frames).positions;
  double worst = 0.0;
  for (int v = 0; v < 3; ++v)
    worst = std::max(worst, (frames[2] * (rest[2].inverse() * mesh.positions[v]) - moved[v]).norm());
  return worst;
}

/// What the catalogue says of a solver that may be missing.
std::string complaintAbout(const std::string& solverName) {
  try {
    gelenk::makeSolver(solverName);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "";
}

}  // namespace user
