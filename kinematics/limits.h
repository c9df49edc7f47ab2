#pragma once

#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"

namespace gelenk {

// How one coordinate is moved into its range. Whoever keeps limits asks here: projectToLimits, the active set
// of the iterative solvers, the drag solver's tree, the geometric methods and the race of serial chains.

/// The angle turned by whole turns into [lower, upper] where the range holds one, else to one side of it.
inline double wrapInto(double angle, double lower, double upper) {
  constexpr double turn = 2.0 * M_PI;
  if (angle < lower) angle += turn * std::ceil((lower - angle) / turn);
  if (angle > upper) angle -= turn * std::ceil((angle - upper) / turn);
  return angle;
}

/// Nearest value within the range of an axis; angles whose range holds a full turn wrap.
inline double intoRange(const AxisDof& dof, double value) {
  if (dof.isFullTurn()) value = wrapInto(value, dof.lower, dof.upper);
  return std::clamp(value, dof.lower, dof.upper);
}

/// Moves a swing (2x, 2y) to the nearest point of the ellipse about the centre where it lies outside; true
/// where it did.
inline bool intoSwing(const Eigen::Vector2d& centre, const Eigen::Vector2d& radii, Eigen::Vector2d& swing) {
  const Eigen::Vector2d offset = swing - centre;
  if (!(offset.cwiseQuotient(radii).squaredNorm() > 1.0)) return false;
  swing = centre + nearestOnEllipse(radii, offset);
  return true;
}

/// Swing-twist coordinates of a ball, moved into its limits.
inline Eigen::Vector3d intoBall(const BallLimit& limit, Eigen::Vector3d c) {
  Eigen::Vector2d swing = c.head<2>();
  if (intoSwing(limit.swingCentre, limit.swingRadii, swing)) c.head<2>() = swing;
  c.z() = std::clamp(c.z(), limit.twistLower, limit.twistUpper);
  return c;
}

}  // namespace gelenk
