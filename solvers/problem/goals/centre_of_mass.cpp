#include "solvers/problem/goals/whole_body.h"

// r = target - centre of mass; metres, world. J: kinematics/masses.h.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {goal_fields::target};

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = goal.target - massReached(goal, at);
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  centreOfMassJacobian(at.skeleton, *goal.masses, at.frames, at.twists, at.A);
  J = at.A;
}
void model(const Goal& goal, std::span<const Vector3d> y, double, bool, DragModel& out) {
  out.clear(1);
  out.force[0] = goal.target - y[0];
  out.cost = 0.5 * out.force[0].squaredNorm();
  for (int k = 0; k < 3; ++k) out.addRow(1, 0, Vector3d::Unit(k));
}
void capture(Goal& goal, const GoalPlace& at) { goal.target = massReached(goal, at); }
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d centre = massReached(goal, at);
  mark.points.push_back(goal.target);
  mark.rings.push_back({centre, Vector3d::UnitY(), 0.5 * markSize(at.skeleton)});
  mark.rings.push_back({centre, Vector3d::UnitX(), 0.5 * markSize(at.skeleton)});
}

}  // namespace

const GoalType centreOfMassGoal{.kind = GoalKind::CentreOfMass,
                                .name = "centre-of-mass",
                                .title = "Centre of mass",
                                .asks = "The centre of mass is at a place.",
                                .fields = fields,
                                .needsMasses = true,
                                .movesWithPose = true,
                                .rows = rows<3>,
                                .residual = residual,
                                .jacobian = jacobian,
                                .error = positionError,
                                .joints = heavyJoints,
                                .drag = {.sums = 1, .carried = carriedMass, .model = model},
                                .reached = massReached,
                                .capture = capture,
                                .mark = mark};

}  // namespace gelenk
