#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// Hierarchical top-down animation of a figure's legs (lecture 10.1.1): hip, then knee, then foot, each by
/// keyframed angles, while the root moves forward at a constant speed. One pose a frame. Ground: y = 0 m; the
/// figure walks along +z.
struct LegAnimation {
  double framesPerSecond = 60.0;
  std::vector<Eigen::VectorXd> q;             ///< a frame
  std::vector<std::array<bool, 2>> onGround;  ///< left, right: the ball of the foot is meant to stand
  double duration() const { return static_cast<double>(q.size()) / framesPerSecond; }
};

/// Angles in degrees at a phase of the step, 0 to 1 from one heel strike to the next; between keys a cosine.
struct LegKey {
  double phase, degrees;
};
struct LegKeys {
  std::vector<LegKey> hip, knee, foot;  ///< flexion; foot: plantar flexion
  double footFlat = 0.12,
         liftOff = 0.6;  ///< between these phases the ball of the foot is meant to stand on the ground
  double cycle = 1.2;    ///< seconds
  double speed = 1.0;    ///< of the root, m/s
  double crouch = 0.04;  ///< by which the root is lower than at rest, metres
};
LegKeys lectureLegKeys();

/// The angle at a phase (wraps around). keys: ascending in phase, at least one.
double keyedAngle(const std::vector<LegKey>& keys, double phase);

/// Plays the keys on both legs of the built-in figure, half a cycle apart, for `cycles` cycles.
LegAnimation keyframedLegs(const Skeleton& figure, const LegKeys& keys, int cycles = 2);

/// The slide's two problems, measured on one frame of one foot.
struct FootMeasure {
  double sliding =
      0.0;  ///< horizontal way of the ball of a foot on the ground since the frame before, metres
  double penetration = 0.0;  ///< depth of the lowest point of the sole below the ground, metres
};
/// [frame][left, right]
std::vector<std::array<FootMeasure, 2>> measureFeet(const Skeleton& figure, const LegAnimation& animation);

struct FootSummary {
  double worstSliding = 0.0;      ///< metres a frame
  double totalSliding = 0.0;      ///< metres, both feet
  double worstPenetration = 0.0;  ///< metres
  int framesBelowGround = 0;      ///< feet and frames with more than 1e-9 m
};
FootSummary summarise(const std::vector<std::array<FootMeasure, 2>>& feet);

/// Pinned feet on top of the same animation: a foot on the ground stays where it came down (two-link closed
/// form for hip and knee, 10.1.3), heel and toes are turned out of the ground; in the air the way back to the
/// animated foot is blended, and the sole is kept above the ground.
LegAnimation pinFeet(const Skeleton& figure, const LegAnimation& animation);

/// The sole in world coordinates: heel, ball, toe tip. side: 0 left, 1 right.
std::array<Eigen::Vector3d, 3> solePoints(const Skeleton& figure, const Eigen::VectorXd& q, int side);

}  // namespace gelenk
