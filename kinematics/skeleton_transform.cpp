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
  const auto slides = [&](int i) { return joints[i].axes[0].kind == AxisDof::Kind::Translation; };
  for (const int i : skeleton.followers()) {
    Coupling& c = *joints[i].coupling;
    if (slides(i)) c.multiplier *= factor, c.offset *= factor;
    if (slides(c.source)) c.multiplier /= factor;
  }
  return Skeleton(std::move(joints), rest);
}

MotionClip scaled(const Skeleton& skeleton, MotionClip clip, double factor) {
  for (int i = 0; i < skeleton.jointCount(); ++i)
    for (std::size_t k = 0; k < skeleton.joint(i).axes.size(); ++k)
      if (skeleton.joint(i).axes[k].kind == AxisDof::Kind::Translation)
        clip.q.row(skeleton.qIndex(i) + k) *= factor;
  return clip;
}

StillTranslations withoutStillTranslations(const Skeleton& skeleton, const MotionClip& clip,
                                           double tolerance) {
  validate(skeleton, clip);
  std::vector<Joint> joints = skeleton.joints();
  std::vector<std::string> still;
  std::vector<int> kept;  // rows of q that stay
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    auto& axes = joints[i].axes;
    const int first = skeleton.qIndex(i),
              end = i + 1 < skeleton.jointCount() ? skeleton.qIndex(i + 1) : skeleton.nq();
    int count = 0;
    while (count < static_cast<int>(axes.size()) && axes[count].kind == AxisDof::Kind::Translation) ++count;
    const auto places = clip.q.middleRows(first, count);
    if (i == 0 || count == 0 || skeleton.isCoupled(i) ||
        (places.colwise() - places.col(0)).cwiseAbs().maxCoeff() > tolerance) {
      count = 0;
    } else {
      for (int k = 0; k < count; ++k) joints[i].parentFromZero.translate(axes[k].axis * places(k, 0));
      axes.erase(axes.begin(), axes.begin() + count);
      still.push_back(joints[i].name);
    }
    for (int row = first + count; row < end; ++row) kept.push_back(row);
  }
  return {.skeleton = Skeleton(std::move(joints), Eigen::VectorXd(skeleton.rest()(kept))),
          .clip = {.framesPerSecond = clip.framesPerSecond, .q = clip.q(kept, Eigen::all)},
          .joints = std::move(still)};
}

}  // namespace gelenk
