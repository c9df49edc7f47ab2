#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/document/model.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// The limbs of a model that carry muscles by default: arms and legs found by the names that common rigs use
/// (upperarm_l, lowerarm_l, hand_l; thigh_l, calf_l, foot_l). Joints of such names that make no limb are
/// passed over. Empty where none is found.
std::vector<Limb> standardLimbs(const Skeleton& skeleton, const Frames& restFrames);

/// A limb from joint names "shoulder,elbow,wrist". Throws std::invalid_argument naming what is wrong.
Limb limbByNames(const Skeleton& skeleton, const Frames& restFrames, const std::string& commaSeparated);

/// Of one limb: its section proportions and its muscle control.
struct LimbSettings {
  double jointGap = elbowGap;  ///< of the shorter link, distance of the connecting planes from the joint
  double wedge = 1.0 / 6.0;
  MuscleControl control;
};
LimbSettings defaultLimbSettings(const Limb& limb);

/// Muscle layers of a body.
struct MuscleSettings {
  bool enabled = false;
  bool lattice = true;         ///< drawn
  bool split = false;          ///< the same skin without layers beside it
  bool alone = false;          ///< of the body, the shown limb is drawn
  std::string shownLimb = {};  ///< whose lattice is drawn; empty: every limb's
  std::vector<std::pair<std::string, LimbSettings>> limbs = {};  ///< by name, in the order of limbsOf
};

/// The limbs of a known name, where the skin is bound; empty without a skin.
std::vector<Limb> limbsOf(const Model& model);
/// Every limb with its defaults; the first one's lattice is shown.
MuscleSettings defaultMuscleSettings(const std::vector<Limb>& limbs);

/// Applies gap and wedge to a limb's shape. Throws std::invalid_argument where the planes would cross.
void applyProportions(Limb& limb, const LimbSettings& settings);

/// The layers bound to a skin with the weights that it has now, controls as set. skin: of the model, or the
/// same with edited weights. Throws std::invalid_argument as applyProportions does.
MuscleRig makeMuscleRig(const Model& model, const Skin& skin, const MuscleSettings& settings);
/// Puts the settings' controls into a rig of the same limbs and proportions.
void applyControls(MuscleRig& rig, const MuscleSettings& settings);
/// Whether a rig bound for the one serves the other with applyControls alone.
bool sameProportions(const MuscleSettings& a, const MuscleSettings& b);

}  // namespace gelenk
