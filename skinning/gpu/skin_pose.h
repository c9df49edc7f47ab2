#pragma once

#include <vector>

#include "skinning/skin.h"

namespace gelenk {

/// T_skin = T_anim T_rest^-1 of every joint as three rows of four floats (row-major 3x4), 12 floats a joint: float begins here.
/// A value: one mesh is drawn with as many poses as there are ghosts.
struct SkinPose {
  std::vector<float> rows;
  int jointCount() const { return static_cast<int>(rows.size()) / 12; }
};
SkinPose poseSkin(const Skin& skin, const Frames& worldFromJoint);
/// The same into existing storage; allocates only when the size changes.
void poseSkin(const Skin& skin, const Frames& worldFromJoint, SkinPose& out);
/// The pose that leaves every vertex where it is.
SkinPose unposed(int jointCount);

}  // namespace gelenk
