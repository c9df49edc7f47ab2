#pragma once

#include "apps/commands/image.h"
#include "apps/document/model.h"
#include "apps/document/theme.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// A sheet of pictures of one limb, for judging its muscle layer by eye: rows straight, 60 and 120 degrees of
/// bend; columns linear blending, volumes alone (FFD), volumes with muscle and volume rule. The limb is cut
/// off the body and seen along its bend axis, bones and control planes through a translucent skin.
struct MuscleSheet {
  int cellWidth = 480, cellHeight = 560;  ///< pixels at scale 1
  double scale = 1.0;
  int smoothing = 3;  ///< n x n pixels drawn for one
  Theme theme = Theme::Light;
};

/// Needs a current context. Throws std::invalid_argument for a model without a skin or a limb of one link.
Image drawMuscleSheet(const Model& model, const Limb& limb, const MuscleSheet& sheet);

}  // namespace gelenk
