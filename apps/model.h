#pragma once

#include <optional>
#include <string>
#include <vector>

#include "kinematics/motion_clip.h"
#include "kinematics/skeleton.h"
#include "skinning/skin.h"

namespace gelenk {

/// What a user names on the command line or drops on the window: a skeleton, mostly with a body around it.
struct Model {
  std::string name;
  Skeleton skeleton;
  std::optional<Skin> skin = {};
  bool planar = false;                 ///< moves in the x-y plane: seen from above by default
  Eigen::Vector3d up = Eigen::Vector3d::UnitY();  ///< against gravity; figures stand along y, robots and planar scenes along z
  std::optional<MotionClip> clip = {};  ///< a motion that came with it, for players; never clamped
  std::vector<std::string> handles = {};  ///< joints that get a drag handle; empty: the end-effectors
  std::vector<std::string> pins = {};     ///< handles that are pinned when the model is opened, such as the feet
  std::vector<std::string> notes = {};    ///< facts worth telling, such as the weight lost by keeping four influences
};

/// Built-in models by name ("figure", "planar", robots), else a file by its extension.
/// Throws std::invalid_argument listing the names, or ParseError.
Model openModel(const std::string& nameOrFile);

/// The model with a rounded body around its bones (skinning/body_around.h) where it has none; for everything that shows it. Taken from the
/// cache when the same skeleton was shown before. A skeleton around which no body can be made stays bare, and a note says why.
Model withBody(Model model);

/// Names of the built-in models.
std::vector<std::string> builtInModels();

}  // namespace gelenk
