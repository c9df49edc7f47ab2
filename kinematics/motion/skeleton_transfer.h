#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/asf_amc.h"

namespace gelenk {

/// A chain of ASF bones, from the body outwards, that takes the place of a path of fitted joints: the bones'
/// ends are laid on the path in the proportions of their lengths.
struct BonePath {
  std::vector<std::string> bones;
  std::vector<std::string> joints;  ///< two or more; names, or indices written as numbers
  std::string file = {};            ///< where the path was read, for messages
  int line = 0;                     ///< 0: the path is of no file
};

/// One line a chain, `bone bone ... : joint joint ...`; '#' begins a comment. Throws ParseError.
std::vector<BonePath> parseBonePaths(std::string_view text, const std::string& file);

/// The bones of CMU's skeletons on the joints of Pinocchio's built-in human (namedAsHuman).
std::vector<BonePath> cmuOnPinocchioHuman();

/// Paths for any two skeletons, from joints of equal names (joint_matching.h; a bone's joint is where it
/// begins): the bones between two matched joints lie on the fitted joints between the two, and the bones at
/// the root begin where the root's match stands (else at the joint called pelvis or hips, else at the fitted
/// root). Bones that two paths would want belong to the first. Empty where nothing matches.
std::vector<BonePath> bonePathsByName(const AsfSkeleton& asf, const Skeleton& fitted);

/// A piece of a fitted bone (the one from joint `child` to its parent) that an ASF bone lies on; 0 at the
/// parent, 1 at the child.
struct BonePiece {
  int child;
  double from, to;
  int joint;  ///< of the ASF skeleton
};

/// The fitted skeleton on the ASF skeleton (exercise sheet, "Skelettanpassung"): new directions and lengths,
/// and for every bone
///     A = rotation from the old to the new direction,    O_new = A O_old,
/// so that the bone's direction in its own frame, O^T direction, stays as it was. Antiparallel directions
/// take a perpendicular axis of A, bones without length are passed over; the twist about the bone is not
/// determined by this and stays that of the smallest rotation.
///
/// The skeleton keeps the zero pose of the ASF (same angles, same directions in motion) with the new lengths,
/// so that a clip of the ASF plays on it unchanged. The body is bound in the fitted pose: T_rest of the sheet
/// is bindFrames, T_skinning = T_anim T_rest^-1.
struct TransferredSkeleton {
  Skeleton skeleton;                      ///< rests with its root at the fitted place
  Frames bindFrames;                      ///< O_new at the fitted places, one a joint
  std::vector<Eigen::Quaterniond> turns;  ///< A, one a joint of the skeleton
  double heightRatio =
      1.0;  ///< fitted over ASF: height (y) of the root above the lowest joint; scale the clip's root by it
  std::vector<BonePiece> pieces;             ///< which ASF bone lies where on the fitted bones
  std::vector<std::string> unmatchedBones;   ///< ASF bones in no path: they turn with their parent and take
                                             ///< the mean ratio of lengths
  std::vector<std::string> unmatchedJoints;  ///< fitted joints whose bone is on no path
};

/// Throws std::invalid_argument, for paths of a file ParseError with its line: an unknown bone or joint,
/// bones of one path that do not hang on each other, joints of one path that are no neighbours, paths at the
/// root that do not begin at one joint, a bone in two paths.
TransferredSkeleton transferSkeleton(const AsfSkeleton& asf, const Skeleton& fitted,
                                     const std::vector<BonePath>& paths);

/// The clip with the root's translations multiplied by `factor`, for a body of another size.
MotionClip withScaledRoot(const Skeleton& skeleton, MotionClip clip, double factor);

}  // namespace gelenk
