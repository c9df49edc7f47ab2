#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/motion/motion_clip.h"
#include "kinematics/skeleton.h"

namespace gelenk {

/// Metres in one file unit of an ASF whose `:units` say `length L`: values are inches times L (CMU: 0.45).
double asfMetresPerUnit(double lengthUnit);

/// A skeleton in the Acclaim format. Every bone turns about its start: bone b is joint b at the bone's start,
/// and the bone's end is the origin of endJoint: the first bone that hangs on it, or a fixed joint "b_end".
///
/// With C = Rz Ry Rx of the bone's `axis` and M = Rz Ry Rx of its dofs (in the order that `axis` names, last
/// letter outermost; missing ones 0): W_child = W_parent C M C^-1 and end = start + W_child (direction *
/// length). The joint's frame is W C, so that M turns about its own coordinate axes: parentFromZero =
/// C_parent^-1 [C | direction * length of the parent].
struct AsfSkeleton {
  /// Where one value of an AMC line goes: q[qIndex] = scale * value.
  struct Channel {
    int qIndex;    ///< -1: nowhere, a changing length
    double scale;  ///< metres or radians per file unit
    bool rotation;
  };
  struct Bone {
    std::string name;
    int joint;                      ///< equals the bone's position in `bones`; 0 is the root
    int endJoint;                   ///< the root's is itself
    std::vector<Channel> channels;  ///< in the order of the AMC line; empty: the bone never appears there
    double length = 0.0;            ///< metres
    Eigen::Vector3d direction =
        Eigen::Vector3d::Zero();  ///< world, in the zero pose; as in the file, 6 digits near a unit vector
    Eigen::Quaterniond axis = Eigen::Quaterniond::Identity();  ///< C: worldFromJoint in the zero pose
  };

  Skeleton skeleton;
  std::vector<Bone> bones;  ///< root first, parents before children
  double metresPerUnit = asfMetresPerUnit(0.45);
  double radiansPerUnit = 1.0;
  std::string name;
  std::vector<Note> notes;

  std::optional<int> findBone(std::string_view name) const;  ///< upper and lower case are not told apart
};

/// metresPerUnit: overrules what `:units length` says. Throws ParseError. Limits become radians; (-inf inf)
/// is no limit; zero-length bones are allowed; the length dof `l` is passed over, which the notes tell.
AsfSkeleton readAsf(const std::string& path, std::optional<double> metresPerUnit = {});
AsfSkeleton parseAsf(std::string_view text, const std::string& file,
                     std::optional<double> metresPerUnit = {});

/// A motion for that skeleton. The file holds no rate (CMU: 120 Hz) unless it has the line
/// `:SAMPLES-PER-SECOND n`, which some programs write. Values outside the skeleton's limits are kept. The
/// first frame says which bones the motion has: bones of the skeleton that it lacks stay in their zero pose,
/// bones that the skeleton lacks are passed over, and notes (where not null) tell it. Throws ParseError: both
/// at once (a motion of another skeleton), no root, frames with other bones than the first, a bone twice in a
/// frame or with another number of values than its dofs, frame numbers that do not count up by one, a number
/// that is none, no frame.
MotionClip readAmc(const std::string& path, const AsfSkeleton& asf, double framesPerSecond = 120.0,
                   std::vector<Note>* notes = nullptr);
MotionClip parseAmc(std::string_view text, const std::string& file, const AsfSkeleton& asf,
                    double framesPerSecond = 120.0, std::vector<Note>* notes = nullptr);

/// A skeleton of any kind as ASF, angles in degrees. metresPerUnit decides the `:units length`. Every joint
/// but fixed ends becomes a bone with the frame of the bind pose as its axis; joints that turn about their
/// own z, y, x axes (any of them, in this order) keep their dofs and limits, all others get rx ry rz. Where
/// the children of a joint start at different places, bones without dofs lead there. Joints other than the
/// root lose translations: throws std::invalid_argument for those.
std::string formatAsf(const Skeleton& skeleton, double metresPerUnit = asfMetresPerUnit(0.45));
/// The motion that goes with formatAsf(skeleton).
std::string formatAmc(const Skeleton& skeleton, const MotionClip& clip,
                      double metresPerUnit = asfMetresPerUnit(0.45));

}  // namespace gelenk
