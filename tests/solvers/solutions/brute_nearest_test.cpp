// The nearest solution of the Panda against a search that shares nothing with the closed form of the family
// but the kinematics: the last joint swept in fine steps, the other six solved completely at each, what comes
// near refined. 300 poses in the suite; GELENK_PANDA_POSES=100000 is the figure of docs/solutions.md.
#include <gtest/gtest.h>

#include <cstdlib>

#include "kinematics/notation/robots.h"
#include "solvers/solutions/self_motion.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;

struct Sweep {
  const SevenJointArm& arm;
  const Isometry3d& pose;
  const Vector7d& near;

  /// Past a fold a slice may still give what misses the pose by its rounding, 1e-9, which is not a solution:
  /// a distance changes there by the root of it.
  bool reaches(const Vector7d& q) const {
    return (tipFrame(arm.chain(), q).matrix() - pose.matrix()).cwiseAbs().maxCoeff() < 1e-12;
  }

  /// Distance of the solution at the held angle that is nearest to `beside`, or to `near` without one; beyond
  /// the limits infinite.
  double at(double angle, const Vector7d* beside, Vector7d& q) const {
    SliceSolutions found;
    arm.slice(pose, angle, beside ? *beside : near, found);
    double best = INFINITY, distance = INFINITY;
    for (int i = 0; i < found.count; ++i) {
      if (!found.withinLimits[i] || !reaches(found.q[i])) continue;
      const double away = (found.q[i] - (beside ? *beside : near)).norm();
      if (away < best) best = away, q = found.q[i], distance = (q - near).norm();
    }
    return beside && best > 0.3 ? INFINITY : distance;
  }

  /// Golden section between two held angles, on the branch through q.
  double refined(double a, double b, const Vector7d& q) const {
    constexpr double golden = 0.3819660112501051;
    double x = a + golden * (b - a), y = b - golden * (b - a), best = (q - near).norm();
    Vector7d at1, at2;
    double fx = at(x, &q, at1), fy = at(y, &q, at2);
    for (int k = 0; k < 32; ++k) {
      best = std::min({best, fx, fy});
      if (fx < fy) {
        b = y, y = x, fy = fx;
        x = a + golden * (b - a), fx = at(x, &q, at1);
      } else {
        a = x, x = y, fx = fy;
        y = b - golden * (b - a), fy = at(y, &q, at2);
      }
    }
    return best;
  }
};

TEST(Panda, TheNearestSolutionIsThatOfAFineSweep) {
  const char* wanted = std::getenv("GELENK_PANDA_POSES");
  const int poses = wanted ? std::atoi(wanted) : 300;
  constexpr int steps = 400;
  const Skeleton skeleton = toSkeleton(robotTable("panda"));
  const SevenJointArm arm(testing::chainOf(robotTable("panda")));
  const int held = arm.heldJoint();
  const double lower = arm.chain().lower[held], h = (arm.chain().upper[held] - lower) / steps;
  std::mt19937_64 random(2028);
  int none = 0, nearer = 0, farther = 0;
  for (int trial = 0; trial < poses; ++trial) {
    const Vector7d made = randomWithinLimits(skeleton, random), near = randomWithinLimits(skeleton, random);
    const Isometry3d pose = tipFrame(arm.chain(), made);
    Vector7d best;
    if (!arm.nearest(pose, near, best)) {
      ++none;
      continue;
    }
    const double distance = (best - near).norm();
    EXPECT_LT((tipFrame(arm.chain(), best).matrix() - pose.matrix()).cwiseAbs().maxCoeff(), 1e-9);
    const Sweep sweep{arm, pose, near};
    double brute = INFINITY;
    for (int k = 0; k <= steps; ++k) {
      SliceSolutions found;
      const double angle = lower + k * h;
      arm.slice(pose, angle, near, found);
      for (int i = 0; i < found.count; ++i) {
        if (!found.withinLimits[i] || !sweep.reaches(found.q[i])) continue;
        const double own = (found.q[i] - near).norm();
        brute = std::min(brute, own);
        // From one sweep to the next the distance changes by less than this, but near a fold.
        if (own < distance + 0.03)
          brute = std::min(brute, sweep.refined(std::max(lower, angle - h),
                                                std::min(lower + steps * h, angle + h), found.q[i]));
      }
    }
    nearer += brute < distance - 1e-6;
    farther += brute > distance + 1e-6;
  }
  std::printf(
      "%d poses of the Panda: %d without a solution, %d where the sweep found a nearer one, %d where it "
      "found none as near\n",
      poses, none, nearer, farther);
  EXPECT_EQ(none, 0);
  EXPECT_EQ(nearer, 0);
  EXPECT_LE(farther, poses / 8);  // the sweep's own misses: minima at folds and at limits within a step
}

}  // namespace
}  // namespace gelenk
