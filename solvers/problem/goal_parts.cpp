#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

// What several types of goals are made of.
namespace gelenk::goal_parts {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

void oneJoint(const Goal& goal, const Skeleton&, std::vector<int>& out) { out.push_back(goal.joint); }
void twoJoints(const Goal& goal, const Skeleton&, std::vector<int>& out) {
  out.push_back(goal.joint);
  out.push_back(goal.otherJoint);
}
Vector3d pointReached(const Goal& goal, const GoalPlace& at) {
  return at.frames[goal.joint] * goal.pointInJoint;
}

void putPointRows(const GoalMotion& at, int joint, const Vector3d& world, Eigen::Ref<MatrixXd> J) {
  pointJacobian(at.skeleton, at.twists, joint, world, at.A);
  J = at.A;
}
void putRotationRows(const GoalMotion& at, int joint, Eigen::Ref<MatrixXd> J) {
  rotationJacobian(at.skeleton, at.twists, joint, at.A);
  J = at.A;
}

Vector3d rotationError(const Eigen::Quaterniond& wanted, const Eigen::Isometry3d& worldFromJoint) {
  return logRotation(wanted.normalized() * Eigen::Quaterniond(worldFromJoint.linear()).conjugate());
}

void addPointHessian(const GoalBend& at, int row, MatrixXd& H) {
  const auto J = at.J.middleRows<3>(row);
  H.noalias() += J.transpose() * J;
  // force . d2p/(da db) = (force x omega_a) . J_b for a above b
  const Vector3d force = at.r.segment<3>(row);
  for (std::size_t i = 0; i < at.path.size(); ++i)
    for (int a = at.path[i].first; a < at.path[i].first + at.path[i].count; ++a) {
      const Vector3d lever = force.cross(at.twists.col(a).tail<3>().matrix());
      for (int b = at.path[i].first; b < at.path[i].first + at.path[i].count; ++b) {
        const double half = 0.5 * lever.dot(J.col(b));
        H(a, b) -= half;
        H(b, a) -= half;
      }
      for (std::size_t j = i + 1; j < at.path.size(); ++j)
        for (int b = at.path[j].first; b < at.path[j].first + at.path[j].count; ++b) {
          const double value = lever.dot(J.col(b));
          H(a, b) -= value;
          H(b, a) -= value;
        }
    }
}

void addRotationHessian(const GoalBend& at, int row, MatrixXd& H) {
  const auto J = at.J.middleRows<3>(row);
  const Vector3d error = at.r.segment<3>(row) / std::sqrt(at.weight);
  at.A = squaredAngleHessian(error) * J;
  H.noalias() += J.transpose() * at.A;
  // exp(omega_a s) exp(omega_b t) turns by omega_a s + omega_b t + 1/2 s t omega_a x omega_b + ...
  const Vector3d moment = at.weight * error;
  for (std::size_t i = 0; i < at.path.size(); ++i)
    for (int a = at.path[i].first; a < at.path[i].first + at.path[i].count; ++a) {
      const Vector3d lever = 0.5 * moment.cross(at.twists.col(a).tail<3>().matrix());
      for (std::size_t j = i + 1; j < at.path.size(); ++j)
        for (int b = at.path[j].first; b < at.path[j].first + at.path[j].count; ++b) {
          const double value = lever.dot(at.twists.col(b).tail<3>());
          H(a, b) -= value;
          H(b, a) -= value;
        }
    }
}

void addPointDerivative(const GoalBend& at, int row, const VectorXd& d, Eigen::Ref<MatrixXd> dJ) {
  // Column b of J moves by omega_a x J_b for every a above it and by omega_b x J_a for every a below it;
  // within a ball both halves count, as exp(omega) has no order.
  const auto J = at.J.middleRows<3>(row);
  Vector3d after = Vector3d::Zero(), above = Vector3d::Zero();
  for (const DofGroup& group : at.path)
    for (int k = group.first; k < group.first + group.count; ++k) after += J.col(k) * d[k];
  for (const DofGroup& group : at.path) {
    Vector3d turn = Vector3d::Zero(), own = Vector3d::Zero();
    for (int k = group.first; k < group.first + group.count; ++k) {
      turn += at.twists.col(k).tail<3>() * d[k];
      own += J.col(k) * d[k];
    }
    after -= own;
    for (int k = group.first; k < group.first + group.count; ++k) {
      const Vector3d omega = at.twists.col(k).tail<3>(), column = J.col(k);
      dJ.col(k).segment<3>(row) += (above + 0.5 * turn).cross(column) + omega.cross(after + 0.5 * own);
    }
    above += turn;
  }
}

void addRotationDerivative(const GoalBend& at, int row, const VectorXd& d, Eigen::Ref<MatrixXd> dJ) {
  const auto J = at.J.middleRows<3>(row);
  Vector3d above = Vector3d::Zero();
  for (const DofGroup& group : at.path) {
    for (int k = group.first; k < group.first + group.count; ++k) {
      const Vector3d column = J.col(k);
      dJ.col(k).segment<3>(row) += above.cross(column);
    }
    for (int k = group.first; k < group.first + group.count; ++k) above += at.twists.col(k).tail<3>() * d[k];
  }
}

void addTriad(const Vector3d& at, const Eigen::Quaterniond& orientation, double size, GoalMark& mark) {
  for (int k = 0; k < 3; ++k)
    mark.segments.push_back(
        {at, at + size * (orientation.normalized() * Vector3d::Unit(k)), GoalMark::Stress::Faint});
}

double markSize(const Skeleton& skeleton) {
  double longest = 0.0;
  for (int i = 0; i < skeleton.jointCount(); ++i) longest = std::max(longest, chainLength(skeleton, i));
  return longest > 0.0 ? 0.04 * longest : 0.1;
}

}  // namespace gelenk::goal_parts
