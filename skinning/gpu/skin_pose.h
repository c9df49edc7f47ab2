#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "skinning/muscles/layered_blend.h"
#include "skinning/muscles/muscle_skin.h"
#include "skinning/skin.h"

namespace gelenk {

/// Rows of four floats in the shader's block of muscle layers, the 16 KB that every GL 3.3 offers.
inline constexpr int maxLayerRows = 1024;

/// T_skin = T_anim T_rest^-1 of every joint as rows of four floats: float begins here. A value: one mesh is
/// drawn with as many poses as there are ghosts.
struct SkinPose {
  /// A joint after the other. 3 rows: T_skin (row-major 3x4), the plain linear blend. 4: its unit quaternion
  /// (x, y, z, w) besides. 7: its twist besides (axis, 1 / length), (head, phi at the head), (phi at the end
  /// less that, 0, 0, 0); all 0 where a joint spreads none.
  std::vector<float> rows;
  int jointRows = 3;
  std::string_view method = {};  ///< word that the shader's part of the method stands under; empty: plain
  /// Muscle layers, rows of four floats; empty: none. A limb after the other: its planes over section
  /// coordinates in metres as (origin, turn), axis x, axis y, 6 links + 1 and then 4 + 4 that carry the near
  /// and far end rigidly; then the three columns of worldFromDisplacement of every link.
  std::vector<float> layers = {};
  bool sculpted =
      false;  ///< some control points are displaced; the mesh knows how (SkinnedMeshGl::setSculpture)
  int rowCount() const { return static_cast<int>(rows.size()) / 4; }
  int jointCount() const { return rowCount() / jointRows; }
};
SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out);
/// For a mesh that was prepared for a method of the shader.
void poseSkin(const PreparedSkin& prepared, const PosedBones& bones, SkinPose& out);
/// With muscle layers, whose limbs are posed by poseLimbs or MuscleRig::pose.
void poseSkin(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
              SkinPose& out);
/// With muscle layers in displacement form. bones: of layered.outside, withEnds.
void poseSkin(const LayeredSkin& layered, const PosedBones& bones, const std::vector<LimbPose>& limbs,
              SkinPose& out);
/// First row of a limb in `layers`, and where in them the matrix of its first link begins. limb = number of
/// limbs: all rows.
int firstLayerRow(const MuscleSkin& body, int limb);
int firstLinkRow(const MuscleSkin& body, int limb);
/// Rows of a pose in the block that every GL 3.3 offers, and in a line of the texture that is used beyond.
inline constexpr int maxBlockRows = 1023;
/// Words that a program for such a pose defines: POSE_IN_TEXTURE, the method's and TWIST, and, drawn with its
/// layers, LAYERS, SCULPTED where control points are displaced.
std::string poseDefines(const SkinPose& pose, bool layered);
/// The pose that leaves every vertex where it is.
SkinPose unposed(int jointCount);

}  // namespace gelenk
