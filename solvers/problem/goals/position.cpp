#include "solvers/problem/goal_type.h"

// r = target - x, the point x of the joint; metres, world.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::joint, goal_fields::point, goal_fields::target};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = goal.target - pointReached(goal, at);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  putPointRows(at, goal.joint, at.frames[goal.joint] * goal.pointInJoint, J);
}
void hessian(const Goal&, const GoalBend& at, MatrixXd& H) { addPointHessian(at, 0, H); }
void derivative(const Goal&, const GoalBend& at, const VectorXd& d, Eigen::Ref<MatrixXd> dJ) {
  addPointDerivative(at, 0, d, dJ);
}
void points(const Goal& goal, const Skeleton&, DragPoints& out) {
  out.add({.at = {.joint = goal.joint, .inJoint = goal.pointInJoint}, .target = goal.target});
}
void capture(Goal& goal, const GoalPlace& at) { goal.target = pointReached(goal, at); }
void mark(const Goal& goal, const GoalPlace&, GoalMark& mark) { mark.points.push_back(goal.target); }

}  // namespace

const GoalType positionGoal{.kind = GoalKind::Position,
                            .name = "position",
                            .title = "Position",
                            .asks = "A point of a joint is at a place.",
                            .fields = fields,
                            .movesWithPose = true,
                            .rows = rows<3>,
                            .residual = residual,
                            .jacobian = jacobian,
                            .addHessian = hessian,
                            .addJacobianDerivative = derivative,
                            .error = positionError,
                            .joints = oneJoint,
                            .drag = {.points = points},
                            .reached = pointReached,
                            .capture = capture,
                            .mark = mark};

}  // namespace gelenk
