#pragma once

#include <optional>

#include "kinematics/motion/joint_matching.h"
#include "kinematics/motion/motion_clip.h"

namespace gelenk {

struct RetargetOptions {
  std::optional<double> scale = {};  ///< of the path; default: from the bones' lengths
  /// Up in the source, y or z; default: along which it stands.
  std::optional<Eigen::Vector3d> sourceUp = {};
  Eigen::Vector3d targetUp = Eigen::Vector3d::UnitY();
  bool keepFeet = false, keepHands = false;  ///< in the places where the source has them, scaled
};

/// How far a bone of the target points from where it should, over all frames, radians.
struct RemainingAngle {
  int joint = 0;  ///< of the target: the bone's beginning
  double mean = 0.0, largest = 0.0;
};

/// A hand or foot that was to stay in its place: what is left, and how it slides where the source's stands.
struct KeptPlace {
  int joint = 0;                     ///< of the target
  double mean = 0.0, largest = 0.0;  ///< metres
  int framesBeyond = 0;              ///< whose place lies beyond the limb's bones, stretched or folded
  double largestWithin = 0.0;        ///< metres, in the other frames
  double sourceSlide = 0.0,
         targetSlide = 0.0;  ///< mean way along the floor a frame in contact; source's scaled
  int contactFrames = 0;
};

/// A motion on another skeleton.
struct RetargetedClip {
  MotionClip clip;
  JointMatching matching;
  double scale = 1.0;      ///< of the path
  bool rootMoves = false;  ///< false: the target has no joint with three translations to carry the path
  Eigen::Vector3d sourceUp = Eigen::Vector3d::UnitY();
  int standingFrame =
      -1;  ///< whose directions were compared with the target's rest pose; -1: the source's rest
  double uprightness = 1.0;                    ///< of that pose; below 0.8 the source never stands
  std::vector<RemainingAngle> remaining = {};  ///< of every matched bone, in the order of the target's joints
  std::vector<KeptPlace> kept = {};
};

/// Beyond these a scale of the path is more likely a unit that was not told.
inline constexpr double smallestUsualScale = 0.2, largestUsualScale = 5.0;

/// The source's motion on the target, joint by joint as matched. With the target's rest frames T0, the frames
/// S0 of the source where it stands (its rest pose where that is a stance, else its most upright frame), its
/// frames S(t) and
///     A = the rotation from the target's rest direction of the bone to the source's in S0, towards the
///     matched joint below;
///         where several lead on, and in the pelvis and above it, the turn about y from where the target
///         faces to where the source faces; at the end of a limb the A above
/// a matched joint turns to S(t) S0^-1 A T0, so that bones point where the source's point whatever the two
/// rest poses are, as in the exercise sheet's transfer; the twist about a bone is the source's departure from
/// S0. A joint that is a hinge (one axis, a second one along the bone at most) turns so that its bone points
/// as the source's; where the joint above is a ball, this twists about its own bone as far as that needs, to
/// the side within the hinge's limits. Other joints of fewer axes come as near as setJointRotation can;
/// unmatched ones keep their rest values; nothing is clamped to limits.
///
/// The path is that of the middle of both hips (else of the pelvis, else of the topmost matched joint),
/// scaled by the ratio of the legs' lengths along their bones (else of all matched bones) above the ankles'
/// height, which every body keeps. The source's floor is that of its rest pose on y = 0 unless the body
/// plainly stands elsewhere in most frames, else where its lowest joint goes; the target's is that of its
/// rest pose on y = 0, else the source's. Kept hands and feet are put in the source's scaled places by their
/// limbs alone. Throws std::invalid_argument where fewer than two joints match, or for a scale that is not
/// positive.
RetargetedClip retargeted(const Skeleton& source, const MotionClip& clip, const Skeleton& target,
                          const RetargetOptions& options = {});

}  // namespace gelenk
