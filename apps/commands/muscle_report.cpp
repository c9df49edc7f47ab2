#include "apps/commands/muscle_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "skinning/bodies/self_intersection.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr double degree = M_PI / 180.0;

/// The skinned mesh and, a vertex, the image of the rest normal under the deformation's derivative.
struct DeformedSurface {
  std::vector<Vector3d> positions, normalImages;
};

DeformedSurface deformLinear(const Skin& skin, const Frames& frames) {
  const auto matrices = skinningMatrices(skin, frames);
  DeformedSurface out;
  for (std::size_t v = 0; v < skin.mesh.positions.size(); ++v) {
    Vector3d x = Vector3d::Zero(), n = Vector3d::Zero();
    for (int k = 0; k < 4; ++k) {
      const Eigen::Isometry3d& T = matrices[skin.influences[v].joints[k]];
      x += skin.influences[v].weights[k] * (T * skin.mesh.positions[v]);
      n += skin.influences[v].weights[k] * (T.linear() * skin.mesh.normals[v]);
    }
    out.positions.push_back(x);
    out.normalImages.push_back(n);
  }
  return out;
}

DeformedSurface deformLayered(const MuscleSkin& body, const Frames& frames, const std::vector<LimbPose>& rest,
                              const std::vector<LimbPose>& now) {
  const auto matrices = skinningMatrices(body.skin, frames);
  SkinnedVertices skinned;
  skinWithMuscles(body, frames, now, skinned);
  DeformedSurface out{.positions = skinned.positions, .normalImages = {}};
  for (std::size_t v = 0; v < body.vertices.size(); ++v) {
    Vector3d n = Vector3d::Zero();
    for (int k = 0; k < 4; ++k)
      n += body.outside[v].weights[k] *
           (matrices[body.outside[v].joints[k]].linear() * body.skin.mesh.normals[v]);
    const LimbVertex& vertex = body.vertices[v];
    if (vertex.limb >= 0 && vertex.volume >= 0) {
      const Matrix3d J = now[vertex.limb].evaluate(vertex.volume, vertex.uvw).derivatives;
      const Matrix3d J0 = rest[vertex.limb].evaluate(vertex.volume, vertex.uvw).derivatives;
      n += vertex.weight * (J * J0.partialPivLu().solve(body.skin.mesh.normals[v]));
    } else if (vertex.limb >= 0) {
      const bool nearEnd = vertex.volume == LimbVertex::beyondNear;
      const Eigen::Isometry3d& end =
          nearEnd ? now[vertex.limb].worldFromNearEnd : now[vertex.limb].worldFromFarEnd;
      n += vertex.weight * (end.linear() * vertex.normal);
    }
    out.normalImages.push_back(n);
  }
  return out;
}

double smallestDeterminant(const Mesh& mesh, const DeformedSurface& at, const LimbSurface& surface) {
  std::vector<char> inLimb(mesh.positions.size(), 0);
  for (const int v : surface.vertices) inLimb[v] = 1;
  double smallest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b, c] : mesh.triangles) {
    if (!inLimb[a] || !inLimb[b] || !inLimb[c]) continue;
    const Vector3d rest =
        (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]);
    const Vector3d now = (at.positions[b] - at.positions[a]).cross(at.positions[c] - at.positions[a]);
    const double element = rest.dot(mesh.normals[a] + mesh.normals[b] + mesh.normals[c]);
    if (element > 1e-16)
      smallest =
          std::min(smallest, now.dot(at.normalImages[a] + at.normalImages[b] + at.normalImages[c]) / element);
  }
  return smallest;
}

double surfaceVolume(const LimbSurface& surface, const std::vector<Vector3d>& positions) {
  const Vector3d origin = positions[surface.vertices[0]];
  double sixfold = 0.0;
  for (const auto& [a, b, c] : surface.triangles)
    sixfold +=
        (positions[surface.vertices[a]] - origin)
            .dot((positions[surface.vertices[b]] - origin).cross(positions[surface.vertices[c]] - origin));
  return sixfold / 6.0;
}

/// Area inside the closed surface on the plane through point with the unit normal: each cut triangle gives
/// one oriented segment, and half the sum of p x q over them is the area, whatever the order.
double sectionArea(const LimbSurface& surface, const std::vector<Vector3d>& positions, const Vector3d& point,
                   const Vector3d& normal) {
  double twice = 0.0;
  for (const auto& triangle : surface.triangles) {
    Vector3d corner[3];
    double height[3];
    for (int k = 0; k < 3; ++k) {
      corner[k] = positions[surface.vertices[triangle[k]]] - point;
      height[k] = normal.dot(corner[k]);
    }
    Vector3d cut[2];
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((height[k] < 0.0) == (height[next] < 0.0)) continue;
      const Vector3d crossing =
          corner[k] + height[k] / (height[k] - height[next]) * (corner[next] - corner[k]);
      cut[height[k] < 0.0 ? 0 : 1] = crossing;  // up-going edge first: one orientation for all segments
    }
    if ((height[0] < 0.0) != (height[1] < 0.0) || (height[1] < 0.0) != (height[2] < 0.0))
      twice += normal.dot(cut[0].cross(cut[1]));
  }
  return std::abs(0.5 * twice);
}

/// q with joint turned so that its frame rotates by angle about the axis (unit, frame of the joint's zero
/// motion at the end).
VectorXd turned(const Skeleton& skeleton, VectorXd q, int joint, const Vector3d& axisInJoint, double angle) {
  const Joint& description = skeleton.joint(joint);
  if (description.ball) {
    setBallRotation(skeleton, q, joint, ballRotation(skeleton, q, joint) * expRotation(angle * axisInJoint));
    return q;
  }
  int best = -1;
  double alignment = 0.5;
  for (std::size_t k = 0; k < description.axes.size(); ++k) {
    const double along = description.axes[k].axis.dot(axisInJoint);
    if (description.axes[k].kind == AxisDof::Kind::Rotation && std::abs(along) > std::abs(alignment)) {
      best = static_cast<int>(k);
      alignment = along;
    }
  }
  if (best >= 0) q[skeleton.qIndex(joint) + best] += alignment > 0.0 ? angle : -angle;
  return q;
}

struct Method {
  const char* name;
  bool layered, volume, muscle;
};
constexpr Method methods[] = {{"lbs", false, false, false},
                              {"ffd", true, false, false},
                              {"ffd-volume", true, true, false},
                              {"ffd-muscle", true, true, true}};

class LimbMeasurement {
 public:
  LimbMeasurement(const Skeleton& skeleton, const Skin& skin, const Limb& limb)
      : rest_(restFrames(skeleton)),
        rig_(bindMuscles(skin, {limb}, rest_), rest_),
        restPoses_(poseLimbs(rig_.body(), rest_)) {}

  const Limb& limb() const { return rig_.body().limbs[0]; }

  /// Section planes at 10 % to 90 % of the link, by its bone.
  double smallestSection(int link, const std::vector<Vector3d>& positions, const Frames& frames) const {
    const LimbFrames now = limbFrames(limb(), frames), before = limbFrames(limb(), rest_);
    double smallest = std::numeric_limits<double>::infinity();
    for (double share = 0.1; share < 0.95; share += 0.1) {
      const auto area = [&](const LimbFrames& f, const std::vector<Vector3d>& x) {
        return sectionArea(rig_.surface(0), x, f.joints[link] + share * (f.joints[link + 1] - f.joints[link]),
                           f.rotations[link].col(2));
      };
      const double restArea = area(before, rig_.body().skin.mesh.positions);
      if (restArea > 0.0) smallest = std::min(smallest, area(now, positions) / restArea);
    }
    return smallest;
  }

  DeformationRow measure(const Method& method, const Frames& frames, const char* motion, double degrees,
                         int twistedLink) {
    rig_.controls()[0] = method.muscle ? defaultMuscleControl(limb()) : noMuscleControl(limb());
    rig_.controls()[0].keepVolume = method.volume;
    const DeformedSurface at = method.layered
                                   ? deformLayered(rig_.body(), frames, restPoses_, rig_.pose(frames))
                                   : deformLinear(rig_.body().skin, frames);
    const Mesh& mesh = rig_.body().skin.mesh;
    DeformationRow row{.limb = limb().name, .motion = motion, .method = method.name, .degrees = degrees};
    row.volume = surfaceVolume(rig_.surface(0), at.positions) / rig_.restVolume(0);
    row.smallestDet = smallestDeterminant(mesh, at, rig_.surface(0));
    row.intersectingPairs = static_cast<int>(selfIntersections(at.positions, mesh.triangles).size());
    if (twistedLink >= 0) row.smallestSection = smallestSection(twistedLink, at.positions, frames);
    return row;
  }

 private:
  Frames rest_;
  MuscleRig rig_;
  std::vector<LimbPose> restPoses_;
};

}  // namespace

Frames bentTo(const Skeleton& skeleton, const Limb& limb, double bend) {
  Frames frames = restFrames(skeleton);
  const LimbFrames rest = limbFrames(limb, frames);
  const Matrix3d turn =
      rest.rotations[0] * Eigen::AngleAxisd(bend, Vector3d::UnitY()) * rest.rotations[1].transpose();
  const Eigen::Isometry3d moved = Eigen::Translation3d(rest.joints[1]) *
                                  Eigen::Isometry3d(Eigen::Quaterniond(turn)) *
                                  Eigen::Translation3d(-rest.joints[1]);
  std::vector<char> carried(skeleton.jointCount(), 0);
  for (int j = limb.joints[1]; j < skeleton.jointCount(); ++j) {
    carried[j] = j == limb.joints[1] || (skeleton.parent(j) >= 0 && carried[skeleton.parent(j)]);
    if (carried[j]) frames[j] = moved * frames[j];
  }
  return frames;
}

std::vector<DeformationRow> measureLimb(const Skeleton& skeleton, const Skin& skin, const Limb& limb,
                                        const std::function<void(double)>& progress) {
  LimbMeasurement measurement(skeleton, skin, limb);
  const Limb& bound = measurement.limb();
  std::vector<DeformationRow> rows;
  const double steps = 16.0 + 2.0 * 18.0;
  double done = 0.0;
  if (bound.joints.size() > 2) {
    for (int degrees = 0; degrees <= 150; degrees += 10) {
      const Frames frames = bentTo(skeleton, bound, degrees * degree);
      for (const Method& method : methods)
        rows.push_back(measurement.measure(method, frames, "bend", degrees, -1));
      progress(++done / steps);
    }
  }
  for (std::size_t link = 0; link < 2 && link + 1 < bound.joints.size(); ++link)
    for (int degrees = 0; degrees <= 170; degrees += 10) {
      const VectorXd q = turned(skeleton, skeleton.rest(), bound.joints[link],
                                bound.jointFromLink[link].col(2), degrees * degree);
      const Frames frames = forwardKinematics(skeleton, q);
      for (const Method& method : methods)
        rows.push_back(measurement.measure(method, frames, link == 0 ? "twist-first" : "twist-second",
                                           degrees, static_cast<int>(link)));
      progress(++done / steps);
    }
  return rows;
}

std::string toCsv(const std::vector<DeformationRow>& rows) {
  std::string text = "limb,motion,method,degrees,volume,smallest_det,intersecting_pairs,smallest_section\n";
  for (const DeformationRow& row : rows)
    text += fmt::format("{},{},{},{:g},{:.9f},{:.6f},{},{:.6f}\n", row.limb, row.motion, row.method,
                        row.degrees, row.volume, row.smallestDet, row.intersectingPairs, row.smallestSection);
  return text;
}

}  // namespace gelenk
