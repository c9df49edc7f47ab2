#include "skinning/bodies/body_around.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "kinematics/motion/joint_matching.h"
#include "skinning/io/skin_cache.h"
#include "skinning/rigging/bone_heat.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// A bone with what its body needs: the bone before it (-1 for the first) and the radii at its ends.
struct Link {
  Bone bone;
  int before = -1;
  double radius = 0.0, endRadius = 0.0;
};

double longest(const std::vector<Bone>& bones) {
  double length = 0.0;
  for (const Bone& bone : bones) length = std::max(length, bone.length());
  return length;
}

/// Index of the bone that ends where each bone begins: the nearest one on the way to the root, else the first
/// bone.
std::vector<int> bonesBefore(const Skeleton& skeleton, const Frames& frames, const std::vector<Bone>& bones) {
  std::vector<std::vector<int>> of(skeleton.jointCount());
  for (int b = 0; b < static_cast<int>(bones.size()); ++b) of[bones[b].joint].push_back(b);
  std::vector<int> into(skeleton.jointCount(), -1), before(bones.size(), -1);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    for (const int b : of[i]) before[b] = into[i] >= 0 ? into[i] : b == 0 ? -1 : 0;
    for (const int child : skeleton.children(i)) {
      into[child] = into[i];
      for (const int b : of[i])
        if (bones[b].to == frames[child].translation()) into[child] = b;
    }
  }
  return before;
}

/// The head of a body whose face has joints of its own (jaw, eyes, tongue, lips); -1: none.
int headWithFace(const Skeleton& skeleton) {
  const std::vector<PlainName> names = plainNames(skeleton);
  for (int head = 0; head < skeleton.jointCount(); ++head) {
    if (names[head].part != "head" || skeleton.parent(head) < 0) continue;
    int below = 0, branches = 0;
    for (int i = head + 1; i < skeleton.jointCount(); ++i)
      if (skeleton.isAncestor(head, i)) ++below, branches += skeleton.parent(i) == head;
    if (below > 3 && branches > 1) return head;
  }
  return -1;
}

/// Bones of which those of a face are one, the head, on along the neck about as far as the face reaches out.
struct BodyBones {
  std::vector<Bone> bones;
  int head = -1;  ///< joint; see headWithFace
};
BodyBones bodyBones(const Skeleton& skeleton, const Frames& frames) {
  BodyBones result{bonesOf(skeleton, frames), headWithFace(skeleton)};
  if (result.head < 0) return result;
  const Vector3d at = frames[result.head].translation();
  double reach = 0.0;
  for (int i = result.head + 1; i < skeleton.jointCount(); ++i)
    if (skeleton.isAncestor(result.head, i)) reach = std::max(reach, (frames[i].translation() - at).norm());
  const Vector3d along = at - frames[skeleton.parent(result.head)].translation();
  if (!(reach > 0.0) || !(along.norm() > 1e-9 * reach)) return result.head = -1, result;
  std::erase_if(result.bones, [&](const Bone& b) { return skeleton.isAncestor(result.head, b.joint); });
  const auto before = std::find_if(result.bones.begin(), result.bones.end(),
                                   [&](const Bone& b) { return b.joint > result.head; });
  result.bones.insert(before, {result.head, at, at + 0.6 * reach * along.normalized()});
  return result;
}

std::vector<Link> linksOf(const Skeleton& skeleton, double thickness) {
  const Frames frames = restFrames(skeleton);
  const auto [bones, head] = bodyBones(skeleton, frames);
  const std::vector<int> before = bonesBefore(skeleton, frames, bones);
  const double L = longest(bones) > 0.0 ? longest(bones) : 1.0;
  constexpr double power = 2.5;

  std::vector<Link> links(bones.size());
  std::vector<double> carried(bones.size(), 0.0);  // sum of radius^power of the bones after it
  for (int b = static_cast<int>(bones.size()) - 1; b >= 0; --b) {
    const double own =
        thickness * 0.13 * std::pow(std::max(bones[b].length(), 0.02 * L), 0.7) * std::pow(L, 0.3);
    const double fromChildren = std::min(std::pow(carried[b], 1.0 / power), thickness * 0.19 * L);
    links[b] = {bones[b], before[b], std::max(own, fromChildren), 0.0};
    if (before[b] >= 0) carried[before[b]] += std::pow(links[b].radius, power);
  }
  for (Link& link : links) link.endRadius = 0.0;
  for (const Link& link : links)
    if (link.before >= 0) links[link.before].endRadius = std::max(links[link.before].endRadius, link.radius);
  for (Link& link : links)
    link.endRadius = link.endRadius > 0.0 ? std::min(link.endRadius, link.radius) : 0.75 * link.radius;
  for (Link& link : links)
    if (head >= 0 && link.bone.joint == head) link.radius = link.endRadius = 0.8 * link.bone.length();
  return links;
}

/// The normal of the plane in which the mechanism moves, where there is one: every axis turns about it and
/// every bone lies across it.
std::optional<Vector3d> planeOfMotion(const Skeleton& skeleton, const std::vector<Link>& links) {
  const Frames frames = restFrames(skeleton);
  std::optional<Vector3d> normal;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (skeleton.joint(i).ball) return std::nullopt;
    for (const AxisDof& dof : skeleton.joint(i).axes) {
      const Vector3d axis = frames[i].linear() * dof.axis;
      if (dof.kind == AxisDof::Kind::Translation) continue;
      if (!normal) normal = axis;
      if (normal->cross(axis).norm() > 1e-6) return std::nullopt;
    }
  }
  for (const Link& link : links)
    if (normal && std::abs(normal->dot(link.bone.to - link.bone.from)) > 1e-6 * link.bone.length())
      return std::nullopt;
  return normal;
}

BodyShape shapeOf(const Skeleton& skeleton, const std::vector<Link>& links) {
  const std::optional<Vector3d> normal = planeOfMotion(skeleton, links);
  std::vector<BodyPart> parts;
  for (const Link& link : links) {
    BodyPart part{.form = BodyPart::Form::RoundCone,
                  .parent = link.before,
                  .a = link.bone.from,
                  .b = link.bone.to,
                  .radiusA = link.radius,
                  .radiusB = link.endRadius};
    if (link.before >= 0) {
      part.blend = 0.6 * link.radius;
      part.siblingBlend = 0.25 * link.radius;
    }
    if (normal) part.flat = *normal, part.flatness = 0.6;
    parts.push_back(std::move(part));
  }
  return BodyShape(std::move(parts));
}

/// Lenses where thin links gather, such as at hands: each draws the grid together so that the thinnest spans
/// a cell and a half.
std::vector<GridLens> lensesFor(const std::vector<Link>& links, double cell, double size) {
  struct Cluster {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    double thinnest = 1e300;
  };
  std::vector<Cluster> clusters;
  for (const Link& link : links) {
    const double thin = std::min(link.radius, link.endRadius);
    if (thin > 1.2 * cell) continue;
    const Vector3d middle = 0.5 * (link.bone.from + link.bone.to);
    Cluster* own = nullptr;
    for (Cluster& c : clusters)
      if ((c.sum / c.count - middle).norm() < 0.1 * size) own = &c;
    if (!own) own = &clusters.emplace_back();
    own->sum += middle;
    ++own->count;
    own->thinnest = std::min(own->thinnest, thin);
  }
  if (clusters.size() > 6) return {};
  std::vector<GridLens> lenses;
  for (const Cluster& c : clusters)
    lenses.push_back({{c.sum / c.count}, std::clamp(1.8 * cell / c.thinnest, 1.0, 4.0), 0.13 * size});
  return lenses;
}

}  // namespace

BodyShape shapeAround(const Skeleton& skeleton) { return shapeOf(skeleton, linksOf(skeleton, 1.0)); }

Mesh bodyAround(const Skeleton& skeleton, const BodyAroundOptions& options) {
  std::vector<Link> links = linksOf(skeleton, options.thickness);
  double area = 0.0;
  for (const Link& link : links) area += 2.0 * M_PI * link.radius * (link.bone.length() + link.radius);
  const double cell = std::sqrt(area / (0.8 * std::max(options.vertices, 100)));
  const double size = shapeOf(skeleton, links).bounds().sizes().maxCoeff();
  const std::vector<GridLens> lenses = lensesFor(links, cell, size);
  const double thinnest = lenses.empty() ? 1.2 * cell : 0.3 * cell;  // what the grid can still show
  for (Link& link : links) {
    link.radius = std::max(link.radius, thinnest);
    link.endRadius = std::max(link.endRadius, thinnest);
  }
  return polygonise(shapeOf(skeleton, links), {.cell = cell, .lenses = lenses});
}

Skin bodySkin(const Skeleton& skeleton, const BodyAroundOptions& options) {
  Mesh mesh = bodyAround(skeleton, options);
  const Frames rest = restFrames(skeleton);
  const SparseWeights weights = boneHeatWeights(mesh, bodyBones(skeleton, rest).bones);
  return bindSkin(std::move(mesh), rest, fourLargest(weights, skeleton.jointCount()));
}

std::uint64_t bodySkinKey(const Skeleton& skeleton) {
  constexpr double methodVersion = 2.0;
  std::vector<double> facts{methodVersion};
  const Frames rest = restFrames(skeleton);
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    for (const double entry : rest[i].matrix().reshaped()) facts.push_back(entry);
    facts.insert(facts.end(), {static_cast<double>(skeleton.parent(i)), skeleton.joint(i).ball ? 1.0 : 0.0});
    for (const AxisDof& dof : skeleton.joint(i).axes)
      facts.insert(facts.end(), {static_cast<double>(dof.kind), dof.axis.x(), dof.axis.y(), dof.axis.z()});
  }
  if (const int head = headWithFace(skeleton); head >= 0) facts.push_back(head);
  return checksum({reinterpret_cast<const char*>(facts.data()), facts.size() * sizeof(double)});
}

}  // namespace gelenk
