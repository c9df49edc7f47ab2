#pragma once

#include <optional>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// The elbow or knee of the limb that ends at `joint`: going up from it, the first of the next three joints
/// that bends by a hinge of at least 85 degrees (a twist may follow) and whose parent turns about several
/// axes (a shoulder, a hip). nullopt where there is none.
std::optional<int> limbMiddle(const Skeleton& skeleton, int joint);

}  // namespace gelenk
