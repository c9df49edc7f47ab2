#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "apps/document/model.h"
#include "solvers/problem/ik_problem.h"

namespace gelenk {

// What the commands that solve for one joint of a model read from their options.

/// The joint asked for, or the model's only end. Throws std::invalid_argument that lists the ends.
int effectorOf(const Model& model, const std::string& name);

/// X Y Z: a Position goal; X Y Z QW QX QY QZ: a Pose. Throws std::invalid_argument for another count, numbers
/// that are not finite and quaternions that are not of length 1.
Goal targetGoal(const std::vector<double>& target, int joint);

/// nq values, or the rest pose where there are none. option: named in the errors. Throws
/// std::invalid_argument for another count, numbers that are not finite and ball joints' quaternions that are
/// not of length 1.
Eigen::VectorXd startConfiguration(const std::vector<double>& values, const Skeleton& skeleton,
                                   const std::string& option);

}  // namespace gelenk
