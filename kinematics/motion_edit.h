#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "kinematics/motion_clip.h"

namespace gelenk {

/// Zero-phase low-pass: a Butterworth filter of second order, once forwards and once backwards over oddly continued ends; the gain at cutoffHz
/// is 1 / sqrt 2 in all. Rotations of joints with several axes or a ball are filtered as quaternions of one hemisphere and normalised, then given back
/// to the joint; translations and single angles (unwrapped) directly. Throws std::invalid_argument unless 0 < cutoffHz < rate / 2.
MotionClip lowPassed(const Skeleton& skeleton, const MotionClip& clip, double cutoffHz);

/// base with the layer's departure from `reference` on top: rotation = base * slerp(1, reference^-1 layer, weight), joint by joint; translations add likewise.
/// joints: which take part; empty: all. The layer repeats where it is shorter. Throws std::invalid_argument for another frame rate or skeleton.
MotionClip layered(const Skeleton& skeleton, const MotionClip& base, const MotionClip& layer, const Eigen::VectorXd& reference, double weight,
                   std::span<const int> joints = {});

/// first, then second: over `seconds` the end of the one fades into the beginning of the other along quaternions, with a smooth step. alignRoot: the second is turned about y and
/// moved along the floor so that its root begins the fade where the first one's is, heading the same way (needs a root with three translations at right
/// angles and a free rotation; else it stays). Throws std::invalid_argument when a clip is shorter than the fade or the rates differ.
MotionClip crossFaded(const Skeleton& skeleton, const MotionClip& first, const MotionClip& second, double seconds, bool alignRoot = true);

/// A wanted rotation of one joint (relative to its zero, jointRotation) at one frame.
struct JointKey {
  int frame = 0;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};
/// The clip with the joint brought to the keys: each key's departure fades with a smooth step over `falloff` seconds to both sides, or up to the next key, from which
/// departure goes over to departure. Throws std::invalid_argument for frames outside the clip or out of order.
MotionClip keyed(const Skeleton& skeleton, const MotionClip& clip, int joint, std::span<const JointKey> keys, double falloff);

/// Moves the joint's origin to `target` (world, metres) by the least change of the given joints' dofs: Gauss-Newton steps of minimum norm from q. Returns the distance left.
double reachWithLeastChange(const Skeleton& skeleton, Eigen::VectorXd& q, int joint, const Eigen::Vector3d& target, std::span<const int> movingJoints);

/// One foot: the ball of the foot, the tip of the toes (-1: none) that the joint at the ball turns, and the joints of the leg from the hip down to the
/// ankle.
struct Foot {
  std::string name;
  int ball = -1, tip = -1;
  std::vector<int> leg;
};
/// Feet of CMU's skeletons (ltoes, rtoes and what is above); empty where the names are others.
std::vector<Foot> cmuFeet(const Skeleton& skeleton);
/// The foot whose ball is that joint: its leg are the three turning joints above, its tip the first child.
Foot footAt(const Skeleton& skeleton, int ball);

/// Frames [first, last] in which the foot stands.
struct Contact {
  int foot = 0, first = 0, last = 0;
};

struct FootPlantOptions {
  double floor = 0.0;             ///< height (y) that no foot may go below, metres
  double plantedBelow = 0.3;      ///< a ball slower than this stands, m/s (all three directions)
  double shortest = 0.1;          ///< contacts shorter than this are none, s
  double blend = 0.15;            ///< before and after a contact the correction fades, s
};

/// Contacts by the balls' speeds (central differences).
std::vector<Contact> footContacts(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet, const FootPlantOptions& options = {});

/// What a clip's feet do in given contacts.
struct FootFacts {
  double meanSlide = 0.0;        ///< mean horizontal way of planted balls a frame, metres
  double largestSlide = 0.0;     ///< largest of these
  double deepestPenetration = 0.0;  ///< of balls and tips below the floor in all frames, metres
  int plantedSteps = 0;          ///< pairs of neighbouring frames in contact
};
FootFacts footFacts(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet, std::span<const Contact> contacts, double floor);

/// The clip with feet that stand still: in each contact the ball stays at one place of the floor plane (the middle of where it slid), leg joints change as little as
/// possible, the correction fades outside contacts, and nothing of the foot stays below the floor. All other joints keep their values.
MotionClip footPlanted(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet, std::span<const Contact> contacts,
                       const FootPlantOptions& options = {});

}  // namespace gelenk
