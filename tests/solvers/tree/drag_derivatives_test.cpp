#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/mannequin.h"
#include "solvers/tree/drag_solver.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

MatrixXd dense(const TreeMatrix& H) {
  MatrixXd full = MatrixXd::Zero(H.size(), H.size());
  for (int k = 0; k < H.size(); ++k) {
    int a = k;
    for (int d = H.depth(k); d >= 0; --d, a = H.parent(a)) full(k, a) = full(a, k) = H.row(k)[d];
  }
  return full;
}

/// A random skeleton with points and directions on some joints, at a pose away from rest and anchor.
struct Problem {
  Skeleton skeleton;
  DragDescent descent;
  DragDescent::Settings settings{.lambda = 0.3, .kappa = 0.2};

  /// Every second one with joints that follow others.
  Problem(std::mt19937_64& random, int joints, int number = 0)
      : Problem(random, testing::randomTree(random, joints, number)) {}

 private:
  /// A pose at most 1.3 rad in any ball from q: the squared angle of the posture term has a kink at a half
  /// turn.
  static VectorXd near(const Skeleton& skeleton, const VectorXd& q, std::mt19937_64& random) {
    VectorXd d(skeleton.nv());
    for (double& entry : d) entry = 1.5 * (uniform01(random) - 0.5);
    return projectToLimits(skeleton, integrate(skeleton, q, d));
  }

  Problem(std::mt19937_64& random, const Skeleton& made)
      : Problem(random, made, randomWithinLimits(made, random)) {}

  Problem(std::mt19937_64& random, const Skeleton& made, const VectorXd& q)
      : skeleton(made), descent(skeleton, 0.7, postureStiffness(skeleton), near(skeleton, q, random)) {
    const int joints = skeleton.jointCount();
    std::vector<int> goals;
    for (int k = 0; k < 4; ++k) goals.push_back(static_cast<int>(random() % joints));
    descent.build(goals, Vector3d(0.3, -0.2, 0.1));
    for (int k = 0; k < 8; ++k)
      descent.points().push_back({.node = descent.tree().carrier(goals[k / 2]),
                                  .direction = k % 2 == 1,
                                  .weight = 0.1 + uniform01(random),
                                  .local = uniform01(random) * testing::randomUnit(random),
                                  .target = 2.0 * testing::randomUnit(random)});
    descent.load(q);
    descent.anchor();
    VectorXd d(descent.tree().dofCount());
    for (double& entry : d) entry = 0.2 * (uniform01(random) - 0.5);
    descent.moveFreely(d.data());
  }

 public:
  DragDescent movedBy(const VectorXd& d) const {
    DragDescent moved = descent;
    moved.moveFreely(d.data());
    return moved;
  }
};

TEST(DragDerivatives, PlacedPointsAgreeWithForwardKinematics) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 50; ++i) {
    const Skeleton skeleton = testing::randomTree(random, 12, i);
    GoalTree tree(skeleton, 0.4);
    const std::vector<int> joints{11, 7, 3};
    tree.build(joints, {1, 2, 3});
    const VectorXd q = randomWithinLimits(skeleton, random);
    TreePose pose;
    tree.load(q, pose);
    VectorXd back = skeleton.rest();
    tree.store(pose, back);
    const Frames frames = forwardKinematics(skeleton, q), framesBack = forwardKinematics(skeleton, back);
    for (const int joint : joints) {
      const Vector3d point(0.1, -0.5, 0.2), world = frames[joint] * point;
      const TreePoint carried{.node = tree.carrier(joint), .local = tree.toCarrier(joint, point)};
      EXPECT_LE((tree.at(pose, carried) - tree.toTree(world)).norm(), 1e-13);
      EXPECT_LE((framesBack[joint] * point - world).norm(), 1e-13);
    }
  }
}

TEST(DragDerivatives, GradientMatchesCentralDifferencesOnEveryKindOfJoint) {
  std::mt19937_64 random(2);
  constexpr double h = 1e-5;
  for (int i = 0; i < 60; ++i) {
    Problem problem(random, 10, i);
    const int n = problem.descent.tree().dofCount();
    VectorXd g(n);
    TreeMatrix H;
    problem.descent.derivatives(problem.settings, 1.0, g.data(), H);
    for (int k = 0; k < n; ++k) {
      const VectorXd d = h * VectorXd::Unit(n, k);
      const double slope =
          (problem.movedBy(d).objective(problem.settings) - problem.movedBy(-d).objective(problem.settings)) /
          (2 * h);
      EXPECT_NEAR(slope, g[k], 1e-8 * std::max(1.0, g.norm())) << "dof " << k;  // h^2 f'''
    }
  }
}

TEST(DragDerivatives, HessianMatchesDifferencesOfTheGradientOnEveryKindOfJoint) {
  std::mt19937_64 random(3);
  constexpr double h = 1e-3;  // second differences of the objective: rounding 1e-16 / h^2 and truncation h^2
  for (int i = 0; i < 40; ++i) {
    Problem problem(random, 10, i);
    const int n = problem.descent.tree().dofCount();
    VectorXd g(n);
    TreeMatrix H;
    H.setStructure(problem.descent.tree().dofParents());
    problem.descent.derivatives(problem.settings, 1.0, g.data(), H);
    MatrixXd full = dense(H);
    for (const TreeCoupling& c : problem.descent.tree().couplings()) {  // what follows moves with its source
      const int follower = problem.descent.tree().node(c.follower).dof,
                source = problem.descent.tree().node(c.source).dof;
      full.row(source) += c.multiplier * full.row(follower);
      full.col(source) += c.multiplier * full.col(follower);
      full.row(follower).setZero();
      full.col(follower).setZero();
    }
    const double scale = std::max(1.0, full.norm());
    for (int a = 0; a < n; ++a)
      for (int b = 0; b <= a; ++b) {
        // d^2 f / da db along one joint step each: e_a +- e_b, so that free balls are differenced through one
        // exp.
        const VectorXd plus = h * (VectorXd::Unit(n, a) + VectorXd::Unit(n, b)),
                       minus = h * (VectorXd::Unit(n, a) - VectorXd::Unit(n, b));
        const auto f = [&](const VectorXd& d) { return problem.movedBy(d).objective(problem.settings); };
        const double second = a == b ? (f(plus) - 2 * f(VectorXd::Zero(n)) + f(-plus)) / (4 * h * h)
                                     : (f(plus) + f(-plus) - f(minus) - f(-minus)) / (4 * h * h);
        EXPECT_NEAR(second, full(a, b), 2e-5 * scale) << "entry " << a << ", " << b;
      }
  }
}

TEST(DragDerivatives, GaussNewtonIsExactWhereEveryTargetIsMet) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 20; ++i) {
    Problem problem(random, 10);
    problem.settings = {.lambda = 0.0, .kappa = 0.0};
    for (TreePoint& point : problem.descent.points())
      point.target = problem.descent.tree().at(problem.descent.pose(), point);
    const int n = problem.descent.tree().dofCount();
    VectorXd g(n);
    TreeMatrix exact, gaussNewton;
    exact.setStructure(problem.descent.tree().dofParents());
    gaussNewton.setStructure(problem.descent.tree().dofParents());
    problem.descent.derivatives(problem.settings, 0.0, g.data(), gaussNewton);
    problem.descent.derivatives(problem.settings, 1.0, g.data(), exact);
    EXPECT_LE((dense(exact) - dense(gaussNewton)).norm(), 1e-13 * std::max(1.0, dense(exact).norm()));
    EXPECT_LE(g.norm(), 1e-13);
  }
}

TEST(TreeMatrix, SolvesWhatADenseCholeskySolves) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 40; ++i) {
    Problem problem(random, 14);
    const int n = problem.descent.tree().dofCount();
    VectorXd x(n), b(n);
    TreeMatrix H;
    H.setStructure(problem.descent.tree().dofParents());
    problem.descent.derivatives(problem.settings, 0.0, x.data(), H);
    for (double& entry : b) entry = uniform01(random);
    MatrixXd full = dense(H);
    const int fixed = static_cast<int>(random() % n);
    if (i % 2 == 0) {  // one unknown held at a value
      VectorXd right = b;
      H.subtractColumn(fixed, 0.3, right.data());
      right[fixed] = 0.3;
      VectorXd expected = b - 0.3 * full.col(fixed);
      expected[fixed] = 0.3;
      EXPECT_LE((right - expected).norm(), 1e-13);
      EXPECT_NEAR(H.rowTimes(fixed, b.data()), full.row(fixed) * b, 1e-12);
      H.isolate(fixed);
      full.row(fixed).setZero();
      full.col(fixed).setZero();
      full(fixed, fixed) = 1.0;
      b = right;
    }
    EXPECT_EQ((dense(H) - full).norm(), 0.0);
    x = b;
    ASSERT_TRUE(H.factor(0.0));
    H.solve(x.data());
    EXPECT_LE((x - full.llt().solve(b)).norm(), 1e-10 * std::max(1.0, x.norm()));
  }
}

TEST(TreeMatrix, RefusesWhatIsNotPositiveDefinite) {
  TreeMatrix H;
  const std::vector<int> chain{-1, 0, 1};
  H.setStructure(chain);
  for (int k = 0; k < 3; ++k) H.diagonal(k) = 1.0;
  H.row(2)[0] = 1.1;
  EXPECT_FALSE(H.factor(1e-9));
}

}  // namespace
}  // namespace gelenk
