#pragma once

#include <Eigen/Core>

namespace gelenk {

class Sandbox;

/// Takes the pose of the other solution whose ghost lies under the window's pixel; false where there is none.
bool takeBranchAt(Sandbox&, const Eigen::Vector2d& pixel);

}  // namespace gelenk
