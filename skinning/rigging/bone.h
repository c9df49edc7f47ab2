#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/note.h"
#include "skinning/mesh.h"

namespace gelenk {

/// A segment that a joint carries rigidly, in world coordinates: from the joint to one of its children.
struct Bone {
  int joint = 0;
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();

  double length() const { return (to - from).norm(); }
};

/// The bones of a skeleton in the pose of the frames: one for each joint and child that lie apart, carried by
/// the joint at the top, so that the forearm's skin follows the elbow. Fixed end sites carry nothing. A
/// moving joint without children gets a stub that continues its parent's bone by a third (a point where there
/// is none).
///
/// A root that only places the body, such as one on the floor below the hips, has no bone. Without a skin it
/// is told by the other joints: it translates, has one child, and some joint beyond that child lies back on
/// the root's half of the way, as feet do. In limbs, tails and tentacles all joints lie onwards.
std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames);

/// The same for a skin bound in that pose, which decides about the root: its bones are left out where the
/// greater part of them lies outside the body while other bones lie inside it. A root without a bone hands
/// the question on to its only child.
std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames, const Mesh& skin);

/// Share of the bone's length that lies inside the surface (winding number above one half), 0 to 1.
double shareInside(const Bone& bone, const Mesh& mesh);

/// What looks wrong about bones and skin together: bones that lie outside the mesh for the most part
/// ("bone-outside", names in the text) and sizes that differ as units do ("rig-unit": more than threefold).
std::vector<Note> rigNotes(const Skeleton& skeleton, std::span<const Bone> bones, const Mesh& skin);

/// Distance from the segment. A bone of zero length is a point.
double distanceTo(const Bone& bone, const Eigen::Vector3d& p);

}  // namespace gelenk
