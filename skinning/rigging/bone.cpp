#include "skinning/rigging/bone.h"

#include <algorithm>

namespace gelenk {

using Eigen::Vector3d;

namespace {

bool onlyPlacesTheBody(const Skeleton& skeleton, int joint) {
  if (joint != 0 || skeleton.children(joint).size() != 1) return false;
  const auto& axes = skeleton.joint(joint).axes;
  return std::any_of(axes.begin(), axes.end(),
                     [](const AxisDof& dof) { return dof.kind == AxisDof::Kind::Translation; });
}

}  // namespace

std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames) {
  double size = 0.0;
  for (const auto& frame : frames)
    size = std::max(size, (frame.translation() - frames[0].translation()).norm());
  const double shortest = 1e-6 * size;

  std::vector<Bone> bones;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (onlyPlacesTheBody(skeleton, i)) continue;
    const Vector3d at = frames[i].translation();
    for (const int child : skeleton.children(i)) {
      const Bone bone{i, at, frames[child].translation()};
      if (bone.length() > shortest) bones.push_back(bone);
    }
    if (!skeleton.children(i).empty() || skeleton.vCount(i) == 0) continue;
    const int parent = skeleton.parent(i);
    const Vector3d before =
        parent < 0 ? Vector3d(Vector3d::Zero()) : Vector3d(at - frames[parent].translation());
    bones.push_back({i, at, at + before / 3.0});
  }
  if (bones.empty()) bones.push_back({0, frames[0].translation(), frames[0].translation()});
  return bones;
}

double distanceTo(const Bone& bone, const Vector3d& p) {
  const Vector3d along = bone.to - bone.from;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - bone.from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (bone.from + t * along - p).norm();
}

}  // namespace gelenk
