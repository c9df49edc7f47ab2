#pragma once

#include "kinematics/motion/joint_matching.h"
#include "kinematics/motion/motion_clip.h"

namespace gelenk {

/// A motion on another skeleton.
struct RetargetedClip {
  MotionClip clip;
  JointMatching matching;
  double scale = 1.0;  ///< of the path: height of the pelvis (else of the topmost matched joint) above the
                       ///< lowest joint, target over source
  bool rootMoves = false;  ///< false: the target has no joint with three translations to carry the path
};

/// The source's motion on the target, joint by joint as matched. With rest frames S0, T0, the source's frames
/// S(t) and
///     A = the rotation from the target's rest direction of the bone to the source's, towards the matched
///     joint below;
///         where several lead on, and in the pelvis and above it, the turn about y from where the target
///         faces to where the source faces; at the end of a limb the A above
/// a matched joint turns to S(t) S0^-1 A T0, so that bones point where the source's point whatever the two
/// rest poses are, as in the exercise sheet's transfer; the twist about a bone is the source's departure from
/// rest. Joints of fewer axes come as near as setJointRotation can, unmatched ones keep their rest values,
/// nothing is clamped to limits. The path of the pelvis, else of the topmost matched joint, is scaled about
/// the floor below the rest pose (y up). Throws std::invalid_argument where fewer than two joints match.
RetargetedClip retargeted(const Skeleton& source, const MotionClip& clip, const Skeleton& target);

}  // namespace gelenk
