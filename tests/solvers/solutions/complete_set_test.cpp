#include "solvers/solutions/complete_set.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "kinematics/notation/planar_chain.h"
#include "kinematics/notation/robots.h"
#include "solvers/problem/ik_solver.h"
#include "solvers/problem/judge.h"
#include "tests/solvers/solutions/recall.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::apart;
using testing::chainOf;
using testing::generalArm;
using testing::poseError;
using testing::randomAngles;
using testing::Recall;
using testing::recall;

TEST(SixJointArm, TheClassIsReadOffTheAxes) {
  EXPECT_EQ(SixJointArm(chainOf(robotTable("puma560"))).describe(),
            "spherical wrist: axes 4, 5 and 6 meet in a point");
  EXPECT_EQ(SixJointArm(chainOf(robotTable("ur5"))).describe(), "three parallel axes: axes 2, 3 and 4");
  for (const char* name : {"jaco2", "xarm6", "crx10ia"})
    EXPECT_EQ(SixJointArm(chainOf(generalArm(name))).kind(), LoopClass::General) << name;
  EXPECT_THROW(SixJointArm{chainOf(robotTable("panda"))}, std::invalid_argument);
}

TEST(SixJointArm, ThePoseThatMadeTheTargetIsInTheSet) {
  for (const char* name : {"puma560", "ur5", "jaco2", "xarm6", "crx10ia"}) {
    SCOPED_TRACE(name);
    const bool table = std::string(name) == "puma560" || std::string(name) == "ur5";
    const SixJointArm arm(chainOf(table ? robotTable(name) : generalArm(name)));
    const Recall r = recall(arm, 400, 31);
    EXPECT_EQ(r.missed, 0);
    EXPECT_LE(r.missedSingular, 1);
    EXPECT_LT(r.worst, 1e-11);  // metres and sines; rounding of six rotations is 1e-15
  }
}

/// Poses that the elimination alone loses, without noticing: found by 30,000 random targets.
TEST(SixJointArm, WhatTheEliminationLosesIsFoundBesideTheAxesThatMeet) {
  struct Case {
    const char* arm;
    Vector6d q;
  };
  std::vector<Case> cases(6);
  cases[0].arm = cases[1].arm = cases[2].arm = cases[3].arm = "crx10ia";
  cases[4].arm = cases[5].arm = "xarm6";
  cases[0].q << -1.411482, 1.570875, 2.638948, -1.314676, 1.365694, -1.898361;
  cases[1].q << -1.665269, 1.542593, 1.400504, 1.166641, -0.306515, 1.766370;
  cases[2].q << -1.983413, -1.569948, -2.722041, 0.530239, 0.423639, -1.555349;
  cases[3].q << 1.408777, -1.570412, -0.831403, -0.091470, -1.392315, 1.807641;
  cases[4].q << 1.258636, 1.491183, -1.249104, -0.928429, 1.597094, 0.742748;
  cases[5].q << -1.073654, -0.006217, 0.818980, 2.657035, 2.699999, -1.044386;
  for (const Case& c : cases) {
    const SixJointArm arm(chainOf(generalArm(c.arm)));
    ArmSolutions found;
    arm.solve(tipFrame(arm.chain(), c.q), Vector6d::Zero(), found);
    double nearest = INFINITY;
    for (const ArmSolution& s : found.all()) nearest = std::min(nearest, apart(s.q, c.q));
    EXPECT_LT(nearest, 1e-5) << c.arm << " " << c.q.transpose();
    EXPECT_EQ(found.count % 2, 0);
  }
}

TEST(SixJointArm, RandomArmsLoseNoPose) {
  std::mt19937_64 random(32);
  Recall all;
  for (int arm = 0; arm < 12; ++arm) {
    const Recall r = recall(SixJointArm(chainOf(testing::randomArm(random))), 40, random());
    all.missed += r.missed;
    all.worst = std::max(all.worst, r.worst);
  }
  EXPECT_EQ(all.missed, 0);
  EXPECT_LT(all.worst, 1e-11);
}

TEST(SixJointArm, EveryPlaceOfASphericalOrParallelTripleIsSolved) {
  const double h = M_PI / 2;
  const std::vector<std::vector<Vector3d>> arms = {
      {{0.15, h, 0.67}, {0.43, 0, 0}, {0.02, -h, 0.15}, {0, h, 0.43}, {0, -h, 0}, {0, 0, 0.1}},  // offset
                                                                                                 // shoulder
      {{0.15, 0.3, 0.67}, {0.43, 0.7, 0.2}, {0.02, -1.1, 0.15}, {0, 1, 0.43}, {0, -0.9, 0}, {0, 0, 0.1}},
      {{0, 0.9, 0.67},
       {0, -0.7, 0},
       {0.3, 0.4, 0.2},
       {0.2, -1.1, 0.15},
       {0.1, 1, 0.43},
       {0, 0, 0.1}},  // first
      {{0.3, 0.9, 0.67},
       {0.2, -0.7, 0.2},
       {0, 1.4, 0.2},
       {0, -1.1, 0},
       {0.1, 1, 0.43},
       {0.1, 0, 0.1}},  // middle
      {{0.3, 0.9, 0.67}, {0.4, 0, 0.2}, {0.5, M_PI, 0.2}, {0.1, -1.1, 0.1}, {0.1, 1, 0.43}, {0.1, 0, 0.1}},
      {{0.3, 0, 0.67}, {0.4, M_PI, 0.2}, {0.5, 0.7, 0.2}, {0.1, -1.1, 0.1}, {0.1, 1, 0.43}, {0.1, 0, 0.1}},
  };
  for (size_t i = 0; i < arms.size(); ++i) {
    SCOPED_TRACE(i);
    const SixJointArm arm(chainOf(testing::standardTable("triple", arms[i])));
    EXPECT_NE(arm.kind(), LoopClass::General);
    const Recall r = recall(arm, 300, 33);
    EXPECT_EQ(r.missed, 0);
    EXPECT_LT(r.worst, 1e-11);
  }
}

/// Levenberg-Marquardt with a Jacobian of difference quotients; true where the loop closes.
bool dampedNewton(const Loop& loop, Vector6d& u) {
  double mu = 1e-2;
  Vector6d e = loopError(loop, u);
  for (int iteration = 0; iteration < 60; ++iteration) {
    if (e.norm() < 1e-10) return true;
    Matrix6d J;
    for (int i = 0; i < 6; ++i) {
      Vector6d v = u;
      v[i] += 1e-7;
      J.col(i) = (loopError(loop, v) - e) / 1e-7;
    }
    const Vector6d next = u - (J.transpose() * J + mu * Matrix6d::Identity()).llt().solve(J.transpose() * e);
    const Vector6d after = loopError(loop, next);
    if (after.norm() < e.norm()) {
      u = next, e = after, mu = std::max(0.2 * mu, 1e-14);
    } else {
      mu *= 4.0;
      if (mu > 1e6) return false;
    }
  }
  return false;
}

/// Independent of every elimination: Newton from many random starts finds solutions one by one.
TEST(SixJointArm, NewtonFromManyStartsFindsNoOtherSolution) {
  std::mt19937_64 random(34);
  int foundByNewton = 0, inSet = 0, beyond = 0;
  for (int k = 0; k < 14; ++k) {
    const char* names[] = {"jaco2", "xarm6", "crx10ia"};
    const SerialChain chain = chainOf(k < 6 ? generalArm(names[k % 3]) : testing::randomArm(random));
    const SixJointArm arm(chain);
    const Isometry3d pose = tipFrame(chain, randomAngles(random));
    ArmSolutions set;
    arm.solve(pose, Vector6d::Zero(), set);
    Loop loop;
    for (int i = 0; i < 5; ++i) {
      const ChainConstants& C = chain.constants;
      loop.link[i].linear() << 1, 0, 0, 0, C.cosAlpha[i + 1], -C.sinAlpha[i + 1], 0, C.sinAlpha[i + 1],
          C.cosAlpha[i + 1];
      loop.link[i].translation() = Vector3d(C.a[i + 1], 0, 0) + loop.link[i].linear().col(2) * C.d[i + 1];
      loop.link[i].makeAffine();
    }
    loop.link[5] = (chain.worldFromBase.inverse() * pose * chain.lastFromTip.inverse()).inverse();
    LoopSolutions newton;
    for (int start = 0; start < 300; ++start) {
      Vector6d u = randomAngles(random);
      if (dampedNewton(loop, u)) add(newton, u, 0.0);
    }
    for (int i = 0; i < newton.count; ++i) {
      bool known = false;
      Vector6d q = newton.u[i];
      for (int j = 0; j < 6; ++j) q[j] -= chain.constants.theta[j];
      for (const ArmSolution& s : set.all()) known |= apart(s.q, q) < 1e-5;
      beyond += !known;
    }
    foundByNewton += newton.count;
    inSet += set.count;
  }
  EXPECT_EQ(beyond, 0);
  EXPECT_GE(inSet + beyond, foundByNewton);
  EXPECT_GE(foundByNewton, 9 * inSet / 10);  // or the test would say nothing
}

/// The signed count of solutions is the same for every pose, so it is that of a pose out of reach: zero.
TEST(SixJointArm, AsManySolutionsLieOnOneSideOfTheSingularitiesAsOnTheOther) {
  std::mt19937_64 random(61);
  int checked = 0;
  for (int k = 0; k < 8; ++k) {
    const char* names[] = {"puma560", "ur5", "jaco2", "crx10ia"};
    const SixJointArm arm(chainOf(k < 2   ? robotTable(names[k])
                                  : k < 4 ? generalArm(names[k])
                                          : testing::randomArm(random)));
    ArmSolutions found;
    for (int t = 0; t < 50; ++t) {
      arm.solve(tipFrame(arm.chain(), randomAngles(random)), Vector6d::Zero(), found);
      int surplus = 0;
      double least = INFINITY;
      for (const ArmSolution& s : found.all()) {
        // By difference quotients of the tip's pose, along the tip's axes.
        const Isometry3d pose = tipFrame(arm.chain(), s.q);
        Matrix6d J;
        for (int i = 0; i < 6; ++i) {
          Vector6d q = s.q;
          q[i] += 1e-6;
          const Isometry3d moved = pose.inverse() * tipFrame(arm.chain(), q);
          J.col(i) << moved.translation(), 0.5 * (moved(2, 1) - moved(1, 2)),
              0.5 * (moved(0, 2) - moved(2, 0)), 0.5 * (moved(1, 0) - moved(0, 1));
        }
        const double det = (J / 1e-6).determinant();
        surplus += det > 0.0 ? 1 : -1;
        least = std::min(least, std::abs(det));
      }
      if (least < 1e-5) continue;  // the quotient's own error
      EXPECT_EQ(surplus, 0) << k << ", " << found.count << " solutions";
      ++checked;
    }
  }
  EXPECT_GT(checked, 300);
}

/// A random arm of whose four solutions the best cut shows two, both with the same sign of the determinant.
TEST(SixJointArm, SignsThatDoNotBalanceAskAnotherCut) {
  std::mt19937_64 random(2026);
  DhTable table;
  std::uint64_t seed = 0;
  for (int a = 0; a <= 193; ++a) table = testing::randomArm(random), seed = random();
  const SixJointArm arm(chainOf(table));
  std::mt19937_64 ofArm(seed);
  Vector6d q;
  for (int t = 0; t <= 81; ++t) q = randomAngles(ofArm);
  ArmSolutions found;
  arm.solve(tipFrame(arm.chain(), q), Vector6d::Zero(), found);
  EXPECT_EQ(found.count, 4);
  EXPECT_TRUE(found.complete);
  double nearest = INFINITY;
  for (const ArmSolution& s : found.all()) nearest = std::min(nearest, apart(s.q, q));
  EXPECT_LT(nearest, 1e-5);
}

TEST(SixJointArm, SomePosesOfTheCrxHaveSixteenSolutions) {
  const SixJointArm arm(chainOf(generalArm("crx10ia")));
  std::mt19937_64 random(35);
  int most = 0;
  ArmSolutions found;
  for (int t = 0; t < 400 && most < 16; ++t) {
    arm.solve(tipFrame(arm.chain(), randomAngles(random)), Vector6d::Zero(), found);
    most = std::max(most, found.count);
  }
  EXPECT_EQ(most, 16);
}

TEST(SixJointArm, AxesThatMissAClassByLittleAreSolvedOnTheTrueArm) {
  const double h = M_PI / 2;
  for (const double miss : {1e-12, 1e-9, 1e-7, 1e-6}) {
    SCOPED_TRACE(miss);
    const SixJointArm wrist(chainOf(testing::standardTable(
        "wrist",
        {{0, h, 0.67}, {0.43, miss, 0}, {0.02, -h, 0.15}, {miss, h, 0.43}, {0, -h, miss}, {0, 0, 0.1}})));
    const SixJointArm parallel(chainOf(testing::standardTable(
        "parallel",
        {{0, h, 0.09}, {-0.42, miss, 0}, {-0.39, -miss, 0}, {0, h, 0.11}, {0, -h, 0.09}, {0, 0, 0.08}})));
    for (const SixJointArm* arm : {&wrist, &parallel}) {
      const Recall r = recall(*arm, 200, 36);
      EXPECT_EQ(r.missed, 0);
      EXPECT_LT(r.worst, 2e-9);  // parallel to 1e-9: Denavit-Hartenberg feet lie 1e9 lengths away
    }
  }
}

TEST(SixJointArm, ASingularWristIsAFamilyAndKeepsTheReference) {
  const SixJointArm arm(chainOf(robotTable("puma560")));
  Vector6d q;
  q << 0.3, 0.4, -0.5, 0.7, 0.0, 0.2;
  ArmSolutions found;
  arm.solve(tipFrame(arm.chain(), q), q, found);
  double nearest = INFINITY;
  int families = 0;
  for (const ArmSolution& s : found.all()) {
    EXPECT_LT(poseError(arm.chain(), s.q, tipFrame(arm.chain(), q)), 1e-8);
    families += s.free != 0;
    nearest = std::min(nearest, (s.q - q).cwiseAbs().maxCoeff());
    EXPECT_TRUE(s.free == 0 || s.free == 1u << 3);
  }
  EXPECT_GT(families, 0);
  EXPECT_LT(nearest, 1e-7);
  const Singularity where = singularity(arm.chain(), q);
  EXPECT_LT(where.sigmaMin, 1e-12);
  EXPECT_NEAR(std::abs(where.direction[3]), std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(std::abs(where.direction[5]), std::sqrt(0.5), 1e-9);
}

TEST(SixJointArm, BranchesOfThePumaHaveEightDifferentNames) {
  for (const char* name : {"puma560", "ur5"}) {
    const SixJointArm arm(chainOf(robotTable(name)));
    std::mt19937_64 random(37);
    ArmSolutions found;
    for (int t = 0; t < 50; ++t) {
      arm.solve(tipFrame(arm.chain(), randomAngles(random)), Vector6d::Zero(), found);
      for (int i = 0; i < found.count; ++i)
        for (int j = 0; j < i; ++j) {
          const ArmSolution &a = found.list[i], &b = found.list[j];
          EXPECT_FALSE(a.shoulder == b.shoulder && a.elbow == b.elbow && a.wrist == b.wrist) << name;
        }
    }
  }
}

/// Shoulder, elbow and wrist by their meaning: frames one after the other, axes and centres in the world.
TEST(SixJointArm, NamesOfBranchesAreTheSidesOnWhichTheLinksLie) {
  for (const char* name : {"puma560", "ur5"}) {
    const SixJointArm arm(chainOf(robotTable(name)));
    const ChainConstants& C = arm.chain().constants;
    std::mt19937_64 random(40);
    ArmSolutions found;
    for (int t = 0; t < 50; ++t) {
      arm.solve(tipFrame(arm.chain(), randomAngles(random)), Vector6d::Zero(), found);
      for (const ArmSolution& s : found.all()) {
        Vector3d axis[6], origin[6];
        Isometry3d frame = Isometry3d::Identity();
        for (int i = 0; i < 6; ++i) {
          frame = frame * Eigen::AngleAxisd(std::atan2(C.sinAlpha[i], C.cosAlpha[i]), Vector3d::UnitX()) *
                  Eigen::Translation3d(C.a[i], 0, C.d[i]) *
                  Eigen::AngleAxisd(C.theta[i] + s.q[i], Vector3d::UnitZ());
          axis[i] = frame.linear().col(2), origin[i] = frame.translation();
        }
        const auto sign = [](double x) { return x > 1e-9 ? 1 : x < -1e-9 ? -1 : 0; };
        EXPECT_EQ(s.shoulder, sign(axis[0].cross(axis[1]).dot(origin[5] - origin[0])));
        EXPECT_EQ(s.elbow, sign(axis[1].dot((origin[2] - origin[1]).cross(origin[3] - origin[2]))));
        EXPECT_EQ(s.wrist, sign(axis[4].dot(axis[3].cross(axis[5]))));
      }
    }
  }
}

/// Straight elbows, wrists in line, points on axis 1: no solution twice, the error told is that of forward
/// kinematics, and the pose that made the target is among them.
TEST(SixJointArm, WhereBranchesMergeNoSolutionIsToldTwice) {
  for (const char* name : {"puma560", "ur5"}) {
    SCOPED_TRACE(name);
    const SixJointArm arm(chainOf(robotTable(name)));
    std::mt19937_64 random(41);
    int merged = 0;
    for (int t = 0; t < 400; ++t) {
      Vector6d q = randomAngles(random);
      // Joint 3 at the stretched arm, joint 5 at the wrist in line, exactly or nearly.
      const double beside = t % 4 < 2 ? 0.0 : std::pow(10.0, -3.0 - t % 9);
      const bool puma = arm.kind() == LoopClass::SphericalTriple;
      const Vector3d forearm = Vector3d(arm.chain().constants.a[3], arm.chain().constants.d[3], 0);
      if (t % 2 == 0) q[2] = beside + (puma ? std::atan2(forearm.x(), forearm.y()) : 0.0);
      if (t % 3 == 0 && (t % 2 == 1 || beside == 0.0)) q[4] = beside;
      const Isometry3d pose = tipFrame(arm.chain(), q);
      ArmSolutions found;
      arm.solve(pose, q, found);
      double nearest = INFINITY;
      for (int i = 0; i < found.count; ++i) {
        const ArmSolution& s = found.list[i];
        nearest = std::min(nearest, apart(s.q, q));
        EXPECT_LT(poseError(arm.chain(), s.q, pose), 1e-8);
        EXPECT_LT(poseError(arm.chain(), s.q, pose), 10.0 * s.error + 1e-12);
        for (int k = 0; k < i; ++k) EXPECT_GT(apart(found.list[k].q, s.q), 1e-8);
      }
      EXPECT_LT(nearest, 1e-4) << t << " " << q.transpose();
      merged += found.count < 8;
    }
    EXPECT_GT(merged, 50);
  }
}

/// Elbow and wrist singular at once, exactly or nearly: what could take any value takes the reference's, with
/// which the elbow may not reach; then the family's nearest member that does.
TEST(SixJointArm, AFamilyThatEndsBeforeTheReferenceIsToldByTheNearestOfIt) {
  for (const char* name : {"puma560", "ur5"}) {
    const SixJointArm arm(chainOf(robotTable(name)));
    const ChainConstants& C = arm.chain().constants;
    const bool puma = arm.kind() == LoopClass::SphericalTriple;
    std::mt19937_64 random(2026);
    std::normal_distribution<double> normal;
    for (const double elbow : {0.0, 1e-12, 1e-10, 1e-8, 1e-6})
      for (const double wrist : {0.0, 1e-12, 1e-10, 1e-9, 1e-8, 1e-7})
        for (const double noise : {0.0, 1e-16, 1e-15}) {
          SCOPED_TRACE(::testing::Message()
                       << name << ", elbow " << elbow << ", wrist " << wrist << ", noise " << noise);
          int empty = 0, lost = 0;
          for (int t = 0; t < 100; ++t) {
            Vector6d q = randomAngles(random);
            q[2] = elbow + (puma ? std::atan2(C.a[3], C.d[3]) : 0.0);
            q[4] = wrist;
            Isometry3d pose = tipFrame(arm.chain(), q);
            for (int i = 0; i < 3; ++i) pose.translation()[i] += noise * normal(random);
            ArmSolutions found;
            arm.solve(pose, randomAngles(random), found);
            empty += found.count == 0;
            for (const ArmSolution& s : found.all()) EXPECT_LT(poseError(arm.chain(), s.q, pose), 1e-8);
            arm.solve(pose, q, found);
            double nearest = INFINITY;
            for (const ArmSolution& s : found.all()) nearest = std::min(nearest, apart(s.q, q));
            lost += nearest > 1e-3;
          }
          EXPECT_EQ(empty, 0);
          // Between these the pose's rounding moves the solution that made it farther than to another of the
          // set; elsewhere it may do so now and then.
          if (wrist <= 1e-12 || (wrist >= 1e-8 && noise < 1e-15)) {
            EXPECT_LE(lost, 2);
          }
        }
  }
}

TEST(SixJointArm, OutOfReachHasNoSolution) {
  for (const char* name : {"puma560", "ur5", "crx10ia"}) {
    const std::string which = name;
    const SixJointArm arm(chainOf(which == "crx10ia" ? generalArm(name) : robotTable(name)));
    Isometry3d pose = Isometry3d::Identity();
    pose.translation() << 3.0, 0.5, 0.5;
    ArmSolutions found;
    arm.solve(pose, Vector6d::Zero(), found);
    EXPECT_EQ(found.count, 0) << name;
    EXPECT_TRUE(found.complete) << name;
  }
}

/// Levenberg-Marquardt on the tip's pose, with a Jacobian of difference quotients.
bool reachedByNewton(const SerialChain& chain, const Isometry3d& pose, Vector6d& q) {
  const auto errorAt = [&](const Vector6d& x) {
    const Isometry3d miss = pose.inverse() * tipFrame(chain, x);
    Vector6d e;
    e << miss.translation(), miss(2, 1) - miss(1, 2), miss(0, 2) - miss(2, 0), miss(1, 0) - miss(0, 1);
    return e;
  };
  double mu = 1e-2;
  Vector6d e = errorAt(q);
  for (int iteration = 0; iteration < 60; ++iteration) {
    if (e.norm() < 1e-10) return poseError(chain, q, pose) < 1e-9;
    Matrix6d J;
    for (int i = 0; i < 6; ++i) {
      Vector6d moved = q;
      moved[i] += 1e-7;
      J.col(i) = (errorAt(moved) - e) / 1e-7;
    }
    const Vector6d next = q - (J.transpose() * J + mu * Matrix6d::Identity()).llt().solve(J.transpose() * e);
    const Vector6d after = errorAt(next);
    if (after.norm() < e.norm()) {
      q = next, e = after, mu = std::max(0.2 * mu, 1e-14);
    } else if ((mu *= 4.0) > 1e6) {
      return false;
    }
  }
  return false;
}

TEST(CompleteSet, TheLecturesTwoLinksHaveTwoElbows) {
  PlanarChain chain;
  chain.lengths = {1.0, 0.8};
  const Skeleton skeleton = toSkeleton(chain);
  const CompleteSet set(skeleton, skeleton.jointCount() - 1, {.task = TipTask::Position});
  ArmSolutions found;
  set.solve(Isometry3d(Eigen::Translation3d(1.2, 0.6, 0.0)), Vector6d::Zero(), found);
  ASSERT_EQ(found.count, 2);
  const double reach2 = 1.2 * 1.2 + 0.6 * 0.6, bend = std::acos((reach2 - 1.0 - 0.64) / (2.0 * 0.8));
  EXPECT_NEAR(std::abs(found.list[0].q[1]), bend, 1e-9);
  EXPECT_NEAR(found.list[0].q[1], -found.list[1].q[1], 1e-9);
  set.solve(Isometry3d(Eigen::Translation3d(1.2, 0.6, 0.1)), Vector6d::Zero(), found);  // above the plane
  EXPECT_EQ(found.count, 0);
  set.solve(Isometry3d(Eigen::Translation3d(1.9, 0.0, 0.0)), Vector6d::Zero(), found);  // beyond the reach
  EXPECT_EQ(found.count, 0);
}

TEST(CompleteSet, FewerJointsThanSixAreExactWhereTheSetIsFinite) {
  const Skeleton puma = toSkeleton(robotTable("puma560")), ur5 = toSkeleton(robotTable("ur5"));
  struct Case {
    const Skeleton* skeleton;
    const char* tip;
    CompleteSetTask task;
  };
  const std::vector<Case> cases = {
      {&puma, "joint3", {.task = TipTask::Position, .pointInTip = {0.1, 0.0, 0.4}}},
      {&puma, "joint5", {.task = TipTask::Axis, .pointInTip = {0.0, 0.1, 0.1}, .axisInTip = {0.0, 0.6, 0.8}}},
      {&ur5, "joint5", {.task = TipTask::Axis, .pointInTip = {0.05, 0.1, 0.1}}},
      {&ur5, "joint5", {}},
      {&ur5, "joint4", {}},
      {&puma, "joint3", {}},
      {&puma, "joint2", {}},
  };
  std::mt19937_64 random(38);
  for (const Case& c : cases) {
    const int tip = c.skeleton->jointIndex(c.tip);
    const CompleteSet set(*c.skeleton, tip, c.task);
    SCOPED_TRACE(std::string(c.tip) + " " + set.arm().describe());
    for (int t = 0; t < 30; ++t) {
      const VectorXd q = randomWithinLimits(*c.skeleton, random);
      Isometry3d target = forwardKinematics(*c.skeleton, q)[tip];
      target.translation() = target * c.task.pointInTip;
      const Vector3d axis = target.linear() * c.task.axisInTip;
      if (c.task.task == TipTask::Position) target.linear().setIdentity();
      if (c.task.task == TipTask::Axis) target.rotate(Eigen::AngleAxisd(0.7, c.task.axisInTip));
      ArmSolutions found;
      set.solve(target, Vector6d::Zero(), found);
      bool hit = false;
      for (const ArmSolution& s : found.all()) {
        VectorXd all = q;
        for (int i = 0; i < set.joints(); ++i) all[set.chain().qIndex[i]] = s.q[i];
        const Isometry3d reached = forwardKinematics(*c.skeleton, all)[tip];
        EXPECT_LT((reached * c.task.pointInTip - target.translation()).norm(), 1e-8);
        if (c.task.task == TipTask::Axis) {
          EXPECT_LT((reached.linear() * c.task.axisInTip - axis).norm(), 1e-8);
        } else if (c.task.task == TipTask::Pose) {
          EXPECT_LT((reached.linear() - target.linear()).norm(), 1e-8);
        }
        hit |= apart(all, q) < 1e-5;
      }
      EXPECT_TRUE(hit);
    }
  }
}

/// An arm by rows of standard Denavit-Hartenberg parameters.
Skeleton armOfRows(std::vector<DhRow> rows) {
  return toSkeleton(DhTable{.name = "rows", .convention = DhConvention::Standard, .rows = std::move(rows)});
}

/// The set of the last joint's task at the pose that q makes; each solution is judged by forward kinematics.
ArmSolutions judgedSet(const Skeleton& skeleton, const CompleteSetTask& task, const VectorXd& q,
                       const Vector6d& reference) {
  const int tip = skeleton.jointCount() - 1;
  const CompleteSet set(skeleton, tip, task);
  const Isometry3d made = forwardKinematics(skeleton, q)[tip];
  ArmSolutions found;
  set.solve(made, reference, found);
  for (const ArmSolution& s : found.all()) {
    VectorXd all = q;
    for (int i = 0; i < set.joints(); ++i) all[set.chain().qIndex[i]] = s.q[i];
    const Isometry3d reached = forwardKinematics(skeleton, all)[tip];
    EXPECT_LT((reached.translation() - made.translation()).norm(), 1e-8);
    if (task.task == TipTask::Pose) {
      EXPECT_LT((reached.linear() - made.linear()).norm(), 1e-8);
    }
    if (task.task == TipTask::Axis) {
      EXPECT_LT(((reached.linear() - made.linear()) * task.axisInTip).norm(), 1e-8);
    }
    if (s.free != 0) {
      EXPECT_LT(set.singularity(s.q.head(set.joints())).sigmaMin, 1e-6);
    }
  }
  return found;
}

TEST(CompleteSet, AToolThatRollsAboutItsOwnAxisHasAllPosesAndKeepsTheReferencesRoll) {
  const Skeleton torch = armOfRows({{.alpha = M_PI / 2, .d = 0.3},
                                    {.a = 0.4},
                                    {.a = 0.3},
                                    {.alpha = M_PI / 2, .phi = M_PI / 2},
                                    {.d = 0.1}});
  std::mt19937_64 random(5);
  for (int t = 0; t < 60; ++t) {
    const VectorXd q = randomAngles(random).head(5);
    Vector6d reference = Vector6d::Zero();
    reference[4] = 0.7;
    const ArmSolutions pose = judgedSet(torch, {}, q, reference),
                       axis = judgedSet(torch, {.task = TipTask::Axis}, q, reference);
    EXPECT_EQ(axis.count, pose.count);
    EXPECT_TRUE(axis.complete);
    double nearest = INFINITY;
    for (const ArmSolution& s : axis.all()) {
      EXPECT_EQ(s.q[4], 0.7);
      EXPECT_TRUE(s.free >> 4 & 1);
      nearest = std::min(nearest, apart(VectorXd(s.q.head(4)), VectorXd(q.head(4))));
    }
    EXPECT_LT(nearest, 1e-6);
  }
}

TEST(CompleteSet, CurvesOfFewerJointsAreToldAsCurvesAndNeverAsOutOfReach) {
  const auto planar = [](int n) {
    std::vector<DhRow> rows;
    for (int i = 0; i < n; ++i) rows.push_back({.a = 1.0 - 0.15 * i});
    return armOfRows(rows);
  };
  const Skeleton coaxial = armOfRows({{.d = 0.3}, {.d = 0.1}, {.a = 0.4}});
  std::mt19937_64 random(6);
  for (int t = 0; t < 40; ++t) {
    const Vector6d q = randomAngles(random), reference = randomAngles(random);
    const CompleteSetTask place{.task = TipTask::Position}, pose,
        heading{.task = TipTask::Axis, .axisInTip = Vector3d::UnitX()};
    for (const auto& [skeleton, task] : {std::pair{planar(3), place},
                                         {planar(4), pose},
                                         {planar(5), pose},
                                         {planar(4), heading},
                                         {coaxial, place}}) {
      SCOPED_TRACE(skeleton.nq());
      const ArmSolutions found = judgedSet(skeleton, task, q.head(skeleton.nq()), reference);
      EXPECT_GT(found.count, 0);
      EXPECT_FALSE(found.complete);
      for (const ArmSolution& s : found.all()) EXPECT_NE(s.free, 0);
    }
    // Three conditions in the plane and three joints: finite, and complete.
    const ArmSolutions exact = judgedSet(planar(3), {}, q.head(3), reference);
    EXPECT_EQ(exact.count, 2);
    EXPECT_TRUE(exact.complete);
  }
}

TEST(CompleteSet, AJointThatDoesNotMoveThePointKeepsTheReference) {
  const Skeleton ur5 = toSkeleton(robotTable("ur5"));
  for (const char* tip : {"joint1", "joint3"}) {
    const int joint = ur5.jointIndex(tip);
    const CompleteSet set(ur5, joint, {.task = TipTask::Position});
    const VectorXd q = VectorXd::Constant(ur5.nq(), 0.4);
    Vector6d reference = Vector6d::Zero();
    reference[set.joints() - 1] = 0.25;
    ArmSolutions found;
    set.solve(forwardKinematics(ur5, q)[joint], reference, found);
    EXPECT_EQ(found.count, set.joints() == 1 ? 1 : 2) << tip;
    for (const ArmSolution& s : found.all()) {
      EXPECT_EQ(s.q[set.joints() - 1], 0.25);
      EXPECT_NE(s.free, 0);
    }
  }
}

TEST(CompleteSet, AStretchedArmIsSingularInWhatIsAskedOfIt) {
  const Skeleton arm = armOfRows({{.a = 1.0}, {.a = 0.8}});
  const CompleteSet set(arm, arm.jointCount() - 1, {.task = TipTask::Position});
  EXPECT_LT(set.singularity(Eigen::Vector2d(0.3, 0.0)).sigmaMin, 1e-12);
  EXPECT_GT(set.singularity(Eigen::Vector2d(0.3, 1.0)).sigmaMin, 0.1);
  const ArmSolutions merged = judgedSet(arm, {.task = TipTask::Position}, Eigen::Vector2d(0.3, 0.0), {});
  ASSERT_GT(merged.count, 0);
  EXPECT_EQ(merged.list[0].free, 0);  // branches merge, and no curve is told
}

TEST(CompleteSet, FamiliesAndSlidingJointsAreRefusedWithAReason) {
  const Skeleton panda = toSkeleton(robotTable("panda")), scara = toSkeleton(robotTable("scara"));
  EXPECT_NE(CompleteSet::whyNot(panda, panda.jointCount() - 1).find("families"), std::string::npos);
  DhTable bare = robotTable("scara");
  bare.rows[0].kind = DhJoint::Prismatic, bare.rows[2].kind = DhJoint::Revolute;
  bare.rest = {};
  bare.rows.push_back(DhRow{.kind = DhJoint::Prismatic, .alpha = 1.0});  // behind it no wrist can be
  const Skeleton other = toSkeleton(bare);
  EXPECT_EQ(CompleteSet::whyNot(scara, scara.jointCount() - 1), "");
  EXPECT_NE(CompleteSet::whyNot(other, other.jointCount() - 1).find("slides"), std::string::npos);
}

/// Slides where `slides` says so among the first three joints; a wrist behind them.
DhTable slidingArm(std::mt19937_64& random, unsigned slides) {
  const auto symmetric = [&] { return 2.0 * uniform01(random) - 1.0; };
  DhTable table{.name = "slides", .convention = DhConvention::Standard};
  for (int i = 0; i < 6; ++i) {
    const bool wrist = i >= 3, bare = i == 3 || i == 4;
    const double sign = uniform01(random) < 0.5 ? -1.0 : 1.0, alpha = sign * (0.6 + uniform01(random));
    table.rows.push_back(DhRow{.kind = slides >> i & 1u ? DhJoint::Prismatic : DhJoint::Revolute,
                               .a = wrist ? 0.0 : symmetric(),
                               .alpha = alpha,
                               .d = bare && i == 4 ? 0.0 : symmetric(),
                               .phi = symmetric()});
  }
  return table;
}

/// Stanford arms, gantries and all between, each also with a slide that is at right angles to its neighbours:
/// the pose that made the target is in the set, every solution reaches it, and Newton's method from many
/// starts finds no other.
TEST(SlidingJoints, BehindThemAWristHasItsWholeSet) {
  std::mt19937_64 random(45);
  for (unsigned slides = 1; slides < 8; ++slides)
    for (const bool square : {false, true}) {
      if (square && slides == 5) continue;  // both slides at right angles to axis 2: see below
      SCOPED_TRACE(slides);
      int counted = 0, foundByNewton = 0;
      for (int a = 0; a < 4; ++a) {
        DhTable table = slidingArm(random, slides);
        if (square)
          for (int i = 0; i < 3; ++i) table.rows[i].alpha = M_PI / 2, table.rows[i].a *= i % 2;
        const SerialChain chain = chainOf(table);
        const SixJointArm arm(chain);
        for (int t = 0; t < 25; ++t) {
          Vector6d q = randomAngles(random);
          for (int i = 0; i < 3; ++i)
            if (slides >> i & 1u) q[i] *= 0.5;
          const Isometry3d pose = tipFrame(chain, q);
          ArmSolutions found;
          arm.solve(pose, Vector6d::Zero(), found);
          double nearest = INFINITY;
          const auto difference = [&](const Vector6d& a, const Vector6d& b) {
            double most = 0.0;
            for (int i = 0; i < 6; ++i)
              most = std::max(
                  most, std::abs(slides >> i & 1u ? a[i] - b[i] : std::remainder(a[i] - b[i], 2 * M_PI)));
            return most;
          };
          for (const ArmSolution& s : found.all()) {
            EXPECT_LT(poseError(chain, s.q, pose), 1e-11);
            EXPECT_EQ(s.free, 0);
            nearest = std::min(nearest, difference(s.q, q));
          }
          EXPECT_LT(nearest, 1e-5) << q.transpose();
          if (t > 2) continue;
          std::vector<Vector6d> newton;
          for (int start = 0; start < 120; ++start) {
            Vector6d x = randomAngles(random);
            if (!reachedByNewton(chain, pose, x)) continue;
            bool known = false;
            for (const Vector6d& y : newton) known |= difference(x, y) < 1e-5;
            if (!known) newton.push_back(x);
          }
          for (const Vector6d& x : newton) {
            double own = INFINITY;
            for (const ArmSolution& s : found.all()) own = std::min(own, difference(s.q, x));
            EXPECT_LT(own, 1e-5) << x.transpose();
          }
          counted += found.count, foundByNewton += static_cast<int>(newton.size());
        }
      }
      EXPECT_LE(foundByNewton, counted);
      EXPECT_GE(foundByNewton, 6 * counted / 10) << counted;  // or the test would say nothing
    }
}

TEST(SlidingJoints, ArmsThatHaveOnlyFamiliesAreRefused) {
  std::mt19937_64 random(47);
  DhTable table = slidingArm(random, 5);
  for (int i = 0; i < 3; ++i) table.rows[i].alpha = M_PI / 2;  // the wrist's centre stays in a plane
  EXPECT_THROW(SixJointArm{chainOf(table)}, std::invalid_argument);
}

TEST(SlidingJoints, FewerThanSixJointsHaveTheirSetsToo) {
  const Skeleton scara = toSkeleton(robotTable("scara"));
  const int tip = scara.jointCount() - 1;
  const CompleteSet set(scara, tip);
  std::mt19937_64 random(46);
  for (int t = 0; t < 50; ++t) {
    const VectorXd q = randomWithinLimits(scara, random);
    const Isometry3d pose = forwardKinematics(scara, q)[tip];
    ArmSolutions found;
    set.solve(pose, Vector6d::Zero(), found);
    EXPECT_EQ(found.count, 2);  // two elbows
    double nearest = INFINITY;
    for (const ArmSolution& s : found.all()) {
      VectorXd all = q;
      for (int i = 0; i < set.joints(); ++i) all[set.chain().qIndex[i]] = s.q[i];
      EXPECT_LT((forwardKinematics(scara, all)[tip].matrix() - pose.matrix()).norm(), 1e-10);
      nearest = std::min(nearest, apart(all, q));
    }
    EXPECT_LT(nearest, 1e-6);
  }
}

TEST(ClosedForm, TheNearestSolutionWithinLimitsIsTaken) {
  for (const char* name : {"puma560", "ur5", "panda"}) {
    const Skeleton skeleton = toSkeleton(robotTable(name));
    const auto solver = makeSolver("closed-form");
    solver->prepare(skeleton);
    std::mt19937_64 random(39);
    for (int trial = 0; trial < 200; ++trial) {
      const VectorXd known = randomWithinLimits(skeleton, random);
      const Isometry3d pose = forwardKinematics(skeleton, known).back();
      IkProblem problem{.skeleton = &skeleton, .start = randomWithinLimits(skeleton, random)};
      problem.goals = {{.kind = GoalKind::Pose,
                        .joint = skeleton.jointCount() - 1,
                        .target = pose.translation(),
                        .orientation = Eigen::Quaterniond(pose.linear())}};
      const IkReport report = solver->solve(problem, {}, TraceLevel::Off);
      EXPECT_EQ(report.why, Stop::Converged) << name;
      EXPECT_TRUE(judge(problem, report.q).solved) << name;
      EXPECT_LE((report.q - problem.start).norm(), (known - problem.start).norm() + 1e-9) << name;
    }
  }
}

TEST(ClosedForm, IsReadByItsOldName) { EXPECT_EQ(presentName("spherical-wrist"), "closed-form"); }

}  // namespace
}  // namespace gelenk
