#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/document/muscle_settings.h"

namespace gelenk {

/// The rest pose with the limb's second link, and all that hangs on it, turned in the bend plane of the first
/// to the total bend (radians, straight = 0 exactly): past the joint's limits, and off its hinge, where need
/// be.
Frames bentTo(const Skeleton& skeleton, const Limb& limb, double bend);

/// One way of moving the limb's skin, measured at one pose.
struct DeformationRow {
  std::string limb, motion;  ///< motion: "bend" or "twist"
  std::string method;        ///< "lbs", "ffd", "ffd-volume", "ffd-muscle"
  double degrees =
      0.0;  ///< total bend of the first joint between links (straight = 0), or axial twist of a joint
  double volume = 0.0;  ///< enclosed by the limb's surface, relative to rest
  double smallestDet =
      0.0;  ///< smallest ratio of the volume element at the surface, deformed to rest; negative: folded
  int intersectingPairs = 0;  ///< self-intersecting triangle pairs of the whole mesh
  double smallestSection =
      0.0;  ///< smallest area of a cross-section along the twisted bone, relative to rest (twist rows)
};

/// Bends the limb's first inner joint from straight to 150 degrees every 10, and twists the limb's first
/// joint and its first inner joint about the bone from 0 to 170 every 10, for LBS, FFD, FFD with the volume
/// rule and FFD with muscles and the rule. progress is called with the share done, [0, 1].
std::vector<DeformationRow> measureLimb(const Skeleton& skeleton, const Skin& skin, const Limb& limb,
                                        const std::function<void(double)>& progress);

/// Comma-separated values with a header line.
std::string toCsv(const std::vector<DeformationRow>& rows);

}  // namespace gelenk
