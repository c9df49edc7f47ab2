#pragma once

#include <string>

#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// The part of a scene that describes muscle layers: per limb, by name, its section proportions and its
/// muscle control.
struct LimbSettings {
  double jointGap = elbowGap;  ///< of the shorter link, distance of the connecting planes from the joint
  double wedge = 1.0 / 6.0;
  MuscleControl control;
};
LimbSettings defaultLimbSettings(const Limb& limb);
struct MuscleSettings {
  bool enabled = false;
  bool lattice = true;  ///< drawn
  bool split = false;   ///< LBS beside the layers
  std::vector<std::pair<std::string, LimbSettings>> limbs;
};

/// JSON text, exact for every number.
std::string muscleSettingsText(const MuscleSettings& settings);

/// Throws std::runtime_error naming the entry: no JSON, a limb that the model has not (those it has are
/// listed), a value of the wrong kind, not finite or out of its range, curves or planes that do not fit the
/// limb's links.
MuscleSettings parseMuscleSettings(const std::string& text, const std::vector<Limb>& limbs);

/// Applies gap and wedge to a limb's shape. Throws std::invalid_argument where the planes would cross.
void applyProportions(Limb& limb, const LimbSettings& settings);

}  // namespace gelenk
