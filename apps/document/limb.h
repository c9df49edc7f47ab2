#pragma once

#include <optional>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// The elbow or knee of the limb that ends at `joint`: going up from it, the first of the next three joints
/// that bends by a hinge of at least 85 degrees (a twist may follow) and whose parent turns about several
/// axes (a shoulder, a hip). nullopt where there is none.
std::optional<int> limbMiddle(const Skeleton& skeleton, int joint);

/// Where the pole handle of an elbow or knee is drawn: on the side to which the limb is bent, at half the
/// limb's length from the middle joint. A limb that is straight to 1e-6 of its length has no side; the middle
/// joint's own y axis is taken. World, metres.
Eigen::Vector3d polePoint(const Skeleton& skeleton, const Frames& frames, int middle);

}  // namespace gelenk
