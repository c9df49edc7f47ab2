#include "solvers/methods/clip_goals.h"

#include <gtest/gtest.h>

#include "kinematics/forward_kinematics.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

TEST(ClipGoals, AHandHeldOverTwoFramesStaysThereAndOtherFramesAreUntouched) {
  std::vector<Joint> joints{
      {.name = "shoulder", .ball = true}, {.name = "elbow", .parent = 0}, {.name = "hand", .parent = 1}};
  joints[1].parentFromZero.translation() = Vector3d(0.3, 0, 0);
  joints[1].axes = {{AxisDof::Kind::Rotation, Vector3d::UnitY(), 0.0, 2.5}};
  joints[2].parentFromZero.translation() = Vector3d(0.25, 0, 0);
  const Skeleton skeleton(joints);
  MotionClip clip{.framesPerSecond = 30.0, .q = Eigen::MatrixXd(5, 4)};
  for (int f = 0; f < 4; ++f) clip.q.col(f) << 1, 0, 0, 0, 0.5 + 0.1 * f;
  const Vector3d place =
      forwardKinematics(skeleton, clip.q.col(1))[2].translation() + Vector3d(0.01, 0.02, -0.01);
  const auto goals = [&](int frame) -> std::vector<Goal> {
    if (frame != 1 && frame != 2) return {};
    return {{.kind = GoalKind::Position, .name = "hand", .joint = 2, .target = place}};
  };
  const ClipWithGoals result = withGoals(skeleton, clip, goals, *makeSolver("dls"));
  for (const int f : {1, 2})
    EXPECT_LE((forwardKinematics(skeleton, result.clip.q.col(f))[2].translation() - place).norm(), 1e-5);
  EXPECT_LE(result.largestError, 1e-5);
  EXPECT_EQ(result.framesMissed, 0);
  EXPECT_EQ(result.clip.q.col(0), clip.q.col(0));
  EXPECT_EQ(result.clip.q.col(3), clip.q.col(3));
}

}  // namespace
}  // namespace gelenk
