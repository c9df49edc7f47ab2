#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "apps/render/colour.h"

namespace gelenk {

/// Words beside or above a point of the world, in the notation of mathematics.h unless they are a name.
struct SceneLabel {
  Eigen::Vector3d at;
  std::string text;
  Colour colour;
  std::optional<Eigen::Vector3d> mark = {};  ///< what it names, where that lies elsewhere: no label covers it
  bool isName = false;                       ///< of a joint, a solver or a skin: letter by letter
  bool isAbove = false;                      ///< centred above the point, which is no mark of its own
};

}  // namespace gelenk
