#include "skinning/rigging/bone.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "skinning/winding_number.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

constexpr double halfInside = 0.5;

double shortestBone(const Frames& frames) {
  double size = 0.0;
  for (const auto& frame : frames)
    size = std::max(size, (frame.translation() - frames[0].translation()).norm());
  return 1e-6 * size;
}

/// Every bone there could be; the root's are the first.
std::vector<Bone> allBones(const Skeleton& skeleton, const Frames& frames) {
  const double shortest = shortestBone(frames);
  std::vector<Bone> bones;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Vector3d at = frames[i].translation();
    for (const int child : skeleton.children(i)) {
      const Bone bone{i, at, frames[child].translation()};
      if (bone.length() > shortest) bones.push_back(bone);
    }
    if (!skeleton.children(i).empty() || skeleton.qCount(i) == 0) continue;
    const int parent = skeleton.parent(i);
    const Vector3d before =
        parent < 0 ? Vector3d(Vector3d::Zero()) : Vector3d(at - frames[parent].translation());
    bones.push_back({i, at, at + before / 3.0});
  }
  return bones;
}

bool onlyPlacesTheBody(const Skeleton& skeleton, const Frames& frames) {
  const auto& axes = skeleton.joint(0).axes;
  if (skeleton.children(0).size() != 1 || std::none_of(axes.begin(), axes.end(), [](const AxisDof& dof) {
        return dof.kind == AxisDof::Kind::Translation;
      }))
    return false;
  const Vector3d root = frames[0].translation(), way = frames[skeleton.children(0)[0]].translation() - root;
  return std::any_of(frames.begin() + 1, frames.end(), [&](const Eigen::Isometry3d& frame) {
    return (frame.translation() - root).dot(way) < 0.5 * way.squaredNorm();
  });
}

std::vector<Bone> orOnePoint(std::vector<Bone> bones, const Frames& frames) {
  if (bones.empty()) bones.push_back({0, frames[0].translation(), frames[0].translation()});
  return bones;
}

}  // namespace

std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames) {
  std::vector<Bone> bones = allBones(skeleton, frames);
  if (onlyPlacesTheBody(skeleton, frames))
    std::erase_if(bones, [](const Bone& bone) { return bone.joint == 0; });
  return orOnePoint(std::move(bones), frames);
}

std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames, const Mesh& skin) {
  std::vector<Bone> bones = allBones(skeleton, frames);
  std::vector<bool> outside;
  for (const Bone& bone : bones) outside.push_back(shareInside(bone, skin) < halfInside);

  std::vector<bool> places(skeleton.jointCount(), false);  // joints from the root on whose bones are outside
  for (int joint = 0; joint >= 0;) {
    bool held = false;
    for (std::size_t b = 0; b < bones.size(); ++b) held = held || (bones[b].joint == joint && !outside[b]);
    places[joint] = true;
    joint = held || skeleton.children(joint).size() != 1 ? -1 : skeleton.children(joint)[0];
  }
  // A surface that encloses nothing, such as a sheet, says nothing about bones.
  int inside = 0, others = 0;
  for (std::size_t b = 0; b < bones.size(); ++b)
    if (!places[bones[b].joint]) inside += !outside[b], ++others;
  if (2 * inside > others) {
    std::size_t b = 0;
    std::erase_if(bones, [&](const Bone& bone) { return outside[b++] && places[bone.joint]; });
  }
  return orOnePoint(std::move(bones), frames);
}

double shareInside(const Bone& bone, const Mesh& mesh) {
  constexpr int samples = 8;
  int inside = 0;
  for (int k = 0; k < samples; ++k) {
    const Vector3d p = bone.from + (k + 0.5) / samples * (bone.to - bone.from);
    inside += std::abs(windingNumber(mesh, p)) > 0.5;  // triangles may face inwards
  }
  return static_cast<double>(inside) / samples;
}

namespace {

/// "1000 times as large as", "0.01 of the size of": to a power of ten where it is near one.
std::string sizeRatio(double ratio) {
  const double power = std::round(std::log10(ratio));
  const bool near = std::abs(std::log10(ratio) - power) < 0.3;
  const double shown = near ? std::pow(10.0, power) : ratio;
  char text[64];
  std::snprintf(text, sizeof text, "about %.3g times as large as", shown);
  return text;
}

}  // namespace

std::vector<Note> rigNotes(const Skeleton& skeleton, std::span<const Bone> bones, const Mesh& skin) {
  std::vector<Note> notes;
  Eigen::AlignedBox3d ofBones, ofSkin;
  for (const Bone& bone : bones) ofBones.extend(bone.from).extend(bone.to);
  for (const Vector3d& p : skin.positions) ofSkin.extend(p);
  const double ratio = ofBones.diagonal().norm() / ofSkin.diagonal().norm();
  if (std::isfinite(ratio) && ratio > 0.0 && std::abs(std::log10(ratio)) > std::log10(3.0))
    tell(notes, "rig-unit",
         "the skeleton is " + sizeRatio(ratio) + " the mesh: one of them may be in another unit");
  std::vector<std::string> names;
  for (const Bone& bone : bones)
    if (shareInside(bone, skin) < halfInside) {
      const std::string& name = skeleton.joint(bone.joint).name;
      if (names.empty() || names.back() != name) names.push_back(name);
    }
  if (!names.empty())
    tell(notes, "bone-outside",
         "bones of " + std::to_string(names.size()) + " joints lie outside the mesh: " + listed(names));
  return notes;
}

double distanceTo(const Bone& bone, const Vector3d& p) {
  const Vector3d along = bone.to - bone.from;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::clamp((p - bone.from).dot(along) / squared, 0.0, 1.0) : 0.0;
  return (bone.from + t * along - p).norm();
}

}  // namespace gelenk
