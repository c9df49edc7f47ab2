#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

// Look-at: the axis a of the joint points from the joint's origin p at the target t.
// r = rotation vector that turns a into u = (t - p) / |t - p|; radians, world. The wanted direction turns too
// when the origin moves: dr = -((I - u u^T) omega + u x dp / |t - p|), exact where r = 0.
// In the drag solver phi = arm^2 (1 - u . a), exact slope and curvature in (p, a).
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::joint,
                                {"axis", "the axis of the joint that shall point at the target",
                                 GoalField::Meaning::AxisInJoint, &Goal::axisInJoint, true},
                                goal_fields::target};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  const Vector3d wanted = goal.target - at.frames[goal.joint].translation();
  const Vector3d current = at.frames[goal.joint].linear() * goal.axisInJoint;
  r = wanted.norm() > 0.0 ? logRotation(rotationBetween(current, wanted)) : Vector3d(Vector3d::Zero());
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const Vector3d origin = at.frames[goal.joint].translation(), wanted = goal.target - origin;
  const double distance = std::max(wanted.norm(), 1e-9);
  const Vector3d u = wanted / distance;
  rotationJacobian(at.skeleton, at.twists, goal.joint, at.A);
  pointJacobian(at.skeleton, at.twists, goal.joint, origin, at.B);
  J.noalias() = (Matrix3d::Identity() - u * u.transpose()) * at.A;
  J.noalias() += crossMatrix(u / distance) * at.B;
}

void carried(const Goal& goal, const Skeleton&, int sum, std::vector<Carried>& out) {
  out.push_back(
      sum == 0 ? Carried{.joint = goal.joint}
               : Carried{.joint = goal.joint, .inJoint = goal.axisInJoint.normalized(), .direction = true});
}
void model(const Goal& goal, std::span<const Vector3d> y, double arm, bool exact, DragModel& out) {
  out.clear(2);
  const Vector3d v = goal.target - y[0], a = y[1];
  const double s = v.norm(), w = arm * arm;
  out.stiffness[0] = 0.0;
  out.stiffness[1] = w;
  if (!(s > 1e-9)) return;
  const Vector3d u = v / s, across = a - u * u.dot(a);  // P a
  const double cosine = u.dot(a);
  out.cost = 0.5 * w * (u - a).squaredNorm();
  out.force[0] = -w / s * across;  // the origin goes where u turns to a
  out.force[1] = w * (u - a);      // of no effect along a, which only turns
  const Vector3d e[2] = {u.unitOrthogonal(), u.cross(u.unitOrthogonal())};
  const auto row = [&](const Vector3d& p, const Vector3d& q, double factor) {
    if (factor == 0.0) return;
    const double length = arm * std::sqrt(std::abs(factor));
    DragModel::Row& to = out.row[out.rows++];
    to.c[0] = length * p;
    to.c[1] = length * q;
    to.sign = factor > 0.0 ? 1.0 : -1.0;
  };
  for (const Vector3d& k : e) row(k / s, k, 1.0);  // |P (da + dp / s)|^2
  if (!exact) return;
  // The rest of d^2 phi = |da|^2 + 2 da . P dp / s + (cosine |P dp|^2 + 2 (u . dp)(P a . dp)) / s^2, with
  // 2 x y = (x + y)^2 / 2 - (x - y)^2 / 2.
  row(Vector3d::Zero(), u, 1.0);
  for (const Vector3d& k : e) row(k / s, Vector3d::Zero(), cosine - 1.0);
  row((u + across) / s, Vector3d::Zero(), 0.5);
  row((u - across) / s, Vector3d::Zero(), -0.5);
}

Vector3d reached(const Goal& goal, const GoalPlace& at) {
  const Eigen::Isometry3d& frame = at.frames[goal.joint];
  const double distance = (goal.target - frame.translation()).norm();
  return frame.translation() + distance * (frame.linear() * goal.axisInJoint.normalized());
}
void capture(Goal& goal, const GoalPlace& at) {
  const Eigen::Isometry3d& frame = at.frames[goal.joint];
  const double distance = (goal.target - frame.translation()).norm();
  goal.target = frame.translation() + (distance > 1e-3 ? distance : 10.0 * markSize(at.skeleton)) *
                                          (frame.linear() * goal.axisInJoint.normalized());
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  mark.points.push_back(goal.target);
  mark.segments.push_back({at.frames[goal.joint].translation(), reached(goal, at), GoalMark::Stress::Main});
}

}  // namespace

const GoalType aimGoal{.kind = GoalKind::Aim,
                       .name = "aim",
                       .title = "Look at",
                       .asks = "An axis of a joint points at a place.",
                       .fields = fields,
                       .handleAtTarget = true,
                       .rows = rows<3>,
                       .residual = residual,
                       .jacobian = jacobian,
                       .error = orientationError,
                       .joints = oneJoint,
                       .drag = {.sums = 2, .carried = carried, .model = model},
                       .reached = reached,
                       .capture = capture,
                       .mark = mark};

}  // namespace gelenk
