#include "skinning/rigging/fit/rig_transfer.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <stdexcept>

#include "kinematics/forward_kinematics.h"
#include "kinematics/motion/joint_matching.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// Rotation and scale that bring the first points nearest to the second (Kabsch 1976, Umeyama 1991).
struct Similarity {
  Matrix3d rotation = Matrix3d::Identity();
  double scale = 1.0;
};
Similarity similarity(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  Vector3d meanFrom = Vector3d::Zero(), meanTo = Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) meanFrom += from[i], meanTo += to[i];
  meanFrom /= static_cast<double>(from.size()), meanTo /= static_cast<double>(from.size());
  Matrix3d covariance = Matrix3d::Zero();
  double spread = 0.0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    covariance += (to[i] - meanTo) * (from[i] - meanFrom).transpose();
    spread += (from[i] - meanFrom).squaredNorm();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 1e-6 * svd.singularValues()[0]))
    throw std::invalid_argument("the joints that the two skeletons share lie in one line");
  Vector3d flip(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  return {svd.matrixU() * flip.asDiagonal() * svd.matrixV().transpose(),
          svd.singularValues().dot(flip) / std::max(spread, 1e-300)};
}

}  // namespace

LaidSkeleton layOn(const Skeleton& fitted, const Skeleton& user) {
  const Frames fittedRest = restFrames(fitted), rest = restFrames(user);
  const int n = user.jointCount();
  std::vector<char> known(n, 0);
  std::vector<Vector3d> place(n, Vector3d::Zero()), from, to;
  for (const JointMatch& match : matchJoints(fitted, user).matches) {
    known[match.target] = 1;
    place[match.target] = fittedRest[match.source].translation();
    from.push_back(rest[match.target].translation());
    to.push_back(place[match.target]);
  }
  LaidSkeleton out;
  out.matched = static_cast<int>(from.size());
  if (out.matched < 4) {
    std::string names;
    for (const Joint& joint : fitted.joints()) names += (names.empty() ? "" : ", ") + joint.name;
    throw std::invalid_argument(
        "only " + std::to_string(out.matched) +
        " joints of the skeleton have a name that says where they belong; known are " + names +
        " and the usual other names of these");
  }
  const Similarity global = similarity(from, to);

  // Between two known joints: the same share of the way.
  for (int j = n - 1; j >= 0; --j) {
    if (!known[j]) continue;
    std::vector<int> between;
    int above = user.parent(j);
    while (above >= 0 && !known[above]) between.push_back(above), above = user.parent(above);
    if (above < 0 || between.empty()) continue;
    double total = 0.0;
    for (int k = j; k != above; k = user.parent(k))
      total += (rest[k].translation() - rest[user.parent(k)].translation()).norm();
    double behind = 0.0;
    for (int k = j; user.parent(k) != above; k = user.parent(k)) {
      const int p = user.parent(k);
      behind += (rest[k].translation() - rest[p].translation()).norm();
      place[p] = place[j] + (total > 0.0 ? behind / total : 0.5) * (place[above] - place[j]);
    }
    for (const int k : between) known[k] = 2;
  }
  // Above the first known joint: as they stood, turned and scaled with the whole.
  for (int j = n - 1; j > 0; --j)
    if (const int p = user.parent(j); known[j] && !known[p]) {
      place[p] =
          place[j] + global.scale * (global.rotation * (rest[p].translation() - rest[j].translation()));
      known[p] = 2;
    }

  // Outwards: frames turn with their bone; joints beyond the last known one hang on their parent's.
  std::vector<Matrix3d> turn(n, global.rotation);
  std::vector<double> scale(n, global.scale);
  std::vector<Joint> joints = user.joints();
  Frames frames(n);
  for (int j = 0; j < n; ++j) {
    const int p = user.parent(j);
    if (!known[j] && p >= 0)
      place[j] = place[p] + scale[p] * (turn[p] * (rest[j].translation() - rest[p].translation()));
    if (known[j] != 1) out.placed.push_back(user.joint(j).name);
    if (p >= 0) turn[j] = turn[p], scale[j] = scale[p];
    for (const int c : user.children(j)) {
      const Vector3d before = rest[c].translation() - rest[j].translation(), after = place[c] - place[j];
      if (!known[c] || !(before.norm() > 0.0) || !(after.norm() > 1e-9 * global.scale)) continue;
      turn[j] = rotationBetween(global.rotation * before, after).toRotationMatrix() * global.rotation;
      scale[j] = after.norm() / before.norm();
      break;
    }
    frames[j].linear() = turn[j] * rest[j].linear();
    frames[j].translation() = place[j];
    const Isometry3d parentFromRest = p < 0 ? frames[j] : frames[p].inverse() * frames[j];
    joints[j].parentFromZero = parentFromRest * jointMotion(user, user.rest(), j).inverse();
    joints[j].parentFromZero.linear() =
        Eigen::Quaterniond(joints[j].parentFromZero.linear()).normalized().toRotationMatrix();
  }
  out.skeleton = Skeleton(std::move(joints), user.rest());
  return out;
}

}  // namespace gelenk
