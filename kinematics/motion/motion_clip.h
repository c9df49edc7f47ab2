#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinematics/skeleton.h"

namespace gelenk {

/// A motion of one skeleton, sampled at a constant rate. Nothing in it is clamped to limits.
struct MotionClip {
  double framesPerSecond = 120.0;
  Eigen::MatrixXd q;  ///< nq x frames: column f is the configuration at f / framesPerSecond seconds

  int frameCount() const { return static_cast<int>(q.cols()); }
  /// Seconds from the first frame to the last.
  double duration() const { return q.cols() > 1 ? static_cast<double>(q.cols() - 1) / framesPerSecond : 0.0; }
};

/// Throws std::invalid_argument: rows other than nq, no frame, a rate that is not positive, a value that is
/// not finite.
void validate(const Skeleton& skeleton, const MotionClip& clip);

/// The joint's whole rotation: the product of its rotation axes and its ball, translations left out. q: nq.
Eigen::Quaterniond jointRotation(const Skeleton& skeleton, const Eigen::Ref<const Eigen::VectorXd>& q,
                                 int joint);

/// Sets the joint's rotation axes and ball so that jointRotation comes as near to `rotation` as they allow;
/// what q holds before is the hint that chooses between equivalent angles (Euler branches, full turns). Exact
/// for balls and for three axes at right angles in order (at the gimbal lock the third keeps its hint); for
/// one axis, or two at right angles, the nearest quaternion; other joints of axes are left as they are and
/// false is returned.
bool setJointRotation(const Skeleton& skeleton, Eigen::Ref<Eigen::VectorXd> q, int joint,
                      const Eigen::Quaterniond& rotation);

/// From one configuration (s = 0) to another (s = 1): translations along the line, rotations of every joint
/// as a whole along the shorter arc of quaternions, never angle by angle, because equal poses can have Euler
/// angles half a turn apart. out: nq.
void interpolate(const Skeleton& skeleton, const Eigen::Ref<const Eigen::VectorXd>& from,
                 const Eigen::Ref<const Eigen::VectorXd>& to, double s, Eigen::VectorXd& out);

/// What sample does beyond the clip's ends: stay at the last pose, or begin again (the last frame is then the
/// first one's neighbour).
enum class BeyondEnd { Stay, Loop };

/// The configuration at a time, interpolated between frames. Allocates only when out's size changes.
void sample(const Skeleton& skeleton, const MotionClip& clip, double seconds, BeyondEnd beyond,
            Eigen::VectorXd& out);
Eigen::VectorXd sample(const Skeleton& skeleton, const MotionClip& clip, double seconds,
                       BeyondEnd beyond = BeyondEnd::Stay);

/// The same motion at another rate, first and last frame in place (the last one to within half a new frame).
MotionClip resampled(const Skeleton& skeleton, const MotionClip& clip, double framesPerSecond);

/// Angles of a about e1, then e2, then e3 with rotation = exp(a1 e1) exp(a2 e2) exp(a3 e3), |a2| <= pi / 2 as
/// far as the hint allows: of the two solutions and all full turns the one nearest to the hint. The axes must
/// be an orthonormal triple of either handedness.
Eigen::Vector3d eulerAngles(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& e1,
                            const Eigen::Vector3d& e2, const Eigen::Vector3d& e3,
                            const Eigen::Vector3d& hint);

}  // namespace gelenk
