#include "solvers/drag_solver.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"
#include "tests/solvers/drag_marks.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

TEST(DragSolver, HeldReachableTargetIsMetWhileTheFeetStay) {
  const marks::Figure figure;
  DragSolver solver(figure.skeleton);
  std::vector<DragGoal> goals = figure.goals();
  goals[0].goal.target += Vector3d(-0.1, 0.15, 0.05);
  for (int frame = 0; frame < 60; ++frame) solver.frame(goals);
  const Frames frames = forwardKinematics(figure.skeleton, solver.q());
  for (int k = 0; k < marks::Figure::dragCount; ++k)
    EXPECT_LE((figure.dragged(frames, k) - goals[k].goal.target).norm(), 1e-5);
  EXPECT_LE(figure.pinError(frames), 1e-5);
  EXPECT_EQ(solver.frame(goals).why, Stop::Converged);
}

}  // namespace
}  // namespace gelenk
