#include "solvers/problem/goal_type.h"

// Position and orientation of a joint: r = (target - x; rotation vector of wanted * current^-1).
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::joint, goal_fields::point, goal_fields::target,
                                goal_fields::orientation};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r.head<3>() = goal.target - pointReached(goal, at);
  r.tail<3>() = rotationError(goal.orientation, at.frames[goal.joint]);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  putPointRows(at, goal.joint, at.frames[goal.joint] * goal.pointInJoint, J.topRows(3));
  putRotationRows(at, goal.joint, J.bottomRows(3));
}
void hessian(const Goal&, const GoalBend& at, MatrixXd& H) {
  addPointHessian(at, 0, H);
  addRotationHessian(at, 3, H);
}
void derivative(const Goal&, const GoalBend& at, const VectorXd& d, Eigen::Ref<MatrixXd> dJ) {
  addPointDerivative(at, 0, d, dJ);
  addRotationDerivative(at, 3, d, dJ);
}
void points(const Goal& goal, const Skeleton& skeleton, DragPoints& out) {
  positionGoal.drag.points(goal, skeleton, out);
  orientationGoal.drag.points(goal, skeleton, out);
}
void capture(Goal& goal, const GoalPlace& at) {
  positionGoal.capture(goal, at);
  orientationGoal.capture(goal, at);
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  mark.points.push_back(goal.target);
  addTriad(goal.target, goal.orientation, markSize(at.skeleton), mark);
}

}  // namespace

const GoalType poseGoal{.kind = GoalKind::Pose,
                        .name = "pose",
                        .title = "Pose",
                        .asks = "A point of a joint is at a place and the joint's frame has an orientation.",
                        .fields = fields,
                        .movesWithPose = true,
                        .rows = rows<6>,
                        .residual = residual,
                        .jacobian = jacobian,
                        .addHessian = hessian,
                        .addJacobianDerivative = derivative,
                        .error = poseError,
                        .joints = oneJoint,
                        .drag = {.points = points},
                        .reached = pointReached,
                        .capture = capture,
                        .mark = mark};

}  // namespace gelenk
