#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/skeleton.h"

namespace gelenk {

/// The skeleton file of the German OpenGL tutorial (programs 21 and 22). No public reader exists, the text is
/// the only specification; docs/formats/tutorial.md says what it leaves open. Joints are indices from 0.
struct TutorialSkeleton {
  struct Group {
    std::string name;         ///< without the prefix "NumJoints-"
    std::vector<int> joints;  ///< the first stands at the top
    bool operator==(const Group&) const = default;
  };
  std::vector<Eigen::Vector3d> positions;  ///< in the model's coordinates, metres here
  std::vector<std::array<int, 2>> bones;   ///< (joint that bends, end joint)
  std::vector<Group> groups;               ///< movement groups; the spine's comes first
};

/// Angles of every joint about x, y and z, radians. The default pose has all zero.
using TutorialPose = std::vector<Eigen::Vector3d>;

/// Lists may end in a comma. A section may be there twice if both say the same. Throws ParseError: counts
/// that do not fit the lists, a joint that does not exist, a joint with two parents, no or two roots, a
/// cycle, a bone of zero length, a group with a step that is no bone, a bone in no group or in two, a group
/// whose top is in no group before it.
TutorialSkeleton readTutorialSkeleton(const std::string& path);
TutorialSkeleton parseTutorialSkeleton(std::string_view text, const std::string& file);
/// Six decimals, as in the tutorial, where they hold the value; else the shortest text that does. Reads back
/// bit for bit.
std::string formatTutorialSkeleton(const TutorialSkeleton& skeleton);

/// Throws ParseError: counts that do not fit, a number that is none; repeated sections as above.
TutorialPose readTutorialPose(const std::string& path);
TutorialPose parseTutorialPose(std::string_view text, const std::string& file);
std::string formatTutorialPose(const TutorialPose& pose);

/// The figure as an articulated model: every joint turns about x, then y, then z of the model's axes (R = Rz
/// Ry Rx), frames parallel to the world's in the zero pose; joints are called "joint0" and so on and come
/// parents first.
struct TutorialFigure {
  Skeleton skeleton;
  std::vector<int> jointOfIndex;  ///< joint of the skeleton for each index of the file
};
TutorialFigure toSkeleton(const TutorialSkeleton& tutorial);

/// Pose and configuration hold the same numbers in another order. Throw std::invalid_argument for another
/// number of joints.
Eigen::VectorXd configuration(const TutorialFigure& figure, const TutorialPose& pose);
TutorialPose tutorialPose(const TutorialFigure& figure, const Eigen::VectorXd& q);

/// Any skeleton in the tutorial's form: positions of the bind pose, joints in their order, groups along the
/// chains. Angles of joints that do not turn about their own axes in that order need tutorialPose of the
/// figure that is read back.
TutorialSkeleton toTutorialSkeleton(const Skeleton& skeleton);

}  // namespace gelenk
