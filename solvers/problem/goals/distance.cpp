#include "solvers/problem/goal_type.h"

// Two points of two joints are a length apart: r = length - |x - y|; metres, one row. J = e . (J_x - J_y)
// with e = (x - y) / |x - y|; where the points meet e is any unit vector. In the drag solver phi = 1/2
// (length - |d|)^2 of d = x - y, exact curvature e e^T + (1 - length / |d|) (I - e e^T).
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    goal_fields::joint,
    goal_fields::point,
    goal_fields::other,
    goal_fields::otherPoint,
    {"length", "how far the two points are apart", GoalField::Meaning::Length, &Goal::length}};

Vector3d otherPoint(const Goal& goal, const Frames& frames) {
  return frames[goal.otherJoint] * goal.pointInOther;
}
Vector3d unit(const Vector3d& d) { return d.norm() > 0.0 ? Vector3d(d.normalized()) : Vector3d::UnitX(); }

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r[0] = goal.length - (pointReached(goal, at) - otherPoint(goal, at.frames)).norm();
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const Vector3d x = at.frames[goal.joint] * goal.pointInJoint, y = otherPoint(goal, at.frames);
  pointJacobian(at.skeleton, at.twists, goal.joint, x, at.A);
  pointJacobian(at.skeleton, at.twists, goal.otherJoint, y, at.B);
  at.A -= at.B;
  J.noalias() = unit(x - y).transpose() * at.A;
}
void carried(const Goal& goal, const Skeleton&, int, std::vector<Carried>& out) {
  out.push_back({.joint = goal.joint, .inJoint = goal.pointInJoint});
  out.push_back({.joint = goal.otherJoint, .inJoint = goal.pointInOther, .share = -1.0});
}
void model(const Goal& goal, std::span<const Vector3d> y, double, bool exact, DragModel& out) {
  out.clear(1);
  const double d = y[0].norm(), off = goal.length - d;
  const Vector3d e = unit(y[0]);
  out.force[0] = off * e;
  out.cost = 0.5 * off * off;
  out.addRow(1, 0, e);
  if (!exact || !(d > 1e-9)) return;
  const double factor = -off / d;
  if (factor == 0.0) return;
  const Vector3d f = std::sqrt(std::abs(factor)) * e.unitOrthogonal();
  for (const Vector3d& across : {f, Vector3d(e.cross(f))})
    out.addRow(1, 0, across, factor > 0.0 ? 1.0 : -1.0);
}
std::string whyNot(const Goal& goal, const Skeleton&) {
  return goal.joint == goal.otherJoint ? "a distance needs two different joints" : "";
}
void capture(Goal& goal, const GoalPlace& at) {
  goal.length = (pointReached(goal, at) - otherPoint(goal, at.frames)).norm();
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d x = pointReached(goal, at), y = otherPoint(goal, at.frames), e = unit(x - y),
                 middle = 0.5 * (x + y);
  mark.segments.push_back({x, y, GoalMark::Stress::Faint});
  const Vector3d from = middle - 0.5 * goal.length * e, to = middle + 0.5 * goal.length * e;
  mark.segments.push_back({from, to, GoalMark::Stress::Main});
  for (const Vector3d& end : {from, to}) mark.rings.push_back({end, e, 0.4 * markSize(at.skeleton)});
}

}  // namespace

const GoalType distanceGoal{.kind = GoalKind::Distance,
                            .name = "distance",
                            .title = "Distance",
                            .asks = "Two points of two joints are a length apart.",
                            .fields = fields,
                            .rows = rows<1>,
                            .residual = residual,
                            .jacobian = jacobian,
                            .error = positionError,
                            .whyNot = whyNot,
                            .joints = twoJoints,
                            .drag = {.sums = 1, .carried = carried, .model = model},
                            .reached = pointReached,
                            .capture = capture,
                            .mark = mark};

}  // namespace gelenk
