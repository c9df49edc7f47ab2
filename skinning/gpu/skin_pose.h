#pragma once

#include <string>
#include <vector>

#include "skinning/muscle_skin.h"
#include "skinning/skin.h"

namespace gelenk {

/// Rows of four floats in the shader's block of muscle layers, the 16 KB that every GL 3.3 offers: half for planes, half for the
/// displacements of 16 links.
inline constexpr int maxLayerRows = 1024, firstDisplacementRow = 512;

/// T_skin = T_anim T_rest^-1 of every joint as three rows of four floats (row-major 3x4), 12 floats a joint: float begins here.
/// A value: one mesh is drawn with as many poses as there are ghosts.
struct SkinPose {
  std::vector<float> rows;
  /// Muscle layers, rows of four floats; empty: none. First every limb's planes as (origin, axis u, axis v), 6 links + 1 of the limb
  /// and then 4 + 4 that carry the near and far end rigidly. Where muscles are sculpted, from row firstDisplacementRow on 16
  /// displacements for plane 2 and 16 for plane 4 of every link of every limb; the fourth number of the link's first is 1 where any is not zero.
  std::vector<float> layers = {};
  bool sculpted = false;  ///< some displacement is not zero
  int jointCount() const { return static_cast<int>(rows.size()) / 12; }
};
SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out);
/// With muscle layers, whose limbs are posed by poseLimbs or MuscleRig::pose.
void poseSkin(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs, SkinPose& out);
/// First plane of a limb in `layers`, and its first link in the displacements.
int firstLayerPlane(const MuscleSkin& body, int limb);
int firstLayerLink(const MuscleSkin& body, int limb);
/// What a program needs to draw the pose's layers: "LAYERS", and "SCULPTED" where control points are displaced; "" without layers.
std::string layerDefines(const SkinPose& pose);
/// The pose that leaves every vertex where it is.
SkinPose unposed(int jointCount);

}  // namespace gelenk
