#pragma once

#include <Eigen/Core>
#include <optional>
#include <random>
#include <span>

#include "kinematics/skeleton.h"

namespace gelenk {

/// The zero configuration: angles and displacements 0, ball joints at the identity. Length nq.
Eigen::VectorXd neutral(const Skeleton& skeleton);

/// Moves on the configuration manifold: q (+) dq. Axes add; ball joints take q * exp(dq) and stay of unit
/// length. q: nq, dq: nv. Angles are not wrapped and limits are not applied.
Eigen::VectorXd integrate(const Skeleton& skeleton, const Eigen::VectorXd& q, const Eigen::VectorXd& dq);
void integrate(const Skeleton& skeleton, const Eigen::VectorXd& q, const Eigen::VectorXd& dq,
               Eigen::VectorXd& out);

/// The tangent with integrate(from, difference(from, to)) == to (ball joints: as rotations). Length nv.
Eigen::VectorXd difference(const Skeleton& skeleton, const Eigen::VectorXd& from, const Eigen::VectorXd& to);
void difference(const Skeleton& skeleton, const Eigen::VectorXd& from, const Eigen::VectorXd& to,
                Eigen::VectorXd& out);

/// A configuration from numbers that a user gives: one for every entry of q, or one for every entry but the
/// followers', who take what their sources say in either case. None where there are neither so many.
std::optional<Eigen::VectorXd> configurationFrom(const Skeleton& skeleton, std::span<const double> values);

/// Uniform within limits: axes uniform in their range (unlimited rotations in [-pi, pi], unlimited
/// translations in
/// [-1, 1] m), limited balls uniform in swing-twist coordinates, free balls uniform over all rotations.
Eigen::VectorXd randomWithinLimits(const Skeleton& skeleton, std::mt19937_64& random);

/// The nearest configuration within limits, joint by joint: axes are clamped, swings are moved to the nearest
/// point of their cone (Euclidean in swing-twist coordinates), twists are clamped, quaternions are
/// normalised, followers take what their sources say.
Eigen::VectorXd projectToLimits(const Skeleton& skeleton, const Eigen::VectorXd& q);
/// The same into existing storage, which may be q itself.
void projectToLimits(const Skeleton& skeleton, const Eigen::VectorXd& q, Eigen::VectorXd& out);

/// How far the joint lies outside its limits, 0 within: radians or metres for axes and twists; for swings the
/// excess of the normalised ellipse radius times the smaller ellipse radius. Judged from the quaternion
/// itself. A follower is within its limits where its source is.
double limitViolation(const Skeleton& skeleton, const Eigen::VectorXd& q, int joint);
/// Largest violation of all joints.
double limitViolation(const Skeleton& skeleton, const Eigen::VectorXd& q);

/// Point of the ellipse (x / radii.x)^2 + (y / radii.y)^2 = 1 nearest to a point outside it.
Eigen::Vector2d nearestOnEllipse(const Eigen::Vector2d& radii, const Eigen::Vector2d& point);

/// The quaternion of joint i, which must be a ball.
Eigen::Quaterniond ballRotation(const Skeleton& skeleton, const Eigen::VectorXd& q, int joint);
void setBallRotation(const Skeleton& skeleton, Eigen::VectorXd& q, int joint,
                     const Eigen::Quaterniond& rotation);

/// Sets the first axis of a joint; a follower's moves its source, and with it all that follow it, so that it
/// gets there (nothing where its multiplier is 0).
void setJointValue(const Skeleton& skeleton, Eigen::VectorXd& q, int joint, double value);

/// A number in [0, 1), the same on every platform for the same state of the generator.
double uniform01(std::mt19937_64& random);

}  // namespace gelenk
