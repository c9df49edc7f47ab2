#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

// The axis a of a joint points along the direction u of the world, wherever the joint is: an aim at a point
// that is infinitely far. r = rotation vector that turns a into u; radians, world. dr = -(I - u u^T) omega,
// exact where r = 0.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    goal_fields::joint,
    {"axis", "the axis of the joint that shall point so", GoalField::Meaning::AxisInJoint, &Goal::axisInJoint,
     true},
    {"direction", "where the axis shall point, world", GoalField::Meaning::Direction, &Goal::direction}};

Vector3d current(const Goal& goal, const GoalPlace& at) {
  return at.frames[goal.joint].linear() * goal.axisInJoint.normalized();
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = logRotation(rotationBetween(current(goal, at), goal.direction));
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const Vector3d u = goal.direction.normalized();
  rotationJacobian(at.skeleton, at.twists, goal.joint, at.A);
  J.noalias() = (Eigen::Matrix3d::Identity() - u * u.transpose()) * at.A;
}
void points(const Goal& goal, const Skeleton&, DragPoints& out) {
  out.add({.at = {.joint = goal.joint, .inJoint = goal.axisInJoint.normalized(), .direction = true},
           .target = goal.direction.normalized()});
}
Vector3d reached(const Goal& goal, const GoalPlace& at) { return at.frames[goal.joint].translation(); }
void capture(Goal& goal, const GoalPlace& at) { goal.direction = current(goal, at); }
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d origin = reached(goal, at);
  const double length = 3.0 * markSize(at.skeleton);
  mark.segments.push_back({origin, origin + length * goal.direction.normalized(), GoalMark::Stress::Main});
  mark.segments.push_back({origin, origin + length * current(goal, at), GoalMark::Stress::Faint});
}

}  // namespace

const GoalType directionGoal{.kind = GoalKind::Direction,
                             .name = "direction",
                             .title = "Direction",
                             .asks = "An axis of a joint points along a direction of the world.",
                             .fields = fields,
                             .rows = rows<3>,
                             .residual = residual,
                             .jacobian = jacobian,
                             .error = orientationError,
                             .joints = oneJoint,
                             .drag = {.points = points},
                             .reached = reached,
                             .capture = capture,
                             .mark = mark};

}  // namespace gelenk
