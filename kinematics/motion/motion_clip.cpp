#include "kinematics/motion/motion_clip.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double rightAngleTolerance = 1e-9;

/// Positions, in joint.axes, of the rotations; at most three are told apart from "many".
struct RotationAxes {
  int count = 0;
  int at[3] = {0, 0, 0};
};
RotationAxes rotationAxes(const Joint& joint) {
  RotationAxes axes;
  for (int k = 0; k < static_cast<int>(joint.axes.size()); ++k) {
    if (joint.axes[k].kind != AxisDof::Kind::Rotation) continue;
    if (axes.count < 3) axes.at[axes.count] = k;
    ++axes.count;
  }
  return axes;
}

double nearestTurn(double angle, double hint) {
  return angle + 2.0 * M_PI * std::round((hint - angle) / (2.0 * M_PI));
}

bool atRightAngles(const Vector3d& a, const Vector3d& b) { return std::abs(a.dot(b)) < rightAngleTolerance; }

/// Angles (a, b) whose exp(a e1) exp(b e2), e1 at right angles to e2, is the nearest quaternion to q. In the
/// basis (1, e1, e2, e1 x e2) that product is (cos cos, sin cos, cos sin, sin sin) of the half angles a and
/// b; the inner product with q is to be the largest.
Eigen::Vector2d nearestTwoAngles(const Quaterniond& q, const Vector3d& e1, const Vector3d& e2,
                                 const Eigen::Vector2d& hint) {
  const double w = q.w(), x = q.vec().dot(e1), y = q.vec().dot(e2), z = q.vec().dot(e1.cross(e2));
  // cos a cos b = (cos(a - b) + cos(a + b)) / 2 and so on split it into one term of the sum and one of the
  // difference.
  const double sum = std::atan2(x + y, w - z), difference = std::atan2(x - y, w + z);
  const double a = sum + difference, b = sum - difference;  // whole angles: twice the half sum and difference
  return {nearestTurn(a, hint[0]), nearestTurn(b, hint[1])};
}

/// q <- exp(angle axis) from the right.
void turn(Quaterniond& q, const Vector3d& axis, double angle) {
  const double s = std::sin(0.5 * angle);
  q = q * Quaterniond(std::cos(0.5 * angle), s * axis.x(), s * axis.y(), s * axis.z());
}

Quaterniond slerp(const Quaterniond& a, Quaterniond b, double s) {
  if (a.dot(b) < 0.0) b.coeffs() = -b.coeffs();
  return (a * expRotation(s * logRotation(a.conjugate() * b))).normalized();
}

}  // namespace

void validate(const Skeleton& skeleton, const MotionClip& clip) {
  if (clip.q.rows() != skeleton.nq())
    throw std::invalid_argument("the clip has " + std::to_string(clip.q.rows()) +
                                " values a frame, the skeleton needs nq = " + std::to_string(skeleton.nq()));
  if (clip.q.cols() == 0) throw std::invalid_argument("the clip has no frame");
  if (!(clip.framesPerSecond > 0.0) || !std::isfinite(clip.framesPerSecond))
    throw std::invalid_argument("the clip's frame rate must be positive, found " +
                                std::to_string(clip.framesPerSecond));
  if (!clip.q.allFinite()) throw std::invalid_argument("the clip has a value that is not finite");
}

Quaterniond jointRotation(const Skeleton& skeleton, const Eigen::Ref<const VectorXd>& q, int index) {
  const Joint& joint = skeleton.joint(index);
  const double* value = q.data() + skeleton.qIndex(index);
  Quaterniond rotation = Quaterniond::Identity();
  for (const AxisDof& dof : joint.axes) {
    if (dof.kind == AxisDof::Kind::Rotation) turn(rotation, dof.axis, *value);
    ++value;
  }
  if (joint.ball) rotation = rotation * Quaterniond(value[0], value[1], value[2], value[3]);
  return rotation;
}

Vector3d eulerAngles(const Quaterniond& rotation, const Vector3d& e1, const Vector3d& e2, const Vector3d& e3,
                     const Vector3d& hint) {
  // With h = (e1 x e2) . e3 = +-1 and R in the basis (e1, e2, e3):  R13 = h sin a2, R11 = cos a2 cos a3, R12
  // = -h cos a2 sin a3, R23 = -h sin a1 cos a2, R33 = cos a1 cos a2.
  const double h = e1.cross(e2).dot(e3) > 0.0 ? 1.0 : -1.0;
  const Eigen::Matrix3d R = rotation.toRotationMatrix();
  const Vector3d r1 = R * e1, r2 = R * e2, r3 = R * e3;
  const double sine = h * e1.dot(r3);
  const double cosine = std::hypot(e1.dot(r1), e1.dot(r2));
  Vector3d first;
  first[1] = std::atan2(sine, cosine);
  if (cosine > 1e-9) {
    first[0] = std::atan2(-h * e2.dot(r3), e3.dot(r3));
    first[2] = std::atan2(-h * e1.dot(r2), e1.dot(r1));
  } else {  // gimbal lock: only a1 +- a3 is determined; a3 keeps its hint
    first[2] = hint[2];
    first[0] = h * std::atan2(e3.dot(r2), e2.dot(r2)) - (e1.dot(r3) > 0.0 ? 1.0 : -1.0) * hint[2];
  }
  Vector3d second(first[0] + M_PI, M_PI - first[1], first[2] + M_PI);
  for (int k = 0; k < 3; ++k) {
    first[k] = nearestTurn(first[k], hint[k]);
    second[k] = nearestTurn(second[k], hint[k]);
  }
  return (first - hint).squaredNorm() <= (second - hint).squaredNorm() ? first : second;
}

bool setJointRotation(const Skeleton& skeleton, Eigen::Ref<VectorXd> q, int index,
                      const Quaterniond& rotation) {
  const Joint& joint = skeleton.joint(index);
  double* value = q.data() + skeleton.qIndex(index);
  const RotationAxes axes = rotationAxes(joint);
  if (joint.ball) {
    Quaterniond before = Quaterniond::Identity();
    for (std::size_t k = 0; k < joint.axes.size(); ++k)
      if (joint.axes[k].kind == AxisDof::Kind::Rotation) turn(before, joint.axes[k].axis, value[k]);
    Quaterniond ball = (before.conjugate() * rotation).normalized();
    double* at = value + joint.axes.size();
    if (ball.dot(Quaterniond(at[0], at[1], at[2], at[3])) < 0.0) ball.coeffs() = -ball.coeffs();
    at[0] = ball.w(), at[1] = ball.x(), at[2] = ball.y(), at[3] = ball.z();
    return true;
  }
  if (axes.count == 0) return true;
  const Vector3d& e1 = joint.axes[axes.at[0]].axis;
  if (axes.count == 1) {
    double& angle = value[axes.at[0]];
    angle = nearestTurn(2.0 * std::atan2(rotation.vec().dot(e1), rotation.w()), angle);
    return true;
  }
  const Vector3d& e2 = joint.axes[axes.at[1]].axis;
  if (!atRightAngles(e1, e2)) return false;
  if (axes.count == 2) {
    const Eigen::Vector2d hint(value[axes.at[0]], value[axes.at[1]]);
    const Eigen::Vector2d angles = nearestTwoAngles(rotation, e1, e2, hint);
    value[axes.at[0]] = angles[0], value[axes.at[1]] = angles[1];
    return true;
  }
  const Vector3d& e3 = joint.axes[axes.at[2]].axis;
  if (axes.count > 3 || !atRightAngles(e1, e3) || !atRightAngles(e2, e3)) return false;
  const Vector3d angles =
      eulerAngles(rotation, e1, e2, e3, {value[axes.at[0]], value[axes.at[1]], value[axes.at[2]]});
  for (int k = 0; k < 3; ++k) value[axes.at[k]] = angles[k];
  return true;
}

void interpolate(const Skeleton& skeleton, const Eigen::Ref<const VectorXd>& from,
                 const Eigen::Ref<const VectorXd>& to, double s, VectorXd& out) {
  out = from;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    const int at = skeleton.qIndex(i);
    const RotationAxes rotations = rotationAxes(joint);
    const bool angleByAngle = !joint.ball && rotations.count == 1;
    for (std::size_t k = 0; k < joint.axes.size(); ++k) {
      const double step = to[at + k] - from[at + k];
      if (joint.axes[k].kind == AxisDof::Kind::Translation)
        out[at + k] = from[at + k] + s * step;
      else if (angleByAngle)
        out[at + k] = from[at + k] + s * std::remainder(step, 2.0 * M_PI);
    }
    if (angleByAngle || (rotations.count == 0 && !joint.ball)) continue;
    const Quaterniond rotation = slerp(jointRotation(skeleton, from, i), jointRotation(skeleton, to, i), s);
    if (!setJointRotation(skeleton, out, i, rotation))
      for (std::size_t k = 0; k < joint.axes.size(); ++k)
        out[at + k] = from[at + k] + s * std::remainder(to[at + k] - from[at + k], 2.0 * M_PI);
  }
}

void sample(const Skeleton& skeleton, const MotionClip& clip, double seconds, BeyondEnd beyond,
            VectorXd& out) {
  const int last = clip.frameCount() - 1;
  double at = seconds * clip.framesPerSecond;
  if (beyond == BeyondEnd::Loop && last > 0) at -= (last + 1) * std::floor(at / (last + 1));
  at = std::clamp(at, 0.0, beyond == BeyondEnd::Loop ? last + 1.0 : static_cast<double>(last));
  const int frame = std::min(static_cast<int>(at), last);
  const double s = at - frame;
  if (s == 0.0) {
    out = clip.q.col(frame);
    return;
  }
  interpolate(skeleton, clip.q.col(frame), clip.q.col(frame == last ? 0 : frame + 1), s, out);
}

VectorXd sample(const Skeleton& skeleton, const MotionClip& clip, double seconds, BeyondEnd beyond) {
  VectorXd q;
  sample(skeleton, clip, seconds, beyond, q);
  return q;
}

MotionClip resampled(const Skeleton& skeleton, const MotionClip& clip, double framesPerSecond) {
  if (!(framesPerSecond > 0.0)) throw std::invalid_argument("a frame rate must be positive");
  constexpr double most = 1e7;  // frames: four days at 30 Hz
  if (!(clip.duration() * framesPerSecond < most))
    throw std::invalid_argument("resampling would make more than ten million frames");
  const int count = static_cast<int>(std::lround(clip.duration() * framesPerSecond)) + 1;
  MotionClip result{.framesPerSecond = framesPerSecond, .q = Eigen::MatrixXd(clip.q.rows(), count)};
  VectorXd q;
  for (int f = 0; f < count; ++f) {
    sample(skeleton, clip, f / framesPerSecond, BeyondEnd::Stay, q);
    result.q.col(f) = q;
  }
  return result;
}

}  // namespace gelenk
