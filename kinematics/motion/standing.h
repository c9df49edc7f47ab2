#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "kinematics/motion/motion_clip.h"

namespace gelenk {

/// The joints that tell whether a body stands, found by their names (joint_matching.h); -1 where there is
/// none.
struct StandingParts {
  struct Leg {
    int hip = -1, foot = -1;
  };
  std::vector<Leg> legs = {};  ///< those with both ends
  int pelvis = -1, head = -1;  ///< the head, else the neck, else the chest

  bool empty() const { return legs.empty() && (pelvis < 0 || head < 0); }
};
StandingParts standingParts(const Skeleton& skeleton);

/// How upright the body is, 1 at best: the smallest cosine between `up` and foot -> hip of every leg and
/// pelvis -> head. 0 without parts.
double uprightness(const StandingParts& parts, const Frames& frames, const Eigen::Vector3d& up);

/// Length of the legs from hip to foot along their bones, the mean of both; 0 without legs.
double legLength(const Skeleton& skeleton, const StandingParts& parts, const Frames& frames);

/// A pose in which directions of bones mean what they look like: the rest pose where the body stands in it,
/// else the most upright frame of the clip.
struct StandingPose {
  Frames frames;
  int frame = -1;            ///< of the clip; -1: the rest pose
  double uprightness = 1.0;  ///< below 0.8 nothing stands; 1 where no parts are known
};
StandingPose standingPose(const Skeleton& skeleton, const MotionClip& clip, const StandingParts& parts,
                          const Eigen::Vector3d& up);

/// The axis that points up, y or z: z only where the body stands along it and nowhere along y. Where names
/// tell nothing, it stands along an axis on the lowest of its ends, at least two, left and right (x) of its
/// middle; at rest and in the first frame.
Eigen::Vector3d upOf(const Skeleton& skeleton, const MotionClip& clip, const StandingParts& parts);

}  // namespace gelenk
