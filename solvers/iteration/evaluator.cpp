#include "solvers/iteration/evaluator.h"

#include <algorithm>
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
  BendTriangle(const Goal& goal, const Skeleton& skeleton)
      : a(skeleton.parent(goal.joint)), b(goal.joint), c(-1) {
    if (a < 0 || skeleton.children(b).empty())
      throw std::invalid_argument("a pole goal needs a joint with a parent and a child; '" +
                                  skeleton.joint(b).name + "' has not both");
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
      const Vector3d a = frames[t.a].translation(), b = frames[t.b].translation(),
                     c = frames[t.c].translation();
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
  const int nv = skeleton().nv();
  r_.resize(rows_);
  J_.resize(rows_, nv);
  for (Eigen::Matrix3Xd* scratch : {&A_, &B_, &C_}) scratch->resize(3, nv);
  for (const Goal& goal : problem.goals) {
    std::vector<Group> path;
    for (int joint = goal.joint; joint >= 0;
         joint = skeleton().parent(joint)) {  // from the tip, turned round below
      const int axes = static_cast<int>(skeleton().joint(joint).axes.size());
      if (skeleton().joint(joint).ball) path.push_back({skeleton().vIndex(joint) + axes, 3});
      for (int k = axes - 1; k >= 0; --k) path.push_back({skeleton().vIndex(joint) + k, 1});
    }
    std::reverse(path.begin(), path.end());
    paths_.push_back(std::move(path));
  }
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
  Eigen::Matrix3Xd &A = A_, &B = B_, &C = C_;
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
        const Vector3d a = frames_[t.a].translation(), b = frames_[t.b].translation(),
                       c = frames_[t.c].translation();
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
        const Eigen::RowVectorXd dN =
            e.cross(s).transpose() * dU + s.cross(u).transpose() * (B - A) - u.cross(e).transpose() * A;
        const Eigen::RowVectorXd dD =
            (-(s.transpose() * A) - u.dot(s) * (s.transpose() * dU - u.transpose() * A)) / D;
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

void CountedEvaluator::addPointDerivative(const std::vector<Group>& path, int row, const VectorXd& d,
                                          MatrixXd& dJ) const {
  // Column b of J moves by omega_a x J_b for every a above it and by omega_b x J_a for every a below it;
  // within a ball both halves count, as exp(omega) has no order.
  Vector3d after = Vector3d::Zero(), above = Vector3d::Zero();
  for (const Group& group : path)
    for (int k = group.first; k < group.first + group.count; ++k) after += J_.col(k).segment<3>(row) * d[k];
  for (const Group& group : path) {
    Vector3d turn = Vector3d::Zero(), own = Vector3d::Zero();
    for (int k = group.first; k < group.first + group.count; ++k) {
      turn += twists_.col(k).tail<3>() * d[k];
      own += J_.col(k).segment<3>(row) * d[k];
    }
    after -= own;
    for (int k = group.first; k < group.first + group.count; ++k) {
      const Vector3d omega = twists_.col(k).tail<3>(), column = J_.col(k).segment<3>(row);
      dJ.col(k).segment<3>(row) = (above + 0.5 * turn).cross(column) + omega.cross(after + 0.5 * own);
    }
    above += turn;
  }
}

void CountedEvaluator::jacobianDerivative(const VectorXd& d, MatrixXd& dJ) {
  jacobian();
  ++counters_.hessians;
  dJ.setZero(rows_, skeleton().nv());
  int row = 0;
  for (std::size_t g = 0; g < problem_.goals.size(); ++g) {
    const Goal& goal = problem_.goals[g];
    const bool hasPoint = goal.kind == GoalKind::Position || goal.kind == GoalKind::Pose;
    const bool hasRotation = goal.kind == GoalKind::Orientation || goal.kind == GoalKind::Pose;
    if (hasPoint) addPointDerivative(paths_[g], row, d, dJ);
    if (hasRotation) {
      const int at = row + (hasPoint ? 3 : 0);
      Vector3d above = Vector3d::Zero();
      for (const Group& group : paths_[g]) {
        for (int k = group.first; k < group.first + group.count; ++k)
          dJ.col(k).segment<3>(at) = above.cross(J_.col(k).segment<3>(at));
        for (int k = group.first; k < group.first + group.count; ++k)
          above += twists_.col(k).tail<3>() * d[k];
      }
    }
    row += residualRows(goal, skeleton());
  }
}

void CountedEvaluator::addPointCurvature(const std::vector<Group>& path, int row, const Vector3d& force) {
  // force . d2p/(da db) = (force x omega_a) . J_b for a above b
  for (std::size_t i = 0; i < path.size(); ++i)
    for (int a = path[i].first; a < path[i].first + path[i].count; ++a) {
      const Vector3d lever = force.cross(twists_.col(a).tail<3>().matrix());
      for (int b = path[i].first; b < path[i].first + path[i].count; ++b) {
        const double half = 0.5 * lever.dot(J_.col(b).segment<3>(row));
        H_(a, b) -= half;
        H_(b, a) -= half;
      }
      for (std::size_t j = i + 1; j < path.size(); ++j)
        for (int b = path[j].first; b < path[j].first + path[j].count; ++b) {
          const double value = lever.dot(J_.col(b).segment<3>(row));
          H_(a, b) -= value;
          H_(b, a) -= value;
        }
    }
}

void CountedEvaluator::addRotationCurvature(const std::vector<Group>& path, const Vector3d& moment) {
  // exp(omega_a s) exp(omega_b t) turns by omega_a s + omega_b t + 1/2 s t omega_a x omega_b + ...
  for (std::size_t i = 0; i < path.size(); ++i)
    for (int a = path[i].first; a < path[i].first + path[i].count; ++a) {
      const Vector3d lever = 0.5 * moment.cross(twists_.col(a).tail<3>().matrix());
      for (std::size_t j = i + 1; j < path.size(); ++j)
        for (int b = path[j].first; b < path[j].first + path[j].count; ++b) {
          const double value = lever.dot(twists_.col(b).tail<3>());
          H_(a, b) -= value;
          H_(b, a) -= value;
        }
    }
}

namespace {

/// Hessian of 1/2 |log R|^2 in exponential coordinates about R with log R = theta u: u u^T + (theta/2)
/// cot(theta/2) (I - u u^T).
Matrix3d squaredAngleHessian(const Vector3d& logR) {
  const double theta = logR.norm();
  if (theta < 1e-4) return Matrix3d::Identity() * (1.0 - theta * theta / 12.0);
  const Vector3d u = logR / theta;
  const double across = 0.5 * theta / std::tan(0.5 * theta);
  return across * Matrix3d::Identity() + (1.0 - across) * u * u.transpose();
}

}  // namespace

const MatrixXd& CountedEvaluator::hessian() {
  jacobian();
  ++counters_.hessians;
  H_.setZero(skeleton().nv(), skeleton().nv());
  int row = 0;
  for (std::size_t g = 0; g < problem_.goals.size(); ++g) {
    const Goal& goal = problem_.goals[g];
    const int rows = residualRows(goal, skeleton());
    const double w = std::sqrt(goal.weight);  // r_ and J_ carry it once already
    const bool hasPoint = goal.kind == GoalKind::Position || goal.kind == GoalKind::Pose;
    const bool hasRotation = goal.kind == GoalKind::Orientation || goal.kind == GoalKind::Pose;
    const auto J = J_.middleRows(row, rows);
    if (!(w > 0.0)) {
      row += rows;
      continue;
    }
    if (goal.kind == GoalKind::Posture) {
      addPostureHessian(row, goal.weight);
    } else if (!hasRotation) {
      H_.noalias() += J.transpose() * J;
    } else {
      if (hasPoint) H_.noalias() += J.topRows(3).transpose() * J.topRows(3);
      const Vector3d error = r_.segment<3>(row + rows - 3) / w;
      A_ = squaredAngleHessian(error) * J.bottomRows(3);
      H_.noalias() += J.bottomRows(3).transpose() * A_;
      addRotationCurvature(paths_[g], goal.weight * error);
    }
    if (hasPoint) addPointCurvature(paths_[g], row, r_.segment<3>(row));
    row += rows;
  }
  return H_;
}

void CountedEvaluator::addPostureHessian(int row, double weight) {
  for (int i = 0; i < skeleton().jointCount(); ++i) {
    const int axes = static_cast<int>(skeleton().joint(i).axes.size()), first = skeleton().vIndex(i);
    for (int k = 0; k < axes; ++k) H_(first + k, first + k) += weight;
    if (skeleton().joint(i).ball)
      H_.block<3, 3>(first + axes, first + axes) +=
          weight * squaredAngleHessian(r_.segment<3>(row + first + axes) / std::sqrt(weight));
  }
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
