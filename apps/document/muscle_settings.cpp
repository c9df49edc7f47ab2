#include "apps/document/muscle_settings.h"

#include <algorithm>
#include <stdexcept>

namespace gelenk {

std::vector<Limb> standardLimbs(const Skeleton& skeleton, const Frames& rest) {
  struct KnownLimb {
    const char *name, *first, *second, *tip;
    double gap;
  };
  static constexpr KnownLimb known[] = {{"left arm", "upperarm_l", "lowerarm_l", "hand_l", elbowGap},
                                        {"right arm", "upperarm_r", "lowerarm_r", "hand_r", elbowGap},
                                        {"left leg", "thigh_l", "calf_l", "foot_l", kneeGap},
                                        {"right leg", "thigh_r", "calf_r", "foot_r", kneeGap}};
  std::vector<Limb> limbs;
  for (const auto& [name, a, b, c, gap] : known) {
    const auto i = skeleton.findJoint(a), j = skeleton.findJoint(b), k = skeleton.findJoint(c);
    if (!i || !j || !k) continue;
    try {
      limbs.push_back(makeLimb(skeleton, rest, name, {*i, *j, *k}));
      setJointGap(limbs.back().shape, gap);
    } catch (const std::invalid_argument&) {
      // Right names on joints that make no limb: not consecutive, no length, or straight balls without a bend
      // axis.
    }
  }
  return limbs;
}

Limb limbByNames(const Skeleton& skeleton, const Frames& rest, const std::string& names) {
  std::vector<int> joints;
  for (std::size_t at = 0; at <= names.size();) {
    const std::size_t comma = std::min(names.find(',', at), names.size());
    joints.push_back(skeleton.jointIndex(names.substr(at, comma - at)));
    at = comma + 1;
  }
  std::string name = names;  // a limb's name is a field of comma-separated tables
  std::replace(name.begin(), name.end(), ',', '/');
  return makeLimb(skeleton, rest, name, joints);
}

LimbSettings defaultLimbSettings(const Limb& limb) {
  return {.jointGap = jointGap(limb.shape), .wedge = limb.shape.wedge, .control = defaultMuscleControl(limb)};
}

std::vector<Limb> limbsOf(const Model& model) {
  return model.skin ? standardLimbs(model.skeleton, bindFrames(model)) : std::vector<Limb>{};
}

MuscleSettings defaultMuscleSettings(const std::vector<Limb>& limbs) {
  MuscleSettings settings;
  for (const Limb& limb : limbs) settings.limbs.emplace_back(limb.name, defaultLimbSettings(limb));
  if (!limbs.empty()) settings.shownLimb = limbs.front().name;
  return settings;
}

void applyProportions(Limb& limb, const LimbSettings& settings) {
  LimbShape shape = limb.shape;
  shape.wedge = settings.wedge;
  setJointGap(shape, settings.jointGap);
  validate(shape);
  limb.shape = shape;
}

MuscleRig makeMuscleRig(const Model& model, const Skin& skin, const MuscleSettings& settings) {
  std::vector<Limb> limbs = limbsOf(model);
  for (const auto& [name, limbSettings] : settings.limbs)
    for (Limb& limb : limbs)
      if (limb.name == name) applyProportions(limb, limbSettings);
  const Frames rest = bindFrames(model);
  MuscleRig rig(bindMuscles(skin, limbs, rest), rest);
  applyControls(rig, settings);
  return rig;
}

void applyControls(MuscleRig& rig, const MuscleSettings& settings) {
  const std::vector<Limb>& limbs = rig.body().limbs;
  for (std::size_t l = 0; l < limbs.size(); ++l)
    for (const auto& [name, limbSettings] : settings.limbs)
      if (limbs[l].name == name) rig.controls()[l] = limbSettings.control;
}

bool sameProportions(const MuscleSettings& a, const MuscleSettings& b) {
  return std::ranges::equal(a.limbs, b.limbs, [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.jointGap == y.second.jointGap && x.second.wedge == y.second.wedge;
  });
}

}  // namespace gelenk
