#include "solvers/evaluator.h"

#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Vector3d orientationError(const Goal& goal, const Eigen::Isometry3d& worldFromJoint) {
  return logRotation(goal.orientation.normalized() * Quaterniond(worldFromJoint.linear()).conjugate());
}

/// The three points of a pole goal: a (parent), b (the joint), c (its first child).
struct BendTriangle {
  int a, b, c;
  BendTriangle(const Goal& goal, const Skeleton& skeleton) : a(skeleton.parent(goal.joint)), b(goal.joint), c(-1) {
    if (a < 0 || skeleton.children(b).empty())
      throw std::invalid_argument("a pole goal needs a joint with a parent and a child; '" + skeleton.joint(b).name +
                                  "' has not both");
    c = skeleton.children(b).front();
  }
};

}  // namespace

int residualRows(const Goal& goal, const Skeleton& skeleton) {
  switch (goal.kind) {
    case GoalKind::Position:
    case GoalKind::Orientation:
    case GoalKind::Aim: return 3;
    case GoalKind::Pose: return 6;
    case GoalKind::Pole: return 1;
    case GoalKind::Posture: return skeleton.nv();
  }
  return 0;
}

void goalResidual(const Goal& goal, const Skeleton& skeleton, const VectorXd& q, const Frames& frames,
                  Eigen::Ref<VectorXd> r) {
  const Eigen::Isometry3d& worldFromJoint = frames[goal.joint];
  switch (goal.kind) {
    case GoalKind::Position: r = goal.target - worldFromJoint * goal.pointInJoint; break;
    case GoalKind::Orientation: r = orientationError(goal, worldFromJoint); break;
    case GoalKind::Pose:
      r.head<3>() = goal.target - worldFromJoint * goal.pointInJoint;
      r.tail<3>() = orientationError(goal, worldFromJoint);
      break;
    case GoalKind::Aim: {
      const Vector3d wanted = goal.target - worldFromJoint.translation();
      const Vector3d current = worldFromJoint.linear() * goal.axisInJoint;
      r = wanted.norm() > 0.0 ? logRotation(rotationBetween(current, wanted)) : Vector3d(Vector3d::Zero());
      break;
    }
    case GoalKind::Pole: {
      const BendTriangle t(goal, skeleton);
      const Vector3d a = frames[t.a].translation(), b = frames[t.b].translation(), c = frames[t.c].translation();
      const Vector3d u = (c - a).normalized(), s = goal.target - a;
      const double width = (s - u * u.dot(s)).norm();
      r[0] = width > 1e-12 ? u.dot((b - a).cross(s)) / width : 0.0;
      break;
    }
    case GoalKind::Posture: r = difference(skeleton, q, goal.posture); break;
  }
}

CountedEvaluator::CountedEvaluator(const IkProblem& problem)
    : problem_(problem), begin_(std::chrono::steady_clock::now()) {
  for (const Goal& goal : problem.goals) rows_ += residualRows(goal, skeleton());
  r_.resize(rows_);
  J_.resize(rows_, skeleton().nv());
}

double CountedEvaluator::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

void CountedEvaluator::moveTo(const VectorXd& q) {
  q_ = q;
  forwardKinematics(skeleton(), q_, frames_);
  ++counters_.forwardKinematics;
  jacobianIsCurrent_ = false;
  int row = 0;
  for (const Goal& goal : problem_.goals) {
    const int rows = residualRows(goal, skeleton());
    goalResidual(goal, skeleton(), q_, frames_, r_.segment(row, rows));
    r_.segment(row, rows) *= std::sqrt(goal.weight);
    row += rows;
  }
}

const MatrixXd& CountedEvaluator::jacobian() {
  if (jacobianIsCurrent_) return J_;
  jacobianIsCurrent_ = true;
  ++counters_.jacobians;
  dofTwists(skeleton(), q_, frames_, twists_);
  const int nv = skeleton().nv();
  Eigen::Matrix3Xd A(3, nv), B(3, nv), C(3, nv);
  int row = 0;
  for (const Goal& goal : problem_.goals) {
    const int rows = residualRows(goal, skeleton());
    auto J = J_.middleRows(row, rows);
    const Eigen::Isometry3d& worldFromJoint = frames_[goal.joint];
    switch (goal.kind) {
      case GoalKind::Position:
        pointJacobian(skeleton(), twists_, goal.joint, worldFromJoint * goal.pointInJoint, A);
        J = A;
        break;
      case GoalKind::Orientation:
        rotationJacobian(skeleton(), twists_, goal.joint, A);
        J = A;
        break;
      case GoalKind::Pose:
        pointJacobian(skeleton(), twists_, goal.joint, worldFromJoint * goal.pointInJoint, A);
        rotationJacobian(skeleton(), twists_, goal.joint, B);
        J.topRows(3) = A;
        J.bottomRows(3) = B;
        break;
      case GoalKind::Aim: {  // the wanted direction turns too when the joint's origin moves
        const Vector3d wanted = goal.target - worldFromJoint.translation();
        const double distance = std::max(wanted.norm(), 1e-9);
        const Vector3d w = wanted / distance;
        rotationJacobian(skeleton(), twists_, goal.joint, A);
        pointJacobian(skeleton(), twists_, goal.joint, worldFromJoint.translation(), B);
        J = (Matrix3d::Identity() - w * w.transpose()) * A + crossMatrix(w) * B / distance;
        break;
      }
      case GoalKind::Pole: {  // r = N / D, N = u . (b-a) x s, D = |s - u u.s|
        const BendTriangle t(goal, skeleton());
        const Vector3d a = frames_[t.a].translation(), b = frames_[t.b].translation(), c = frames_[t.c].translation();
        const double length = std::max((c - a).norm(), 1e-12);
        const Vector3d u = (c - a) / length, s = goal.target - a, e = b - a;
        const double D = (s - u * u.dot(s)).norm();
        if (D <= 1e-12) {
          J.setZero();
          break;
        }
        const double N = u.dot(e.cross(s));
        pointJacobian(skeleton(), twists_, t.a, a, A);
        pointJacobian(skeleton(), twists_, t.b, b, B);
        pointJacobian(skeleton(), twists_, t.c, c, C);
        const Eigen::Matrix3Xd dU = (Matrix3d::Identity() - u * u.transpose()) / length * (C - A);
        const Eigen::RowVectorXd dN = e.cross(s).transpose() * dU + s.cross(u).transpose() * (B - A) - u.cross(e).transpose() * A;
        const Eigen::RowVectorXd dD = (-(s.transpose() * A) - u.dot(s) * (s.transpose() * dU - u.transpose() * A)) / D;
        J = -(dN / D - N / (D * D) * dD);
        break;
      }
      case GoalKind::Posture: J.setIdentity(); break;
    }
    J *= std::sqrt(goal.weight);
    row += rows;
  }
  return J_;
}

bool CountedEvaluator::withinTolerance() const {
  int row = 0;
  for (const Goal& goal : problem_.goals) {
    const int rows = residualRows(goal, skeleton());
    const double unweight = goal.weight > 0.0 ? 1.0 / std::sqrt(goal.weight) : 0.0;
    const auto r = r_.segment(row, rows);
    row += rows;
    const auto exceeds = [&](double norm, double tolerance) { return !(norm * unweight <= tolerance); };
    switch (goal.kind) {
      case GoalKind::Position:
      case GoalKind::Pole:
        if (exceeds(r.norm(), problem_.positionTolerance)) return false;
        break;
      case GoalKind::Orientation:
      case GoalKind::Aim:
        if (exceeds(r.norm(), problem_.orientationTolerance)) return false;
        break;
      case GoalKind::Pose:
        if (exceeds(r.head<3>().norm(), problem_.positionTolerance)) return false;
        if (exceeds(r.tail<3>().norm(), problem_.orientationTolerance)) return false;
        break;
      case GoalKind::Posture: break;  // a preference
    }
  }
  return true;
}

}  // namespace gelenk
