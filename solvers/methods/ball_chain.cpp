#include "solvers/methods/ball_chain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "kinematics/configuration.h"
#include "solvers/iteration/attempt.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// J J^T, column-free: sum of |r|^2 I - r r^T over the joints.
Matrix3d reachMatrix(std::span<const Vector3d> points) {
  const Vector3d& effector = points.back();
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
  for (const Vector3d& p : points.first(points.size() - 1)) {
    const Vector3d r = effector - p;
    xx += r.x() * r.x(), xy += r.x() * r.y(), xz += r.x() * r.z();
    yy += r.y() * r.y(), yz += r.y() * r.z(), zz += r.z() * r.z();
  }
  Matrix3d A;
  A << yy + zz, -xy, -xz, -xy, xx + zz, -yz, -xz, -yz, xx + yy;
  return A;
}

/// Turns joint i about its point by r_i x y, all at once, root first.
void turnAll(std::span<Vector3d> points, std::span<Quaterniond> rotations, const Vector3d& y,
             double largestTurn) {
  const Vector3d effector = points.back();
  Quaterniond sum = Quaterniond::Identity();
  Vector3d before = points[0];
  double largest = 0.0;
  for (size_t i = 0; i + 1 < points.size(); ++i)
    largest = std::max(largest, (effector - points[i]).cross(y).squaredNorm());
  const double scale = largest > largestTurn * largestTurn ? largestTurn / std::sqrt(largest) : 1.0;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const Vector3d half = (effector - before).cross(y) * (0.5 * scale);
    sum = sum * Quaterniond(1.0, half.x(), half.y(),
                            half.z());  // 2 atan of the half angle: equal to it in first order
    sum.normalize();
    const Vector3d bone = points[i + 1] - before;
    before = points[i + 1];
    points[i + 1] = points[i] + sum * bone;
    if (!rotations.empty()) rotations[i] = sum * rotations[i];
  }
}

/// A chain in line with its target has no slope sideways: a small turn of the second joint gives it one.
void leaveLine(std::span<Vector3d> points, std::span<Quaterniond> rotations) {
  const Vector3d line = points.back() - points.front();
  if (points.size() < 3 || line.squaredNorm() == 0.0) return;
  const Quaterniond aside(Eigen::AngleAxisd(0.02, line.unitOrthogonal()));
  for (size_t i = 1; i + 1 < points.size(); ++i) {
    points[i + 1] = points[1] + aside * (points[i + 1] - points[1]);
    if (!rotations.empty()) rotations[i] = aside * rotations[i];
  }
}

/// The path of unlimited balls, as points and world rotations.
struct BallPath {
  std::vector<int> joints;
  std::vector<Isometry3d> fromParent;  ///< zero frame of each in the moved frame of the ball above
  Vector3d tip = Vector3d::Zero();
  std::string whyNot;

  BallPath(const Skeleton& skeleton, const Goal& goal) {
    std::vector<int> path;
    for (int j = goal.joint; j >= 0; j = skeleton.parent(j)) path.push_back(j);
    Isometry3d since = Isometry3d::Identity();
    for (auto j = path.rbegin(); j != path.rend(); ++j) {
      const Joint& joint = skeleton.joint(*j);
      since = since * joint.parentFromZero;
      if (!joint.axes.empty() || joint.ballLimit) {
        whyNot = "joint '" + joint.name + "' on the path is not an unlimited ball";
        return;
      }
      if (!joint.ball) continue;
      joints.push_back(*j);
      fromParent.push_back(since);
      since = Isometry3d::Identity();
    }
    tip = since * goal.pointInJoint;
    if (joints.empty()) whyNot = "no joint on the path turns";
  }
};

class BallChain final : public IkSolver {
 public:
  explicit BallChain(const BallChainParameters& parameters) : p_(parameters) {}
  std::string whyUnsupported(const IkProblem& problem) const override {
    if (problem.goals.empty()) return {};
    if (problem.goals.size() != 1 || problem.goals[0].kind != GoalKind::Position)
      return "solves exactly one position goal";
    return BallPath(*problem.skeleton, problem.goals[0]).whyNot;
  }

  IkReport solve(const IkProblem& problem, const Budget& budget, TraceLevel trace) const override {
    if (!whyUnsupported(problem).empty()) return unsupported(problem);
    const Skeleton& skeleton = *problem.skeleton;
    return solveWithRestarts(problem, budget, trace, [&](Attempt& attempt) {
      const BallPath path(skeleton, problem.goals[0]);
      const size_t n = path.joints.size();
      const auto run = [&] {
        std::vector<Vector3d> points(n + 1);
        std::vector<Quaterniond> turned(n, Quaterniond::Identity()), before(n);
        Isometry3d above = Isometry3d::Identity();
        for (size_t i = 0; i < n; ++i) {
          above = above * path.fromParent[i];
          points[i] = above.translation();
          above.rotate(ballRotation(skeleton, attempt.at.q(), path.joints[i]));
          before[i] = Quaterniond(above.linear());
        }
        points[n] = above * path.tip;
        const BallChainResult result =
            solveBallChain(points, turned, problem.goals[0].target, 0.5 * problem.positionTolerance,
                           budget.maxIterations - 1, p_);
        VectorXd q = attempt.at.q();
        Quaterniond parent = Quaterniond::Identity();
        for (size_t i = 0; i < n; ++i) {
          const Quaterniond world = turned[i] * before[i];
          setBallRotation(
              skeleton, q, path.joints[i],
              ((parent * Quaterniond(path.fromParent[i].linear())).conjugate() * world).normalized());
          parent = world;
        }
        for (int i = 0; i < result.iterations; ++i) attempt.countIteration(0.0, 0.0);
        attempt.propose(q);
      };
      while (!attempt.isOver()) {
        run();
        if (attempt.isOver()) return;
        const Attempt::Rest rest = attempt.rest();
        if (rest == Attempt::Rest::No) attempt.stop(Stop::Stalled);
      }
    });
  }

 private:
  BallChainParameters p_;
};

}  // namespace

BallChainResult solveBallChain(std::span<Vector3d> points, std::span<Quaterniond> rotations,
                               const Vector3d& target, double tolerance, int maxIterations,
                               const BallChainParameters& parameters) {
  BallChainResult result;
  result.distance = (target - points.back()).norm();
  int withoutProgress = 0;
  double caution = 1.0;  // grows while steps overshoot
  while (result.iterations < maxIterations && result.distance > tolerance) {
    ++result.iterations;
    const Vector3d e = target - points.back();
    Matrix3d A = reachMatrix(points);
    A.diagonal().array() += parameters.damping * caution * e.squaredNorm() + 1e-12 * (1.0 + A.trace());
    const Vector3d y = A.ldlt().solve(e);
    double slope = 0.0, reach = 0.0;
    for (const Vector3d& p : points.first(points.size() - 1)) {
      const Vector3d r = points.back() - p;
      slope = std::max(slope, r.cross(e).norm());
      reach = std::max(reach, r.norm());
    }
    if (slope < 1e-9 * reach * e.norm())
      leaveLine(points, rotations);
    else
      turnAll(points, rotations, y, parameters.largestTurn);
    const double now = (target - points.back()).norm();
    caution = now < result.distance ? std::max(1.0, 0.25 * caution) : 8.0 * caution;
    withoutProgress = now < result.distance * (1.0 - 1e-9) ? 0 : withoutProgress + 1;
    result.distance = now;
    if (withoutProgress > 10) break;
  }
  return result;
}

std::unique_ptr<IkSolver> makeBallChain(const BallChainParameters& parameters) {
  return std::make_unique<BallChain>(parameters);
}

}  // namespace gelenk
