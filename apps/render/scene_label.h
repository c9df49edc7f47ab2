#pragma once

#include <Eigen/Core>
#include <string>

#include "apps/render/colour.h"

namespace gelenk {

/// Words beside a point of the world, in the notation of mathematics.h.
struct SceneLabel {
  Eigen::Vector3d at;
  std::string text;
  Colour colour;
};

}  // namespace gelenk
