#include "skinning/rigging/fit/rig_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

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

/// The trunk of a body with shoulders and hips, for segments that stand in for what its spine carries.
class Trunk {
 public:
  Vector3d chest, pelvis;          ///< the middles between shoulders and hips
  Vector3d shoulders[2], hips[2];  ///< left, right
  /// Of a four-legged body the direction in which all legs hang down from the trunk; nothing: it has none.
  std::optional<Vector3d> down;
  double knees = 0.0;  ///< where the knees are along the way from pelvis (0) to chest (1)

  static std::optional<Trunk> of(const Skeleton& skeleton, const Frames& rest) {
    const int shoulders[2] = {findJoint(skeleton, {"shoulder_l", "fshoulder_l", "15"},
                                        {"upperarm", Side::Left}),
                              findJoint(skeleton, {"shoulder_r", "fshoulder_r", "12"},
                                        {"upperarm", Side::Right})},
              hips[2] = {findJoint(skeleton, {"hip_l", "8"}, {"thigh", Side::Left}),
                         findJoint(skeleton, {"hip_r", "4"}, {"thigh", Side::Right})};
    if (std::min({shoulders[0], shoulders[1], hips[0], hips[1]}) < 0) return {};
    Trunk out(skeleton, rest);
    out.spine_ = spineOf(skeleton, shoulders, hips);
    if (out.spine_.empty()) return {};
    for (int side = 0; side < 2; ++side)
      out.shoulders[side] = out.at(shoulders[side]), out.hips[side] = out.at(hips[side]);
    out.chest = 0.5 * (out.shoulders[0] + out.shoulders[1]);
    out.pelvis = 0.5 * (out.hips[0] + out.hips[1]);
    out.findLegs(shoulders, hips);
    return out;
  }

  /// Adds the segment from a to b in pieces, each carried by the spine's joint that carries the bone at its
  /// height: in a skeleton rooted at the hips the nearest joint below, in one rooted at the chest the nearest
  /// above. place: moves what lies between.
  template <class Place>
  void add(std::vector<RigBone>& bones, const Vector3d& a, const Vector3d& b, Place place) const {
    constexpr int pieces = 8;
    Vector3d from = place(a);
    for (int k = 1; k <= pieces; ++k) {
      const Vector3d to = place(a + (b - a) * k / pieces);
      const int joint = carrier(0.5 * (from + to));
      bones.push_back({{joint, from, to}, endOf(joint)});
      from = to;
    }
  }

 private:
  Trunk(const Skeleton& skeleton, const Frames& rest) : skeleton_(skeleton), rest_(rest) {}

  Vector3d at(int joint) const { return rest_[joint].translation(); }
  double height(const Vector3d& p) const { return (chest - pelvis).dot(p - pelvis); }

  int carrier(const Vector3d& p) const {
    const bool rootedBelow = height(at(spine_.front())) < height(at(spine_.back()));
    int best = spine_.front();
    for (const int j : spine_)
      if (rootedBelow ? height(at(j)) <= height(p) : height(at(j)) >= height(p)) best = j;
    return best;
  }
  /// The stand-in's bone is the spine's own, else the joint's first.
  int endOf(int joint) const {
    for (const int child : skeleton_.children(joint))
      if (std::find(spine_.begin(), spine_.end(), child) != spine_.end()) return child;
    return skeleton_.children(joint).front();
  }

  void findLegs(const int shoulders[2], const int hips[2]) {
    std::vector<Vector3d> legs;
    for (const int top : {shoulders[0], shoulders[1], hips[0], hips[1]}) {
      Vector3d reach = Vector3d::Zero();
      for (int j = top; j < skeleton_.jointCount(); ++j)
        if (skeleton_.isAncestor(top, j) && (at(j) - at(top)).norm() > reach.norm()) reach = at(j) - at(top);
      legs.push_back(reach.normalized());
    }
    const Vector3d along = (chest - pelvis).normalized();
    Vector3d across = legs[0] + legs[1] + legs[2] + legs[3];
    across = (across - along.dot(across) * along).normalized();
    constexpr double upright = 0.8;
    if (std::any_of(legs.begin(), legs.end(), [&](const Vector3d& leg) { return leg.dot(across) < upright; }))
      return;
    down = across;
    for (const int hip : {hips[0], hips[1]})
      for (const int knee : skeleton_.children(hip))
        knees += 0.5 * height(at(knee)) / (chest - pelvis).squaredNorm() /
                 static_cast<double>(skeleton_.children(hip).size());
  }

  const Skeleton& skeleton_;
  const Frames& rest_;
  std::vector<int> spine_;
};

/// How far the surface lies from p along a unit vector; 0: it does not.
double depthAlong(const Mesh& mesh, const Vector3d& p, const Vector3d& direction) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]], u = mesh.positions[t[1]] - a, v = mesh.positions[t[2]] - a;
    const Vector3d n = u.cross(v);
    const double distance = n.dot(a - p) / n.dot(direction);
    if (!(distance > 0.0) || distance >= least) continue;
    const Vector3d q = p + distance * direction - a;
    const double s = n.dot(q.cross(v)) / n.squaredNorm(), r = n.dot(u.cross(q)) / n.squaredNorm();
    constexpr double rim = 1e-6;  // a ray may run along an edge, as in the middle of many meshes
    if (s > -rim && r > -rim && s + r < 1.0 + rim) least = distance;
  }
  return std::isfinite(least) ? least : 0.0;
}

std::vector<RigBone> heatingBones(const Mesh& mesh, const Skeleton& skeleton, const Frames& rest,
                                  const std::optional<Trunk>& trunk, const RigWeightOptions& options) {
  std::vector<RigBone> bones;
  const auto at = [&](int j) { return Vector3d(rest[j].translation()); };
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (const int parent = skeleton.parent(i); parent >= 0 && (at(i) - at(parent)).norm() > 0.0)
      bones.push_back(
          {{parent, at(parent), at(i)}, skeleton.joint(i).name == "neck" ? neckColumn(skeleton, i) : i});
  if (!trunk) return bones;
  const Vector3d &chest = trunk->chest, &pelvis = trunk->pelvis;
  const double loin = trunk->down ? trunk->knees + options.ribLoin : 0.0,
               waist = trunk->down ? options.animalWaist : options.ribWaist;
  for (int side = 0; side < 2; ++side)
    trunk->add(
        bones,
        chest + options.ribWidth * (trunk->shoulders[side] - chest) + options.ribDrop * (pelvis - chest),
        pelvis + waist * (trunk->hips[side] - pelvis) + loin * (chest - pelvis),
        [](const Vector3d& p) { return p; });
  if (trunk->down)
    trunk->add(bones, pelvis + (trunk->knees + options.bellyGroin) * (chest - pelvis),
               pelvis + options.bellyBreast * (chest - pelvis), [&](const Vector3d& p) -> Vector3d {
                 return p + options.bellyDepth * depthAlong(mesh, p, *trunk->down) * *trunk->down;
               });
  return bones;
}

}  // namespace

std::vector<RigBone> rigBones(const Mesh& mesh, const Skeleton& skeleton, const Frames& rest,
                              const RigWeightOptions& options) {
  return heatingBones(mesh, skeleton, rest, Trunk::of(skeleton, rest), options);
}

RigWeights rigWeights(const Mesh& mesh, const Skeleton& skeleton, const RigWeightOptions& options,
                      WeightLoss* loss) {
  const Frames rest = restFrames(skeleton);
  const std::optional<Trunk> trunk = Trunk::of(skeleton, rest);
  std::vector<Bone> byEnd;  // heat for each bone by itself
  for (const RigBone& one : heatingBones(mesh, skeleton, rest, trunk, options))
    byEnd.push_back({one.end, one.bone.from, one.bone.to});
  const double strength = trunk && trunk->down ? options.animalStrength : options.strength;
  const SparseWeights heat = boneHeatWeights(mesh, byEnd, {.strength = strength, .voxels = options.voxels});
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
