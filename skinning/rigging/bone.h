#pragma once

#include <Eigen/Core>
#include <vector>

#include "kinematics/forward_kinematics.h"

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
/// is none). A root that only places the body (it translates and has one child) has no bone.
std::vector<Bone> bonesOf(const Skeleton& skeleton, const Frames& frames);

/// Distance from the segment. A bone of zero length is a point.
double distanceTo(const Bone& bone, const Eigen::Vector3d& p);

}  // namespace gelenk
