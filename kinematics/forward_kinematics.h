#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// worldFromJoint for every joint: the narrow waist. Every source of poses (dragging, mocap, sliders,
/// solvers) ends in Frames; every skin, muscle layer and renderer begins there. Metres.
using Frames = std::vector<Eigen::Isometry3d>;

/// worldFromJoint(i) = worldFromParent * parentFromZero * motion_i(q). q: nq.
Frames forwardKinematics(const Skeleton& skeleton, const Eigen::VectorXd& q);
/// The same into existing storage; allocates only when the size changes.
void forwardKinematics(const Skeleton& skeleton, const Eigen::VectorXd& q, Frames& worldFromJoint);

/// The joint's own motion: axis_1(q_1) * ... * axis_n(q_n) * ball. q: the whole configuration.
Eigen::Isometry3d jointMotion(const Skeleton& skeleton, const Eigen::VectorXd& q, int joint);

/// The bind pose: forwardKinematics(skeleton, skeleton.rest()).
Frames restFrames(const Skeleton& skeleton);

/// Sum of the offsets' lengths from the joint up to the root's frame: no point fixed to the joint's origin
/// can be farther from the root than this (translation axes aside). Metres.
double chainLength(const Skeleton& skeleton, int joint);

}  // namespace gelenk
