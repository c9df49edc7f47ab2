#include "kinematics/notation/dh_table.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "kinematics/configuration.h"

namespace gelenk {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

Isometry3d rotationX(double angle) { return Isometry3d(Eigen::AngleAxisd(angle, Vector3d::UnitX())); }
Isometry3d rotationZ(double angle) { return Isometry3d(Eigen::AngleAxisd(angle, Vector3d::UnitZ())); }
Isometry3d translation(double x, double y, double z) { return Isometry3d(Eigen::Translation3d(x, y, z)); }

/// Variables in order of the rows; fixed rows get 0.
std::vector<double> perRow(const DhTable& table, const VectorXd& q) {
  if (q.size() != table.variableCount())
    throw std::invalid_argument("the DH table has " + std::to_string(table.variableCount()) +
                                " variables, not " + std::to_string(q.size()));
  std::vector<double> values;
  Eigen::Index at = 0;
  for (const DhRow& row : table.rows) values.push_back(row.kind == DhJoint::Fixed ? 0.0 : q[at++]);
  return values;
}

}  // namespace

const char* toString(DhConvention convention) {
  return convention == DhConvention::Modified ? "modified" : "standard";
}

const char* toString(DhJoint kind) {
  switch (kind) {
    case DhJoint::Revolute: return "revolute";
    case DhJoint::Prismatic: return "prismatic";
    case DhJoint::Fixed: return "fixed";
  }
  return "unknown";
}

const char* toString(AxisPair kind) {
  switch (kind) {
    case AxisPair::Skew: return "skew";
    case AxisPair::Crossing: return "crossing";
    case AxisPair::Parallel: return "parallel";
    case AxisPair::Coincident: return "coincident";
  }
  return "unknown";
}

int DhTable::variableCount() const {
  return static_cast<int>(
      std::count_if(rows.begin(), rows.end(), [](const DhRow& r) { return r.kind != DhJoint::Fixed; }));
}

void validate(const DhTable& table) {
  if (table.rows.empty()) throw std::invalid_argument("a DH table needs at least one row");
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const DhRow& row = table.rows[i];
    const std::string which = "DH row " + std::to_string(i + 1);
    if (!std::isfinite(row.a) || !std::isfinite(row.alpha) || !std::isfinite(row.d) ||
        !std::isfinite(row.phi))
      throw std::invalid_argument(which + ": a, alpha, d and phi must be finite");
    if (!(row.lower <= row.upper))
      throw std::invalid_argument(which + ": the lower limit lies above the upper one");
  }
  if (table.rest && table.rest->size() != table.variableCount())
    throw std::invalid_argument("the rest pose of the DH table has " + std::to_string(table.rest->size()) +
                                " values for " + std::to_string(table.variableCount()) + " variables");
}

int parameterCount(const DhTable& table) { return 4 * static_cast<int>(table.rows.size()) + 3; }

Isometry3d dhTransform(const DhRow& row, DhConvention convention, double q) {
  const double phi = row.phi + (row.kind == DhJoint::Revolute ? q : 0.0);
  const double d = row.d + (row.kind == DhJoint::Prismatic ? q : 0.0);
  if (convention == DhConvention::Modified)
    return rotationX(row.alpha) * translation(row.a, 0.0, d) * rotationZ(phi);
  return rotationZ(phi) * translation(0.0, 0.0, d) * translation(row.a, 0.0, 0.0) * rotationX(row.alpha);
}

Frames dhFrames(const DhTable& table, const VectorXd& q) {
  const std::vector<double> values = perRow(table, q);
  Frames frames{table.base};
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    frames.push_back(frames.back() * dhTransform(table.rows[i], table.convention, values[i]));
  frames.push_back(frames.back() * table.tool);
  return frames;
}

Skeleton toSkeleton(const DhTable& table) {
  validate(table);
  std::vector<Joint> joints{{.name = "base", .parent = -1, .parentFromZero = table.base}};
  VectorXd rest(table.variableCount());
  int variables = 0, fixedRows = 0;
  Isometry3d carried = Isometry3d::Identity();  // what the row before left behind its variable
  for (const DhRow& row : table.rows) {
    Joint joint{.name = {}, .parent = static_cast<int>(joints.size()) - 1};
    const bool turns = row.kind == DhJoint::Revolute;
    if (table.convention == DhConvention::Modified) {
      joint.parentFromZero = rotationX(row.alpha) * translation(row.a, 0.0, row.d) * rotationZ(row.phi);
    } else if (turns) {
      joint.parentFromZero = carried * rotationZ(row.phi);
      carried = translation(row.a, 0.0, row.d) * rotationX(row.alpha);
    } else {
      joint.parentFromZero = carried * rotationZ(row.phi) * translation(0.0, 0.0, row.d);
      carried = translation(row.a, 0.0, 0.0) * rotationX(row.alpha);
    }
    if (row.kind == DhJoint::Fixed) {
      joint.name = "frame" + std::to_string(++fixedRows);
    } else {
      rest[variables] = table.rest ? (*table.rest)[variables] : std::clamp(0.0, row.lower, row.upper);
      joint.name = "joint" + std::to_string(++variables);
      joint.axes = {AxisDof{.kind = turns ? AxisDof::Kind::Rotation : AxisDof::Kind::Translation,
                            .axis = Vector3d::UnitZ(),
                            .lower = row.lower,
                            .upper = row.upper}};
    }
    joints.push_back(joint);
  }
  joints.push_back({.name = "tool",
                    .parent = static_cast<int>(joints.size()) - 1,
                    .parentFromZero = carried * table.tool});
  return Skeleton(std::move(joints), rest);
}

DhTable toConvention(const DhTable& table, DhConvention convention) {
  validate(table);
  if (convention == table.convention) return table;
  DhTable out = table;
  out.convention = convention;
  const std::size_t n = table.rows.size();
  if (convention == DhConvention::Standard) {  // [X_1 Z_1] [X_2 Z_2] ... = X_1 [Z_1 X_2] ... [Z_n]
    out.base = table.base * rotationX(table.rows[0].alpha) * translation(table.rows[0].a, 0.0, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      out.rows[i].a = i + 1 < n ? table.rows[i + 1].a : 0.0;
      out.rows[i].alpha = i + 1 < n ? table.rows[i + 1].alpha : 0.0;
    }
  } else {  // [Z_1 X_1] [Z_2 X_2] ... = [Z_1] [X_1 Z_2] ... X_n
    for (std::size_t i = 0; i < n; ++i) {
      out.rows[i].a = i > 0 ? table.rows[i - 1].a : 0.0;
      out.rows[i].alpha = i > 0 ? table.rows[i - 1].alpha : 0.0;
    }
    out.tool = translation(table.rows[n - 1].a, 0.0, 0.0) * rotationX(table.rows[n - 1].alpha) * table.tool;
  }
  return out;
}

CommonNormal commonNormal(const AxisLine& first, const AxisLine& second, const Vector3d& near,
                          const Vector3d& xHint) {
  constexpr double parallelSine = 1e-9, meetingDistance = 1e-9;
  for (const AxisLine* line : {&first, &second})
    if (!line->point.allFinite() || !line->direction.allFinite() || line->direction.norm() == 0.0)
      throw std::invalid_argument("a joint axis needs a finite point and a direction that is not zero");
  const Vector3d u = first.direction.normalized(), v = second.direction.normalized();
  const Vector3d cross = u.cross(v);
  CommonNormal normal;
  Vector3d gap;
  if (cross.norm() < parallelSine) {
    normal.footOnFirst = first.point + u * u.dot(near - first.point);
    gap = second.point - normal.footOnFirst;
    gap -= u * u.dot(gap);
    normal.kind = gap.norm() < meetingDistance ? AxisPair::Coincident : AxisPair::Parallel;
    if (normal.kind == AxisPair::Coincident) {
      gap.setZero();
      normal.x = xHint - u * u.dot(xHint);
      normal.x = normal.x.norm() > 1e-6 ? normal.x.normalized() : u.unitOrthogonal();
    } else {
      normal.x = gap.normalized();
    }
    normal.footOnSecond = normal.footOnFirst + gap;
  } else {
    // first.point + s u and second.point + t v are nearest where their difference is a multiple of u x v.
    const Vector3d between = second.point - first.point;
    const double s = between.cross(v).dot(cross) / cross.squaredNorm();
    const double t = between.cross(u).dot(cross) / cross.squaredNorm();
    normal.footOnFirst = first.point + s * u;
    normal.footOnSecond = second.point + t * v;
    const double signedDistance = between.dot(cross.normalized());
    normal.kind = std::abs(signedDistance) < meetingDistance ? AxisPair::Crossing : AxisPair::Skew;
    normal.x = cross.normalized() * (normal.kind == AxisPair::Skew && signedDistance < 0.0 ? -1.0 : 1.0);
    gap = normal.kind == AxisPair::Skew ? Vector3d(std::abs(signedDistance) * normal.x)
                                        : Vector3d(Vector3d::Zero());
  }
  normal.a = gap.norm();
  normal.alpha = std::atan2(cross.dot(normal.x), u.dot(v));
  return normal;
}

DhTable dhFromAxes(std::span<const AxisLine> axes, std::span<const DhJoint> kinds) {
  if (axes.empty()) throw std::invalid_argument("at least one joint axis is needed");
  if (!kinds.empty() && kinds.size() != axes.size())
    throw std::invalid_argument(std::to_string(kinds.size()) + " joint kinds are given for " +
                                std::to_string(axes.size()) + " axes");
  const auto kind = [&](std::size_t i) { return kinds.empty() ? DhJoint::Revolute : kinds[i]; };

  // The chain of normals. A lone axis is paired with itself.
  std::vector<CommonNormal> normals;
  Vector3d near = Vector3d::Zero(), x = Vector3d::UnitX();
  for (std::size_t i = 0; i + 1 < axes.size() || i == 0; ++i) {
    normals.push_back(commonNormal(axes[i], axes[std::min(i + 1, axes.size() - 1)], near, x));
    near = normals.back().footOnSecond;
    x = normals.back().x;
  }

  const Vector3d z = axes[0].direction.normalized();
  DhTable table;
  table.base.linear() << normals[0].x, z.cross(normals[0].x), z;
  table.base.translation() = normals[0].footOnFirst;
  table.rows.push_back({.kind = kind(0)});
  for (std::size_t i = 1; i < axes.size(); ++i) {
    const CommonNormal& here = normals[i - 1];
    const CommonNormal* next = i < normals.size() ? &normals[i] : nullptr;
    const Vector3d zi = axes[i].direction.normalized();
    DhRow row{.kind = kind(i), .a = here.a, .alpha = here.alpha};
    if (next) {
      row.d = (next->footOnFirst - here.footOnSecond).dot(zi);
      row.phi = std::atan2(here.x.cross(next->x).dot(zi), here.x.dot(next->x));
    }
    table.rows.push_back(row);
  }
  return table;
}

namespace {

/// Joints that move, on the way from the root to `end`; -1: to the end described in the header.
std::vector<int> movingChain(const Skeleton& skeleton, int& end) {
  std::vector<int> moving, leaves;
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (skeleton.qCount(i) > 0) moving.push_back(i);
    if (skeleton.children(i).empty()) leaves.push_back(i);
  }
  if (moving.empty())
    throw std::invalid_argument("a Denavit-Hartenberg table needs a joint that moves; there is none");
  const bool chosen = end >= 0;
  if (!chosen) end = leaves.size() == 1 ? leaves[0] : moving.back();
  std::vector<int> chain;
  for (const int i : moving) {
    if (!skeleton.isAncestor(i, end)) {
      if (chosen) continue;
      throw std::invalid_argument("a Denavit-Hartenberg table is one chain; joint '" +
                                  skeleton.joint(i).name + "' is not on the way to '" +
                                  skeleton.joint(end).name + "'. Name the end of the chain to be written");
    }
    if (skeleton.joint(i).coupling)
      throw std::invalid_argument("a Denavit-Hartenberg table has no couplings; joint '" +
                                  skeleton.joint(i).name + "' follows '" +
                                  skeleton.joint(skeleton.joint(i).coupling->source).name + "'");
    if (skeleton.joint(i).ball || skeleton.vCount(i) != 1)
      throw std::invalid_argument(
          "a Denavit-Hartenberg row has one degree of freedom, turning or sliding; joint '" +
          skeleton.joint(i).name + "' has " + std::to_string(skeleton.vCount(i)));
    chain.push_back(i);
  }
  if (chain.empty())
    throw std::invalid_argument("no joint moves on the way to '" + skeleton.joint(end).name + "'");
  return chain;
}

/// Largest difference of the end's frames, metres and entries of the rotation, over poses of all ranges.
double disagreement(const DhChain& chain, const Skeleton& skeleton, int end) {
  std::mt19937_64 random(1);
  double worst = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const VectorXd q = randomWithinLimits(skeleton, random);
    VectorXd variables(chain.joints.size());
    for (std::size_t k = 0; k < chain.joints.size(); ++k) variables[k] = q[skeleton.qIndex(chain.joints[k])];
    worst = std::max(worst, (dhFrames(chain.table, variables).back().matrix() -
                             forwardKinematics(skeleton, q)[end].matrix())
                                .cwiseAbs()
                                .maxCoeff());
  }
  return worst;
}

}  // namespace

DhChain dhFromSkeleton(const Skeleton& skeleton, int end) {
  DhChain chain;
  chain.joints = movingChain(skeleton, end);
  VectorXd zero = skeleton.rest();
  for (const int i : chain.joints) zero[skeleton.qIndex(i)] = 0.0;
  const Frames frames = forwardKinematics(skeleton, zero);
  std::vector<AxisLine> lines;
  std::vector<DhJoint> kinds;
  for (const int i : chain.joints) {
    const AxisDof& dof = skeleton.joint(i).axes[0];
    lines.push_back({frames[i].translation(), frames[i].linear() * dof.axis});
    kinds.push_back(dof.kind == AxisDof::Kind::Rotation ? DhJoint::Revolute : DhJoint::Prismatic);
  }
  chain.table = dhFromAxes(lines, kinds);
  VectorXd rest(chain.joints.size());
  for (std::size_t k = 0; k < chain.joints.size(); ++k) {
    const AxisDof& dof = skeleton.joint(chain.joints[k]).axes[0];
    chain.table.rows[k].lower = dof.lower, chain.table.rows[k].upper = dof.upper;
    rest[k] = skeleton.rest()[skeleton.qIndex(chain.joints[k])];
  }
  chain.table.rest = rest;
  const VectorXd none = VectorXd::Zero(chain.joints.size());
  chain.table.tool = dhFrames(chain.table, none).back().inverse() * frames[end];
  if (const double difference = disagreement(chain, skeleton, end); !(difference <= 1e-9))
    throw std::invalid_argument(
        "two neighbouring axes are so nearly parallel that the table would be off by " +
        std::to_string(difference) + " m or rad");
  return chain;
}

std::vector<AxisLine> jointAxes(const DhTable& table, const VectorXd& q) {
  const Frames frames = dhFrames(table, q);
  std::vector<AxisLine> axes;
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    if (table.rows[i].kind == DhJoint::Fixed) continue;
    // Modified: the variable moves along z of the row's own frame; standard: of the frame before.
    const Isometry3d& frame = table.convention == DhConvention::Modified ? frames[i + 1] : frames[i];
    axes.push_back({frame.translation(), frame.linear().col(2)});
  }
  return axes;
}

}  // namespace gelenk
