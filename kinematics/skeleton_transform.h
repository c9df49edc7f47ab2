#pragma once

#include "kinematics/motion/motion_clip.h"
#include "kinematics/skeleton.h"

namespace gelenk {

/// The same skeleton, turned as a whole about the world's origin (another up axis). Configurations mean the
/// same poses, turned.
Skeleton rotated(const Skeleton& skeleton, const Eigen::Quaterniond& worldFromOld);

/// The same skeleton, larger by `factor` (> 0) about the world's origin: offsets, translation limits and the
/// rest configuration.
Skeleton scaled(const Skeleton& skeleton, double factor);
/// The clip that goes with it: translations times `factor`.
MotionClip scaled(const Skeleton& skeleton, MotionClip clip, double factor);

/// The same motion on a skeleton without translations that stand still in it.
struct StillTranslations {
  Skeleton skeleton;
  MotionClip clip;
  std::vector<std::string> joints;  ///< whose translations became part of their offsets
};
/// Some exporters give every joint six channels. Where the translations that a joint begins with stay within
/// `tolerance` (metres) of the first frame's, that place becomes the joint's offset and the axes go; joint 0
/// keeps its own. Joints' frames are as before to that tolerance, in every frame.
StillTranslations withoutStillTranslations(const Skeleton& skeleton, const MotionClip& clip,
                                           double tolerance = 1e-6);

}  // namespace gelenk
