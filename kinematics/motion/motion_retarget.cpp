#include "kinematics/motion/motion_retarget.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/motion/motion_edit.h"
#include "kinematics/motion/standing.h"
#include "kinematics/rotation.h"
#include "kinematics/skeleton_transform.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double standsAbove = 0.8;  // 37 degrees from upright

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

/// The rotation that brings the target's directions nearest to the source's: least sum of squares (Kabsch
/// 1976).
Matrix3d nearestRotation(const Directions& bones) {
  Matrix3d M = Matrix3d::Zero();
  for (std::size_t k = 0; k < bones.target.size(); ++k) M += bones.source[k] * bones.target[k].transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  if ((U * svd.matrixV().transpose()).determinant() < 0.0) U.col(2) = -U.col(2);
  return U * svd.matrixV().transpose();
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

/// A joint that brings its bone about one axis, and the ball above whose twist helps it.
struct Hinge {
  int axis = -1;   ///< position in the joint's axes; -1: no hinge
  int twist = -1;  ///< of a second axis along the bone; -1: none
  int ball = -1;   ///< -1: nothing above can help
};

bool isBall(const Joint& joint) {
  if (joint.ball) return true;
  std::vector<Vector3d> axes;
  for (const AxisDof& dof : joint.axes)
    if (dof.kind == AxisDof::Kind::Rotation) axes.push_back(dof.axis);
  return axes.size() == 3 && std::abs(axes[0].dot(axes[1])) < 1e-9 && std::abs(axes[0].dot(axes[2])) < 1e-9 &&
         std::abs(axes[1].dot(axes[2])) < 1e-9;
}

double angleBetween(const Vector3d& a, const Vector3d& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Angle about the unit axis that turns a towards b; `otherwise` where one of them lies along the axis.
double angleAbout(const Vector3d& axis, const Vector3d& a, const Vector3d& b, double otherwise) {
  const Vector3d p = a - axis.dot(a) * axis, q = b - axis.dot(b) * axis;
  if (!(p.norm() > 1e-9 * a.norm()) || !(q.norm() > 1e-9 * b.norm())) return otherwise;
  return std::atan2(axis.dot(p.cross(q)), p.dot(q));
}

double nearestTurn(double angle, double hint) {
  return angle + 2.0 * M_PI * std::round((hint - angle) / (2.0 * M_PI));
}

/// The turning joints between pelvis and neck (or head), from below; empty where names do not tell.
std::vector<int> spineOf(const Skeleton& skeleton) {
  const auto names = plainNames(skeleton);
  const auto named = [&](const char* part) {
    const auto at = std::find(names.begin(), names.end(), PlainName{part});
    return at == names.end() ? -1 : static_cast<int>(at - names.begin());
  };
  const int pelvis = named("pelvis"), neck = named("neck") >= 0 ? named("neck") : named("head");
  std::vector<int> spine;
  if (pelvis < 0 || neck < 0 || !skeleton.isAncestor(pelvis, neck)) return spine;
  for (int j = skeleton.parent(neck); j > pelvis; j = skeleton.parent(j))
    if (skeleton.vCount(j) > 0) spine.push_back(j);
  std::reverse(spine.begin(), spine.end());
  return spine;
}

/// Every maker counts the spine's joints otherwise: those that no name has matched are paired from below,
/// each run of them between two that names have.
void matchSpines(const Skeleton& source, const Skeleton& target, JointMatching& matching) {
  std::vector<int> from = spineOf(source);
  const std::vector<int> onto = spineOf(target);
  for (const JointMatch& match : matching.matches)
    if (std::find(onto.begin(), onto.end(), match.target) == onto.end()) std::erase(from, match.source);
  const auto placeInSource = [&](int t) {  // -1: not matched
    for (const JointMatch& match : matching.matches)
      if (match.target == t)
        return static_cast<int>(std::find(from.begin(), from.end(), match.source) - from.begin());
    return -1;
  };
  std::vector<JointMatch> found;
  int low = 0;
  for (std::size_t i = 0; i < onto.size();) {
    std::size_t end = i;
    while (end < onto.size() && placeInSource(onto[end]) < 0) ++end;
    const int high = end < onto.size() ? placeInSource(onto[end]) : static_cast<int>(from.size());
    const int wanted = static_cast<int>(end - i), there = high - low, n = std::min(wanted, there);
    for (int k = 0; k < n; ++k) found.push_back({from[low + k * there / n], onto[i + k * wanted / n]});
    low = high + 1;
    i = end + 1;
  }
  for (const JointMatch& match : found) {
    std::erase(matching.unmatchedSource, source.joint(match.source).name);
    std::erase(matching.unmatchedTarget, target.joint(match.target).name);
  }
  matching.matches.insert(matching.matches.end(), found.begin(), found.end());
  std::sort(matching.matches.begin(), matching.matches.end(),
            [](const JointMatch& a, const JointMatch& b) { return a.target < b.target; });
}

/// Everything about a pair of skeletons that no frame changes.
class Retargeter {
 public:
  Retargeter(const Skeleton& source, const MotionClip& clip, const Skeleton& target,
             const JointMatching& matching, const RetargetOptions& options)
      : source_(source),
        target_(target),
        standing_(standingPose(source, clip, standingParts(source), Vector3d::UnitY())),
        targetRest_(restFrames(target)),
        sourceOf_(target.jointCount(), -1),
        childOf_(target.jointCount(), -1),
        aligned_(target.jointCount()),
        hinges_(target.jointCount()),
        twists_(target.jointCount(), 0.0) {
    const Frames& sourceRest = standing_.frames;
    for (const JointMatch& match : matching.matches) sourceOf_[match.target] = match.source;
    std::vector<int> matchedAbove(target.jointCount(), -1);
    std::vector<Directions> directions(target.jointCount());
    double sourceLengths = 0.0, targetLengths = 0.0;
    for (int t = 0; t < target.jointCount(); ++t) {
      const int parent = target.parent(t);
      if (parent >= 0) matchedAbove[t] = sourceOf_[parent] >= 0 ? parent : matchedAbove[parent];
      if (sourceOf_[t] < 0) continue;
      if (top_ < 0) top_ = t;
      if (matchedAbove[t] < 0) continue;
      const Vector3d inSource =
          sourceRest[sourceOf_[t]].translation() - sourceRest[sourceOf_[matchedAbove[t]]].translation();
      const Vector3d inTarget = targetRest_[t].translation() - targetRest_[matchedAbove[t]].translation();
      if (!(inSource.norm() > 1e-9) || !(inTarget.norm() > 1e-9)) continue;
      directions[matchedAbove[t]].source.push_back(inSource.normalized());
      directions[matchedAbove[t]].target.push_back(inTarget.normalized());
      childOf_[matchedAbove[t]] = t;
      sourceLengths += inSource.norm(), targetLengths += inTarget.norm();
    }
    // The path is the pelvis' where both have one: a rig's root may stand on the floor.
    const auto names = plainNames(target);
    for (int t = 0; t < target.jointCount(); ++t)
      if (sourceOf_[t] >= 0 && names[t] == PlainName{"pelvis"}) top_ = t;
    const Matrix3d whole = facing(sourceRest, targetRest_, names, sourceOf_);
    const StandingParts sourceParts = standingParts(source), targetParts = standingParts(target);
    targetStands_ =
        targetParts.empty() || uprightness(targetParts, targetRest_, Vector3d::UnitY()) >= standsAbove;
    // Where both stand, the trunk keeps its own shape: rigs differ in where a spine bends and a collar bone
    // begins.
    const bool stand =
        !sourceParts.empty() && !targetParts.empty() && targetStands_ && standing_.uprightness >= standsAbove;
    for (int t = 0; t < target.jointCount(); ++t) {
      if (sourceOf_[t] < 0) continue;
      const Directions& bones = directions[t];
      const bool ofTrunk = stand && (names[t].side == Side::Middle || names[t].part == "clavicle");
      const bool isBone = bones.target.size() == 1 && !target.isAncestor(t, top_) && !ofTrunk;
      if (!isBone) childOf_[t] = -1;
      if (isBone)
        aligned_[t] = rotationBetween(bones.target[0], bones.source[0]).toRotationMatrix();
      else if (!targetStands_ && bones.target.size() > 1)
        aligned_[t] = nearestRotation(bones);
      else
        aligned_[t] = bones.target.empty() && matchedAbove[t] >= 0 ? aligned_[matchedAbove[t]] : whole;
    }
    for (int t = 0; t < target.jointCount(); ++t)
      if (childOf_[t] >= 0) hinges_[t] = hingeAt(t, directions);
    moving_ = movingJoint(target, top_);
    if (sourceParts.legs.size() == 2 && targetParts.legs.size() == 2)
      for (int k = 0; k < 2; ++k) {
        sourceHips_.push_back(sourceParts.legs[k].hip);
        targetHips_.push_back(targetParts.legs[k].hip);
      }
    findScale(sourceLengths, targetLengths, options);
    findFloors(clip);
    const double ankles = ankleHeight(sourceParts, standing_.frames);
    sourceFloor_ += ankles;
    targetFloor_ += targetStands_ ? ankleHeight(targetParts, targetRest_) : scale_ * ankles;
  }

  double scale() const { return scale_; }
  bool rootMoves() const { return moving_ >= 0; }
  const StandingPose& standing() const { return standing_; }
  const std::vector<int>& sourceOf() const { return sourceOf_; }

  /// q: the pose of the frame before, whose angles choose between equivalent ones.
  void pose(const Frames& source, VectorXd& q) {
    Frames& frames = frames_;
    frames.resize(target_.jointCount());
    for (int t = 0; t < target_.jointCount(); ++t) {
      if (sourceOf_[t] >= 0) {
        const Matrix3d wanted = wantedRotation(source, t);
        if (hinges_[t].axis >= 0) {
          poseHinge(t, wanted, q, frames);
        } else {
          setJointRotation(
              target_, q, t,
              Quaterniond(Matrix3d(zeroFrame(t, frames).linear().transpose() * wanted)).normalized());
        }
      }
      frames[t] = zeroFrame(t, frames) * jointMotion(target_, q, t);
    }
    if (moving_ < 0) return;
    const Joint& joint = target_.joint(moving_);
    const Matrix3d zero = joint.parent < 0
                              ? Matrix3d(joint.parentFromZero.linear())
                              : Matrix3d(frames[joint.parent].linear() * joint.parentFromZero.linear());
    const Vector3d way = zero.transpose() * (placeOf(pathPoint(source, sourceHips_, sourceOf_[top_])) -
                                             pathPoint(frames, targetHips_, top_));
    for (int k = 0; k < 3; ++k) q[target_.qIndex(moving_) + k] += joint.axes[k].axis.dot(way);
  }

  /// The source's place in the target's world.
  Vector3d placeOf(Vector3d place) const {
    place.y() -= sourceFloor_;
    place *= scale_;
    place.y() += targetFloor_;
    return place;
  }

  Matrix3d wantedRotation(const Frames& source, int t) const {
    const int s = sourceOf_[t];
    return source[s].linear() * standing_.frames[s].linear().transpose() * aligned_[t] *
           targetRest_[t].linear();
  }

  /// Of every bone with one matched end: the angle between where it points and where it should, else NaN.
  double remaining(const Frames& source, const Frames& posed, int t) const {
    if (sourceOf_[t] < 0 || childOf_[t] < 0) return std::nan("");
    const Vector3d bone = targetRest_[t].linear().transpose() *
                          (targetRest_[childOf_[t]].translation() - targetRest_[t].translation());
    return angleBetween(wantedRotation(source, t) * bone,
                        posed[childOf_[t]].translation() - posed[t].translation());
  }

 private:
  /// What the path is of: the middle of both hips, since rigs put their pelvis or root where they like.
  static Vector3d pathPoint(const Frames& frames, const std::vector<int>& hips, int otherwise) {
    if (hips.empty()) return frames[otherwise].translation();
    return 0.5 * (frames[hips[0]].translation() + frames[hips[1]].translation());
  }

  Eigen::Isometry3d zeroFrame(int t, const Frames& frames) const {
    const Joint& joint = target_.joint(t);
    return joint.parent < 0 ? joint.parentFromZero : frames[joint.parent] * joint.parentFromZero;
  }

  /// The bone in the joint's own frame, as it is at rest.
  Vector3d boneOf(int t) const {
    return (targetRest_[t].linear().transpose() *
            (targetRest_[childOf_[t]].translation() - targetRest_[t].translation()))
        .normalized();
  }

  Hinge hingeAt(int t, const std::vector<Directions>& directions) const {
    const Joint& joint = target_.joint(t);
    Hinge hinge;
    if (joint.ball) return hinge;
    for (int k = 0; k < static_cast<int>(joint.axes.size()); ++k) {
      const AxisDof& dof = joint.axes[k];
      if (dof.kind != AxisDof::Kind::Rotation) continue;
      if (hinge.axis < 0)
        hinge.axis = k;
      else if (hinge.twist < 0 && std::abs(dof.axis.dot(boneOf(t))) > 0.99)
        hinge.twist = k;
      else
        return {};
    }
    if (hinge.axis < 0) return hinge;
    int above = joint.parent;
    while (above >= 0 && target_.vCount(above) == 0 && sourceOf_[above] < 0) above = target_.parent(above);
    if (above >= 0 && sourceOf_[above] >= 0 && isBall(target_.joint(above)) &&
        directions[above].target.size() == 1 && childOf_[above] == t)
      hinge.ball = above;
    return hinge;
  }

  /// Twists the ball above about its bone, then turns the hinge, so that its own bone points along the wanted
  /// one. The hinge's axis h keeps its angle with the bone f: the twist by phi about u has to bring it to
  /// h(phi) . d = h . f, which is X cos phi + Y sin phi = Z.
  void poseHinge(int t, const Matrix3d& wanted, VectorXd& q, Frames& frames) {
    const Hinge& hinge = hinges_[t];
    const AxisDof& dof = target_.joint(t).axes[hinge.axis];
    const Vector3d bone = boneOf(t), direction = wanted * bone;
    double& angle = q[target_.qIndex(t) + hinge.axis];
    const auto angleFor = [&](const Matrix3d& zero) {
      return nearestTurn(angleAbout(dof.axis, bone, zero.transpose() * direction, angle), angle);
    };
    Eigen::Isometry3d zero = zeroFrame(t, frames);
    if (hinge.ball >= 0) {
      const Vector3d u = (zero.translation() - frames[hinge.ball].translation()).normalized();
      const Vector3d h = zero.linear() * dof.axis, across = h - u.dot(h) * u;
      const double X = across.dot(direction), Y = u.cross(across).dot(direction),
                   Z = dof.axis.dot(bone) - u.dot(h) * u.dot(direction), R = std::hypot(X, Y);
      double twist = twists_[t];
      constexpr double straight = 0.03;  // where any twist does: that of the frame before
      if (u.allFinite() && u.cross(direction).norm() > straight && R > 1e-6) {
        const double middle = std::atan2(Y, X), half = std::acos(std::clamp(Z / R, -1.0, 1.0));
        double best = unlimited;
        for (const double candidate : {middle - half, middle + half}) {
          const double phi = nearestTurn(candidate, twists_[t]);
          const Matrix3d turned = Eigen::AngleAxisd(phi, u) * zero.linear();
          const double theta = std::remainder(angleFor(turned), 2.0 * M_PI);
          const double outside = std::max({0.0, dof.lower - theta, theta - dof.upper});
          const double cost = 10.0 * outside + std::abs(phi - twists_[t]);
          if (cost < best) best = cost, twist = phi;
        }
      }
      twists_[t] = std::remainder(twist, 2.0 * M_PI);
      const Matrix3d turned = Eigen::AngleAxisd(twist, u) * frames[hinge.ball].linear();
      setJointRotation(
          target_, q, hinge.ball,
          Quaterniond(Matrix3d(zeroFrame(hinge.ball, frames).linear().transpose() * turned)).normalized());
      for (int i = hinge.ball; i < t; ++i)
        if (target_.isAncestor(hinge.ball, i)) frames[i] = zeroFrame(i, frames) * jointMotion(target_, q, i);
      zero = zeroFrame(t, frames);
    }
    angle = angleFor(zero.linear());
    if (hinge.twist < 0) return;
    const Vector3d& along = target_.joint(t).axes[hinge.twist].axis;
    const Quaterniond left(
        Matrix3d((zero.linear() * Eigen::AngleAxisd(angle, dof.axis)).transpose() * wanted));
    double& turn = q[target_.qIndex(t) + hinge.twist];
    turn = nearestTurn(2.0 * std::atan2(left.vec().dot(along), left.w()), turn);
  }

  void findScale(double sourceLengths, double targetLengths, const RetargetOptions& options) {
    if (options.scale) {
      scale_ = *options.scale;
      return;
    }
    const double from = legLength(source_, standingParts(source_), standing_.frames),
                 to = legLength(target_, standingParts(target_), targetRest_);
    if (from > 1e-9 && to > 1e-9)
      scale_ = to / from;
    else if (sourceLengths > 1e-9)
      scale_ = targetLengths / sourceLengths;
  }

  /// Of the feet's joints over the lowest joint where the body stands: heights scale above them, so that legs
  /// of other lengths stand as straight and every foot keeps its own height. 0 without legs.
  static double ankleHeight(const StandingParts& parts, const Frames& frames) {
    double sum = 0.0;
    for (const StandingParts::Leg& leg : parts.legs)
      sum += frames[leg.foot].translation().y() - lowest(frames);
    return parts.legs.empty() ? 0.0 : sum / static_cast<double>(parts.legs.size());
  }

  void findFloors(const MotionClip& clip) {
    const StandingParts parts = standingParts(source_);
    const double sourceLegs = legLength(source_, parts, standing_.frames),
                 targetLegs = legLength(target_, standingParts(target_), targetRest_);
    const double sourceLowest = lowest(standing_.frames), targetLowest = lowest(targetRest_);
    const bool targetOnFloor =
        targetStands_ && (!(targetLegs > 0.0) || std::abs(targetLowest) < 0.1 * targetLegs);
    const bool sourceOnFloor =
        standing_.frame < 0 && (!(sourceLegs > 0.0) || std::abs(sourceLowest) < 0.1 * sourceLegs);
    std::vector<double> upright, all;
    Frames frames;
    for (int f = 0; f < clip.frameCount(); ++f) {
      forwardKinematics(source_, clip.q.col(f), frames);
      all.push_back(lowest(frames));
      if (!parts.empty() && uprightness(parts, frames, Vector3d::UnitY()) >= standsAbove)
        upright.push_back(all.back());
    }
    std::vector<double>& heights = 2 * upright.size() >= all.size() ? upright : all;
    const auto tenth = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 10);
    std::nth_element(heights.begin(), tenth, heights.end());
    // A rest pose on the floor counts unless the body plainly stands elsewhere in most frames.
    const bool elsewhere = &heights == &upright && std::abs(*tenth - sourceLowest) > 0.2 * sourceLegs;
    sourceFloor_ = sourceOnFloor && !elsewhere ? sourceLowest : *tenth;
    // A target that rests with its root at the origin does not say where its floor is: the source's, if near
    // 0.
    targetFloor_ = targetOnFloor                               ? targetLowest
                   : std::abs(sourceFloor_) < 0.2 * sourceLegs ? scale_ * sourceFloor_
                                                               : 0.0;
  }

  const Skeleton& source_;
  const Skeleton& target_;
  StandingPose standing_;
  Frames targetRest_, frames_;
  std::vector<int> sourceOf_;  ///< of each target joint; -1: none
  std::vector<int> childOf_;  ///< the matched joint that a matched joint's bone leads to; -1: none or several
  std::vector<Matrix3d> aligned_;  ///< A, of matched joints
  std::vector<Hinge> hinges_;
  bool targetStands_ = true;    ///< at rest
  std::vector<double> twists_;  ///< of the ball above each hinge, of the frame before
  int top_ = -1, moving_ = -1;  ///< what carries the path, and the joint whose translations follow
  std::vector<int> sourceHips_, targetHips_;  ///< both hips of both bodies; else empty
  double sourceFloor_ = 0.0, targetFloor_ = 0.0, scale_ = 1.0;
};

/// The turning joints of a limb from its root to the joint above its end.
std::vector<int> limbAbove(const Skeleton& skeleton, int end, std::string_view first) {
  const auto names = plainNames(skeleton);
  std::vector<int> limb;
  for (int j = skeleton.parent(end); j >= 0; j = skeleton.parent(j)) {
    if (skeleton.vCount(j) > 0) limb.push_back(j);
    if (names[j].part == first) break;
  }
  return limb;
}

/// How near and how far from its root a limb's end can be by the lengths of its bones.
struct LimbReach {
  double least = 0.0, most = 0.0;  ///< metres
};
LimbReach limbReach(const Frames& frames, const std::vector<int>& limb, int end) {
  double longest = 0.0, sum = 0.0;
  for (const int joint : limb) {
    const double bone = (frames[end].translation() - frames[joint].translation()).norm();
    longest = std::max(longest, bone), sum += bone;
    end = joint;
  }
  return {std::max(0.0, 2.0 * longest - sum), sum};
}

/// Puts the ends of limbs where the source has them and turns them as before.
void keepPlaces(const Skeleton& source, const MotionClip& clip, const Skeleton& target, const char* end,
                const char* first, bool onFloor, const Retargeter& retargeter, RetargetedClip& result) {
  const auto names = plainNames(target);
  for (int t = 0; t < target.jointCount(); ++t) {
    const int s = retargeter.sourceOf()[t];
    if (names[t].part != end || names[t].side == Side::Middle || s < 0) continue;
    const std::vector<int> limb = limbAbove(target, t, first);
    const LimbReach reach = limbReach(restFrames(target), limb, t);
    KeptPlace kept{.joint = t};
    double sourceWay = 0.0, targetWay = 0.0;
    Vector3d lastSource = Vector3d::Zero(), lastTarget = lastSource;
    for (int f = 0; f < clip.frameCount(); ++f) {
      const Frames from = forwardKinematics(source, clip.q.col(f));
      VectorXd q = result.clip.q.col(f);
      const Matrix3d turn = forwardKinematics(target, q)[t].linear();
      const Vector3d scaled = retargeter.placeOf(from[s].translation());
      const double left = reachWithLeastChange(target, q, t, scaled, limb);
      const Frames posed = forwardKinematics(target, q);
      const Matrix3d zero = posed[target.parent(t)].linear() * target.joint(t).parentFromZero.linear();
      setJointRotation(target, q, t, Quaterniond(Matrix3d(zero.transpose() * turn)).normalized());
      result.clip.q.col(f) = q;
      kept.mean += left / clip.frameCount();
      kept.largest = std::max(kept.largest, left);
      const double wanted = limb.empty() ? 0.0 : (scaled - posed[limb.back()].translation()).norm();
      if (wanted < reach.least || wanted > reach.most)
        ++kept.framesBeyond;
      else
        kept.largestWithin = std::max(kept.largestWithin, left);
      if (f > 0 && onFloor) {  // standing: slower than 0.3 m/s in the target's size
        const double way = (scaled - lastSource).norm();
        if (way * clip.framesPerSecond < 0.3) {
          sourceWay += (scaled - lastSource).head<3>().cwiseProduct(Vector3d(1, 0, 1)).norm();
          targetWay += (posed[t].translation() - lastTarget).cwiseProduct(Vector3d(1, 0, 1)).norm();
          ++kept.contactFrames;
        }
      }
      lastSource = scaled, lastTarget = posed[t].translation();
    }
    if (kept.contactFrames > 0)
      kept.sourceSlide = sourceWay / kept.contactFrames, kept.targetSlide = targetWay / kept.contactFrames;
    result.kept.push_back(kept);
  }
}

RetargetedClip retargetedUpright(const Skeleton& source, const MotionClip& clip, const Skeleton& target,
                                 const RetargetOptions& options, RetargetedClip result) {
  Retargeter retargeter(source, clip, target, result.matching, options);
  result.scale = retargeter.scale();
  result.rootMoves = retargeter.rootMoves();
  result.standingFrame = retargeter.standing().frame;
  result.uprightness = retargeter.standing().uprightness;
  Frames frames;
  VectorXd q = target.rest();
  for (int f = 0; f < clip.frameCount(); ++f) {
    forwardKinematics(source, clip.q.col(f), frames);
    retargeter.pose(frames, q);
    result.clip.q.col(f) = q;
  }
  if (options.keepFeet) keepPlaces(source, clip, target, "foot", "thigh", true, retargeter, result);
  if (options.keepHands) keepPlaces(source, clip, target, "hand", "upperarm", false, retargeter, result);
  for (int t = 0; t < target.jointCount(); ++t) {
    RemainingAngle angle{.joint = t};
    for (int f = 0; f < clip.frameCount(); ++f) {
      forwardKinematics(source, clip.q.col(f), frames);
      const double left = retargeter.remaining(frames, forwardKinematics(target, result.clip.q.col(f)), t);
      if (std::isnan(left)) break;
      angle.mean += left / clip.frameCount();
      angle.largest = std::max(angle.largest, left);
      if (f + 1 == clip.frameCount()) result.remaining.push_back(angle);
    }
  }
  return result;
}

/// To y up, for the two axes there are.
Quaterniond upright(const Vector3d& up) {
  return up.z() > 0.5 ? Quaterniond(Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()))
                      : Quaterniond::Identity();
}

}  // namespace

RetargetedClip retargeted(const Skeleton& source, const MotionClip& clip, const Skeleton& target,
                          const RetargetOptions& options) {
  validate(source, clip);
  if (options.scale && !(*options.scale > 0.0 && std::isfinite(*options.scale)))
    throw std::invalid_argument("the scale of a path must be positive");
  RetargetedClip result{
      .clip = {.framesPerSecond = clip.framesPerSecond, .q = Eigen::MatrixXd(target.nq(), clip.frameCount())},
      .matching = matchJoints(source, target)};
  if (result.matching.matches.size() < 2)
    throw std::invalid_argument("the motion's joints have other names than the model's: " +
                                std::to_string(result.matching.matches.size()) + " of " +
                                std::to_string(target.jointCount()) + " match, two are needed");
  matchSpines(source, target, result.matching);
  result.sourceUp = options.sourceUp ? *options.sourceUp : upOf(source, clip, standingParts(source));
  const bool turnSource = result.sourceUp.z() > 0.5, turnTarget = options.targetUp.z() > 0.5;
  if (!turnSource && !turnTarget) return retargetedUpright(source, clip, target, options, std::move(result));
  // Configurations mean the same poses in a skeleton that is turned as a whole.
  return retargetedUpright(turnSource ? rotated(source, upright(result.sourceUp)) : source, clip,
                           turnTarget ? rotated(target, upright(options.targetUp)) : target, options,
                           std::move(result));
}

}  // namespace gelenk
