#include "skinning/muscles/layered_blend.h"

#include <algorithm>

namespace gelenk {
namespace {

/// What is left outside the limb and E with the limb's weight, heaviest first.
Influences merged(const Influences& outside, int end, double weight) {
  std::vector<std::pair<double, int>> kept{{weight, end}};
  for (int k = 0; k < 4; ++k)
    if (outside.weights[k] > 0.0) kept.emplace_back(outside.weights[k], outside.joints[k]);
  std::stable_sort(kept.begin(), kept.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  Influences in{.joints = {0, 0, 0, 0}, .weights = {0, 0, 0, 0}};
  for (std::size_t k = 0; k < std::min<std::size_t>(4, kept.size()); ++k) {
    in.weights[k] = kept[k].first;
    in.joints[k] = kept[k].second;
  }
  return in;
}

bool carriesLimb(const MuscleSkin& body, int joint) {
  return std::any_of(body.limbs.begin(), body.limbs.end(), [&](const Limb& limb) {
    return std::find(limb.joints.begin(), limb.joints.end() - 1, joint) != limb.joints.end() - 1;
  });
}

}  // namespace

LayeredSkin prepareLayers(const MuscleSkin& body, const SkinMethod& method, const Frames& bound,
                          TwistSpread spread) {
  LayeredSkin layered;
  Skin skin = body.skin;
  const int joints = skin.jointCount();
  for (const LimbPose& rest : poseLimbs(body, bound)) {
    skin.jointFromRestWorld.push_back(rest.worldFromNearEnd.inverse(Eigen::Isometry));
    skin.jointFromRestWorld.push_back(rest.worldFromFarEnd.inverse(Eigen::Isometry));
  }
  layered.endJoint.assign(body.vertices.size(), -1);
  layered.vertices = body.vertices;
  for (std::size_t v = 0; v < body.vertices.size(); ++v) {
    const LimbVertex& vertex = body.vertices[v];
    if (vertex.limb < 0) continue;
    const int links = static_cast<int>(body.limbs[vertex.limb].shape.links.size());
    const bool far =
        vertex.volume == LimbVertex::beyondFar || (links > 1 && vertex.volume >= 2 * (links - 1));
    layered.endJoint[v] = joints + 2 * vertex.limb + (far ? 1 : 0);
    skin.influences[v] = merged(body.outside[v], layered.endJoint[v], vertex.weight);
  }
  std::erase_if(spread.bones, [&](const TwistBone& bone) { return carriesLimb(body, bone.joint); });
  layered.outside = prepareSkin(std::move(skin), method, std::move(spread));
  return layered;
}

LayeredSkin verticesOf(const LayeredSkin& layered, std::span<const int> vertices) {
  LayeredSkin some{.outside = verticesOf(layered.outside, vertices), .endJoint = {}, .vertices = {}};
  for (const int v : vertices) {
    some.endJoint.push_back(layered.endJoint[v]);
    some.vertices.push_back(layered.vertices[v]);
  }
  return some;
}

Frames withEnds(const Frames& worldFromJoint, const std::vector<LimbPose>& limbs) {
  Frames frames = worldFromJoint;
  for (const LimbPose& limb : limbs) {
    frames.push_back(limb.worldFromNearEnd);
    frames.push_back(limb.worldFromFarEnd);
  }
  return frames;
}

void skinWithMuscles(const LayeredSkin& layered, const Frames& worldFromJoint,
                     const std::vector<LimbPose>& limbs, SkinnedVertices& out, const Eigen::VectorXd* q,
                     SkinNormals normals) {
  const PosedBones bones = poseBones(layered.outside, withEnds(worldFromJoint, limbs), q);
  blendSkin(layered.outside, bones, out, normals);
  const std::vector<Eigen::Vector3d>& rest = layered.outside.skin.mesh.positions;
  for (std::size_t v = 0; v < layered.vertices.size(); ++v) {
    const LimbVertex& vertex = layered.vertices[v];
    if (vertex.limb < 0) continue;
    const auto [x, n] = deformLimbVertex(limbs[vertex.limb], vertex);
    out.positions[v] += vertex.weight * (x - bones.worldFromRest[layered.endJoint[v]] * rest[v]);
    const Eigen::Vector3d carried =
        bones.worldFromRest[layered.endJoint[v]].linear() * layered.outside.skin.mesh.normals[v];
    out.normals[v] = (out.normals[v] + vertex.weight * (n - carried)).normalized();
  }
}

}  // namespace gelenk
