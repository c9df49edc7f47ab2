#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "kinematics/forward_kinematics.h"
#include "kinematics/motion/motion_clip.h"

namespace gelenk {

/// Zero-phase low-pass: a Butterworth filter of second order, once forwards and once backwards over oddly
/// continued ends; the gain at cutoffHz is 1 / sqrt 2 in all. Rotations of joints with several axes or a ball
/// are filtered as quaternions of one hemisphere and normalised, then given back to the joint; translations
/// and single angles (unwrapped) directly. Throws std::invalid_argument unless 0 < cutoffHz < rate / 2.
MotionClip lowPassed(const Skeleton& skeleton, const MotionClip& clip, double cutoffHz);

/// A clip to be laid over another one of the same skeleton.
struct Layer {
  enum class Kind {
    Override,  ///< rotation = slerp(base, layer, weight), joint by joint; translations along the line
    Additive,  ///< rotation = base * slerp(1, reference^-1 layer, weight): the layer's departure from
               ///< `reference` on top; translations add likewise
  };
  MotionClip clip;
  Kind kind = Kind::Override;
  double weight = 1.0;             ///< 0: nothing of the layer, 1: all of it; Additive may exceed 1
  std::vector<int> joints = {};    ///< which take part; empty: all
  Eigen::VectorXd reference = {};  ///< Additive: nq; empty: the skeleton's rest pose
};

/// The base clip with the layer over it; the layer repeats where it is shorter. Throws std::invalid_argument
/// for another frame rate or skeleton, a weight that is not finite, negative, or for Override above 1, or a
/// joint that does not exist.
MotionClip layered(const Skeleton& skeleton, const MotionClip& base, const Layer& layer);

/// The joint and all below it.
std::vector<int> limbBelow(const Skeleton& skeleton, int joint);

/// first, then second: over `seconds` the end of the one fades into the beginning of the other along
/// quaternions, with a smooth step. alignRoot: the second is turned about y and moved along the floor so that
/// its root begins the fade where the first one's is, heading the same way (needs a root with three
/// translations at right angles and a free rotation; else it stays). Throws std::invalid_argument when a clip
/// is shorter than the fade or the rates differ.
MotionClip crossFaded(const Skeleton& skeleton, const MotionClip& first, const MotionClip& second,
                      double seconds, bool alignRoot = true);

/// A wanted pose at one frame. q: nq, of which only the keyed joint's entries count.
struct JointKey {
  int frame = 0;
  Eigen::VectorXd q;
};
/// The clip with the joint brought to the keys: each key's departure (a rotation, and what its translations
/// differ by) fades with a smooth step over `falloff` seconds to both sides, or up to the next key, where
/// departure goes over to departure. Throws std::invalid_argument for frames outside the clip or out of
/// order, and for poses of another length.
MotionClip keyed(const Skeleton& skeleton, const MotionClip& clip, int joint, std::span<const JointKey> keys,
                 double falloff);

/// Moves the joint's origin to `target` (world, metres) by the least turns of the given joints: damped
/// Gauss-Newton steps of minimum norm from q; what lies straight bends. Returns the distance left.
double reachWithLeastChange(const Skeleton& skeleton, Eigen::VectorXd& q, int joint,
                            const Eigen::Vector3d& target, std::span<const int> movingJoints);

/// One foot: the ball of the foot, the tip of the toes (-1: none) that the joint at the ball turns, and the
/// joints of the leg from the hip down to the ankle.
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
  double floor = 0.0;         ///< height (y) that no foot may go below, metres
  double plantedBelow = 0.3;  ///< a ball slower than this stands, m/s (all three directions)
  double shortest = 0.1;      ///< contacts shorter than this are none, s
  double blend = 0.15;        ///< before and after a contact the correction fades, s
};

/// Contacts by the balls' speeds (central differences).
std::vector<Contact> footContacts(const Skeleton& skeleton, const MotionClip& clip,
                                  std::span<const Foot> feet, const FootPlantOptions& options = {});

/// What a clip's feet do in given contacts.
struct FootFacts {
  double meanSlide = 0.0;           ///< mean horizontal way of planted balls a frame, metres
  double largestSlide = 0.0;        ///< largest of these
  double deepestPenetration = 0.0;  ///< of balls and tips below the floor in all frames, metres
  int plantedSteps = 0;             ///< pairs of neighbouring frames in contact
};
FootFacts footFacts(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet,
                    std::span<const Contact> contacts, double floor);

/// The clip with feet that stand still: in each contact the ball stays at one place of the floor plane (the
/// middle of where it slid), leg joints change as little as possible, the correction fades outside contacts,
/// and nothing of the foot stays below the floor. All other joints keep their values.
MotionClip footPlanted(const Skeleton& skeleton, const MotionClip& clip, std::span<const Foot> feet,
                       std::span<const Contact> contacts, const FootPlantOptions& options = {});

}  // namespace gelenk
