#include "solvers/problem/goal_type.h"

// A point x of a joint stays on one side of a plane, such as above the floor: r = max(0, (target - x) . n +
// margin) with the outward direction n; metres, one row. J = n . J_x where r > 0. The curvature n n^T is
// exact.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    goal_fields::joint,
    goal_fields::point,
    {"target", "a point of the plane", GoalField::Meaning::Target, &Goal::target},
    {"normal", "the direction out of the forbidden half space", GoalField::Meaning::Direction,
     &Goal::direction, true},
    {"margin", "how far from the plane at least", GoalField::Meaning::Length, &Goal::length, true}};

double depth(const Goal& goal, const Vector3d& x) {
  return std::max(0.0, (goal.target - x).dot(goal.direction.normalized()) + goal.length);
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r[0] = depth(goal, pointReached(goal, at));
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const Vector3d x = at.frames[goal.joint] * goal.pointInJoint;
  if (!(depth(goal, x) > 0.0)) {
    J.setZero();
    return;
  }
  pointJacobian(at.skeleton, at.twists, goal.joint, x, at.A);
  J.noalias() = goal.direction.normalized().transpose() * at.A;
}
void carried(const Goal& goal, const Skeleton&, int, std::vector<Carried>& out) {
  out.push_back({.joint = goal.joint, .inJoint = goal.pointInJoint});
}
void model(const Goal& goal, std::span<const Vector3d> y, double, bool, DragModel& out) {
  out.clear(1);
  const double inside = depth(goal, y[0]);
  if (!(inside > 0.0)) return;
  const Vector3d n = goal.direction.normalized();
  out.force[0] = inside * n;
  out.cost = 0.5 * inside * inside;
  out.addRow(1, 0, n);
}
/// The plane goes to the point, where it was on the forbidden side.
void capture(Goal& goal, const GoalPlace& at) {
  const double inside = depth(goal, pointReached(goal, at));
  goal.target -= inside * goal.direction.normalized();
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d n = goal.direction.normalized(), x = n.unitOrthogonal(), z = n.cross(x);
  const Vector3d point = pointReached(goal, at), foot = point + n * n.dot(goal.target - point);
  const double half = 3.0 * markSize(at.skeleton);
  mark.points.push_back(goal.target);
  mark.polygons.push_back(
      {{foot + half * (x + z), foot + half * (x - z), foot - half * (x + z), foot + half * (z - x)}, true});
  mark.segments.push_back({foot, point, GoalMark::Stress::Faint});
}

}  // namespace

const GoalType halfSpaceGoal{.kind = GoalKind::HalfSpace,
                             .name = "half-space",
                             .title = "Stay above a plane",
                             .asks = "A point of a joint stays on one side of a plane, such as the floor.",
                             .fields = fields,
                             .oneSided = true,
                             .handleAtTarget = true,
                             .rows = rows<1>,
                             .residual = residual,
                             .jacobian = jacobian,
                             .error = positionError,
                             .joints = oneJoint,
                             .drag = {.sums = 1, .carried = carried, .model = model},
                             .reached = pointReached,
                             .capture = capture,
                             .mark = mark};

}  // namespace gelenk
