#pragma once

#include <array>
#include <vector>

#include "skinning/muscles/muscle_skin.h"

namespace gelenk {

/// How the muscles of one link answer to the bend of a joint: what happens to planes 2 and 4. With theta the
/// total bend,
///     f = (1 - cos(theta - rest)) / (1 - cos(fullBend - rest))   in [0, 1], 0 at rest, 1 at the full bend,
/// the muscle on the inside of the bend (flexor) swells with f + activation, the one on the outside
/// (extensor) with activation and slackens with f, and the tendon thins the plane next to the joint with f.
/// A bulge k stretches the section by 1 + k across (x, towards the inside) and 1 + k/4 sideways, and moves it
/// by k r to its own side.
struct MuscleCurve {
  double flexor = 0.2;     ///< k at full bend, dimensionless
  double extensor = 0.05;  ///< k the outside loses at full bend and gains by activation
  double nearJoint =
      0.1;  ///< share of the bulge that the plane nearer the joint gets: the belly sits away from the joint
  double tendon = 0.0;    ///< share by which the plane nearer the joint is thinned at full bend
  double fullBend = 2.6;  ///< radians, total bend (straight = 0)
};

/// Controls of a limb, saved with the scene.
struct MuscleControl {
  std::vector<MuscleCurve> curves;    ///< one a link
  double activation = 0.0;            ///< [0, 1], contraction without motion
  bool keepVolume = true;             ///< volume rule on
  std::vector<MuscleState> sculpted;  ///< edits made by hand on top, one a link (identity where empty)
};
/// Upper link with a biceps, lower link slight.
MuscleControl defaultMuscleControl(const Limb& limb);
/// The volumes alone: muscles at rest, volume rule off.
MuscleControl noMuscleControl(const Limb& limb);

/// The states of planes 2 and 4 of every link for the limb's present bend, before the volume rule.
std::vector<MuscleState> muscleStates(const Limb& limb, const LimbFrames& frames,
                                      const MuscleControl& control);

/// The part of the body on one limb as a closed surface: its triangles and fans over the openings.
struct LimbSurface {
  std::vector<int> vertices;                  ///< indices into the skin
  std::vector<std::array<int, 3>> triangles;  ///< indices into vertices; closed
};
LimbSurface limbSurface(const MuscleSkin& body, int limb);

/// Volume enclosed by the limb's surface as it is skinned (bones outside the limb included), cubic metres.
double limbVolume(const MuscleSkin& body, const LimbSurface& surface, const Frames& worldFromJoint,
                  const LimbPose& pose);

/// The volume rule: the common scale s of planes 2 and 4 of all links that keeps the volume at its rest
/// value. Scaling moves each link's points in one plane of directions only, so the volume is quadratic in s:
/// three samples give it exactly. Returns the root nearest 1; where no root exists the s of the nearest
/// volume (reached is then false).
struct VolumeScale {
  double scale = 1.0;
  bool reached = true;
};
VolumeScale volumeKeepingScale(const MuscleSkin& body, int limb, const LimbSurface& surface,
                               const Frames& worldFromJoint, const LimbFrames& frames,
                               const std::vector<MuscleState>& states, double restVolume);

/// The states with stretch, offset and displacement of every plane scaled by s about the bone.
std::vector<MuscleState> scaled(std::vector<MuscleState> states, double s);

/// Everything that a frame needs: poses of all limbs with their muscles and, where asked for, the volume
/// rule.
class MuscleRig {
 public:
  MuscleRig(MuscleSkin body, const Frames& restFrames);

  const MuscleSkin& body() const { return body_; }
  std::vector<MuscleControl>& controls() { return controls_; }
  const std::vector<MuscleControl>& controls() const { return controls_; }
  const LimbSurface& surface(int limb) const { return surfaces_[limb]; }
  double restVolume(int limb) const { return restVolumes_[limb]; }

  /// q: see limbFrames.
  std::vector<LimbPose> pose(const Frames& worldFromJoint, const Eigen::VectorXd* q = nullptr) const;

 private:
  MuscleSkin body_;
  std::vector<MuscleControl> controls_;
  std::vector<LimbSurface> surfaces_;
  std::vector<double> restVolumes_;
};

}  // namespace gelenk
