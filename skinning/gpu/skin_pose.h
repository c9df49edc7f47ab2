#pragma once

#include <string>
#include <vector>

#include "skinning/muscles/muscle_skin.h"
#include "skinning/skin.h"

namespace gelenk {

/// Rows of four floats in the shader's block of muscle layers, the 16 KB that every GL 3.3 offers.
inline constexpr int maxLayerRows = 1024;

/// T_skin = T_anim T_rest^-1 of every joint as three rows of four floats (row-major 3x4), 12 floats a joint:
/// float begins here. A value: one mesh is drawn with as many poses as there are ghosts.
struct SkinPose {
  std::vector<float> rows;
  /// Muscle layers, rows of four floats; empty: none. A limb after the other: its planes as (origin, axis u,
  /// axis v), 6 links + 1 and then 4 + 4 that carry the near and far end rigidly; then the three columns of
  /// worldFromDisplacement of every link.
  std::vector<float> layers = {};
  bool sculpted =
      false;  ///< some control points are displaced; the mesh knows how (SkinnedMeshGl::setSculpture)
  int jointCount() const { return static_cast<int>(rows.size()) / 12; }
};
SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out);
/// With muscle layers, whose limbs are posed by poseLimbs or MuscleRig::pose.
void poseSkin(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
              SkinPose& out);
/// First row of a limb in `layers`, and where in them the matrix of its first link begins. limb = number of
/// limbs: all rows.
int firstLayerRow(const MuscleSkin& body, int limb);
int firstLinkRow(const MuscleSkin& body, int limb);
/// What a program needs to draw the pose's layers: "LAYERS", and "SCULPTED" where control points are
/// displaced; "" without layers.
std::string layerDefines(const SkinPose& pose);
/// The pose that leaves every vertex where it is.
SkinPose unposed(int jointCount);

}  // namespace gelenk
