#pragma once

#include <Eigen/Core>
#include <string>

#include "kinematics/skeleton.h"

namespace gelenk {

/// The other side's joint for every joint, by name: "_l" / "_r" (or ".l", "-L", ...) at the end, or "left" /
/// "right" in any capitalisation anywhere. Joints without a side are their own partner. Throws
/// std::invalid_argument for a joint whose partner is missing.
std::vector<int> mirrorPartners(const Skeleton& skeleton);

/// The pose reflected at the plane x = 0: every joint origin p goes to where its partner's was, (-p.x, p.y,
/// p.z). Exact: applied twice it gives q back. q: nq. Throws std::invalid_argument, naming the joint, where
/// the skeleton itself is not symmetric (offsets beyond 1e-6 of its size, another motion, or axes that are no
/// reflections of each other).
Eigen::VectorXd mirrorPose(const Skeleton& skeleton, const Eigen::VectorXd& q);

/// Why no pose of it can be reflected; empty: every one can.
std::string whyNotMirrored(const Skeleton& skeleton);

}  // namespace gelenk
