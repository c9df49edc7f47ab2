#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/mannequin_masses.h"
#include "kinematics/rotation.h"
#include "solvers/problem/support.h"
#include "solvers/tree/drag_solver.h"

// The drags by which the drag solver is judged, for the tests and for the table that drag_benchmark prints.
// Everything measured here comes from the configuration alone: forward kinematics, quaternions.
namespace gelenk::marks {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Both hands and the head are dragged, the feet stay.
struct Figure {
  Skeleton skeleton = mannequin();
  int hands[2] = {skeleton.jointIndex("hand_l"), skeleton.jointIndex("hand_r")};
  int head = skeleton.jointIndex("head");
  int feet[2] = {skeleton.jointIndex("foot_l"), skeleton.jointIndex("foot_r")};
  Vector3d palm{0.0, 0.0, 0.08};
  VectorXd start = skeleton.rest();
  Frames startFrames = forwardKinematics(skeleton, start);

  static constexpr int dragCount = 3;
  int dragJoint(int k) const { return k < 2 ? hands[k] : head; }
  Vector3d dragPoint(int k) const { return k < 2 ? palm : Vector3d(0.0, 0.0, 0.1); }
  Vector3d dragged(const Frames& frames, int k) const { return frames[dragJoint(k)] * dragPoint(k); }

  std::vector<Goal> pins() const {
    std::vector<Goal> goals;
    for (const int foot : feet)
      goals.push_back({.kind = GoalKind::Pose,
                       .name = "foot",
                       .joint = foot,
                       .target = startFrames[foot].translation(),
                       .orientation = Eigen::Quaterniond(startFrames[foot].linear()),
                       .role = Role::Pin});
    return goals;
  }
  std::vector<Goal> goals() const {
    std::vector<Goal> all;
    for (int k = 0; k < dragCount; ++k)
      all.push_back({.name = "drag",
                     .joint = dragJoint(k),
                     .pointInJoint = dragPoint(k),
                     .target = dragged(startFrames, k)});
    for (const Goal& pin : pins()) all.push_back(pin);
    return all;
  }
  void setTargets(std::vector<Goal>& goals, const std::vector<Vector3d>& targets) const {
    for (int k = 0; k < dragCount; ++k) goals[k].target = targets[k];
  }

  /// Largest distance of three points of each foot (ankle, 10 cm along the bone, 10 cm up) from where they
  /// were.
  double pinError(const Frames& frames) const {
    double worst = 0.0;
    for (const int foot : feet)
      for (const Vector3d& point : {Vector3d(0, 0, 0), Vector3d(0, 0, 0.1), Vector3d(0, 0.1, 0)})
        worst = std::max(worst, (frames[foot] * point - startFrames[foot] * point).norm());
    return worst;
  }
  /// Largest rotation of a joint between two configurations, radians.
  double largestRotation(const VectorXd& a, const VectorXd& b) const {
    double largest = 0.0;
    for (int i = 0; i < skeleton.jointCount(); ++i) {
      if (skeleton.vCount(i) == 0) continue;
      const Eigen::Quaterniond before(jointMotion(skeleton, a, i).linear()),
          after(jointMotion(skeleton, b, i).linear());
      largest = std::max(largest, logRotation(before.conjugate() * after).norm());
    }
    return largest;
  }
};

/// The figure's masses and soles.
inline BalanceOptions balanceOf(const Figure& figure) {
  BalanceOptions balance{.masses = std::make_shared<const Masses>(mannequinMasses(figure.skeleton))};
  for (const FootPoint& point : mannequinSoles(figure.skeleton))
    balance.supports.push_back({point.joint, point.inJoint});
  return balance;
}

/// How far the centre of mass stands outside the hull of the soles where they were at the start, metres;
/// below 0 inside. The feet are pinned.
struct Tipping {
  explicit Tipping(const Figure& figure) : masses(mannequinMasses(figure.skeleton)) {
    std::vector<Vector3d> soles;
    for (const FootPoint& point : mannequinSoles(figure.skeleton))
      soles.push_back(figure.startFrames[point.joint] * point.inJoint);
    polygon = SupportPolygon::hull(soles, Vector3d::UnitY());
  }
  double operator()(const Frames& frames) const { return polygon.outside(centreOfMass(masses, frames)); }

  Masses masses;
  SupportPolygon polygon;
};

/// Half way between rest and a pose uniform within limits; the root stays.
inline VectorXd halfRangePose(const Skeleton& skeleton, std::mt19937_64& random) {
  VectorXd to = randomWithinLimits(skeleton, random);
  to.head<3>().setZero();
  setBallRotation(skeleton, to, 0, Eigen::Quaterniond::Identity());
  return projectToLimits(
      skeleton, integrate(skeleton, skeleton.rest(), 0.5 * difference(skeleton, skeleton.rest(), to)));
}

/// Targets of both hands and the head, frame by frame.
using Path = std::vector<std::vector<Vector3d>>;

/// A path that can be followed: the targets are those of a moving pose within limits whose feet stay, at most
/// `step` metres a frame. The pose moves between random ones (half way between rest and random within
/// limits).
inline Path reachablePath(const Figure& figure, std::mt19937_64& random, int frames, double step) {
  const Skeleton& skeleton = figure.skeleton;
  DragDescent feet(skeleton, 1.0, std::vector<double>(skeleton.nv(), 1.0), skeleton.rest());
  const std::vector<Goal> pins = figure.pins();
  feet.build(std::vector<int>{figure.feet[0], figure.feet[1]}, Vector3d::Zero());
  for (const int foot : figure.feet) {
    const Eigen::Isometry3d& frame = figure.startFrames[foot];
    const int node = feet.tree().carrier(foot);
    for (int k = 0; k < 3; ++k)
      feet.points().push_back(
          {.node = node, .direction = true, .local = Vector3d::Unit(k), .target = frame.linear().col(k)});
    feet.points().push_back({.node = node, .target = frame.translation()});
  }
  /// The nearest pose to q whose feet are in place, or none.
  const auto withFeet = [&](const VectorXd& q) -> std::optional<VectorXd> {
    feet.load(q);
    for (int i = 0; i < 60; ++i) {
      feet.anchor();
      const StepOutcome outcome =
          feet.step({.lambda = 0.0, .kappa = 1e-6, .smallestStep = 1e-13, .exact = false});
      if (feet.residual() < 1e-11 || !outcome.moved) break;
    }
    VectorXd out = q;
    feet.tree().store(feet.pose(), out);
    if (figure.pinError(forwardKinematics(skeleton, out)) > 1e-9 || limitViolation(skeleton, out) > 1e-12)
      return std::nullopt;
    return out;
  };
  const auto targetsOf = [&](const VectorXd& q) {
    const Frames at = forwardKinematics(skeleton, q);
    std::vector<Vector3d> targets;
    for (int k = 0; k < Figure::dragCount; ++k) targets.push_back(figure.dragged(at, k));
    return targets;
  };
  const auto distance = [](const std::vector<Vector3d>& a, const std::vector<Vector3d>& b) {
    double largest = 0.0;
    for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, (a[k] - b[k]).norm());
    return largest;
  };

  Path path{targetsOf(figure.start)};
  VectorXd from = figure.start, now = from;
  while (static_cast<int>(path.size()) < frames) {
    const auto reached = withFeet(halfRangePose(skeleton, random));
    if (!reached) continue;
    const VectorXd move = difference(skeleton, from, *reached);
    double s = 0.0;
    while (s < 1.0 && static_cast<int>(path.size()) < frames) {
      double ds = 0.2;
      std::optional<VectorXd> next;
      std::vector<Vector3d> targets;
      for (; ds > 1e-7; ds *= 0.6) {
        next = withFeet(projectToLimits(skeleton, integrate(skeleton, from, std::min(1.0, s + ds) * move)));
        if (!next) continue;
        targets = targetsOf(*next);
        if (distance(targets, path.back()) <= step) break;
      }
      if (ds <= 1e-7) break;  // the feet let the pose jump here: turn towards another pose
      s = std::min(1.0, s + ds);
      now = *next;
      path.push_back(targets);
    }
    from = now;
  }
  return path;
}

/// Targets that leave what can be reached: each moves with `step` metres a frame towards random points of a
/// ball of radius 1.3 m around the chest.
inline Path wildPath(const Figure& figure, std::mt19937_64& random, int frames, double step) {
  const auto somewhere = [&] {
    Vector3d v;
    do v = 2.0 * Vector3d(uniform01(random), uniform01(random), uniform01(random)) - Vector3d::Ones();
    while (v.norm() > 1.0);
    return Vector3d(Vector3d(0.0, 1.2, 0.0) + 1.3 * v);
  };
  std::vector<Vector3d> at, to;
  for (int k = 0; k < Figure::dragCount; ++k) {
    at.push_back(figure.dragged(figure.startFrames, k));
    to.push_back(somewhere());
  }
  Path path{at};
  while (static_cast<int>(path.size()) < frames) {
    for (int k = 0; k < Figure::dragCount; ++k) {
      if ((to[k] - at[k]).norm() < step) to[k] = somewhere();
      at[k] += step * (to[k] - at[k]).normalized();
    }
    path.push_back(at);
  }
  return path;
}

inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const std::size_t at = std::min(values.size() - 1, static_cast<std::size_t>(share * values.size()));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[at];
}

/// What a drag along a path showed.
struct Shown {
  std::vector<double> errors;      ///< metres, every dragged point and frame
  std::vector<double> seconds;     ///< a frame
  double worstPin = 0.0;           ///< metres
  double worstRotation = 0.0;      ///< radians a joint and frame
  double worstJump = 0.0;          ///< rotation over (target step / 0.5 m)
  double worstViolation = 0.0;     ///< of limits
  int notFinite = 0, outside = 0;  ///< frames with the centre of mass outside the soles
  double worstTipping = 0.0;       ///< metres outside
  long iterations = 0, factorisations = 0;

  void add(const Shown& other) {
    errors.insert(errors.end(), other.errors.begin(), other.errors.end());
    seconds.insert(seconds.end(), other.seconds.begin(), other.seconds.end());
    worstPin = std::max(worstPin, other.worstPin);
    worstRotation = std::max(worstRotation, other.worstRotation);
    worstJump = std::max(worstJump, other.worstJump);
    worstViolation = std::max(worstViolation, other.worstViolation);
    notFinite += other.notFinite;
    outside += other.outside;
    worstTipping = std::max(worstTipping, other.worstTipping);
    iterations += other.iterations;
    factorisations += other.factorisations;
  }
};

/// Follows the path frame by frame; step: metres a frame.
inline Shown follow(const Figure& figure, DragSolver& solver, const Path& path, double step) {
  Shown shown;
  std::vector<Goal> goals = figure.goals();
  const Tipping tipping(figure);
  Frames frames;
  for (const auto& targets : path) {
    figure.setTargets(goals, targets);
    const VectorXd before = solver.q();
    const IkReport& report = solver.frame(goals);
    const VectorXd& q = report.q;
    shown.seconds.push_back(report.seconds);
    shown.iterations += report.counters.iterations;
    shown.factorisations += report.counters.factorisations;
    if (!q.allFinite()) {
      ++shown.notFinite;
      continue;
    }
    forwardKinematics(figure.skeleton, q, frames);
    for (int k = 0; k < Figure::dragCount; ++k)
      shown.errors.push_back((targets[k] - figure.dragged(frames, k)).norm());
    shown.worstPin = std::max(shown.worstPin, figure.pinError(frames));
    const double tipped = tipping(frames);
    shown.outside += tipped > 0.0;
    shown.worstTipping = std::max(shown.worstTipping, tipped);
    const double rotation = figure.largestRotation(before, q);
    shown.worstRotation = std::max(shown.worstRotation, rotation);
    if (step > 0.0) shown.worstJump = std::max(shown.worstJump, rotation / (step / 0.5));
    shown.worstViolation = std::max(shown.worstViolation, limitViolation(figure.skeleton, q));
  }
  return shown;
}

}  // namespace gelenk::marks
