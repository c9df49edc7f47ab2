#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

// A joint keeps its pose in the frame of another one: its point on that of the other, its frame turned by
// `orientation` (otherFromJoint) from the other's. r = (y - x; rotation vector of R_other orientation R^-1);
// metres and radians, world axes. J = the differences of both joints' geometric Jacobians, the rotation rows
// exact where the error vanishes.
// In the drag solver four sums: x - y and the three axes of the frame less where they are wanted,
// phi = 1/2 |x - y|^2 + arm^2 / 6 sum_k |a_k - b_k|^2, exact.
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
    {"orientation", "otherFromJoint wanted", GoalField::Meaning::Rotation, &Goal::orientation}};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  relativePositionGoal.residual(goal, at, r.head<3>());
  r.tail<3>() =
      rotationError(Eigen::Quaterniond(at.frames[goal.otherJoint].linear()) * goal.orientation.normalized(),
                    at.frames[goal.joint]);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  relativePositionGoal.jacobian(goal, at, J.topRows(3));
  rotationJacobian(at.skeleton, at.twists, goal.joint, at.A);
  rotationJacobian(at.skeleton, at.twists, goal.otherJoint, at.B);
  J.bottomRows(3) = at.A - at.B;
}
void carried(const Goal& goal, const Skeleton& skeleton, int sum, std::vector<Carried>& out) {
  if (sum == 0) {
    relativePositionGoal.drag.carried(goal, skeleton, sum, out);
    return;
  }
  const Vector3d axis = Vector3d::Unit(sum - 1);
  out.push_back({.joint = goal.joint, .inJoint = axis, .direction = true});
  out.push_back({.joint = goal.otherJoint,
                 .inJoint = goal.orientation.normalized() * axis,
                 .direction = true,
                 .share = -1.0});
}
void model(const Goal&, std::span<const Vector3d> y, double arm, bool, DragModel& out) {
  out.clear(4);
  for (int j = 0; j < 4; ++j) {
    const double stiffness = j == 0 ? 1.0 : arm * arm / 3.0, length = std::sqrt(stiffness);
    out.stiffness[j] = stiffness;
    out.force[j] = -stiffness * y[j];
    out.cost += 0.5 * stiffness * y[j].squaredNorm();
    for (int k = 0; k < 3; ++k) out.addRow(4, j, length * Vector3d::Unit(k));
  }
}
void capture(Goal& goal, const GoalPlace& at) {
  relativePositionGoal.capture(goal, at);
  goal.orientation =
      Eigen::Quaterniond(at.frames[goal.otherJoint].linear().transpose() * at.frames[goal.joint].linear())
          .normalized();
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  relativePositionGoal.mark(goal, at, mark);
  const Eigen::Isometry3d& other = at.frames[goal.otherJoint];
  addTriad(other * goal.pointInOther, Eigen::Quaterniond(other.linear()) * goal.orientation.normalized(),
           markSize(at.skeleton), mark);
}

}  // namespace

const GoalType relativePoseGoal{
    .kind = GoalKind::RelativePose,
    .name = "relative-pose",
    .title = "Pose relative to a joint",
    .asks = "A joint keeps its place and orientation in the frame of another joint.",
    .fields = fields,
    .rows = rows<6>,
    .residual = residual,
    .jacobian = jacobian,
    .error = poseError,
    .whyNot = relativePositionGoal.whyNot,
    .joints = twoJoints,
    .drag = {.sums = 4, .carried = carried, .model = model},
    .reached = pointReached,
    .capture = capture,
    .mark = mark};

}  // namespace gelenk
