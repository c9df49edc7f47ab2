#include "kinematics/skeleton_transform.h"

#include <stdexcept>

namespace gelenk {

Skeleton rotated(const Skeleton& skeleton, const Eigen::Quaterniond& worldFromOld) {
  std::vector<Joint> joints = skeleton.joints();
  joints[0].parentFromZero = Eigen::Isometry3d(worldFromOld.normalized()) * joints[0].parentFromZero;
  return Skeleton(std::move(joints), skeleton.rest());
}

Skeleton scaled(const Skeleton& skeleton, double factor) {
  if (!(factor > 0.0)) throw std::invalid_argument("a scale must be positive");
  std::vector<Joint> joints = skeleton.joints();
  Eigen::VectorXd rest = skeleton.rest();
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    joints[i].parentFromZero.translation() *= factor;
    for (std::size_t k = 0; k < joints[i].axes.size(); ++k) {
      AxisDof& dof = joints[i].axes[k];
      if (dof.kind != AxisDof::Kind::Translation) continue;
      dof.lower *= factor, dof.upper *= factor;
      rest[skeleton.qIndex(i) + k] *= factor;
    }
  }
  return Skeleton(std::move(joints), rest);
}

MotionClip scaled(const Skeleton& skeleton, MotionClip clip, double factor) {
  for (int i = 0; i < skeleton.jointCount(); ++i)
    for (std::size_t k = 0; k < skeleton.joint(i).axes.size(); ++k)
      if (skeleton.joint(i).axes[k].kind == AxisDof::Kind::Translation) clip.q.row(skeleton.qIndex(i) + k) *= factor;
  return clip;
}

}  // namespace gelenk
