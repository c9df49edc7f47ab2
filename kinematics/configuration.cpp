#include "kinematics/configuration.h"

#include <algorithm>
#include <cmath>

#include "kinematics/limits.h"
#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Quaterniond quaternionAt(const VectorXd& q, int at) { return {q[at], q[at + 1], q[at + 2], q[at + 3]}; }

void putQuaternion(VectorXd& q, int at, const Quaterniond& r) {
  q.segment<4>(at) << r.w(), r.x(), r.y(), r.z();
}

int ballIndex(const Skeleton& skeleton, int joint) {
  return skeleton.qIndex(joint) + static_cast<int>(skeleton.joint(joint).axes.size());
}

double range(const AxisDof& dof, bool upper) {
  const double reach = dof.kind == AxisDof::Kind::Rotation ? M_PI : 1.0;
  const double value = upper ? dof.upper : dof.lower;
  if (std::isfinite(value)) return value;
  const double other = upper ? dof.lower : dof.upper;  // half-bounded: the finite side plus one whole span
  if (std::isfinite(other)) return upper ? other + 2.0 * reach : other - 2.0 * reach;
  return upper ? reach : -reach;
}

}  // namespace

Vector2d nearestOnEllipse(const Vector2d& radii, const Vector2d& p) {
  // Newton on the secular equation (a px / (t + a^2))^2 + (b py / (t + b^2))^2 = 1, which is convex and
  // decreasing for t >= 0, so it never overshoots.
  const Vector2d squares = radii.cwiseProduct(radii);
  double t = 0.0;
  for (int i = 0; i < 60; ++i) {
    const Vector2d shifted = squares.array() + t;
    const Vector2d ratio = radii.cwiseProduct(p).cwiseQuotient(shifted);
    const double f = ratio.squaredNorm() - 1.0;
    const double slope = -2.0 * (ratio.array().square() / shifted.array()).sum();
    const double step = -f / slope;
    t += step;
    if (std::abs(step) <= 1e-16 * (t + squares.maxCoeff())) break;
  }
  Vector2d nearest = squares.cwiseProduct(p).cwiseQuotient((squares.array() + t).matrix());
  return nearest / nearest.cwiseQuotient(radii).norm();  // onto the ellipse to the last bit
}

double uniform01(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

VectorXd neutral(const Skeleton& skeleton) {
  VectorXd q = VectorXd::Zero(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (skeleton.joint(i).ball) q[ballIndex(skeleton, i)] = 1.0;
  skeleton.couple(q);
  return q;
}

std::optional<VectorXd> configurationFrom(const Skeleton& skeleton, std::span<const double> values) {
  const auto given = static_cast<int>(values.size());
  const int followers = static_cast<int>(skeleton.followers().size());
  if (given != skeleton.nq() && given != skeleton.nq() - followers) return std::nullopt;
  VectorXd q(skeleton.nq());
  std::size_t next = 0;
  for (int i = 0; i < skeleton.jointCount(); ++i)
    for (int k = 0; k < skeleton.qCount(i); ++k)
      q[skeleton.qIndex(i) + k] = skeleton.joint(i).coupling && given < skeleton.nq() ? 0.0 : values[next++];
  skeleton.couple(q);
  return q;
}

void integrate(const Skeleton& skeleton, const VectorXd& q, const VectorXd& dq, VectorXd& out) {
  out.resize(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int axes = static_cast<int>(skeleton.joint(i).axes.size());
    const int iq = skeleton.qIndex(i), iv = skeleton.vIndex(i);
    for (int k = 0; k < axes; ++k) out[iq + k] = q[iq + k] + dq[iv + k];
    if (!skeleton.joint(i).ball) continue;
    const Quaterniond moved = quaternionAt(q, iq + axes) * expRotation(dq.segment<3>(iv + axes));
    putQuaternion(out, iq + axes, moved.normalized());
  }
  skeleton.couple(out);
}

VectorXd integrate(const Skeleton& skeleton, const VectorXd& q, const VectorXd& dq) {
  VectorXd out;
  integrate(skeleton, q, dq, out);
  return out;
}

VectorXd difference(const Skeleton& skeleton, const VectorXd& from, const VectorXd& to) {
  VectorXd dq;
  difference(skeleton, from, to, dq);
  return dq;
}

void difference(const Skeleton& skeleton, const VectorXd& from, const VectorXd& to, VectorXd& dq) {
  dq.resize(skeleton.nv());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const int axes = static_cast<int>(skeleton.joint(i).axes.size());
    const int iq = skeleton.qIndex(i), iv = skeleton.vIndex(i);
    if (skeleton.joint(i).coupling) continue;  // its dimension is its source's
    for (int k = 0; k < axes; ++k) dq[iv + k] = to[iq + k] - from[iq + k];
    if (skeleton.joint(i).ball)
      dq.segment<3>(iv + axes) =
          logRotation(quaternionAt(from, iq + axes).conjugate() * quaternionAt(to, iq + axes));
  }
}

VectorXd randomWithinLimits(const Skeleton& skeleton, std::mt19937_64& random) {
  VectorXd q(skeleton.nq());
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    int at = skeleton.qIndex(i);
    for (const AxisDof& dof : joint.axes) {
      const double lower = range(dof, false), upper = range(dof, true);
      q[at++] = lower + (upper - lower) * uniform01(random);
    }
    if (!joint.ball) continue;
    Quaterniond rotation;
    if (joint.ballLimit) {
      const BallLimit& limit = *joint.ballLimit;
      const double lower = std::max(limit.twistLower, -M_PI), upper = std::min(limit.twistUpper, M_PI);
      Vector2d swing;
      do {  // uniform on the ellipse's disc, kept inside |c| < 2 where a swing exists
        const double radius = std::sqrt(uniform01(random)), angle = 2.0 * M_PI * uniform01(random);
        swing = limit.swingCentre +
                radius * Vector2d(std::cos(angle), std::sin(angle)).cwiseProduct(limit.swingRadii);
      } while (swing.norm() >= 2.0);
      rotation =
          fromSwingTwistCoordinates({swing.x(), swing.y(), lower + (upper - lower) * uniform01(random)});
    } else {  // Shoemake 1992
      const double u = uniform01(random), a = 2.0 * M_PI * uniform01(random),
                   b = 2.0 * M_PI * uniform01(random);
      rotation = Quaterniond(std::sqrt(u) * std::cos(b), std::sqrt(1.0 - u) * std::sin(a),
                             std::sqrt(1.0 - u) * std::cos(a), std::sqrt(u) * std::sin(b));
    }
    putQuaternion(q, at, rotation);
  }
  skeleton.couple(q);
  return q;
}

VectorXd projectToLimits(const Skeleton& skeleton, const VectorXd& q) {
  VectorXd out;
  projectToLimits(skeleton, q, out);
  return out;
}

void projectToLimits(const Skeleton& skeleton, const VectorXd& q, VectorXd& out) {
  if (&out != &q) out = q;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    const Joint& joint = skeleton.joint(i);
    int at = skeleton.qIndex(i);
    for (const AxisDof& dof : joint.axes) {
      out[at] = std::clamp(q[at], dof.lower, dof.upper);
      ++at;
    }
    if (!joint.ball) continue;
    Quaterniond rotation = quaternionAt(q, at).normalized();
    if (joint.ballLimit && limitViolation(skeleton, q, i) > 0.0)
      rotation = fromSwingTwistCoordinates(intoBall(*joint.ballLimit, swingTwistCoordinates(rotation)));
    putQuaternion(out, at, rotation);
  }
  skeleton.couple(out);
}

double limitViolation(const Skeleton& skeleton, const VectorXd& q, int i) {
  const Joint& joint = skeleton.joint(i);
  if (joint.coupling) return 0.0;
  int at = skeleton.qIndex(i);
  double worst = 0.0;
  for (const AxisDof& dof : joint.axes) {
    worst = std::max({worst, dof.lower - q[at], q[at] - dof.upper});
    ++at;
  }
  if (joint.ball && joint.ballLimit) {
    const BallLimit& limit = *joint.ballLimit;
    const Vector3d c = swingTwistCoordinates(quaternionAt(q, at));
    const double excess = (c.head<2>() - limit.swingCentre).cwiseQuotient(limit.swingRadii).norm() - 1.0;
    worst = std::max(
        {worst, excess * limit.swingRadii.minCoeff(), limit.twistLower - c.z(), c.z() - limit.twistUpper});
  }
  return worst;
}

double limitViolation(const Skeleton& skeleton, const VectorXd& q) {
  double worst = 0.0;
  for (int i = 0; i < skeleton.jointCount(); ++i) worst = std::max(worst, limitViolation(skeleton, q, i));
  return worst;
}

Quaterniond ballRotation(const Skeleton& skeleton, const VectorXd& q, int joint) {
  return quaternionAt(q, ballIndex(skeleton, joint));
}

void setJointValue(const Skeleton& skeleton, VectorXd& q, int joint, double value) {
  const auto& coupling = skeleton.joint(joint).coupling;
  if (coupling && coupling->multiplier != 0.0)
    q[skeleton.qIndex(coupling->source)] = (value - coupling->offset) / coupling->multiplier;
  else if (!coupling)
    q[skeleton.qIndex(joint)] = value;
  skeleton.couple(q);
}

void setBallRotation(const Skeleton& skeleton, VectorXd& q, int joint, const Quaterniond& rotation) {
  putQuaternion(q, ballIndex(skeleton, joint), rotation);
}

}  // namespace gelenk
