#include "apps/render/scene_marks.h"

#include <algorithm>
#include <cmath>

#include "apps/document/limb.h"
#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "solvers/problem/goal_type.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

/// worldFromZero of the joint's motion after its first `axes` axes.
Isometry3d worldFromMotion(const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames,
                           int joint, int axes) {
  const Joint& j = skeleton.joint(joint);
  Isometry3d T = (j.parent < 0 ? Isometry3d::Identity() : frames[j.parent]) * j.parentFromZero;
  for (int k = 0; k < axes; ++k) {
    const double value = q[skeleton.qIndex(joint) + k];
    if (j.axes[k].kind == AxisDof::Kind::Rotation)
      T.rotate(Eigen::AngleAxisd(value, j.axes[k].axis));
    else
      T.translate(value * j.axes[k].axis);
  }
  return T;
}

double boneLength(const Skeleton& skeleton, int joint) {
  double length = 0.0;
  for (const int child : skeleton.children(joint))
    length = std::max(length, skeleton.joint(child).parentFromZero.translation().norm());
  return length;
}

/// The boundary of the swing as a cone around the joint.
void addCone(Overlay& overlay, const Isometry3d& worldFromZero, const BallLimit& limit, double radius,
             const Colour& line, const Colour& fill) {
  std::vector<Vector3d> rim;
  for (int i = 0; i < 48; ++i) {
    const double t = 2.0 * M_PI * i / 48;
    Vector3d c(limit.swingCentre.x() + limit.swingRadii.x() * std::cos(t),
               limit.swingCentre.y() + limit.swingRadii.y() * std::sin(t), 0.0);
    if (c.head<2>().norm() > 1.99) c.head<2>() *= 1.99 / c.head<2>().norm();
    rim.push_back(worldFromZero * (radius * (fromSwingTwistCoordinates(c) * Vector3d::UnitZ())));
  }
  overlay.fan(worldFromZero.translation(), rim, fill);
  overlay.polyline(rim, line, 2.0f, true);
}

/// The range of a rotation axis as a sector, the present angle as a line.
void addArc(Overlay& overlay, const Isometry3d& worldFromAxis, const AxisDof& axis, double value,
            const Vector3d& bone, double radius, const Colour& line, const Colour& fill) {
  Vector3d zero = bone - axis.axis * axis.axis.dot(bone);
  if (zero.norm() < 1e-9) zero = axis.axis.unitOrthogonal();
  zero = radius * zero.normalized();
  const double low = std::max(axis.lower, value - 2.0 * M_PI),
               high = std::min(axis.upper, value + 2.0 * M_PI);
  std::vector<Vector3d> rim;
  for (int i = 0; i <= 32; ++i)
    rim.push_back(worldFromAxis * (Eigen::AngleAxisd(low + (high - low) * i / 32, axis.axis) * zero));
  overlay.fan(worldFromAxis.translation(), rim, fill, false);
  overlay.polyline(rim, line, 2.0f);
  overlay.line(worldFromAxis.translation(), worldFromAxis * (Eigen::AngleAxisd(value, axis.axis) * zero),
               line, 2.0f);
}

}  // namespace

void addLimit(Overlay& overlay, const Session& session, const Frames& frames, int joint, double size,
              const Colour& colour) {
  const Skeleton& skeleton = session.skeleton();
  const Joint& j = skeleton.joint(joint);
  const Eigen::VectorXd& q = session.q();
  const Colour line = withAlpha(colour, 0.9f * colour.a), fill = withAlpha(colour, 0.16f * colour.a);
  const double bone = std::max(boneLength(skeleton, joint), 0.04 * size);
  const double radius = std::clamp(0.5 * bone, 0.03 * size, 0.12 * size);
  const Vector3d alongBone =
      skeleton.children(joint).empty()
          ? Vector3d(Vector3d::UnitZ())
          : skeleton.joint(skeleton.children(joint).front()).parentFromZero.translation();
  for (int k = 0; k < static_cast<int>(j.axes.size()); ++k) {
    const AxisDof& axis = j.axes[k];
    const double value = q[skeleton.qIndex(joint) + k];
    const bool at =
        value <= axis.lower + 2.0 * Session::limitMargin || value >= axis.upper - 2.0 * Session::limitMargin;
    if (axis.kind == AxisDof::Kind::Rotation && at && std::isfinite(axis.upper - axis.lower))
      addArc(overlay, worldFromMotion(skeleton, q, frames, joint, k), axis, value, alongBone, radius, line,
             fill);
  }
  if (j.ballLimit)
    addCone(overlay, worldFromMotion(skeleton, q, frames, joint, static_cast<int>(j.axes.size())),
            *j.ballLimit, radius, line, fill);
}

void addWorkspace(Overlay& overlay, const Session& session, const Frames& frames,
                  const MarkColours& colours) {
  const Skeleton& skeleton = session.skeleton();
  if (session.goals().empty()) return;
  double sum = 0.0, longest = 0.0;
  int base = -1;
  for (int j = session.goals().front().goal.joint; j >= 0; j = skeleton.parent(j)) {
    if (skeleton.joint(j).ball || skeleton.vCount(j) > 1) return;
    if (skeleton.vCount(j) == 1) base = j;
    bool moves = false;  // a joint above that turns carries this offset round
    for (int a = skeleton.parent(j); a >= 0; a = skeleton.parent(a)) {
      if (skeleton.vCount(a) == 1 && skeleton.joint(a).axes[0].kind != AxisDof::Kind::Rotation) return;
      moves = moves || skeleton.vCount(a) == 1;
    }
    if (!moves) continue;
    const double length = skeleton.joint(j).parentFromZero.translation().norm();
    sum += length;
    longest = std::max(longest, length);
  }
  if (base < 0 || sum <= 0.0) return;
  const Vector3d centre = frames[base].translation();
  const double inner = std::max(0.0, 2.0 * longest - sum);
  const Colour fill = withAlpha(colours.accent, 0.07f), line = withAlpha(colours.accent, 0.45f);
  overlay.annulus(centre, Vector3d::UnitX(), Vector3d::UnitY(), inner, sum, fill);
  overlay.arc(centre, Vector3d::UnitX(), Vector3d::UnitY(), sum, line);
  if (inner > 0.0) overlay.arc(centre, Vector3d::UnitX(), Vector3d::UnitY(), inner, line);
}

Vector3d levelRight(const Camera& camera, const Vector3d& up) {
  const Vector3d right = (camera.target - camera.eye()).cross(up);
  return right.norm() > 1e-9 ? Vector3d(right.normalized()) : Vector3d::UnitX();
}

Frames framesBeside(const Session& session, Frames frames, double step, int place) {
  const Camera& camera = session.document().view.camera;
  // Near the camera less: what is looked at stands beside itself, both within the view.
  const Vector3d shift =
      -place * std::min(step, 0.6 * camera.halfHeight()) * levelRight(camera, session.model().up);
  for (Isometry3d& frame : frames) frame.pretranslate(shift);
  return frames;
}

bool isGoalShown(const Session& session, const SceneGoal& goal) {
  if (goal.goal.kind == GoalKind::Posture) return false;
  if (goal.goal.kind != GoalKind::Pole || goal.state != GoalState::Free) return true;
  return std::ranges::any_of(session.goals(), [&](const SceneGoal& other) {
    return other.handle && other.state != GoalState::Free && other.goal.kind != GoalKind::Pole &&
           limbMiddle(session.skeleton(), other.goal.joint) == goal.goal.joint;
  });
}

namespace {

/// What the goal's type says it looks like. Faint lines where it is looked at alone.
void addMark(Overlay& overlay, const GoalMark& mark, const Colour& colour, bool looked) {
  for (const GoalMark::Polygon& polygon : mark.polygons) {
    if (polygon.corners.empty()) continue;
    if (polygon.filled)
      overlay.fan(polygon.corners.front(), polygon.corners, withAlpha(colour, 0.16f), false);
    overlay.polyline(polygon.corners, withAlpha(colour, 0.75f), 1.4f, true);
  }
  for (const GoalMark::Ring& ring : mark.rings) {
    const Vector3d u = ring.normal.unitOrthogonal(), v = ring.normal.normalized().cross(u);
    overlay.arc(ring.centre, u, v, ring.radius, withAlpha(colour, 0.7f), 1.4f);
  }
  for (const GoalMark::Segment& segment : mark.segments)
    if (looked || segment.stress == GoalMark::Stress::Main)
      overlay.line(segment.from, segment.to,
                   withAlpha(colour, segment.stress == GoalMark::Stress::Main ? 0.6f : 0.45f), 1.4f);
}

}  // namespace

void addGoals(Overlay& overlay, const Session& session, double size, const MarkColours& colours,
              std::optional<GoalId> hovered, std::optional<GoalId> selected,
              const std::function<bool(const SceneGoal&)>& shows) {
  using Shape = Overlay::Shape;
  constexpr Colour white{1.0f, 1.0f, 1.0f, 0.95f};
  if (const auto balance = session.balanceGoal()) {
    GoalMark mark;
    goalType(balance->kind).mark(*balance, {session.skeleton(), session.q(), session.frames()}, mark);
    addMark(overlay, mark, colours.pinned, false);
  }
  for (const SceneGoal& goal : session.goals()) {
    if (!shows(goal)) continue;
    const GoalType& type = goalType(goal.goal.kind);
    const Vector3d reached = session.reached(goal.id);
    const bool dragged = session.dragged() == goal.id, active = goal.state != GoalState::Free,
               wish = type.preference < 1.0, looked = hovered == goal.id || dragged;
    const Colour colour = goal.state == GoalState::Pinned ? colours.pinned
                          : wish                          ? colours.pole
                          : active                        ? colours.held
                                                          : colours.free;
    if (active || wish) addMark(overlay, session.mark(goal.id), colour, looked || selected == goal.id);
    if (const double error = session.error(goal.id);
        active && !wish && type.movesWithPose && error > 2e-4 * size) {
      const Colour far = distanceColour(colours, 2.0 * error / size);
      overlay.line(reached, goal.goal.target, far, 1.6f);
      overlay.point(goal.goal.target, far, 10.0f, Shape::Ring);
    }
    if (dragged) overlay.point(reached, withAlpha(colour, 0.25f), 30.0f, Shape::Plain);
    const float d = (wish ? 10.0f : 13.0f) * (looked ? 1.35f : 1.0f);
    if (goal.goal.kind == GoalKind::Pose || goal.goal.kind == GoalKind::Orientation)
      overlay.point(reached, withAlpha(colour, 0.9f), d + 11.0f, Shape::Ring);
    const Shape shape = goal.state == GoalState::Pinned ? Shape::PlainSquare
                        : wish                          ? Shape::Diamond
                                                        : Shape::Plain;
    overlay.point(reached, active || wish ? white : colour, d + 2.6f, shape);
    overlay.point(reached, active || wish ? colour : white, d - 0.8f, shape);
  }
}

}  // namespace gelenk
