#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/model.h"
#include "skinning/blend/elastic_flesh.h"
#include "skinning/blend/skin_choice.h"

namespace gelenk {

/// A pose in which skins are compared, and where to look.
struct SkinPoseCase {
  std::string name;  ///< "elbow 90"
  Frames frames;
  /// What was turned since the bind pose, with all below it, about a world axis through it.
  struct Turn {
    int joint = -1;
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
    double angle = 0.0;  ///< radians
  } turn = {};
  /// The joint of a bone whose shaft does not hold the flesh: radius and ulna cross where a forearm twists.
  int freeBone = -1;
  Eigen::VectorXd q = {};  ///< where the pose comes from a motion; empty: no coordinates are known
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  ///< of the joint that moves, at rest
  double radius = 0.0;                               ///< of the part whose volume counts, metres
  std::vector<int> bones;                            ///< indices of SkinBones across which sections are laid
};
/// A bone of a limb in the bind pose.
struct SkinBone {
  std::string name;
  Eigen::Vector3d head, end;
};
struct SkinTrials {
  std::vector<SkinBone> bones;
  std::vector<FleshBone> rigid = {};  ///< of the whole skeleton, for the elastic reference
  std::vector<SkinPoseCase> poses;
};

/// The standard poses of whatever limbs, neck and spine the model has: parts turned as a whole about a joint
/// of the bind pose, so that they mean the same on every body, whatever its degrees of freedom. The left
/// side.
SkinTrials standardTrials(const Model& model);
/// Frames of a motion, at most `count` of them, evenly. Volume and sections are then the whole body's and all
/// limbs'.
SkinTrials motionTrials(const Model& model, const MotionClip& clip, int count);

struct SkinCell {
  std::string method, pose;
  int pairs = 0;                              ///< of triangles that pass through each other, beyond rest's
  double crease = 0.0;                        ///< degrees, skin_measures.h
  double section = 1.0;                       ///< smallest, of rest
  double volume = 0.0;                        ///< change of the part's, of rest
  double normalMean = 0.0, normalMost = 0.0;  ///< degrees, mean and 95 % of vertices of several bones
  /// Against the elastic reference, where there is one and it does not run through itself: difference of the
  /// volume changes, and rms distance of the part's vertices to its surface, metres.
  std::optional<double> volumeOff, distance;
};
/// Costs of a method, of the model as a whole.
struct SkinCost {
  std::string method;
  double prepareSeconds = 0.0;
  double timesLbs = 0.0;       ///< processor, gradient normals; medians of rounds with all methods in each
  double timesLbsCheap = 0.0;  ///< with cheap normals
  double nanoseconds = 0.0;    ///< a vertex, cheap normals
  int bytes = 0;               ///< a vertex beyond linear blending's
  double largestStep =
      -1.0;  ///< millimetres per 0.1 degree of forearm twist, -200 to 200; below 0: no forearm
};
struct SkinComparison {
  std::vector<SkinChoice> methods;
  std::vector<SkinCell> cells;
  std::vector<SkinCost> costs;
  std::vector<SkinCell> reference;  ///< the elastic flesh's own, where it was asked for
};

/// timing: measure costs too. reference: compute the elastic reference of every pose that turns a limb, and
/// compare with it (minutes). progress: share done and what is being done.
SkinComparison compareSkins(const Model& model, const std::vector<SkinChoice>& methods,
                            const SkinTrials& trials, bool timing, bool reference,
                            const std::function<void(double, const std::string&)>& progress,
                            const std::function<void(const SkinChoice&, const SkinPoseCase&, const Mesh&,
                                                     const SkinnedVertices&)>& picture = {});

std::string toCsv(const std::vector<SkinCell>& cells);
std::string toCsv(const std::vector<SkinCost>& costs);  ///< what was not measured is an empty cell

}  // namespace gelenk
