#pragma once

#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// Whether two lists of joints move alike, limits included; what was prepared for one then serves the other
/// (the address of a skeleton may have been used again).
bool sameJoints(const std::vector<Joint>& a, const std::vector<Joint>& b);

}  // namespace gelenk
