#pragma once

#include <Eigen/Core>
#include <string>

#include "kinematics/skeleton.h"

namespace gelenk {

/// A configuration as a user gives it: nq finite numbers; ball joints' quaternions that are of length 1 to
/// 1e-3 are made so, those that are it to 1e-12 keep every bit; followers take what their sources say. what:
/// how the errors begin, "q" or "--start". Throws std::invalid_argument.
Eigen::VectorXd checkedConfiguration(const Skeleton& skeleton, Eigen::VectorXd q, const std::string& what);

}  // namespace gelenk
