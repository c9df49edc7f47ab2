#pragma once

#include <vector>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

// Twist spread along the bone (the idea: Jacobson and Sorkine 2011, stretchable and twistable bones). Blended
// weights put the whole axial turn of a forearm into the few centimetres where elbow and wrist overlap, and
// the skin there collapses. Here a bone takes back its own axial turn where it begins and follows its child's
// where it ends:
//
//     s = clamp(a . (x - h) / l, 0, 1),  phi(s) = (s - 1) tau_own + s tau_child,  T <- T Rot(a, h; phi(s))
//
//     x rest vertex; h, a, l head, unit axis and length of the bone at rest; tau the turn about a of a joint
//     against its parent since rest, 2 atan2(q . a, q_w).
//
// Nothing is stored a vertex: s follows from its rest position.

/// A joint's coordinate that turns about the bone: tells the turns of half a circle and more apart.
struct TwistCoordinate {
  int index = -1;  ///< in q; -1: none, and the twist is the one in (-pi, pi]
  double sign = 1.0, rest = 0.0;
};

/// The coordinate of a joint about a world axis of the bind pose (unit): its last rotation, which turns what
/// the others left; none where that lies more than 2.6 degrees off.
TwistCoordinate coordinateAbout(const Skeleton& skeleton, const Frames& bound, int joint,
                                const Eigen::Vector3d& axis);
/// The angle, equal to tau but for whole turns, that is nearest to what the coordinate has turned since rest;
/// tau where there is no coordinate or no configuration.
double withWholeTurns(double tau, const TwistCoordinate& coordinate, const Eigen::VectorXd* q);

/// A bone whose twist is spread, in the world of the bind pose; metres.
struct TwistBone {
  int joint = 0, parent = -1;  ///< the joint that carries the bone, and its parent
  int child = -1;              ///< whose axial turn the bone follows at its end; -1: none
  Eigen::Vector3d head = Eigen::Vector3d::Zero(), axis = Eigen::Vector3d::UnitZ();
  double length = 1.0;
  TwistCoordinate own = {}, ofChild = {};
};
struct TwistSpread {
  std::vector<TwistBone> bones;
  bool empty() const { return bones.empty(); }
};

/// The bones of limbs: each chain is shoulder, elbow, hand, or the joints of another limb in that order, one
/// more than its bones. Every bone takes back its own turn, the last one follows the tip. bound: frames of
/// the bind pose. Bones without a length, a chain's first bone without a parent, are passed over.
TwistSpread spreadTwist(const Skeleton& skeleton, const Frames& bound,
                        const std::vector<std::vector<int>>& chains);

/// phi at a bone's head and at its end, radians: linear between.
struct BoneTwist {
  double atHead = 0.0, atEnd = 0.0;
};
/// One a bone of the spread. worldFromRest: T_j of every joint. q: the configuration that the pose comes
/// from, where it is known; without it a twist beyond half a turn jumps by a whole one.
std::vector<BoneTwist> boneTwists(const TwistSpread& spread,
                                  const std::vector<Eigen::Isometry3d>& worldFromRest,
                                  const Eigen::VectorXd* q = nullptr);

}  // namespace gelenk
