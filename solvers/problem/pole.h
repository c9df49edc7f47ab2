#pragma once

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// A limb that bends at b between a and c (shoulder, elbow, wrist), metres: the geometry of poles.
struct PoleBend {
  Eigen::Vector3d a, b, c;

  /// Unit vector from a to c.
  Eigen::Vector3d line() const;
  /// What of target - a stands upright on the line.
  Eigen::Vector3d side(const Eigen::Vector3d& target) const;
  /// Signed distance of b from the half plane through a, c and the target; 0 where the target lies on the
  /// line.
  double distanceFromPlane(const Eigen::Vector3d& target) const;
  /// Where b lies on its circle about the line when it lies on the target's side; b itself where there is no
  /// line or no side.
  Eigen::Vector3d onSide(const Eigen::Vector3d& target) const;
};

/// Where the pole handle of an elbow or knee is drawn: on the side to which the limb is bent, at half the
/// limb's length from the middle joint. A limb that is straight to 1e-6 of its length has no side; the middle
/// joint's own y axis is taken. World, metres.
Eigen::Vector3d polePoint(const Skeleton& skeleton, const Frames& frames, int middle);

}  // namespace gelenk
