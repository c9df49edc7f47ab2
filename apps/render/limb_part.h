#pragma once

#include <vector>

#include "kinematics/skeleton.h"
#include "skinning/skin.h"

namespace gelenk {

/// The joint and all that hangs on it, ascending.
std::vector<int> descendants(const Skeleton& skeleton, int joint);

/// Whether a vertex belongs by half at least to these joints: the part of a body that is shown with them.
bool belongsTo(const Influences& vertex, const std::vector<int>& joints);

}  // namespace gelenk
