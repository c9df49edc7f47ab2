#include "solvers/serial/serial_chain.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double noWall = 1e300;
constexpr double parallelSine =
    1e-11;  // axes closer than this are parallel: the error, 1e-11 of a length, is below rounding's reach

/// The axis of a dof at the chain's zero, in the world.
struct AxisLine {
  Vector3d point, direction;
};

std::vector<int> pathFromRoot(const Skeleton& skeleton, int joint) {
  std::vector<int> path;
  for (int j = joint; j >= 0; j = skeleton.parent(j)) path.push_back(j);
  std::reverse(path.begin(), path.end());
  return path;
}

Vector3d anyPerpendicular(const Vector3d& v) { return v.unitOrthogonal(); }

/// Where the common normal of two lines leaves `from` and meets `to`, and its direction; `previousFoot` lies
/// on `from` and is kept where the lines are parallel, `previousX` where they coincide.
struct CommonNormal {
  Vector3d footOnFrom, footOnTo, x;
  CommonNormal(const AxisLine& from, const AxisLine& to, const Vector3d& previousFoot,
               const Vector3d& previousX) {
    const Vector3d normal = from.direction.cross(to.direction), between = to.point - from.point;
    const double sine = normal.norm();
    if (sine > parallelSine) {
      x = normal / sine;
      footOnFrom = from.point + from.direction * (between.cross(to.direction).dot(x) / sine);
      footOnTo = to.point + to.direction * (between.cross(from.direction).dot(x) / sine);
      return;
    }
    footOnFrom = previousFoot;
    const Vector3d across =
        to.point - previousFoot - from.direction * (to.point - previousFoot).dot(from.direction);
    footOnTo = previousFoot + across;
    const double length = across.norm();
    x = length > 1e-12 ? Vector3d(across / length) : previousX;
  }
};

Isometry3d frameOf(const Vector3d& origin, const Vector3d& x, const Vector3d& z) {
  Isometry3d frame = Isometry3d::Identity();
  frame.linear() << x, z.cross(x), z;
  frame.translation() = origin;
  return frame;
}

/// Signed angle that turns a into b about the unit axis; both perpendicular to it.
double angleAbout(const Vector3d& axis, const Vector3d& a, const Vector3d& b) {
  return std::atan2(axis.dot(a.cross(b)), a.dot(b));
}

/// Fills the Denavit-Hartenberg constants; returns the frame of the last joint at zero.
Isometry3d setParameters(const std::vector<AxisLine>& lines, SerialChain& chain) {
  const int n = chain.n;
  Vector3d x = anyPerpendicular(lines[0].direction), origin = lines[0].point;
  Vector3d previousX = x, arrival = origin;  // where the normal from the axis before meets this one
  for (int i = 0; i < n; ++i) {
    const Vector3d z = lines[i].direction;
    previousX = x;
    if (i + 1 < n) {
      const CommonNormal next(lines[i], lines[i + 1], arrival, x - z * x.dot(z));
      origin = next.footOnFrom;
      x = next.x;
      chain.constants.a[i + 1] = (next.footOnTo - next.footOnFrom).dot(x);
      chain.constants.cosAlpha[i + 1] = z.dot(lines[i + 1].direction);
      chain.constants.sinAlpha[i + 1] = x.dot(z.cross(lines[i + 1].direction));
      if (i == 0) {
        chain.worldFromBase = frameOf(origin, x, z);
      } else {
        chain.constants.theta[i] = angleAbout(z, previousX, x);
        chain.constants.d[i] = (origin - arrival).dot(z);
      }
      arrival = next.footOnTo;
    } else if (i == 0) {
      chain.worldFromBase = frameOf(origin, x, z);
    } else {
      origin = arrival;
    }
  }
  return frameOf(origin, x, lines[n - 1].direction);
}

/// The parameters must give back the skeleton's own forward kinematics.
bool agrees(const Skeleton& skeleton, int tipJoint, const SerialChain& chain) {
  std::mt19937_64 random(1);
  for (int trial = 0; trial < 3; ++trial) {
    VectorXd q = trial == 0 ? neutral(skeleton) : randomWithinLimits(skeleton, random), own(chain.n);
    for (int i = 0; i < chain.n; ++i) own[i] = q[chain.qIndex[i]];
    const Isometry3d expected = forwardKinematics(skeleton, q)[tipJoint], found = tipFrame(chain, own);
    const double reach = chain.length + expected.translation().norm();
    if ((expected.translation() - found.translation()).norm() > 1e-10 * reach) return false;
    if ((expected.linear() - found.linear()).norm() > 1e-10) return false;
  }
  return true;
}

}  // namespace

SerialChainResult extractSerialChain(const Skeleton& skeleton, int tipJoint) {
  if (tipJoint < 0 || tipJoint >= skeleton.jointCount())
    throw std::invalid_argument("joint " + std::to_string(tipJoint) + " is not one of the skeleton's " +
                                std::to_string(skeleton.jointCount()));
  SerialChainResult result;
  SerialChain& chain = result.chain;
  ChainConstants& C = chain.constants;
  std::vector<AxisLine> lines;
  std::vector<double> lower, upper;
  Isometry3d world = Isometry3d::Identity();
  chain.length = 0.0;
  for (const int j : pathFromRoot(skeleton, tipJoint)) {
    const Joint& joint = skeleton.joint(j);
    world = world * joint.parentFromZero;
    if (!lines.empty()) chain.length += joint.parentFromZero.translation().norm();
    if (joint.ball) {
      result.whyNot = "joint '" + joint.name + "' on the path is a ball joint; only one-axis dofs are solved";
      return result;
    }
    if (joint.coupling) {
      result.whyNot = "joint '" + joint.name + "' on the path follows '" +
                      skeleton.joint(joint.coupling->source).name +
                      "'; only joints that move alone are solved";
      return result;
    }
    for (size_t k = 0; k < joint.axes.size(); ++k) {
      const AxisDof& dof = joint.axes[k];
      if (chain.n == maxChainDofs) {
        result.whyNot = "the path has more than " + std::to_string(maxChainDofs) + " dofs";
        return result;
      }
      const bool revolute = dof.kind == AxisDof::Kind::Rotation, wraps = revolute && dof.isFullTurn();
      const int i = chain.n++;
      lines.push_back({world.translation(), world.linear() * dof.axis});
      chain.qIndex.push_back(skeleton.qIndex(j) + static_cast<int>(k));
      chain.wraps.push_back(wraps);
      lower.push_back(dof.lower);
      upper.push_back(dof.upper);
      chain.hasPrismatic |= !revolute;
      C.a[i] = C.d[i] = C.sinAlpha[i] = C.theta[i] = 0.0;
      C.cosAlpha[i] = 1.0;
      C.revolute[i] = revolute ? 1.0 : 0.0;
      C.lower[i] = wraps || dof.lower == -unlimited ? -noWall : dof.lower;
      C.upper[i] = wraps || dof.upper == unlimited ? noWall : dof.upper;
      const double halfRange = revolute ? M_PI : 1.0;
      C.seedLower[i] = C.lower[i] > -noWall  ? C.lower[i]
                       : C.upper[i] < noWall ? C.upper[i] - 2.0 * halfRange
                                             : -halfRange;
      C.seedUpper[i] = C.upper[i] < noWall    ? C.upper[i]
                       : C.lower[i] > -noWall ? C.lower[i] + 2.0 * halfRange
                                              : halfRange;
      if (!revolute && std::isfinite(dof.lower) && std::isfinite(dof.upper))
        chain.length += std::max(std::abs(dof.lower), std::abs(dof.upper));
    }
  }
  if (chain.n == 0) {
    result.whyNot = "no joint on the path moves";
    return result;
  }
  if (chain.length <= 1e-9) chain.length = 1.0;
  chain.lower = Eigen::Map<VectorXd>(lower.data(), chain.n);
  chain.upper = Eigen::Map<VectorXd>(upper.data(), chain.n);
  const Isometry3d worldFromLast = setParameters(lines, chain);
  chain.lastFromTip = worldFromLast.inverse() * world;
  if (!agrees(skeleton, tipJoint, chain))
    result.whyNot =
        "two neighbouring axes are so nearly parallel that Denavit-Hartenberg parameters lose precision";
  return result;
}

Isometry3d tipFrame(const SerialChain& chain, const VectorXd& q) {
  Isometry3d world = chain.worldFromBase;
  const ChainConstants& C = chain.constants;
  for (int i = 0; i < chain.n; ++i) {
    const double angle = C.theta[i] + C.revolute[i] * q[i], shift = C.d[i] + (1.0 - C.revolute[i]) * q[i];
    Isometry3d link = Isometry3d::Identity();
    link.linear() << 1, 0, 0, 0, C.cosAlpha[i], -C.sinAlpha[i], 0, C.sinAlpha[i], C.cosAlpha[i];
    link.translation() = Vector3d(C.a[i], 0, 0) + link.linear().col(2) * shift;
    link.rotate(Eigen::AngleAxisd(angle, Vector3d::UnitZ()));
    world = world * link;
  }
  return world * chain.lastFromTip;
}

}  // namespace gelenk
