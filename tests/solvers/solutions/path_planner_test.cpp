#include "solvers/solutions/path_planner.h"

#include <gtest/gtest.h>

#include "kinematics/notation/robots.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<Isometry3d> line(const SerialChain& chain, const VectorXd& a, const VectorXd& b, int count) {
  std::vector<Isometry3d> poses;
  for (int k = 0; k < count; ++k) poses.push_back(tipFrame(chain, a + (b - a) * (k / double(count - 1))));
  return poses;
}

int jumpsOf(const std::vector<VectorXd>& q, double jump) {
  int jumps = 0;
  for (size_t k = 0; k + 1 < q.size(); ++k) jumps += (q[k + 1] - q[k]).cwiseAbs().maxCoeff() > jump;
  return jumps;
}

/// Fewest jumps over all chains of candidates, by trying every one of them for every next pose.
int fewestJumps(const PathPlanner& planner, const std::vector<Isometry3d>& poses, double jump) {
  std::vector<int> jumps;
  MatrixXd before;
  for (const Isometry3d& pose : poses) {
    const MatrixXd now = planner.candidates(pose);
    std::vector<int> next(now.cols(), before.cols() ? 1 << 20 : 0);
    for (Eigen::Index j = 0; j < now.cols(); ++j)
      for (Eigen::Index i = 0; i < before.cols(); ++i)
        next[j] = std::min(next[j], jumps[i] + ((now.col(j) - before.col(i)).cwiseAbs().maxCoeff() > jump));
    jumps = next, before = now;
  }
  return *std::min_element(jumps.begin(), jumps.end());
}

TEST(PathPlanner, AWayThatTheJointsCanGoHasNoJump) {
  for (const char* name : {"puma560", "ur5", "panda"}) {
    SCOPED_TRACE(name);
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const PathPlanner planner(skeleton, skeleton.jointCount() - 1);
    std::mt19937_64 random(51);
    for (int trial = 0; trial < 2; ++trial) {
      const VectorXd a = 0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest()),
                     b = 0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest());
      const auto poses = line(planner.chain(), a, b, 60);
      const PathPlan plan = planner.plan(poses);
      ASSERT_FALSE(plan.unreachable);
      EXPECT_TRUE(plan.jumps.empty());
      EXPECT_LE(plan.length, 1.1 * (b - a).norm() + 0.3);  // seven joints: the ends lie in slices at first
      for (size_t k = 0; k < poses.size(); ++k) {
        EXPECT_LT((tipFrame(planner.chain(), plan.q[k]).matrix() - poses[k].matrix()).cwiseAbs().maxCoeff(),
                  1e-8);
        for (int i = 0; i < planner.chain().n; ++i) {
          EXPECT_GE(plan.q[k][i], planner.chain().lower[i] - 1e-9);
          EXPECT_LE(plan.q[k][i], planner.chain().upper[i] + 1e-9);
        }
      }
    }
  }
}

/// Straight ways between poses of different branches: jumps that cannot be avoided are told, and there is not
/// one too many.
TEST(PathPlanner, JumpsAreAsFewAsAnyChainOfSolutionsHas) {
  const Skeleton skeleton = toSkeleton(robotTable("puma560"));
  const PathPlanner planner(skeleton, skeleton.jointCount() - 1);
  std::mt19937_64 random(52);
  int withJumps = 0, followed = 0;
  for (int trial = 0; trial < 12; ++trial) {
    const Isometry3d a = tipFrame(planner.chain(), randomWithinLimits(skeleton, random)),
                     b = tipFrame(planner.chain(), randomWithinLimits(skeleton, random));
    std::vector<Isometry3d> poses;
    for (int k = 0; k < 50; ++k) poses.push_back(between(a, b, k / 49.0));
    const PathPlan plan = planner.plan(poses);
    if (plan.unreachable) {
      EXPECT_EQ(planner.candidates(poses[*plan.unreachable]).cols(), 0);
      continue;
    }
    ++followed;
    EXPECT_EQ(jumpsOf(plan.q, 0.5), fewestJumps(planner, poses, 0.5));
    EXPECT_EQ(plan.jumps.size(), static_cast<size_t>(jumpsOf(plan.q, 0.5)));
    for (const PathJump& jump : plan.jumps) EXPECT_FALSE(jump.reason.empty());
    withJumps += !plan.jumps.empty();
  }
  EXPECT_GT(followed, 2);  // or nothing was tested
  EXPECT_GT(withJumps, 0);
}

/// Seven joints: the length is a local minimum from samples 0.3 rad apart; dynamic programming over a set six
/// times finer, without refinement, is the reference.
TEST(PathPlanner, TheWayIsNearlyAsShortAsThatOfABruteSearch) {
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const PathPlanner planner(skeleton, skeleton.jointCount() - 1);
  std::mt19937_64 random(53);
  int followed = 0;
  double worst = 0.0;
  for (int trial = 0; trial < 8 && followed < 4; ++trial) {
    const Isometry3d a = tipFrame(planner.chain(),
                                  0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest())),
                     b = tipFrame(planner.chain(),
                                  0.5 * (randomWithinLimits(skeleton, random) + skeleton.rest()));
    std::vector<Isometry3d> poses;
    for (int k = 0; k < 24; ++k) poses.push_back(between(a, b, k / 23.0));
    const PathPlan plan = planner.plan(poses), brute = planner.plan(poses, {.step = 0.05, .rounds = 0});
    if (plan.unreachable || brute.unreachable) continue;
    ++followed;
    EXPECT_EQ(plan.jumps.size(), brute.jumps.size());
    if (plan.jumps.empty()) worst = std::max(worst, plan.length / brute.length);
  }
  RecordProperty("longest", std::to_string(worst));
  EXPECT_GE(followed, 3);
  EXPECT_GT(worst, 0.0);
  EXPECT_LT(worst, 1.08);  // a local minimum
}

TEST(PathPlanner, ASplineGoesThroughItsKeysAtEqualArcLength) {
  std::vector<Isometry3d> keys(3, Isometry3d::Identity());
  keys[1].translation() << 1, 0, 0;
  keys[2].translation() << 1, 1, 0;
  keys[2].rotate(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ()));
  const auto path = splineThrough(keys, 101);
  ASSERT_EQ(path.size(), 101u);
  EXPECT_LT((path.front().matrix() - keys[0].matrix()).norm(), 1e-12);
  EXPECT_LT((path.back().matrix() - keys[2].matrix()).norm(), 1e-9);
  double shortest = INFINITY, longest = 0.0, atCorner = INFINITY;
  for (size_t k = 0; k + 1 < path.size(); ++k) {
    const double step = (path[k + 1].translation() - path[k].translation()).norm();
    shortest = std::min(shortest, step), longest = std::max(longest, step);
    atCorner = std::min(atCorner, (path[k].translation() - keys[1].translation()).norm());
  }
  EXPECT_LT(longest / shortest, 1.02);
  EXPECT_LT(atCorner, longest);
  EXPECT_THROW(splineThrough(std::span(keys).first(1), 10), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
