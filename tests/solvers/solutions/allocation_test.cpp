// What is said to allocate nothing does not: every call of malloc is counted (glibc; the sanitizers have
// their own).
#include <gtest/gtest.h>

#include <cstdlib>

#include "solvers/solutions/arm_solutions.h"
#include "solvers/solutions/self_motion.h"
#include "tests/solvers/solutions/example_arms.h"

#if defined(__has_feature)
#define GELENK_OWN_MALLOC __has_feature(address_sanitizer)
#elif defined(__SANITIZE_ADDRESS__)
#define GELENK_OWN_MALLOC 1
#else
#define GELENK_OWN_MALLOC 0
#endif
#if defined(__GLIBC__) && !GELENK_OWN_MALLOC

namespace {
thread_local long allocations = 0;
}

extern "C" {
void* __libc_malloc(std::size_t);
void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}
}

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using testing::chainOf;

TEST(Allocations, AreCounted) {
  const long before = allocations;
  Eigen::VectorXd one(100);
  one.setZero();
  EXPECT_GT(allocations, before) << one.norm();
}

TEST(Allocations, CompleteSetsTakeNone) {
  std::mt19937_64 random(61);
  for (const DhTable& table : {robotTable("ur5"), robotTable("puma560"), testing::generalArm("jaco2"),
                               testing::generalArm("crx10ia"), testing::randomArm(random)}) {
    SCOPED_TRACE(table.name);
    const SixJointArm arm(chainOf(table));
    for (int trial = 0; trial < 20; ++trial) {
      const Isometry3d pose = tipFrame(arm.chain(), testing::randomAngles(random));
      ArmSolutions found;
      const long before = allocations;
      arm.solve(pose, Vector6d::Zero(), found);
      EXPECT_EQ(allocations, before);
      EXPECT_GT(found.count, 0);
    }
  }
}

TEST(Allocations, SlicesAndTheNearestSolutionTakeNone) {
  std::mt19937_64 random(62);
  for (const DhTable& table : {robotTable("panda"), robotTable("iiwa14"), testing::xarm7()}) {
    SCOPED_TRACE(table.name);
    const Skeleton skeleton = toSkeleton(table);
    const SevenJointArm arm(chainOf(table));
    for (int trial = 0; trial < 20; ++trial) {
      const Vector7d q = randomWithinLimits(skeleton, random), near = randomWithinLimits(skeleton, random);
      const Isometry3d pose = tipFrame(arm.chain(), q);
      SliceSolutions slice;
      Vector7d best;
      const long before = allocations;
      arm.slice(pose, q[arm.heldJoint()], near, slice);
      EXPECT_TRUE(arm.nearest(pose, near, best));
      EXPECT_EQ(allocations, before);
    }
  }
}

}  // namespace
}  // namespace gelenk

#endif
