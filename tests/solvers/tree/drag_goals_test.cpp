// Goals that the drag solver serves by smooth costs of sums of carried points: their derivatives on the tree,
// and what a drag with them looks like.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "solvers/problem/judge.h"
#include "tests/solvers/problem/random_goal.h"
#include "tests/solvers/tree/drag_marks.h"

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

/// One goal on a tree of all joints of a random skeleton.
struct OneBlock {
  Skeleton skeleton;
  VectorXd q;
  Goal goal;
  DragDescent descent;

  OneBlock(GoalKind kind, std::mt19937_64& random)
      : skeleton(testing::randomSkeleton(random, 8)),
        q(randomWithinLimits(skeleton, random)),
        goal(testing::randomGoalOf(kind, skeleton, q, forwardKinematics(skeleton, q), random, true)),
        descent(skeleton, 0.7, postureStiffness(skeleton), skeleton.rest()) {
    std::vector<int> all;
    for (int i = 0; i < skeleton.jointCount(); ++i) all.push_back(i);
    const Vector3d origin(0.3, -0.2, 0.1);
    descent.build(all, origin);
    const GoalType& type = goalType(kind);
    TreeBlock block{.goal = &goal, .type = &type, .weight = 0.8};
    for (int j = 0; j < type.drag.sums; ++j) {
      block.correction[j] = 0.02 * testing::randomUnit(random);
      std::vector<Carried> carried;
      type.drag.carried(goal, skeleton, j, carried);
      TreeSum sum{.first = static_cast<int>(descent.shares().size())};
      double total = 0.0;
      for (const Carried& part : carried) {
        const GoalTree& tree = descent.tree();
        if (!part.direction) total += part.share;
        const Vector3d local = part.direction ? Vector3d(tree.carrierFromJoint(part.joint) * part.inJoint)
                                              : tree.toCarrier(part.joint, part.inJoint);
        if (tree.carrier(part.joint) < 0) {
          sum.constant += part.share * local;
          continue;
        }
        descent.shares().push_back({.node = tree.carrier(part.joint),
                                    .direction = part.direction,
                                    .share = part.share,
                                    .local = local});
      }
      sum.count = static_cast<int>(descent.shares().size()) - sum.first;
      sum.scale = carried.front().direction ? 1.0 : 0.7;
      if (!carried.front().direction) sum.shift = total * origin;
      descent.sums().push_back(sum);
    }
    descent.blocks().push_back(block);
    descent.load(q);
    descent.anchor();
  }
  DragDescent movedBy(const VectorXd& d) const {
    DragDescent moved = descent;
    moved.moveFreely(d.data());
    return moved;
  }
};

class EveryBlock : public ::testing::TestWithParam<const GoalType*> {};

TEST_P(EveryBlock, GradientAndHessianMatchDifferencesOnEveryKindOfJoint) {
  std::mt19937_64 random(41);
  constexpr double h = 1e-4;
  int pressed = 0;
  for (int i = 0; i < 30; ++i) {
    OneBlock problem(GetParam()->kind, random);
    if (!whyInvalid(problem.goal, problem.skeleton).empty()) continue;
    const int n = problem.descent.tree().dofCount();
    VectorXd g(n);
    TreeMatrix H;
    H.setStructure(problem.descent.tree().dofParents());
    const DragDescent::Settings settings;
    problem.descent.derivatives(settings, 1.0, g.data(), H);
    MatrixXd full = dense(H);
    for (int r = 0; r < problem.descent.rowCount(); ++r)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b)
          full(a, b) +=
              problem.descent.rowSign(r) * problem.descent.rowEntry(r, a) * problem.descent.rowEntry(r, b);
    pressed += g.norm() > 1e-3;
    const auto f = [&](const VectorXd& d) { return problem.movedBy(d).objective(settings); };
    const double scale = std::max(1.0, full.norm());
    for (int a = 0; a < n; ++a) {
      const VectorXd d = h * VectorXd::Unit(n, a);
      EXPECT_NEAR((f(d) - f(-d)) / (2 * h), g[a], 1e-6 * scale) << "dof " << a;  // h^2 f'''
      for (int b = 0; b <= a; ++b) {
        const VectorXd plus = h * (VectorXd::Unit(n, a) + VectorXd::Unit(n, b)),
                       minus = h * (VectorXd::Unit(n, a) - VectorXd::Unit(n, b));
        const double second = a == b ? (f(plus) - 2 * f(VectorXd::Zero(n)) + f(-plus)) / (4 * h * h)
                                     : (f(plus) + f(-plus) - f(minus) - f(-minus)) / (4 * h * h);
        EXPECT_NEAR(second, full(a, b), 2e-5 * scale) << "problem " << i << ", entry " << a << ", " << b;
      }
    }
  }
  EXPECT_GE(pressed, 25);
}

std::vector<const GoalType*> blockTypes() {
  std::vector<const GoalType*> types;
  for (const GoalType* type : goalTypes())
    if (type->drag.model) types.push_back(type);
  return types;
}
INSTANTIATE_TEST_SUITE_P(Table, EveryBlock, ::testing::ValuesIn(blockTypes()), [](const auto& info) {
  std::string name(info.param->name);
  std::erase(name, '-');
  return name;
});

/// A step with rows beside the tree solves what a dense matrix of the whole solves.
TEST(DragRows, StepIsTheDenseNewtonStep) {
  std::mt19937_64 random(42);
  int compared = 0;
  for (int i = 0; i < 60; ++i) {
    OneBlock problem(i % 2 ? GoalKind::CentreOfMass : GoalKind::RelativePose, random);
    problem.descent.blocks()[0].weight = 50.0;
    problem.goal.target = centreOfMass(*problem.goal.masses, forwardKinematics(problem.skeleton, problem.q)) +
                          Vector3d(1e-4, 0, 0);
    if (i % 2 == 0) {
      goalType(problem.goal.kind)
          .capture(problem.goal,
                   {problem.skeleton, problem.q, forwardKinematics(problem.skeleton, problem.q)});
      continue;
    }
    for (auto& correction : problem.descent.blocks()[0].correction) correction.setZero();
    const int n = problem.descent.tree().dofCount();
    const DragDescent::Settings settings{.lambda = 0.0, .kappa = 0.05, .exact = false, .passing = true};
    VectorXd g(n), d(n);
    TreeMatrix H;
    H.setStructure(problem.descent.tree().dofParents());
    problem.descent.derivatives(settings, 0.0, g.data(), H);
    MatrixXd full = dense(H) + 1e-6 * MatrixXd::Identity(n, n);
    for (int r = 0; r < problem.descent.rowCount(); ++r)
      for (int a = 0; a < n; ++a)
        for (int b = 0; b < n; ++b)
          full(a, b) += problem.descent.rowEntry(r, a) * problem.descent.rowEntry(r, b);
    d = -full.llt().solve(g);
    const double before = problem.descent.objective(settings);
    const StepOutcome outcome = problem.descent.step(settings);
    if (!outcome.moved) continue;
    // Far from limits both are one step; at a limit the solver's may be another one: compare where it is
    // equal in size.
    if (std::abs(outcome.step - d.lpNorm<Eigen::Infinity>()) > 1e-9 * std::max(1e-6, outcome.step)) continue;
    ++compared;
    const double fall = before - problem.descent.objective(settings);
    EXPECT_NEAR(fall, -0.5 * g.dot(d),
                1e-3 * std::abs(g.dot(d)));  // a step of 1e-4: the model is the objective
  }
  EXPECT_GE(compared, 15);
}

// ---- loops -----------------------------------------------------------------------------------------------

/// A four-bar linkage opened at its coupler: two cranks on one ground, the loop closed by a goal.
Skeleton fourBar() {
  const auto hinge = [](const char* name, int parent, Vector3d offset, bool turns = true) {
    Joint joint{.name = name, .parent = parent};
    joint.parentFromZero.translation() = offset;
    if (turns) joint.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitZ()}};
    return joint;
  };
  return Skeleton({hinge("ground", -1, {0, 0, 0}, false), hinge("crank", 0, {0, 0, 0}),
                   hinge("coupler", 1, {0.4, 0, 0}), hinge("coupler_end", 2, {1.0, 0, 0}, false),
                   hinge("rocker", 0, {1.0, 0, 0}), hinge("rocker_end", 4, {0.8, 0, 0}, false)});
}

TEST(DragLoops, AFourBarLinkageStaysClosedWhileItsCrankIsLedRound) {
  const Skeleton linkage = fourBar();
  const int crank = linkage.jointIndex("coupler");
  const Goal loop{.kind = GoalKind::RelativePosition,
                  .joint = linkage.jointIndex("coupler_end"),
                  .otherJoint = linkage.jointIndex("rocker_end"),
                  .role = Role::Pin};
  VectorXd q = linkage.rest();
  q << 1.2, -0.6, 1.7;
  IkProblem closing{.skeleton = &linkage, .start = q, .goals = {loop}};
  DragSolver solver(linkage);
  const IkReport closed = solver.solve(closing, {.restarts = 5}, TraceLevel::Off);
  ASSERT_TRUE(judge(closing, closed.q).solved);
  solver.reset(closed.q);
  const double begin = closed.q[0];
  std::vector<Goal> goals{{.joint = crank}, loop};
  double worst = 0.0, worstDrag = 0.0;
  for (int frame = 0; frame < 1000; ++frame) {  // Grashof's crank goes all the way round
    const double angle = begin + 1.2 * 2.0 * M_PI * frame / 1000.0;
    goals[0].target = 0.4 * Vector3d(std::cos(angle), std::sin(angle), 0);
    const VectorXd& at = solver.frame(goals).q;
    const Frames frames = forwardKinematics(linkage, at);
    worst =
        std::max(worst, (frames[loop.joint].translation() - frames[loop.otherJoint].translation()).norm());
    worstDrag = std::max(worstDrag, (frames[crank].translation() - goals[0].target).norm());
  }
  EXPECT_LE(worst, 3e-4);
  EXPECT_LE(worstDrag,
            5e-3);  // the posture's pull on a crank that was wound up by 7.5 rad, less the correction
  RecordProperty("worst_gap_mm", std::to_string(1e3 * worst));
}

TEST(DragLoops, BothHandsHoldABarWhileItIsDragged) {
  const marks::Figure figure;
  DragSolver solver(figure.skeleton);
  std::vector<Goal> goals = figure.pins();
  // The bar: the right hand keeps its pose in the left one's frame.
  Goal bar{.kind = GoalKind::RelativePose,
           .joint = figure.hands[1],
           .otherJoint = figure.hands[0],
           .role = Role::Pin};
  bar.pointInJoint = figure.palm;
  goalType(bar.kind).capture(bar, {figure.skeleton, figure.start, figure.startFrames});
  goals.push_back(bar);
  goals.push_back({.joint = figure.hands[0], .pointInJoint = figure.palm});
  const Vector3d from = figure.dragged(figure.startFrames, 0);
  double worstBar = 0.0, worstTurn = 0.0, worstFeet = 0.0;
  for (int frame = 0; frame < 1500; ++frame) {
    const double t = frame / 120.0;
    goals.back().target =
        from + Vector3d(0.12 * std::sin(t), 0.18 * (1.0 - std::cos(0.7 * t)), 0.10 * std::sin(1.3 * t));
    const VectorXd& q = solver.frame(goals).q;
    const Frames frames = forwardKinematics(figure.skeleton, q);
    VectorXd r(6);
    goalType(bar.kind).residual(bar, {figure.skeleton, q, frames}, r);
    worstBar = std::max(worstBar, r.head<3>().norm());
    worstTurn = std::max(worstTurn, r.tail<3>().norm());
    worstFeet = std::max(worstFeet, figure.pinError(frames));
  }
  EXPECT_LE(worstBar, 3e-4);
  EXPECT_LE(worstTurn, 3e-3);
  EXPECT_LE(worstFeet, 3e-4);
  RecordProperty("worst_bar_mm", std::to_string(1e3 * worstBar));
}

TEST(DragGoals, DistanceAimAndFloorAreMetTogether) {
  const marks::Figure figure;
  DragSolver solver(figure.skeleton);
  std::vector<Goal> goals = figure.pins();
  goals.push_back({.kind = GoalKind::Distance,
                   .joint = figure.hands[0],
                   .pointInJoint = figure.palm,
                   .otherJoint = figure.hands[1],
                   .pointInOther = figure.palm,
                   .length = 0.25});
  goals.push_back(
      {.kind = GoalKind::Aim, .joint = figure.head, .target = {0.5, 1.2, 2.0}, .axisInJoint = {0, -1, 0}});
  goals.push_back({.kind = GoalKind::HalfSpace,
                   .joint = figure.hands[0],
                   .pointInJoint = figure.palm,
                   .target = {0, 1.1, 0},
                   .role = Role::Pin});
  goals.push_back({.kind = GoalKind::KeepOut,
                   .joint = figure.hands[1],
                   .pointInJoint = figure.palm,
                   .target = {0, 1.0, 0.35},
                   .length = 0.2,
                   .end = {0, 1.4, 0.35},
                   .role = Role::Pin});
  for (int i = 0; i < 300; ++i) solver.frame(goals);
  const IkProblem problem{.skeleton = &figure.skeleton, .start = figure.start, .goals = goals};
  const Judgement verdict = judge(problem, solver.q());
  for (std::size_t i = 0; i < goals.size(); ++i) {
    EXPECT_LE(verdict.goals[i].position, 1e-4) << goalType(goals[i].kind).name;
    EXPECT_LE(verdict.goals[i].orientation, 1e-3) << goalType(goals[i].kind).name;
  }
}

TEST(DragGoals, ColdSolveReachesEveryReachableGoalOfTheTable) {
  std::mt19937_64 random(43);
  for (const GoalType* type : goalTypes()) {
    if (!type->judged) continue;
    int solved = 0, asked = 0;
    for (int i = 0; i < 30; ++i) {
      const Skeleton skeleton = testing::randomSkeleton(random, 8);
      const VectorXd there = randomWithinLimits(skeleton, random);
      const Frames frames = forwardKinematics(skeleton, there);
      Goal goal{.kind = type->kind, .joint = 7, .pointInJoint = {0.1, 0, 0}, .otherJoint = 3};
      goal.masses = testing::randomMasses(skeleton, random);
      goal.length = type->kind == GoalKind::KeepOut ? 0.0 : 0.01;
      type->capture(goal, {skeleton, there, frames});
      IkProblem problem{
          .skeleton = &skeleton, .start = randomWithinLimits(skeleton, random), .goals = {goal}};
      if (!whyInvalid(goal, skeleton).empty()) continue;
      problem.positionTolerance = problem.orientationTolerance = 1e-5;
      ++asked;
      const IkReport report = makeDrag()->solve(problem, {.restarts = 10}, TraceLevel::Off);
      EXPECT_EQ(report.why == Stop::Converged, judge(problem, report.q).solved);
      solved += judge(problem, report.q).solved;
    }
    EXPECT_GE(solved, asked - asked / 10) << type->name << " of " << asked;
  }
}

// ---- balance ---------------------------------------------------------------------------------------------

TEST(Balance, TheCentreOfMassStaysOverTheFeetInRandomDrags) {
  const marks::Figure figure;
  marks::Shown shown[2];
  for (const bool balanced : {false, true}) {
    std::mt19937_64 random(2024);
    DragOptions options;
    if (balanced) options.balance = marks::balanceOf(figure);
    DragSolver solver(figure.skeleton, options);
    for (int path = 0; path < 4; ++path) {
      const double step = path % 2 ? 0.01 : 0.05;
      solver.reset(figure.start);
      shown[balanced].add(marks::follow(figure, solver, marks::wildPath(figure, random, 250, step), step));
    }
  }
  EXPECT_GT(shown[false].outside, 100);  // otherwise this shows nothing
  EXPECT_EQ(shown[true].outside, 0);
  EXPECT_LE(shown[true].worstPin, 2e-3);
  EXPECT_LE(shown[true].worstRotation, 0.22);
  EXPECT_LE(shown[true].worstViolation, 1e-12);
  RecordProperty("outside_before", shown[false].outside);
}

}  // namespace
}  // namespace gelenk
