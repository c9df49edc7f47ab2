#include "kinematics/notation/planar_chain.h"

#include <stdexcept>

namespace gelenk {

using Eigen::Isometry2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

namespace {

void requireAngles(const PlanarChain& chain, const VectorXd& phi) {
  if (phi.size() != chain.linkCount())
    throw std::invalid_argument("a planar chain of " + std::to_string(chain.linkCount()) +
                                " links needs as many angles, not " + std::to_string(phi.size()));
}

}  // namespace

PlanarChain lecturePlanarChain() { return {.base = {50.0, 400.0}, .lengths = {150.0, 200.0, 100.0}}; }

int degreesOfFreedom(const PlanarChain& chain) { return chain.linkCount() + 2; }

std::vector<Vector2d> linkPoints(const PlanarChain& chain, const VectorXd& phi) {
  requireAngles(chain, phi);
  std::vector<Vector2d> P{chain.base};
  double sum = 0.0;
  for (int i = 0; i < chain.linkCount(); ++i) {
    sum += phi[i];
    P.push_back(P.back() + chain.lengths[i] * Vector2d(std::cos(sum), std::sin(sum)));
  }
  return P;
}

Vector2d endEffector(const PlanarChain& chain, const VectorXd& phi) { return linkPoints(chain, phi).back(); }

Eigen::Matrix2Xd jacobian(const PlanarChain& chain, const VectorXd& phi) {
  const std::vector<Vector2d> P = linkPoints(chain, phi);
  Eigen::Matrix2Xd D(2, chain.linkCount());
  for (int i = 0; i < chain.linkCount(); ++i) {
    const Vector2d lever = P.back() - P[i];
    D.col(i) << -lever.y(), lever.x();
  }
  return D;
}

std::vector<Isometry2d> hierarchicalFrames(const PlanarChain& chain, const VectorXd& phi) {
  requireAngles(chain, phi);
  std::vector<Isometry2d> K;
  Isometry2d frame = Isometry2d::Identity();
  frame.translate(chain.base);
  for (int i = 0; i < chain.linkCount(); ++i) {
    frame.rotate(phi[i]);
    K.push_back(frame);
    frame.translate(Vector2d(chain.lengths[i], 0.0));
  }
  K.push_back(frame);
  return K;
}

Skeleton toSkeleton(const PlanarChain& chain) {
  if (chain.lengths.empty()) throw std::invalid_argument("a planar chain needs at least one link");
  std::vector<Joint> joints;
  Eigen::Vector3d offset(chain.base.x(), chain.base.y(), 0.0);
  for (int i = 0; i < chain.linkCount(); ++i) {
    Joint joint{.name = "joint" + std::to_string(i + 1), .parent = i - 1};
    joint.parentFromZero.translation() = offset;
    joint.axes = {AxisDof{.kind = AxisDof::Kind::Rotation, .axis = Eigen::Vector3d::UnitZ()}};
    joints.push_back(joint);
    offset = {chain.lengths[i], 0.0, 0.0};
  }
  Joint tip{.name = "end-effector", .parent = chain.linkCount() - 1};
  tip.parentFromZero.translation() = offset;
  joints.push_back(tip);
  return Skeleton(std::move(joints));
}

}  // namespace gelenk
