#include "skinning/rigging/fit/rig_weights.h"

#include <algorithm>

#include "kinematics/motion/joint_matching.h"
#include "skinning/rigging/bone_heat.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// The joint of a side by its name in the rigs of this program, else by what its name means.
int findJoint(const Skeleton& skeleton, std::initializer_list<const char*> names, const PlainName& meaning) {
  for (const char* name : names)
    if (const auto joint = skeleton.findJoint(name)) return *joint;
  const std::vector<PlainName> plain = plainNames(skeleton);
  const auto found = std::find(plain.begin(), plain.end(), meaning);
  return found == plain.end() ? -1 : static_cast<int>(found - plain.begin());
}

/// The joints from the hips' common parent to the shoulders' (both included), by height: the spine.
std::vector<int> spineOf(const Skeleton& skeleton, const int shoulders[2], const int hips[2]) {
  std::vector<int> spine;
  for (int j = 0; j < skeleton.jointCount(); ++j) {
    const int carriedShoulders = skeleton.isAncestor(j, shoulders[0]) + skeleton.isAncestor(j, shoulders[1]),
              carriedHips = skeleton.isAncestor(j, hips[0]) + skeleton.isAncestor(j, hips[1]);
    const bool onThePath = (carriedShoulders == 2) != (carriedHips == 2);
    const bool meeting = carriedShoulders == 2 && carriedHips == 2 &&
                         std::none_of(skeleton.children(j).begin(), skeleton.children(j).end(), [&](int c) {
                           return skeleton.isAncestor(c, shoulders[0]) && skeleton.isAncestor(c, hips[0]);
                         });
    if (onThePath || meeting) spine.push_back(j);
  }
  return spine;
}

/// The skin over the bone from the trunk to the neck is the trunk's: its weight stands in the column of the
/// trunk's last bone where that ends in a joint of its own.
int neckColumn(const Skeleton& skeleton, int neck) {
  for (const char* name : {"chest", "withers"})
    if (const auto end = skeleton.findJoint(name);
        end && skeleton.parent(*end) == skeleton.parent(neck) && skeleton.children(*end).empty())
      return *end;
  return neck;
}

}  // namespace

std::vector<RigBone> rigBones(const Skeleton& skeleton, const Frames& rest, const RigWeightOptions& options) {
  std::vector<RigBone> bones;
  const auto at = [&](int j) { return Vector3d(rest[j].translation()); };
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (const int parent = skeleton.parent(i); parent >= 0 && (at(i) - at(parent)).norm() > 0.0)
      bones.push_back(
          {{parent, at(parent), at(i)}, skeleton.joint(i).name == "neck" ? neckColumn(skeleton, i) : i});
  const int shoulders[2] = {findJoint(skeleton, {"shoulder_l", "fshoulder_l", "15"},
                                      {"upperarm", Side::Left}),
                            findJoint(skeleton, {"shoulder_r", "fshoulder_r", "12"},
                                      {"upperarm", Side::Right})},
            hips[2] = {findJoint(skeleton, {"hip_l", "8"}, {"thigh", Side::Left}),
                       findJoint(skeleton, {"hip_r", "4"}, {"thigh", Side::Right})};
  if (std::min({shoulders[0], shoulders[1], hips[0], hips[1]}) < 0) return bones;
  const Vector3d chest = 0.5 * (at(shoulders[0]) + at(shoulders[1])),
                 pelvis = 0.5 * (at(hips[0]) + at(hips[1]));
  const std::vector<int> spine = spineOf(skeleton, shoulders, hips);
  if (spine.empty()) return bones;
  const auto height = [&](const Vector3d& p) { return (chest - pelvis).dot(p - pelvis); };
  // A piece of a rib belongs to the spine's joint that carries the bone at its height: in a skeleton rooted
  // at the hips the nearest joint below, in one rooted at the chest the nearest above.
  const bool rootedBelow = height(at(spine.front())) < height(at(spine.back()));
  const auto carrier = [&](double h) {
    int best = spine.front();
    for (const int j : spine)
      if (rootedBelow ? height(at(j)) <= h : height(at(j)) >= h) best = j;
    return best;
  };
  // A rib's bone is the spine's own, else the joint's first.
  const auto endOf = [&](int joint) {
    for (const int child : skeleton.children(joint))
      if (std::find(spine.begin(), spine.end(), child) != spine.end()) return child;
    return skeleton.children(joint).front();
  };
  for (int side = 0; side < 2; ++side) {
    const Vector3d from = chest + options.ribWidth * (at(shoulders[side]) - chest) +
                          options.ribDrop * (pelvis - chest),
                   to = pelvis + options.ribWaist * (at(hips[side]) - pelvis);
    constexpr int pieces = 8;
    for (int k = 0; k < pieces; ++k) {
      const Vector3d a = from + (to - from) * k / pieces, b = from + (to - from) * (k + 1) / pieces;
      const int joint = carrier(height(0.5 * (a + b)));
      bones.push_back({{joint, a, b}, endOf(joint)});
    }
  }
  return bones;
}

RigWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const RigWeightOptions& options,
                      WeightLoss* loss) {
  std::vector<Bone> byEnd;  // heat for each bone by itself
  for (const RigBone& one : rigBones(skeleton, restFrames(skeleton), options))
    byEnd.push_back({one.end, one.bone.from, one.bone.to});
  const SparseWeights heat =
      boneHeatWeights(mesh, byEnd, {.strength = options.strength, .voxels = options.voxels});
  const std::vector<Influences> kept = fourLargest(heat, skeleton.jointCount(), loss);
  RigWeights out{.joints = SparseWeights(kept.size()), .bones = SparseWeights(kept.size())};
  for (std::size_t v = 0; v < kept.size(); ++v)
    for (int k = 0; k < 4; ++k) {
      const double weight = kept[v].weights[k];
      if (!(weight > 0.0)) continue;
      out.bones[v].emplace_back(kept[v].joints[k], weight);
      auto& joints = out.joints[v];
      const int joint = skeleton.parent(kept[v].joints[k]);
      const auto entry =
          std::find_if(joints.begin(), joints.end(), [&](const auto& e) { return e.first == joint; });
      if (entry == joints.end())
        joints.emplace_back(joint, weight);
      else
        entry->second += weight;
    }
  return out;
}

}  // namespace gelenk
