#include "skinning/blend/twist_spread.h"

#include <cmath>

namespace gelenk {
namespace {

using Eigen::Vector3d;

double axialTurn(const std::vector<Eigen::Isometry3d>& worldFromRest, int parent, int joint,
                 const Vector3d& axis, const TwistCoordinate& coordinate, const Eigen::VectorXd* q) {
  const Eigen::Quaterniond turn(worldFromRest[parent].linear().transpose() * worldFromRest[joint].linear());
  double tau = 2.0 * std::atan2(turn.vec().dot(axis), turn.w());
  if (tau > M_PI) tau -= 2.0 * M_PI;
  if (tau <= -M_PI) tau += 2.0 * M_PI;
  return withWholeTurns(tau, coordinate, q);
}

}  // namespace

TwistCoordinate coordinateAbout(const Skeleton& skeleton, const Frames& bound, int joint,
                                const Vector3d& axis) {
  constexpr double along = 0.999;  // of unit vectors
  const std::vector<AxisDof>& axes = skeleton.joint(joint).axes;
  if (axes.empty() || skeleton.joint(joint).ball || axes.back().kind != AxisDof::Kind::Rotation) return {};
  const double cosine = axis.dot(bound[joint].linear() * axes.back().axis);
  if (std::abs(cosine) < along) return {};
  const int index = skeleton.qIndex(joint) + static_cast<int>(axes.size()) - 1;
  return {.index = index, .sign = cosine > 0.0 ? 1.0 : -1.0, .rest = skeleton.rest()[index]};
}

double withWholeTurns(double tau, const TwistCoordinate& coordinate, const Eigen::VectorXd* q) {
  if (!q || coordinate.index < 0) return tau;
  const double known = coordinate.sign * ((*q)[coordinate.index] - coordinate.rest);
  return tau + 2.0 * M_PI * std::round((known - tau) / (2.0 * M_PI));
}

TwistSpread spreadTwist(const Skeleton& skeleton, const Frames& bound,
                        const std::vector<std::vector<int>>& chains) {
  TwistSpread spread;
  for (const std::vector<int>& chain : chains)
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      TwistBone bone{.joint = chain[i], .parent = skeleton.parent(chain[i])};
      bone.head = bound[chain[i]].translation();
      const Vector3d along = bound[chain[i + 1]].translation() - bone.head;
      bone.length = along.norm();
      if (bone.parent < 0 || !(bone.length > 1e-9)) continue;
      bone.axis = along / bone.length;
      bone.own = coordinateAbout(skeleton, bound, bone.joint, bone.axis);
      if (i + 2 == chain.size()) {
        bone.child = chain[i + 1];
        bone.ofChild = coordinateAbout(skeleton, bound, bone.child, bone.axis);
      }
      spread.bones.push_back(bone);
    }
  return spread;
}

std::vector<BoneTwist> boneTwists(const TwistSpread& spread,
                                  const std::vector<Eigen::Isometry3d>& worldFromRest,
                                  const Eigen::VectorXd* q) {
  std::vector<BoneTwist> twists;
  for (const TwistBone& bone : spread.bones) {
    BoneTwist twist{.atHead = -axialTurn(worldFromRest, bone.parent, bone.joint, bone.axis, bone.own, q)};
    if (bone.child >= 0)
      twist.atEnd = axialTurn(worldFromRest, bone.joint, bone.child, bone.axis, bone.ofChild, q);
    twists.push_back(twist);
  }
  return twists;
}

}  // namespace gelenk
