#pragma once

#include "kinematics/motion_clip.h"
#include "kinematics/skeleton.h"

namespace gelenk {

/// The same skeleton, turned as a whole about the world's origin (another up axis). Configurations mean the same poses, turned.
Skeleton rotated(const Skeleton& skeleton, const Eigen::Quaterniond& worldFromOld);

/// The same skeleton, larger by `factor` (> 0) about the world's origin: offsets, translation limits and the rest configuration.
Skeleton scaled(const Skeleton& skeleton, double factor);
/// The clip that goes with it: translations times `factor`.
MotionClip scaled(const Skeleton& skeleton, MotionClip clip, double factor);

}  // namespace gelenk
