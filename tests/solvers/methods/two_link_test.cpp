#include "solvers/methods/two_link.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/planar_chain.h"
#include "solvers/problem/judge.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool sanitized = true;
#elif defined(__has_feature)
constexpr bool sanitized = __has_feature(address_sanitizer);
#else
constexpr bool sanitized = false;
#endif

Vector2d reached(const Vector2d& P1, double l1, double l2, const TwoLinkBranch& branch) {
  return endEffector({.base = P1, .lengths = {l1, l2}}, Vector2d(branch.phi1, branch.phi2));
}

/// Targets of every kind: inside, on the borders, next to them, at the base, far away, with lengths from
/// 1e-150 to 1e150.
struct Case {
  double l1, l2;
  Vector2d X;
};
Case randomCase(std::mt19937_64& random) {
  const auto length = [&]() -> double {
    switch (random() % 12) {
      case 0: return 0.0;
      case 1: return 1e-150 * uniform01(random);
      case 2: return 1e150 * uniform01(random);
      case 3: return 1.0;
      default: return uniform01(random);
    }
  };
  Case c{.l1 = length(), .l2 = length(), .X = {}};
  if (random() % 4 == 0) c.l2 = c.l1;
  const double angle = 2.0 * M_PI * uniform01(random), reach = c.l1 + c.l2, hole = std::abs(c.l1 - c.l2);
  double r = 0.0;
  switch (random() % 10) {
    case 0: r = 0.0; break;
    case 1: r = reach; break;
    case 2: r = hole; break;
    case 3: r = std::nextafter(reach, random() % 2 ? 0.0 : 1e300); break;
    case 4: r = std::nextafter(hole, random() % 2 ? 0.0 : 1e300); break;
    case 5: r = reach * (1.0 + uniform01(random)); break;
    case 6: r = hole * uniform01(random); break;
    case 7: r = 5e-324; break;
    default: r = hole + (reach - hole) * uniform01(random);
  }
  c.X = random() % 5 == 0 ? Vector2d(r, 0.0) : Vector2d(r * std::cos(angle), r * std::sin(angle));
  return c;
}

/// The number of trials is settled by GELENK_TWO_LINK_TRIALS where that is set: docs/lecture/inverse.md
/// quotes a run with 20,000,000.
long trials(long usual) {
  const char* text = std::getenv("GELENK_TWO_LINK_TRIALS");
  return text ? std::atol(text) : sanitized ? usual / 20 : usual;
}

TEST(TwoLink, EveryTargetHasFiniteBranchesThatEndWhereTheySay) {
  std::mt19937_64 random(1);
  double worstInside = 0.0, worstOutside = 0.0;
  const long n = trials(1'000'000);
  for (long i = 0; i < n; ++i) {
    const Case c = randomCase(random);
    const TwoLinkSolution solution = solveTwoLink({0, 0}, c.l1, c.l2, c.X);
    const double size = c.l1 + c.l2;
    ASSERT_GE(solution.count, 1);
    for (const TwoLinkBranch& branch : solution.branches()) {
      ASSERT_TRUE(std::isfinite(branch.phi1) && std::isfinite(branch.phi2))
          << c.l1 << " " << c.l2 << " " << c.X.transpose();
      const double miss = (reached({0, 0}, c.l1, c.l2, branch) - c.X).stableNorm();
      ASSERT_EQ(branch.exact, solution.gap <= 4 * 2.3e-16 * size);
      if (solution.kind == TwoLinkCase::TwoElbows && size > 0.0)
        worstInside = std::max(worstInside, miss / size);
      // Outside the miss is the gap, and never less than what geometry allows: the branch is a nearest point.
      if (size > 0.0)
        worstOutside =
            std::max(worstOutside, std::abs(miss - solution.gap) / std::max(size, c.X.stableNorm()));
    }
  }
  EXPECT_LE(worstInside, 1e-14) << "of l1 + l2, " << n << " targets";
  EXPECT_LE(worstOutside, 1e-14);
  RecordProperty("worst_inside_1e18", static_cast<int>(worstInside * 1e18));
  std::printf("  %ld targets, worst error inside %.2e (l1 + l2)\n", n, worstInside);
}

TEST(TwoLink, BothElbowBranchesReachTheTarget) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 10000; ++i) {
    const double l1 = 0.1 + uniform01(random), l2 = 0.1 + uniform01(random);
    const double r = std::abs(l1 - l2) + (l1 + l2 - std::abs(l1 - l2)) * (0.01 + 0.98 * uniform01(random));
    const double angle = 2.0 * M_PI * uniform01(random);
    const Vector2d P1(uniform01(random), uniform01(random)),
        X = P1 + r * Vector2d(std::cos(angle), std::sin(angle));
    const TwoLinkSolution solution = solveTwoLink(P1, l1, l2, X);
    ASSERT_EQ(solution.kind, TwoLinkCase::TwoElbows);
    EXPECT_GT(solution.branch[0].phi2, 0.0);
    EXPECT_EQ(solution.branch[1].phi2, -solution.branch[0].phi2);
    for (const TwoLinkBranch& branch : solution.branches())
      EXPECT_LE((reached(P1, l1, l2, branch) - X).norm(), 1e-14);
  }
}

TEST(TwoLink, DegenerateTargetsAreDefined) {
  const Vector2d O(0, 0);
  const auto base = solveTwoLink(O, 2, 2, O);
  EXPECT_EQ(base.kind, TwoLinkCase::AnyDirection);
  EXPECT_TRUE(base.branch[0].exact);
  const auto straight = solveTwoLink(O, 2, 1, {0, 3});
  EXPECT_EQ(straight.kind, TwoLinkCase::Straight);
  EXPECT_EQ(straight.count, 1);
  EXPECT_EQ(straight.branch[0].phi2, 0.0);
  EXPECT_DOUBLE_EQ(straight.branch[0].phi1, M_PI / 2);
  const auto folded = solveTwoLink(O, 1, 2, {0, 1});
  EXPECT_EQ(folded.kind, TwoLinkCase::Folded);
  EXPECT_LE((reached(O, 1, 2, folded.branch[0]) - Vector2d(0, 1)).norm(), 1e-15);
  const auto far = solveTwoLink(O, 2, 1, {5, 0});
  EXPECT_EQ(far.kind, TwoLinkCase::TooFar);
  EXPECT_FALSE(far.branch[0].exact);
  EXPECT_DOUBLE_EQ(far.gap, 2.0);
  const auto near = solveTwoLink(O, 3, 1, {0.5, 0});
  EXPECT_EQ(near.kind, TwoLinkCase::TooNear);
  EXPECT_DOUBLE_EQ(near.gap, 1.5);
  EXPECT_LE((reached(O, 3, 1, near.branch[0]) - Vector2d(2, 0)).norm(), 1e-15);
  const auto hole = solveTwoLink(O, 3, 1, O);  // every direction is equally near
  EXPECT_EQ(hole.kind, TwoLinkCase::TooNear);
  EXPECT_DOUBLE_EQ(hole.gap, 2.0);
  const auto nothing = solveTwoLink(O, 0, 0, O);
  EXPECT_EQ(nothing.kind, TwoLinkCase::Straight);
  EXPECT_TRUE(nothing.branch[0].exact);
  const auto oneLink = solveTwoLink(O, 0, 2, {0, 2});
  EXPECT_TRUE(oneLink.branch[0].exact);
  EXPECT_LE((reached(O, 0, 2, oneLink.branch[0]) - Vector2d(0, 2)).norm(), 1e-15);
  EXPECT_THROW(solveTwoLink(O, -1, 1, O), std::invalid_argument);
  EXPECT_THROW(solveTwoLink(O, 1, 1, {NAN, 0}), std::invalid_argument);
}

TEST(TwoLink, OfTheSlidesArctangentCandidatesHalfHold) {
  const auto candidates = arctangentCandidates({0, 0}, 10, 10, {10, 0});
  int holding = 0;
  for (const auto& c : candidates) holding += c.distance < 1e-12;
  EXPECT_EQ(holding, 2);
}

TEST(Bend, ReachesTheTargetWithTheElbowOnThePolesSide) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 10000; ++i) {
    const double l1 = 0.1 + uniform01(random), l2 = 0.1 + uniform01(random);
    const Vector3d base = testing::randomUnit(random), pole = testing::randomUnit(random);
    const Vector3d target = base + 2.0 * uniform01(random) * testing::randomUnit(random);
    const Bend bend = bendTowards(base, l1, l2, target, pole);
    EXPECT_NEAR((bend.elbow - base).norm(), l1, 1e-14);
    EXPECT_NEAR((bend.end - bend.elbow).norm(), l2, 1e-14);
    const double r = (target - base).norm();
    const double gap = std::max({0.0, r - l1 - l2, std::abs(l1 - l2) - r});
    EXPECT_NEAR((bend.end - target).norm(), gap, 1e-13);
    const Vector3d u = (target - base).normalized();
    EXPECT_GE((bend.elbow - base).dot(pole - u * u.dot(pole)), -1e-12);
  }
}

/// Largest elbow step over target step while the target crosses the pole direction in a straight line.
double worstJumpAcrossThePole(bool carried, std::mt19937_64& random) {
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    const double l1 = 0.2 + 0.2 * uniform01(random), l2 = 0.2 + 0.2 * uniform01(random);
    const Vector3d pole = testing::randomUnit(random);
    const double r = std::abs(l1 - l2) + (l1 + l2 - std::abs(l1 - l2)) * (0.3 + 0.5 * uniform01(random));
    const Vector3d across = pole.cross(testing::randomUnit(random)).normalized();
    const double offset = i % 2 ? 0.0 : 1e-9;  // through the pole itself and past it
    const double step = 1e-3;
    Vector3d elbow, end;
    bool first = true;
    for (double s = -0.1; s < 0.1; s += step) {
      const Vector3d target = (r * pole + s * across + offset * pole.cross(across));
      if (target.norm() > 0.98 * (l1 + l2)) continue;
      const Vector3d side =
          carried && !first ? carriedPole(Vector3d::Zero(), elbow, end, target, pole) : pole;
      const Bend bend = bendTowards(Vector3d::Zero(), l1, l2, target, side);
      if (!first) worst = std::max(worst, (bend.elbow - elbow).norm() / (target - end).norm());
      first = false;
      elbow = bend.elbow;
      end = bend.end;
    }
  }
  return worst;
}

TEST(Bend, ACarriedPoleDoesNotFlipTheElbow) {
  std::mt19937_64 random(4);
  const double fixed = worstJumpAcrossThePole(false, random);
  const double carried = worstJumpAcrossThePole(true, random);
  std::printf("  elbow step / target step across the pole: fixed pole %.0f, carried pole %.2f\n", fixed,
              carried);
  EXPECT_GT(fixed, 100.0);  // the trap is really there
  EXPECT_LE(carried, 5.0);
}

/// Ball shoulder, hinge elbow with a range, ball wrist, fixed finger tip.
Skeleton arm() {
  std::vector<Joint> joints{{.name = "root", .parent = -1}};
  const auto offset = [](double x, double y, double z) {
    return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
  };
  joints.push_back({.name = "shoulder", .parent = 0, .parentFromZero = offset(0, 1.4, 0), .ball = true});
  joints.push_back({.name = "elbow",
                    .parent = 1,
                    .parentFromZero = offset(0.02, 0, 0.3),
                    .axes = {AxisDof{.axis = Vector3d::UnitX(), .lower = 0.0, .upper = 2.6}}});
  joints.push_back({.name = "wrist", .parent = 2, .parentFromZero = offset(0, 0.01, 0.26), .ball = true});
  joints.push_back({.name = "tip", .parent = 3, .parentFromZero = offset(0, 0, 0.1)});
  return Skeleton(std::move(joints));
}

TEST(TwoLinkSolver, BendsAnArmToEveryReachablePoint) {
  std::mt19937_64 random(5);
  const Skeleton skeleton = arm();
  const auto solver = makeTwoLink();
  for (int i = 0; i < 2000; ++i) {
    const VectorXd there = randomWithinLimits(skeleton, random);
    for (const int joint : {3, 4}) {  // the wrist itself; the tip with the wrist held
      VectorXd goalPose = there;
      VectorXd start = randomWithinLimits(skeleton, random);
      if (joint == 4) goalPose.tail<4>() = start.tail<4>();
      const Vector3d target = forwardKinematics(skeleton, goalPose)[joint].translation();
      const IkProblem problem{
          .skeleton = &skeleton, .start = start, .goals = {{.joint = joint, .target = target}}};
      ASSERT_EQ(solver->whyUnsupported(problem), "");
      const IkReport report = solver->solve(problem, {}, TraceLevel::Off);
      EXPECT_LE(judge(problem, report.q).goals[0].position, 1e-12);
      EXPECT_EQ(report.why, Stop::Converged);
    }
  }
}

TEST(TwoLinkSolver, ReachesPosesWithTheWristsBall) {
  std::mt19937_64 random(6);
  const Skeleton skeleton = arm();
  const auto solver = makeTwoLink();
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Isometry3d there = forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[3];
    const Vector3d point(0.01, 0.02, 0.08);
    const IkProblem problem{.skeleton = &skeleton,
                            .start = randomWithinLimits(skeleton, random),
                            .goals = {{.kind = GoalKind::Pose,
                                       .joint = 3,
                                       .pointInJoint = point,
                                       .target = there * point,
                                       .orientation = Eigen::Quaterniond(there.linear())}}};
    const Judgement verdict = judge(problem, solver->solve(problem, {}, TraceLevel::Off).q);
    EXPECT_LE(verdict.goals[0].position, 1e-12);
    EXPECT_LE(verdict.goals[0].orientation, 1e-12);
  }
}

TEST(TwoLinkSolver, WorksOnThreeAxisShouldersAndInThePlane) {
  std::mt19937_64 random(7);
  std::vector<Joint> joints = arm().joints();
  joints[1].ball = false;
  for (int k : {2, 0, 1}) joints[1].axes.push_back(AxisDof{.axis = Vector3d::Unit(k)});
  const Skeleton threeAxes(joints);
  const Skeleton planar = toSkeleton(PlanarChain{.base = {1, 2}, .lengths = {0.7, 0.6}});
  const auto solver = makeTwoLink();
  for (int i = 0; i < 1000; ++i)
    for (const Skeleton* skeleton : {&threeAxes, &planar}) {
      const int tip = skeleton == &planar ? 2 : 3;
      const Vector3d target =
          forwardKinematics(*skeleton, randomWithinLimits(*skeleton, random))[tip].translation();
      const IkProblem problem{.skeleton = skeleton,
                              .start = randomWithinLimits(*skeleton, random),
                              .goals = {{.joint = tip, .target = target}}};
      EXPECT_LE(judge(problem, solver->solve(problem, {}, TraceLevel::Off).q).goals[0].position, 1e-12);
    }
}

TEST(TwoLinkSolver, LeavesTheArmStretchedTowardsATargetOutOfReach) {
  const Skeleton skeleton = arm();
  IkProblem problem{
      .skeleton = &skeleton, .start = skeleton.rest(), .goals = {{.joint = 3, .target = {2, 2, 1}}}};
  problem.start[skeleton.qIndex(2)] = 1.0;
  const IkReport report = makeTwoLink()->solve(problem, {}, TraceLevel::Off);
  EXPECT_EQ(report.why, Stop::Stationary);
  // Nothing reaches farther than the arm at its best elbow angle, and the hand lies on the line to the
  // target.
  const Frames frames = forwardKinematics(skeleton, report.q);
  const Vector3d shoulder(0, 1.4, 0), hand = frames[3].translation(), target(2, 2, 1);
  EXPECT_LE((hand - shoulder).cross(target - shoulder).norm() / (target - shoulder).norm(), 1e-12);
  std::mt19937_64 random(8);
  for (int i = 0; i < 10000; ++i)
    EXPECT_GE((hand - shoulder).norm() + 1e-12,
              (forwardKinematics(skeleton, randomWithinLimits(skeleton, random))[3].translation() - shoulder)
                  .norm());
  problem.start = report.q;
  EXPECT_LE((makeTwoLink()->solve(problem, {}, TraceLevel::Off).q - report.q).norm(), 1e-12);  // held: still
}

TEST(TwoLinkSolver, ATargetThatCrossesThePoleDoesNotFlipTheElbow) {
  const Skeleton skeleton = arm();
  const auto solver = makeTwoLink();
  std::mt19937_64 random(9);
  double worst = 0.0;
  for (int i = 0; i < 50; ++i) {
    const Vector3d shoulder(0, 1.4, 0), pole = testing::randomUnit(random);
    const Vector3d across = pole.cross(testing::randomUnit(random)).normalized();
    VectorXd q = skeleton.rest();
    Vector3d elbow = Vector3d::Zero(), hand = Vector3d::Zero();
    int frame = 0;
    for (double s = -0.15; s < 0.15; s += 1e-3, ++frame) {
      const Vector3d target = shoulder + 0.4 * pole + s * across;
      const IkProblem problem{
          .skeleton = &skeleton,
          .start = q,
          .goals = {{.joint = 3, .target = target},
                    {.kind = GoalKind::Pole, .joint = 2, .target = shoulder + 3.0 * pole}}};
      q = solver->solve(problem, {}, TraceLevel::Off).q;
      const Frames frames = forwardKinematics(skeleton, q);
      EXPECT_LE((frames[3].translation() - target).norm(), 1e-12);
      if (frame > 1)
        worst = std::max(worst,
                         (frames[2].translation() - elbow).norm() / (frames[3].translation() - hand).norm());
      elbow = frames[2].translation();
      hand = frames[3].translation();
    }
  }
  std::printf("  elbow step / target step across the pole: %.2f\n", worst);
  EXPECT_LE(worst, 5.0);
}

TEST(TwoLinkSolver, BendsTheFiguresArmsAndLegsTogether) {
  const Skeleton figure = mannequin();
  const auto solver = makeTwoLink();
  std::mt19937_64 random(10);
  const Frames rest = restFrames(figure);
  int withinLimits = 0;
  constexpr int trials = 500;
  for (int i = 0; i < trials; ++i) {
    IkProblem problem{.skeleton = &figure, .start = figure.rest()};
    for (const char* name : {"hand_l", "hand_r", "foot_l", "foot_r"}) {
      const int joint = figure.jointIndex(name);
      // Towards the hip or shoulder: always within reach of the bent limb.
      problem.goals.push_back({.name = name,
                               .joint = joint,
                               .target = rest[joint].translation() + Vector3d(0, 0.06, 0.02) +
                                         0.04 * testing::randomUnit(random)});
    }
    ASSERT_EQ(solver->whyUnsupported(problem), "");
    const IkReport report = solver->solve(problem, {}, TraceLevel::Off);
    const Judgement verdict = judge(problem, report.q);
    EXPECT_LE(verdict.limitViolation, 1e-12);
    EXPECT_EQ(report.why == Stop::Converged, verdict.solved);
    withinLimits += verdict.solved;
  }
  EXPECT_GE(withinLimits, trials * 9 / 10);  // the others would need the shoulder outside its limits
}

TEST(TwoLinkSolver, SaysWhyItCannotHelp) {
  const Skeleton skeleton = arm();
  const auto solver = makeTwoLink();
  EXPECT_NE(solver->whyUnsupported(
                {.skeleton = &skeleton, .start = skeleton.rest(), .goals = {{.name = "elbow", .joint = 2}}}),
            "");
  EXPECT_NE(solver->whyUnsupported({.skeleton = &skeleton, .start = skeleton.rest()}), "");
  EXPECT_NE(solver->whyUnsupported(
                {.skeleton = &skeleton, .start = skeleton.rest(), .goals = {{.joint = 3}, {.joint = 4}}}),
            "");
}

}  // namespace
}  // namespace gelenk
