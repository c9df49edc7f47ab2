#include <algorithm>

#include "solvers/problem/goal_type.h"

// A point x of a joint stays outside a capsule: no nearer than `length` to the segment from target to end; a
// sphere where the two are one point. r = max(0, length - d), d = |x - nearest point of the segment|; metres,
// one row, 0 outside. J = n . J_x inside, n = (x - nearest) / d; on the segment itself n is any direction
// across it.
// Exact curvature of 1/2 r^2: n n^T - r / d times what is across n and, beside the segment, across it.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    goal_fields::joint,
    goal_fields::point,
    {"target", "where the capsule's segment begins, or the middle of a sphere", GoalField::Meaning::Target,
     &Goal::target},
    {"end", "where the segment ends; the same point: a sphere", GoalField::Meaning::End, &Goal::end, true},
    {"radius", "how near the point may come to the segment", GoalField::Meaning::Length, &Goal::length}};

struct Inside {
  double depth = 0.0, distance = 0.0;
  Vector3d out = Vector3d::Zero(),
           along = Vector3d::Zero();  ///< along: unit beside the segment, 0 at its ends
};

Inside look(const Goal& goal, const Vector3d& x) {
  const Vector3d line = goal.end - goal.target, to = x - goal.target;
  const double length2 = line.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp(line.dot(to) / length2, 0.0, 1.0) : 0.0;
  const Vector3d from = to - share * line;
  Inside inside{.depth = goal.length - from.norm(), .distance = from.norm()};
  if (!(inside.depth > 0.0)) return {};
  const bool beside = share > 0.0 && share < 1.0;
  if (beside) inside.along = line.normalized();
  inside.out = inside.distance > 1e-12 ? Vector3d(from / inside.distance)
               : length2 > 0.0         ? Vector3d(line.unitOrthogonal())
                                       : Vector3d::UnitY();
  return inside;
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r[0] = look(goal, pointReached(goal, at)).depth;
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const Vector3d x = at.frames[goal.joint] * goal.pointInJoint;
  const Inside inside = look(goal, x);
  if (!(inside.depth > 0.0)) {
    J.setZero();
    return;
  }
  pointJacobian(at.skeleton, at.twists, goal.joint, x, at.A);
  J.noalias() = inside.out.transpose() * at.A;
}
void carried(const Goal& goal, const Skeleton&, int, std::vector<Carried>& out) {
  out.push_back({.joint = goal.joint, .inJoint = goal.pointInJoint});
}
void model(const Goal& goal, std::span<const Vector3d> y, double, bool exact, DragModel& out) {
  out.clear(1);
  const Inside inside = look(goal, y[0]);
  if (!(inside.depth > 0.0)) return;
  out.force[0] = inside.depth * inside.out;
  out.cost = 0.5 * inside.depth * inside.depth;
  out.addRow(1, 0, inside.out);
  if (!exact || !(inside.distance > 1e-9)) return;
  const bool beside = !inside.along.isZero(0.0);
  const Vector3d first = beside ? Vector3d(inside.along.cross(inside.out)) : inside.out.unitOrthogonal();
  const double size = std::sqrt(inside.depth / inside.distance);
  out.addRow(1, 0, size * first, -1.0);
  if (!beside) out.addRow(1, 0, size * inside.out.cross(first), -1.0);
}
void capture(Goal& goal, const GoalPlace& at) {
  if (goal.length > 0.0) return;
  goal.length = 3.0 * markSize(at.skeleton);
  goal.target = goal.end = pointReached(goal, at) + goal.length * Vector3d::UnitX();
}
void mark(const Goal& goal, const GoalPlace&, GoalMark& mark) {
  const Vector3d line = goal.end - goal.target;
  const bool sphere = !(line.norm() > 1e-12);
  const Vector3d axis = sphere ? Vector3d(Vector3d::UnitY()) : Vector3d(line.normalized());
  const Vector3d x = axis.unitOrthogonal(), y = axis.cross(x);
  mark.points.push_back(goal.target);
  if (!sphere) mark.points.push_back(goal.end);
  for (const Vector3d& centre : {goal.target, goal.end}) {
    for (const Vector3d& normal : {axis, x, y}) mark.rings.push_back({centre, normal, goal.length});
    if (sphere) break;
  }
  if (sphere) return;
  for (const Vector3d& side : {x, Vector3d(-x), y, Vector3d(-y)})
    mark.segments.push_back(
        {goal.target + goal.length * side, goal.end + goal.length * side, GoalMark::Stress::Faint});
}

}  // namespace

const GoalType keepOutGoal{.kind = GoalKind::KeepOut,
                           .name = "keep-out",
                           .title = "Keep out of a sphere or capsule",
                           .asks = "A point of a joint stays outside a sphere or a capsule.",
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
