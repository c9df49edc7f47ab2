#include "solvers/problem/pole.h"

#include <algorithm>

#include "solvers/problem/goal_type.h"

// The joint (an elbow, a knee) lies on the side of the target. a, b, c: origins of the joint's parent, the
// joint and its first child; u = (c - a) / |c - a|, s = target - a. r = N / D with N = u . ((b - a) x s) and
// D = |s - u u.s|: the distance of b from the half plane through a, c and the target (metres, signed; also
// zero on the opposite side).
// The drag solver pulls b to the place on its circle about the line a-c that lies on the target's side; that
// place follows the pose between iterations.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    goal_fields::joint, {"target", "a point on the wanted side", GoalField::Meaning::Target, &Goal::target}};

int childOf(const Goal& goal, const Skeleton& skeleton) { return skeleton.children(goal.joint).front(); }

PoleBend bendAt(const Goal& goal, const Skeleton& skeleton, const Frames& frames) {
  return {frames[skeleton.parent(goal.joint)].translation(), frames[goal.joint].translation(),
          frames[childOf(goal, skeleton)].translation()};
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r[0] = bendAt(goal, at.skeleton, at.frames).distanceFromPlane(goal.target);
}

void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const int parent = at.skeleton.parent(goal.joint), child = childOf(goal, at.skeleton);
  const PoleBend bend = bendAt(goal, at.skeleton, at.frames);
  const double length = std::max((bend.c - bend.a).norm(), 1e-12);
  const Vector3d u = bend.line(), s = goal.target - bend.a, e = bend.b - bend.a;
  const double D = bend.side(goal.target).norm(), N = u.dot(e.cross(s));
  if (D <= 1e-12) {
    J.setZero();
    return;
  }
  pointJacobian(at.skeleton, at.twists, parent, bend.a, at.A);
  pointJacobian(at.skeleton, at.twists, goal.joint, bend.b, at.B);
  pointJacobian(at.skeleton, at.twists, child, bend.c, at.C);
  const Eigen::Matrix3Xd dU = (Matrix3d::Identity() - u * u.transpose()) / length * (at.C - at.A);
  const Eigen::RowVectorXd dN =
      e.cross(s).transpose() * dU + s.cross(u).transpose() * (at.B - at.A) - u.cross(e).transpose() * at.A;
  const Eigen::RowVectorXd dD =
      (-(s.transpose() * at.A) - u.dot(s) * (s.transpose() * dU - u.transpose() * at.A)) / D;
  J = -(dN / D - N / (D * D) * dD);
}

std::string whyNot(const Goal& goal, const Skeleton& skeleton) {
  if (skeleton.parent(goal.joint) >= 0 && !skeleton.children(goal.joint).empty()) return {};
  return "a pole goal needs a joint with a parent and a child; '" + skeleton.joint(goal.joint).name +
         "' has not both";
}

/// The child's own motion counts where it slides: only its origin is looked at.
void joints(const Goal& goal, const Skeleton& skeleton, std::vector<int>& out) {
  out.push_back(goal.joint);
  const int child = childOf(goal, skeleton);
  for (const AxisDof& dof : skeleton.joint(child).axes)
    if (dof.kind == AxisDof::Kind::Translation) out.push_back(child);
}
void points(const Goal& goal, const Skeleton&, DragPoints& out) {
  out.add({.at = {.joint = goal.joint}, .target = goal.target});
}
void references(const Goal& goal, const Skeleton& skeleton, std::array<Carried, 3>& out) {
  out[0] = {.joint = skeleton.parent(goal.joint)};
  out[1] = {.joint = goal.joint};
  out[2] = {.joint = goal.joint,
            .inJoint = skeleton.joint(childOf(goal, skeleton)).parentFromZero.translation()};
}
Vector3d follow(const Goal& goal, const std::array<Vector3d, 3>& at) {
  return PoleBend{at[0], at[1], at[2]}.onSide(goal.target);
}

Vector3d reached(const Goal& goal, const GoalPlace& at) {
  return polePoint(at.skeleton, at.frames, goal.joint);
}
void capture(Goal& goal, const GoalPlace& at) { goal.target = reached(goal, at); }
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  mark.segments.push_back({at.frames[goal.joint].translation(), goal.target, GoalMark::Stress::Main});
}

}  // namespace

const GoalType poleGoal{
    .kind = GoalKind::Pole,
    .name = "pole",
    .title = "Pole",
    .asks = "An elbow or a knee lies on the side of a point.",
    .fields = fields,
    .movesWithPose = true,
    .preference = 0.1,
    .rows = rows<1>,
    .residual = residual,
    .jacobian = jacobian,
    .error = positionError,
    .whyNot = whyNot,
    .joints = joints,
    .drag = {.points = points, .references = references, .follow = follow, .measured = false},
    .reached = reached,
    .capture = capture,
    .mark = mark};

}  // namespace gelenk
