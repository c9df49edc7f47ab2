#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/motion/motion_clip.h"
#include "kinematics/skeleton.h"

namespace gelenk {

/// What position channels mean. Programs disagree, the format has no word for it: for the root most write the
/// position itself, for other joints some write the whole offset from the parent and some only the difference
/// from OFFSET.
enum class BvhPositions {
  Automatic,  ///< root: the position itself; others: whichever keeps the bones of the first frame nearer to
              ///< the lengths of their OFFSETs
  Replace,    ///< channels stand in place of OFFSET
  Add,        ///< channels are added to OFFSET, at the root as well
};

struct BvhOptions {
  double metresPerUnit = 1.0;  ///< the file does not say its unit
  BvhPositions positions = BvhPositions::Automatic;
};

struct BvhMotion {
  Skeleton skeleton;
  MotionClip clip;
  std::vector<Note> notes;
};

/// A skeleton and its motion from a BVH. Rotations keep the order of their channels, which may differ from
/// joint to joint: R = R_first R_second R_third; translations come before the rotations whatever the order of
/// the channels. End sites become fixed joints "PARENT_end", or bear their own name where they have one.
/// Several roots hang on a fixed joint "scene". The bind pose has all angles zero and every
/// joint at its OFFSET.
///
/// Notes: another number of rows than `Frames:` says (the rows count), a last frame that is cut off, several
/// roots, how position channels of other joints were understood.
///
/// Throws ParseError: braces or keywords that do not fit, a channel twice, a name twice, numbers that are
/// none, rows whose lengths are not the number of channels, no frame, a frame time that is not positive.
BvhMotion readBvh(const std::string& path, const BvhOptions& options = {});
BvhMotion parseBvh(std::string_view text, const std::string& file, const BvhOptions& options = {});

/// A motion of any skeleton as BVH: the bind pose becomes the pose of zero angles, whatever frames the joints
/// have in it. Joints that turn about coordinate axes in frames parallel to the world's keep their angles and
/// their order, and get the channels they lack with zeros: Blender reads three rotations or none. All others
/// get Zrotation Xrotation Yrotation. Joints that move along axes in this motion, and the root, get position
/// channels, which stand in place of OFFSET; translations that stand still become part of OFFSET. Names are
/// single words (blanks become '_') and numbers have no exponents, as the readers of Blender, Maya's scripts
/// and three.js want them; the latter two cut names at blanks.
std::string formatBvh(const Skeleton& skeleton, const MotionClip& clip, double metresPerUnit = 1.0);

}  // namespace gelenk
