#include "solvers/problem/goal_type.h"

// A point x of a joint stays on a point y of another one, as a hinge or a grip holds them: r = y - x; metres,
// world. J = J_x - J_y: what moves both alike cancels.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::joint, goal_fields::point, goal_fields::other,
                                goal_fields::otherPoint};

Vector3d otherPoint(const Goal& goal, const Frames& frames) {
  return frames[goal.otherJoint] * goal.pointInOther;
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = otherPoint(goal, at.frames) - pointReached(goal, at);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  pointJacobian(at.skeleton, at.twists, goal.joint, at.frames[goal.joint] * goal.pointInJoint, at.A);
  pointJacobian(at.skeleton, at.twists, goal.otherJoint, otherPoint(goal, at.frames), at.B);
  J = at.A - at.B;
}
void carried(const Goal& goal, const Skeleton&, int, std::vector<Carried>& out) {
  out.push_back({.joint = goal.joint, .inJoint = goal.pointInJoint});
  out.push_back({.joint = goal.otherJoint, .inJoint = goal.pointInOther, .share = -1.0});
}
void model(const Goal&, std::span<const Vector3d> y, double, bool, DragModel& out) {
  out.clear(1);
  out.force[0] = -y[0];
  out.cost = 0.5 * y[0].squaredNorm();
  for (int k = 0; k < 3; ++k) out.addRow(1, 0, Vector3d::Unit(k));
}
std::string whyNot(const Goal& goal, const Skeleton&) {
  return goal.joint == goal.otherJoint ? "a relative position needs two different joints" : "";
}
void capture(Goal& goal, const GoalPlace& at) {
  goal.pointInOther = at.frames[goal.otherJoint].inverse() * pointReached(goal, at);
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d x = pointReached(goal, at), y = otherPoint(goal, at.frames);
  mark.segments.push_back({x, y, GoalMark::Stress::Main});
  mark.segments.push_back({y, at.frames[goal.otherJoint].translation(), GoalMark::Stress::Faint});
  mark.rings.push_back({y, Vector3d::UnitY(), 0.4 * markSize(at.skeleton)});
}

}  // namespace

const GoalType relativePositionGoal{.kind = GoalKind::RelativePosition,
                                    .name = "relative-position",
                                    .title = "Point on point",
                                    .asks = "A point of a joint stays on a point of another joint.",
                                    .fields = fields,
                                    .rows = rows<3>,
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
