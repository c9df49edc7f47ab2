#include "kinematics/motion/motion_retarget.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Bones from a matched pair to the matched pairs directly below it.
struct Directions {
  std::vector<Vector3d> source, target;  ///< unit vectors in the rest poses
};

/// The turn about y from where the target faces to where the source faces, told from matched pairs of left
/// and right joints; identity where there are none.
Matrix3d facing(const Frames& source, const Frames& target, const std::vector<PlainName>& targetNames,
                const std::vector<int>& sourceOf) {
  Vector3d inSource = Vector3d::Zero(), inTarget = Vector3d::Zero();
  for (std::size_t t = 0; t < sourceOf.size(); ++t) {
    if (sourceOf[t] < 0 || targetNames[t].side == Side::Middle) continue;
    const double sign = targetNames[t].side == Side::Left ? 1.0 : -1.0;
    inSource += sign * source[sourceOf[t]].translation();
    inTarget += sign * target[t].translation();
  }
  inSource.y() = inTarget.y() = 0.0;
  if (!(inSource.norm() > 1e-6) || !(inTarget.norm() > 1e-6)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(std::atan2(inTarget.cross(inSource).y(), inTarget.dot(inSource)),
                           Vector3d::UnitY())
      .toRotationMatrix();
}

double lowest(const Frames& frames) {
  double y = frames[0].translation().y();
  for (const auto& frame : frames) y = std::min(y, frame.translation().y());
  return y;
}

/// The joint itself or the nearest one above whose first three axes are translations at right angles.
int movingJoint(const Skeleton& skeleton, int joint) {
  for (; joint >= 0; joint = skeleton.parent(joint)) {
    const auto& axes = skeleton.joint(joint).axes;
    if (axes.size() < 3 || !std::all_of(axes.begin(), axes.begin() + 3, [](const AxisDof& dof) {
          return dof.kind == AxisDof::Kind::Translation;
        }))
      continue;
    Matrix3d directions;
    for (int k = 0; k < 3; ++k) directions.col(k) = axes[k].axis;
    if ((directions.transpose() * directions).isIdentity(1e-9)) return joint;
  }
  return -1;
}

/// Everything about a pair of skeletons that no frame changes.
class Retargeter {
 public:
  Retargeter(const Skeleton& source, const Skeleton& target, const JointMatching& matching)
      : target_(target),
        sourceRest_(restFrames(source)),
        targetRest_(restFrames(target)),
        sourceOf_(target.jointCount(), -1),
        aligned_(target.jointCount()) {
    for (const JointMatch& match : matching.matches) sourceOf_[match.target] = match.source;
    std::vector<int> matchedAbove(target.jointCount(), -1);
    std::vector<Directions> directions(target.jointCount());
    for (int t = 0; t < target.jointCount(); ++t) {
      const int parent = target.parent(t);
      if (parent >= 0) matchedAbove[t] = sourceOf_[parent] >= 0 ? parent : matchedAbove[parent];
      if (sourceOf_[t] < 0) continue;
      if (top_ < 0) top_ = t;
      if (matchedAbove[t] < 0) continue;
      const Vector3d inSource =
          sourceRest_[sourceOf_[t]].translation() - sourceRest_[sourceOf_[matchedAbove[t]]].translation();
      const Vector3d inTarget = targetRest_[t].translation() - targetRest_[matchedAbove[t]].translation();
      if (!(inSource.norm() > 1e-9) || !(inTarget.norm() > 1e-9)) continue;
      directions[matchedAbove[t]].source.push_back(inSource.normalized());
      directions[matchedAbove[t]].target.push_back(inTarget.normalized());
    }
    // The path is the pelvis' where both have one: a rig's root may stand on the floor.
    const auto names = plainNames(target);
    for (int t = 0; t < target.jointCount(); ++t)
      if (sourceOf_[t] >= 0 && names[t] == PlainName{"pelvis"}) top_ = t;
    const Matrix3d whole = facing(sourceRest_, targetRest_, names, sourceOf_);
    for (int t = 0; t < target.jointCount(); ++t) {
      if (sourceOf_[t] < 0) continue;
      const Directions& bones = directions[t];
      const bool isBone = bones.target.size() == 1 && !target.isAncestor(t, top_);
      if (isBone)
        aligned_[t] = rotationBetween(bones.target[0], bones.source[0]).toRotationMatrix();
      else
        aligned_[t] = bones.target.empty() && matchedAbove[t] >= 0 ? aligned_[matchedAbove[t]] : whole;
    }
    moving_ = movingJoint(target, top_);
    sourceFloor_ = lowest(sourceRest_), targetFloor_ = lowest(targetRest_);
    const double from = sourceRest_[sourceOf_[top_]].translation().y() - sourceFloor_,
                 to = targetRest_[top_].translation().y() - targetFloor_;
    if (from > 1e-6 && to > 1e-6) scale_ = to / from;
  }

  double scale() const { return scale_; }
  bool rootMoves() const { return moving_ >= 0; }

  /// q: the pose of the frame before, whose angles choose between equivalent ones.
  void pose(const Frames& source, VectorXd& q) const {
    Frames frames(target_.jointCount());
    for (int t = 0; t < target_.jointCount(); ++t) {
      const Joint& joint = target_.joint(t);
      const Eigen::Isometry3d zero =
          joint.parent < 0 ? joint.parentFromZero : frames[joint.parent] * joint.parentFromZero;
      if (sourceOf_[t] >= 0) {
        const int s = sourceOf_[t];
        const Matrix3d wanted =
            source[s].linear() * sourceRest_[s].linear().transpose() * aligned_[t] * targetRest_[t].linear();
        setJointRotation(target_, q, t,
                         Quaterniond(Matrix3d(zero.linear().transpose() * wanted)).normalized());
      }
      frames[t] = zero * jointMotion(target_, q, t);
    }
    if (moving_ < 0) return;
    Vector3d place = source[sourceOf_[top_]].translation();
    place.y() -= sourceFloor_;
    place *= scale_;
    place.y() += targetFloor_;
    const Joint& joint = target_.joint(moving_);
    const Matrix3d zero = joint.parent < 0
                              ? Matrix3d(joint.parentFromZero.linear())
                              : Matrix3d(frames[joint.parent].linear() * joint.parentFromZero.linear());
    const Vector3d way = zero.transpose() * (place - frames[top_].translation());
    for (int k = 0; k < 3; ++k) q[target_.qIndex(moving_) + k] += joint.axes[k].axis.dot(way);
  }

 private:
  const Skeleton& target_;
  Frames sourceRest_, targetRest_;
  std::vector<int> sourceOf_;      ///< of each target joint; -1: none
  std::vector<Matrix3d> aligned_;  ///< A, of matched joints
  int top_ = -1, moving_ = -1;     ///< what carries the path, and the joint whose translations follow
  double sourceFloor_ = 0.0, targetFloor_ = 0.0, scale_ = 1.0;
};

}  // namespace

RetargetedClip retargeted(const Skeleton& source, const MotionClip& clip, const Skeleton& target) {
  validate(source, clip);
  RetargetedClip result{
      .clip = {.framesPerSecond = clip.framesPerSecond, .q = Eigen::MatrixXd(target.nq(), clip.frameCount())},
      .matching = matchJoints(source, target)};
  if (result.matching.matches.size() < 2)
    throw std::invalid_argument("the motion's joints have other names than the model's: " +
                                std::to_string(result.matching.matches.size()) + " of " +
                                std::to_string(target.jointCount()) + " match, two are needed");
  const Retargeter retargeter(source, target, result.matching);
  result.scale = retargeter.scale();
  result.rootMoves = retargeter.rootMoves();
  Frames frames;
  VectorXd q = target.rest();
  for (int f = 0; f < clip.frameCount(); ++f) {
    forwardKinematics(source, clip.q.col(f), frames);
    retargeter.pose(frames, q);
    result.clip.q.col(f) = q;
  }
  return result;
}

}  // namespace gelenk
