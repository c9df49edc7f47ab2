#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "kinematics/jacobian.h"

namespace gelenk {

/// What the joints of a skeleton weigh: of every joint the mass that moves with it and where its centre is.
struct Masses {
  std::vector<double> mass;             ///< kg, one a joint, 0 where nothing is carried
  std::vector<Eigen::Vector3d> centre;  ///< metres, frame of the joint

  double total() const;
  /// Sizes, finite numbers, no mass below 0, a total above 0. Throws std::invalid_argument otherwise.
  void check(const Skeleton& skeleton) const;
};

/// Every bone a rod of this mass a metre, with its centre half way: for skeletons without masses. Bones run
/// from a joint to its children. Throws std::invalid_argument for a skeleton without bones or kgPerMetre <=
/// 0.
Masses rodMasses(const Skeleton& skeleton, double kgPerMetre = 1.0);

/// Metres, world.
Eigen::Vector3d centreOfMass(const Masses& masses, const Frames& frames);

/// d(centreOfMass) / d(dq), 3 x nv: column k is m_k / M (v_k + omega_k x c_k) with the mass m_k and its
/// centre c_k of everything below dof k. One pass over the joints.
void centreOfMassJacobian(const Skeleton& skeleton, const Masses& masses, const Frames& frames,
                          const Twists& twists, Eigen::Ref<Eigen::Matrix3Xd, 0, Eigen::OuterStride<>> J);

}  // namespace gelenk
