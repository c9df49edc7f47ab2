#include "skinning/rigging/fit/rig_weights.h"

#include <algorithm>

#include "skinning/rigging/bone_heat.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// Joints of a trunk, found by what hangs on them: two pairs of limbs and the path between their roots.
struct Trunk {
  std::vector<int> spine;  ///< from the hips up
  int shoulders[2], hips[2];
};

int findJoint(const Skeleton& skeleton, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const auto joint = skeleton.findJoint(name)) return *joint;
  return -1;
}

}  // namespace

std::vector<Bone> rigBones(const Skeleton& skeleton, const Frames& rest) {
  std::vector<Bone> bones;
  const auto at = [&](int j) { return Vector3d(rest[j].translation()); };
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (const int parent = skeleton.parent(i); parent >= 0 && (at(i) - at(parent)).norm() > 0.0)
      bones.push_back({parent, at(parent), at(i)});
  const int shoulders[2] = {findJoint(skeleton, {"shoulder_l", "fshoulder_l", "15"}),
                            findJoint(skeleton, {"shoulder_r", "fshoulder_r", "12"})},
            hips[2] = {findJoint(skeleton, {"hip_l", "8"}), findJoint(skeleton, {"hip_r", "4"})};
  if (std::min({shoulders[0], shoulders[1], hips[0], hips[1]}) < 0) return bones;
  const Vector3d chest = 0.5 * (at(shoulders[0]) + at(shoulders[1])),
                 pelvis = 0.5 * (at(hips[0]) + at(hips[1]));
  std::vector<int> spine;  // the joints on the way between hips and shoulders
  for (int j = 0; j < skeleton.jointCount(); ++j)
    if (skeleton.isAncestor(j, shoulders[0]) == skeleton.isAncestor(j, hips[0])
            ? skeleton.isAncestor(j, shoulders[0]) && skeleton.isAncestor(j, shoulders[1])
            : (skeleton.isAncestor(j, shoulders[0]) && skeleton.isAncestor(j, shoulders[1])) ||
                  (skeleton.isAncestor(j, hips[0]) && skeleton.isAncestor(j, hips[1])))
      spine.push_back(j);
  const Vector3d axis = chest - pelvis;
  const auto height = [&](const Vector3d& p) { return axis.dot(p - pelvis) / axis.squaredNorm(); };
  for (int side = 0; side < 2; ++side) {
    const Vector3d from = chest + 0.75 * (at(shoulders[side]) - chest) + 0.12 * (pelvis - chest),
                   to = pelvis + 0.8 * (at(hips[side]) - pelvis);
    constexpr int pieces = 8;
    for (int k = 0; k < pieces; ++k) {
      const Vector3d a = from + (to - from) * k / pieces, b = from + (to - from) * (k + 1) / pieces;
      const double middle = height(0.5 * (a + b));
      // The carrier: the nearest bone of the spine by height.
      int carrier = spine.empty() ? 0 : spine[0];
      double nearest = unlimited;
      for (const int j : spine)
        for (const int c : skeleton.children(j)) {
          if (std::find(spine.begin(), spine.end(), c) == spine.end()) continue;
          const double low = std::min(height(at(j)), height(at(c))),
                       high = std::max(height(at(j)), height(at(c)));
          const double gap = std::max({low - middle, middle - high, 0.0});
          if (gap < nearest) nearest = gap, carrier = j;
        }
      if (spine.size() > 1 && height(at(spine.back())) < middle &&
          skeleton.isAncestor(spine.front(), spine.back()) && skeleton.isAncestor(spine.back(), shoulders[0]))
        carrier = spine.back();
      bones.push_back({carrier, a, b});
    }
  }
  return bones;
}

SparseWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const std::vector<RigJoint>& joints) {
  (void)joints;
  const std::vector<Bone> bones = rigBones(skeleton, restFrames(skeleton));
  return boneHeatWeights(mesh, bones, {.strength = 10.0, .voxels = 160});
}

}  // namespace gelenk
