#include "kinematics/symmetry.h"

#include <cctype>
#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

/// The same letter-case pattern for another word: Left -> Right, LEFT -> RIGHT, left -> right.
std::string likeCase(const std::string& pattern, std::string word) {
  const bool all = pattern.size() > 1 && std::isupper(static_cast<unsigned char>(pattern[1]));
  for (std::size_t k = 0; k < word.size(); ++k)
    if (all || (k == 0 && std::isupper(static_cast<unsigned char>(pattern[0]))))
      word[k] = static_cast<char>(std::toupper(static_cast<unsigned char>(word[k])));
  return word;
}

std::string lowerCase(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

std::string otherSide(const std::string& name) {
  const std::string lower = lowerCase(name);
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"left", "right"}, {"right", "left"}})
    if (const auto at = lower.find(from); at != std::string::npos)
      return name.substr(0, at) + likeCase(name.substr(at, from.size()), to) + name.substr(at + from.size());
  const std::size_t n = name.size();
  if (n > 2 && (name[n - 2] == '_' || name[n - 2] == '.' || name[n - 2] == '-')) {
    const std::string sides = "lrLR", others = "rlRL";
    if (const auto at = sides.find(name[n - 1]); at != std::string::npos)
      return name.substr(0, n - 1) + others[at];
  }
  return name;
}

/// Entries within rounding of a signed permutation become exact, so that mirroring twice is exact.
Matrix3d snapped(Matrix3d D) {
  for (double& entry : D.reshaped())
    if (std::abs(entry - std::round(entry)) < 1e-9) entry = std::round(entry);
  return D;
}

[[noreturn]] void reject(const Skeleton& skeleton, int joint, int partner, const std::string& why) {
  throw std::invalid_argument("the skeleton is not symmetric at x = 0: '" + skeleton.joint(joint).name +
                              "' and '" + skeleton.joint(partner).name + "' " + why);
}

}  // namespace

std::vector<int> mirrorPartners(const Skeleton& skeleton) {
  std::vector<int> partners;
  for (const Joint& joint : skeleton.joints()) {
    const auto partner = skeleton.findJoint(otherSide(joint.name));
    if (!partner)
      throw std::invalid_argument("joint '" + joint.name + "' has no partner '" + otherSide(joint.name) +
                                  "'");
    partners.push_back(*partner);
  }
  return partners;
}

VectorXd mirrorPose(const Skeleton& skeleton, const VectorXd& q) {
  const std::vector<int> partners = mirrorPartners(skeleton);
  const Frames zero = forwardKinematics(skeleton, neutral(skeleton));
  double size = 1e-12;
  for (const auto& frame : zero) size = std::max(size, frame.translation().norm());
  const Matrix3d S = Vector3d(-1.0, 1.0, 1.0).asDiagonal();

  VectorXd mirrored(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int m = partners[i];
    if (!((S * zero[i].translation() - zero[m].translation()).norm() <= 1e-6 * size))
      reject(skeleton, i, m, "lie elsewhere");
    const auto &axes = skeleton.joint(i).axes, &others = skeleton.joint(m).axes;
    if (axes.size() != others.size() || skeleton.joint(i).ball != skeleton.joint(m).ball)
      reject(skeleton, i, m, "move in different ways");

    // worldFromPartner' = S worldFromJoint D with the constant reflection D. Directions of i are seen by m as
    // D^T a, rotations about them turn the other way round.
    const Matrix3d D = snapped(zero[i].linear().transpose() * S * zero[m].linear());
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const double along = (D.transpose() * axes[k].axis).dot(others[k].axis);
      if (axes[k].kind != others[k].kind || std::abs(std::abs(along) - 1.0) > 1e-6)
        reject(skeleton, i, m, "have axes that are no reflections of each other");
      const bool turns = axes[k].kind == AxisDof::Kind::Rotation;
      mirrored[skeleton.qIndex(m) + k] = ((along > 0.0) == turns ? -1.0 : 1.0) * q[skeleton.qIndex(i) + k];
    }
    if (!skeleton.joint(i).ball) continue;
    const Quaterniond r = ballRotation(skeleton, q, i);
    const Vector3d v = -(D.transpose() * r.vec());
    setBallRotation(skeleton, mirrored, m, Quaterniond(r.w(), v.x(), v.y(), v.z()));
  }
  return mirrored;
}

std::string whyNotMirrored(const Skeleton& skeleton) {
  try {
    mirrorPose(skeleton, neutral(skeleton));
    return {};
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

}  // namespace gelenk
