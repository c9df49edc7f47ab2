#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

// A preference: r = difference(q, posture), nv rows, radians and metres, then those of joints that follow
// others. The drag solver leaves it out; its
// own posture term always pulls towards the skeleton's rest pose.
namespace gelenk {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    {"posture", "the configuration to stay near", GoalField::Meaning::Posture, &Goal::posture}};

int rows(const Skeleton& skeleton) { return skeleton.nv() + static_cast<int>(skeleton.followers().size()); }
void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r.head(at.skeleton.nv()) = difference(at.skeleton, at.q, goal.posture);
  int k = at.skeleton.nv();
  for (const int i : at.skeleton.followers())
    r[k++] = goal.posture[at.skeleton.qIndex(i)] - at.q[at.skeleton.qIndex(i)];
}
void jacobian(const Goal&, const GoalMotion&, Eigen::Ref<MatrixXd> J) { J.setIdentity(); }
void hessian(const Goal&, const GoalBend& at, MatrixXd& H) {
  for (int i = 0; i < at.skeleton.jointCount(); ++i) {
    const int axes = static_cast<int>(at.skeleton.joint(i).axes.size()), first = at.skeleton.vIndex(i);
    for (int k = 0; k < axes; ++k) H(first + k, first + k) += at.weight;
    if (at.skeleton.joint(i).ball)
      H.block<3, 3>(first + axes, first + axes) +=
          at.weight * squaredAngleHessian(at.r.segment<3>(first + axes) / std::sqrt(at.weight));
  }
}
GoalError error(const Eigen::Ref<const VectorXd>&) { return {}; }
Vector3d reached(const Goal&, const GoalPlace& at) { return at.frames[0].translation(); }
void capture(Goal& goal, const GoalPlace& at) { goal.posture = at.q; }
void mark(const Goal&, const GoalPlace&, GoalMark&) {}

}  // namespace

const GoalType postureGoal{.kind = GoalKind::Posture,
                           .name = "posture",
                           .title = "Posture",
                           .asks = "The configuration stays near another one.",
                           .fields = fields,
                           .judged = false,
                           .movesWithPose = true,
                           .rows = rows,
                           .residual = residual,
                           .jacobian = jacobian,
                           .addHessian = hessian,
                           .error = error,
                           .drag = {},
                           .reached = reached,
                           .capture = capture,
                           .mark = mark};

}  // namespace gelenk
