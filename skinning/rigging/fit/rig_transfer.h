#pragma once

#include <string>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// A user's skeleton laid on a fitted one.
struct LaidSkeleton {
  Skeleton skeleton;
  int matched = 0;                  ///< joints whose place follows from a joint of the same meaning
  std::vector<std::string> placed;  ///< the others: by proportion between two of those, or carried along
};

/// The user's joints at the places of the fitted skeleton's joints of the same meaning (joint_matching.h).
/// Those between two such joints keep their share of the way, those beyond hang on as they did, turned and
/// scaled with their parent. Names, motions, limits and rest angles stay; the offsets change so that the rest
/// pose is the body's. Throws std::invalid_argument where fewer than four joints match or all of them lie in
/// one line.
LaidSkeleton layOn(const Skeleton& fitted, const Skeleton& user);

}  // namespace gelenk
