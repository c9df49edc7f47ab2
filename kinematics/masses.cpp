#include "kinematics/masses.h"

#include <numeric>
#include <stdexcept>

namespace gelenk {

using Eigen::Vector3d;

double Masses::total() const { return std::accumulate(mass.begin(), mass.end(), 0.0); }

void Masses::check(const Skeleton& skeleton) const {
  const auto n = static_cast<std::size_t>(skeleton.jointCount());
  if (mass.size() != n || centre.size() != n)
    throw std::invalid_argument("masses for " + std::to_string(mass.size()) + " joints and centres for " +
                                std::to_string(centre.size()) + "; the skeleton has " + std::to_string(n));
  for (std::size_t i = 0; i < n; ++i)
    if (!(mass[i] >= 0.0) || !std::isfinite(mass[i]) || !centre[i].allFinite())
      throw std::invalid_argument("the mass of '" + skeleton.joint(static_cast<int>(i)).name +
                                  "' must be finite and not below 0, its centre finite");
  if (!(total() > 0.0)) throw std::invalid_argument("a skeleton without mass has no centre of mass");
}

Masses rodMasses(const Skeleton& skeleton, double kgPerMetre) {
  if (!(kgPerMetre > 0.0)) throw std::invalid_argument("a rod's mass a metre must be above 0");
  const int n = skeleton.jointCount();
  Masses masses{std::vector<double>(n, 0.0), std::vector<Vector3d>(n, Vector3d::Zero())};
  for (int i = 1; i < n; ++i) {  // the bone to joint i moves with its parent
    const Vector3d bone = skeleton.joint(i).parentFromZero.translation();
    const double mass = kgPerMetre * bone.norm();
    if (!(mass > 0.0)) continue;
    const int parent = skeleton.parent(i);
    const double sum = masses.mass[parent] + mass;
    masses.centre[parent] = (masses.mass[parent] * masses.centre[parent] + mass * 0.5 * bone) / sum;
    masses.mass[parent] = sum;
  }
  if (!(masses.total() > 0.0)) throw std::invalid_argument("a skeleton without bones has no rods to weigh");
  return masses;
}

Vector3d centreOfMass(const Masses& masses, const Frames& frames) {
  double total = 0.0;
  Vector3d moment = Vector3d::Zero();
  for (std::size_t i = 0; i < masses.mass.size(); ++i) {
    if (masses.mass[i] == 0.0) continue;
    total += masses.mass[i];
    moment += masses.mass[i] * (frames[i] * masses.centre[i]);
  }
  return moment / total;
}

void centreOfMassJacobian(const Skeleton& skeleton, const Masses& masses, const Frames& frames,
                          const Twists& twists, Eigen::Ref<Eigen::Matrix3Xd, 0, Eigen::OuterStride<>> J) {
  const int n = skeleton.jointCount();
  const double total = masses.total();
  Eigen::Matrix4Xd below(4, n);  // mass and first moment of the joint and all below it, over the total
  for (int i = 0; i < n; ++i) {
    const double share = masses.mass[i] / total;
    below.col(i) << share * (frames[i] * masses.centre[i]), share;
  }
  for (int i = n - 1; i > 0; --i) below.col(skeleton.parent(i)) += below.col(i);
  for (int i = 0; i < n; ++i)
    for (int k = skeleton.vIndex(i); k < skeleton.vIndex(i) + skeleton.vCount(i); ++k) {
      const Vector3d v = twists.col(k).head<3>(), omega = twists.col(k).tail<3>();
      J.col(k) = below(3, i) * v + omega.cross(below.col(i).head<3>());
    }
  int k = skeleton.nv();
  for (const int i : skeleton.followers()) {
    const Vector3d v = twists.col(k).head<3>(), omega = twists.col(k).tail<3>();
    J.col(skeleton.vIndex(i)) += below(3, i) * v + omega.cross(below.col(i).head<3>());
    ++k;
  }
}

}  // namespace gelenk
