#pragma once

#include <Eigen/Core>

#include "kinematics/forward_kinematics.h"

namespace gelenk {

/// Column k: the twist (v; omega) that tangent dimension k gives to everything below its joint, in world
/// axes; v is the velocity of the body point that passes through the world's origin. 6 x nv (metres,
/// radians). Followers' own motions, times their multipliers, stand behind those, in the order of
/// Skeleton::followers(): 6 x (nv + followers).
using Twists = Eigen::Matrix<double, 6, Eigen::Dynamic>;

/// q: nq, frames: forwardKinematics(skeleton, q). Joints of several axes need q for the axes in between.
void dofTwists(const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames, Twists& twists);
Twists dofTwists(const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames);

/// d(world position of the point) / d(dq): column k = v_k + omega_k x p for the ancestors of the joint, else
/// 0; an ancestor that follows another joint adds its own to that one's column. 3 x nv. pointInJoint: the
/// point in the frame of the joint that carries it.
Eigen::Matrix3Xd pointJacobian(const Skeleton& skeleton, const Eigen::VectorXd& q, const Frames& frames,
                               int joint, const Eigen::Vector3d& pointInJoint);
/// The same from twists that are already there. J must be 3 x nv; columns off the joint's path are set to 0.
void pointJacobian(const Skeleton& skeleton, const Twists& twists, int joint,
                   const Eigen::Vector3d& pointInWorld,
                   Eigen::Ref<Eigen::Matrix3Xd, 0, Eigen::OuterStride<>> J);

/// Geometric Jacobian of the joint's frame: rows 0-2 velocity of its origin, rows 3-5 angular velocity, world
/// axes. 6 x nv.
Eigen::Matrix<double, 6, Eigen::Dynamic> frameJacobian(const Skeleton& skeleton, const Eigen::VectorXd& q,
                                                       const Frames& frames, int joint);
/// Angular rows alone. J must be 3 x nv.
void rotationJacobian(const Skeleton& skeleton, const Twists& twists, int joint,
                      Eigen::Ref<Eigen::Matrix3Xd, 0, Eigen::OuterStride<>> J);

}  // namespace gelenk
