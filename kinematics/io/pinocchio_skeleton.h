#pragma once

#include <string>
#include <string_view>

#include "kinematics/skeleton.h"

namespace gelenk {

/// A skeleton from Pinocchio's text (Baran, Popovic 2007; exercise sheet): one line a joint, `id x y z
/// parent`, the root's parent -1, parents on earlier lines. Ids may be any words and become the joints'
/// names; joints keep the order of the lines.
///
/// The root gets three translations and a ball, every other joint with a child an unlimited ball,
/// end-effectors are fixed frames. All frames are parallel to the world's in the bind pose, which is the zero
/// configuration. Coordinates are taken as metres.
///
/// Throws ParseError: not five words, no number, a parent that is unknown or comes later (the original
/// program attaches such a joint to joint 0 without a word), a cycle, a second root, an id used twice, a bone
/// of zero length, no joint.
Skeleton readPinocchioSkeleton(const std::string& path);
/// The same from text; file names it in messages.
Skeleton parsePinocchioSkeleton(std::string_view text, const std::string& file);

/// Positions of the joints in the bind pose in the shortest notation that reads back as the same bits; ids
/// are the indices, as Pinocchio writes them, or the joints' names, which it also reads.
enum class PinocchioIds { Indices, Names };
std::string formatPinocchioSkeleton(const Skeleton& skeleton, PinocchioIds ids = PinocchioIds::Indices);

/// The joints of Pinocchio's built-in human (18 joints, ids 0 to 17) under their names, where the skeleton is
/// that tree; else unchanged. Pinocchio's "left" joints lie at -x, which is the right side of a body that
/// faces +z: named here by the body's own side.
Skeleton namedAsHuman(const Skeleton& skeleton);

}  // namespace gelenk
