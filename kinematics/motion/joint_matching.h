#pragma once

#include <string>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// Left and right of a body, told from a joint's name.
enum class Side { Middle, Left, Right };

/// What a joint's name says when case, separators, side and the rig's own prefix are put aside:
/// "mixamorig:LeftUpLeg", "thigh.L" and "lfemur" are all (thigh, Left).
struct PlainName {
  std::string part;
  Side side = Side::Middle;
  bool operator==(const PlainName&) const = default;
};

/// Plain names of all joints. Put aside are: everything up to the last ':' or '|'; what all names but the
/// root's begin with up to a separator ("Bip01 ", "def_"); case, separators and leading zeros of numbers. A
/// side is a word left, right, l or r, or a leading l or r where the skeleton has the same name with the
/// other letter. Names of one part of the body (upleg, upperleg, femur, thigh; the table is in the source)
/// become one; a root is the pelvis where there is none.
std::vector<PlainName> plainNames(const Skeleton& skeleton);

struct JointMatch {
  int source = 0, target = 0;
};

struct JointMatching {
  std::vector<JointMatch> matches;  ///< ascending in the target
  std::vector<std::string> unmatchedSource,
      unmatchedTarget;  ///< in the order of the joints; fixed joints without children are left out
};

/// Pairs of joints, each joint in one pair at most: of equal names letter by letter, then of equal plain
/// names; of several with one plain name the one with the shortest name counts, and none where two are
/// equally short. A pair that would turn the hierarchy round (a target below the target of a joint that is
/// below its source) is dropped.
JointMatching matchJoints(const Skeleton& source, const Skeleton& target);

}  // namespace gelenk
