#include "solvers/problem/goals/whole_body.h"
#include "solvers/problem/support.h"

// The centre of mass stands over a convex polygon, by a margin: r = the way across `direction` (up) from it
// to the nearest point of the polygon, 0 inside; metres, world, three rows of rank 2 at a corner and 1 at an
// edge. J = N J_com with N = n n^T at an edge of normal n, I - up up^T at a corner, 0 inside.
namespace gelenk {
namespace {

using namespace goal_parts;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr GoalField fields[] = {
    {"polygon", "corners of the support; their convex hull counts", GoalField::Meaning::Polygon,
     &Goal::polygon},
    {"up", "the direction of the plumb line, upwards", GoalField::Meaning::Direction, &Goal::direction, true},
    {"margin", "how far inside the polygon", GoalField::Meaning::Length, &Goal::length, true}};

SupportPolygon::Nearest nearestTo(const Goal& goal, const Vector3d& centre) {
  const Vector3d up = goal.direction.normalized();
  if (goal.length == 0.0 && SupportPolygon::isConvex(goal.polygon, up))
    return SupportPolygon::nearest(goal.polygon, up, centre);
  return SupportPolygon::hull(goal.polygon, up).inset(goal.length).nearest(centre);
}

void residual(const Goal& goal, const GoalPlace& at, Eigen::Ref<VectorXd> r) {
  r = nearestTo(goal, massReached(goal, at)).way;
}
void jacobian(const Goal& goal, const GoalMotion& at, Eigen::Ref<MatrixXd> J) {
  const auto nearest = nearestTo(goal, centreOfMass(*goal.masses, at.frames));
  if (nearest.way.isZero(0.0)) {
    J.setZero();
    return;
  }
  centreOfMassJacobian(at.skeleton, *goal.masses, at.frames, at.twists, at.A);
  const Vector3d up = goal.direction.normalized(), n = nearest.outward;
  const Matrix3d N =
      nearest.corner ? Matrix3d(Matrix3d::Identity() - up * up.transpose()) : Matrix3d(n * n.transpose());
  J.noalias() = N * at.A;
}
void model(const Goal& goal, std::span<const Vector3d> y, double, bool, DragModel& out) {
  out.clear(1);
  const auto nearest = nearestTo(goal, y[0]);
  out.force[0] = nearest.way;
  out.cost = 0.5 * nearest.way.squaredNorm();
  if (nearest.way.isZero(0.0)) return;
  if (nearest.corner) {
    const Vector3d up = goal.direction.normalized(), x = up.unitOrthogonal();
    out.addRow(1, 0, x);
    out.addRow(1, 0, up.cross(x));
  } else {
    out.addRow(1, 0, nearest.outward);
  }
}
void capture(Goal& goal, const GoalPlace& at) {
  const Vector3d up = goal.direction.normalized(), x = up.unitOrthogonal(), z = up.cross(x);
  Vector3d centre = massReached(goal, at);
  double lowest = centre.dot(up);
  for (const Eigen::Isometry3d& frame : at.frames) lowest = std::min(lowest, frame.translation().dot(up));
  centre += up * (lowest - centre.dot(up));
  const double half = goal.length + 2.0 * markSize(at.skeleton);
  if (goal.polygon.empty())
    goal.polygon = {x + z, x - z, -x - z, z - x};
  else
    return;
  for (Vector3d& corner : goal.polygon) corner = centre + half * corner;
}
void mark(const Goal& goal, const GoalPlace& at, GoalMark& mark) {
  const Vector3d centre = massReached(goal, at), up = goal.direction.normalized();
  SupportPolygon hull = SupportPolygon::hull(goal.polygon, up);
  double ground = 0.0;
  for (const Vector3d& corner : hull.corners)
    ground += corner.dot(up) / static_cast<double>(hull.corners.size());
  const Vector3d foot = centre + up * (ground - centre.dot(up));
  mark.polygons.push_back({hull.corners, true});
  mark.segments.push_back({centre, foot, GoalMark::Stress::Main});
  mark.rings.push_back({foot, up, 0.5 * markSize(at.skeleton)});
  mark.rings.push_back({centre, up, 0.5 * markSize(at.skeleton)});
}

}  // namespace

const GoalType balanceGoal{.kind = GoalKind::Balance,
                           .name = "balance",
                           .title = "Balance",
                           .asks = "The centre of mass stands over a support polygon.",
                           .fields = fields,
                           .oneSided = true,
                           .needsMasses = true,
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
