#include "solvers/problem/goal_type.h"

// r = rotation vector of wanted * current^-1; radians, world axes. J is the angular velocity: the derivative
// where the error vanishes and the usual direction everywhere.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::joint, goal_fields::orientation};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = rotationError(goal.orientation, at.frames[goal.joint]);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  putRotationRows(at, goal.joint, J);
}
void hessian(const Goal&, const GoalBend& at, MatrixXd& H) { addRotationHessian(at, 0, H); }
void derivative(const Goal&, const GoalBend& at, const VectorXd& d, Eigen::Ref<MatrixXd> dJ) {
  addRotationDerivative(at, 0, d, dJ);
}
/// Three axes drawn to the wanted ones.
void points(const Goal& goal, const Skeleton&, DragPoints& out) {
  const Eigen::Matrix3d wanted = goal.orientation.normalized().toRotationMatrix();
  for (int k = 0; k < 3; ++k)
    out.add({.at = {.joint = goal.joint, .inJoint = Vector3d::Unit(k), .direction = true, .share = 1.0 / 3.0},
             .target = wanted.col(k)});
}
Vector3d reached(const Goal& goal, const GoalPlace& at) { return at.frames[goal.joint].translation(); }
void capture(Goal& goal, const GoalPlace& at) {
  goal.orientation = Eigen::Quaterniond(at.frames[goal.joint].linear()).normalized();
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  addTriad(at.frames[goal.joint].translation(), goal.orientation, markSize(at.skeleton), mark);
}

}  // namespace

const GoalType orientationGoal{.kind = GoalKind::Orientation,
                               .name = "orientation",
                               .title = "Orientation",
                               .asks = "A joint's frame has an orientation.",
                               .fields = fields,
                               .movesWithPose = true,
                               .rows = rows<3>,
                               .residual = residual,
                               .jacobian = jacobian,
                               .addHessian = hessian,
                               .addJacobianDerivative = derivative,
                               .error = orientationError,
                               .joints = oneJoint,
                               .drag = {.points = points},
                               .reached = reached,
                               .capture = capture,
                               .mark = mark};

}  // namespace gelenk
