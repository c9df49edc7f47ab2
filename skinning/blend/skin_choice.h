#pragma once

#include <string>
#include <string_view>

#include "skinning/blend/skin_method.h"

namespace gelenk {

/// Muscle layers over a method (skinning/muscles): their volumes alone, or with muscles.
enum class SkinLayers { None, Volumes, Muscles };

/// How a body's skin follows its bones, as a user names it and a scene keeps it: "lbs", "cor+twist",
/// "dqs+twist+smooth=20", "cor+twist+smooth+layers=muscle".
struct SkinChoice {
  SkinMethodKind method = SkinMethodKind::Lbs;
  bool twist = false;      ///< spread along the bones of limbs (twist_spread.h)
  double smoothing = 0.0;  ///< length over which the weights are smoothed first, metres (weight_smoothing.h)
  SkinLayers layers = SkinLayers::None;
  bool operator==(const SkinChoice&) const = default;
};

/// A method's name, then "+twist", "+smooth" (45 mm) or "+smooth=MM", millimetres up to 200, "+layers" or
/// "+layers=muscle". Throws std::invalid_argument that says what there is.
SkinChoice parseSkinChoice(std::string_view text);
std::string toString(const SkinChoice& choice);

/// What a body drawn by the choice needs, its layers apart. skin: with the weights that it has now; skeleton
/// and bound: its skeleton and the frames of the bind pose, in which limbs are looked for.
PreparedSkin prepareSkin(const Skin& skin, const SkinChoice& choice, const Skeleton& skeleton,
                         const Frames& bound);

}  // namespace gelenk
