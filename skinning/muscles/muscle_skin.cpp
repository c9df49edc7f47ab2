#include "skinning/muscles/muscle_skin.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double twistAboutZ(const Matrix3d& rotation) { return swingTwistCoordinates(Quaterniond(rotation)).z(); }

/// The bend axis at rest in world coordinates; see makeLimb.
Vector3d bendAxis(const Skeleton& skeleton, const Frames& rest, const std::vector<int>& joints,
                  const Vector3d& given) {
  if (given.norm() > 0.0) return given.normalized();
  for (std::size_t i = 1; i + 1 < joints.size(); ++i)
    for (const AxisDof& dof : skeleton.joint(joints[i]).axes)
      if (dof.kind == AxisDof::Kind::Rotation) {
        const double sign = std::abs(dof.upper) >= std::abs(dof.lower) ? 1.0 : -1.0;
        return sign * rest[joints[i]].linear() * dof.axis;
      }
  for (std::size_t i = 1; i + 1 < joints.size(); ++i) {
    const Vector3d before = rest[joints[i]].translation() - rest[joints[i - 1]].translation();
    const Vector3d after = rest[joints[i + 1]].translation() - rest[joints[i]].translation();
    const Vector3d axis = before.normalized().cross(after.normalized());
    if (axis.norm() > 1e-3) return axis.normalized();
  }
  throw std::invalid_argument("the limb of joint '" + skeleton.joint(joints.front()).name +
                              "' rests straight and has no hinge: its bend axis must be given");
}

/// A parameter w of the four planes at which the point lies in the blended plane, and its u, v there.
struct PlaneHit {
  Vector3d uvw = Vector3d::Zero();
  double distance = 0.0;  ///< from the middle of the rectangle, in rectangle widths
};

/// The affine volume contains x where n(w) . (x - origin(w)) = 0, n the normal of the blended plane: one
/// equation in w. All roots in [0, 1] are found by scanning and safeguarded Newton; the one nearest the bone
/// counts.
bool findInVolume(const FfdPlane* planes, const Vector3d& x, PlaneHit& best) {
  const auto offPlane = [&](double w) {
    const FfdSample at = evaluateAffine(planes, {0.0, 0.0, w});
    return at.derivatives.col(0).cross(at.derivatives.col(1)).dot(x - at.position);
  };
  constexpr int intervals = 24;
  bool found = false;
  double low = offPlane(0.0);
  for (int i = 0; i < intervals; ++i) {
    double a = static_cast<double>(i) / intervals, b = static_cast<double>(i + 1) / intervals;
    double fa = low;
    const double fb = offPlane(b);
    low = fb;
    if ((fa < 0.0) == (fb < 0.0) && fa != 0.0 && fb != 0.0) continue;
    for (int k = 0; k < 20; ++k) {  // bisection brings w within 1e-8, Newton on all three parameters finishes
      const double middle = 0.5 * (a + b), f = offPlane(middle);
      if ((f < 0.0) == (fa < 0.0)) {
        a = middle;
        fa = f;
      } else {
        b = middle;
      }
    }
    Vector3d uvw(0.5, 0.5, 0.5 * (a + b));
    for (int k = 0; k < 20; ++k) {
      const FfdSample at = evaluateAffine(planes, uvw);
      const Vector3d step = at.derivatives.partialPivLu().solve(x - at.position);
      if (!step.allFinite()) break;
      uvw += step;
      if (step.norm() < 1e-16) break;
    }
    if (!uvw.allFinite() || uvw.z() < -1e-9 || uvw.z() > 1.0 + 1e-9) continue;
    const FfdSample at = evaluateAffine(planes, uvw);
    if ((at.position - x).norm() > 1e-9 * (1.0 + x.norm()) || at.derivatives.determinant() <= 0.0) continue;
    const double distance = (uvw.head<2>() - Vector2d(0.5, 0.5)).norm();
    if (!found || distance < best.distance) best = {uvw, distance};
    found = true;
  }
  return found;
}

/// Vertices with less weight than this do not widen the section rectangle: the little that they follow the
/// limb is extrapolated.
constexpr double mainlyOnLimb = 0.3;

struct LimbShare {
  int limb = -1;
  double weight = 0.0;
};

LimbShare heaviestLimb(const Influences& in, const std::vector<Limb>& limbs) {
  LimbShare best;
  for (int l = 0; l < static_cast<int>(limbs.size()); ++l) {
    double weight = 0.0;
    for (int k = 0; k < 4; ++k)
      if (std::find(limbs[l].joints.begin(), limbs[l].joints.end() - 1, in.joints[k]) !=
          limbs[l].joints.end() - 1)
        weight += in.weights[k];
    if (weight > best.weight) best = {l, weight};
  }
  return best;
}

/// Parameters of x in the rest lattice of its limb; false where there are none.
bool bindVertex(const LimbPose& rest, const Vector3d& x, const Vector3d& n, LimbVertex& vertex) {
  PlaneHit best{};
  bool found = false;
  for (int v = 0; v < rest.volumeCount(); ++v) {
    PlaneHit hit;
    if (findInVolume(&rest.planes[3 * v], x, hit) && (!found || hit.distance < best.distance)) {
      best = hit;
      vertex.volume = v;
      found = true;
    }
  }
  const auto beyond = [&](const Eigen::Isometry3d& end, int volume, double side) {
    const Vector3d local = end.inverse(Eigen::Isometry) * x;
    if (side * local.z() < 0.0) return false;
    vertex.volume = volume;
    vertex.uvw = local;
    vertex.normal = end.linear().transpose() * n;
    return true;
  };
  if (!found)
    return beyond(rest.worldFromFarEnd, LimbVertex::beyondFar, 1.0) ||
           beyond(rest.worldFromNearEnd, LimbVertex::beyondNear, -1.0);
  vertex.uvw = rest.turned(vertex.volume, best.uvw, -1.0);
  vertex.normal = rest.evaluate(vertex.volume, vertex.uvw).derivatives.transpose() * n;
  return true;
}

}  // namespace

Limb makeLimb(const Skeleton& skeleton, const Frames& rest, std::string name, std::vector<int> joints,
              const Vector3d& bendAxisInWorld) {
  if (joints.size() < 2) throw std::invalid_argument("limb '" + name + "' needs at least two joints");
  std::vector<double> lengths;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if (joints[i] < 0 || joints[i] >= skeleton.jointCount())
      throw std::invalid_argument("limb '" + name + "' names joint " + std::to_string(joints[i]) +
                                  ", which does not exist");
    if (i == 0) continue;
    if (skeleton.parent(joints[i]) != joints[i - 1])
      throw std::invalid_argument("limb '" + name + "': joint '" + skeleton.joint(joints[i]).name +
                                  "' is no child of '" + skeleton.joint(joints[i - 1]).name + "'");
    lengths.push_back((rest[joints[i]].translation() - rest[joints[i - 1]].translation()).norm());
    if (!(lengths.back() > 0.0))
      throw std::invalid_argument("limb '" + name + "': the link from '" +
                                  skeleton.joint(joints[i - 1]).name + "' to '" +
                                  skeleton.joint(joints[i]).name + "' has no length");
  }

  Limb limb;
  limb.name = std::move(name);
  limb.joints = std::move(joints);
  limb.shape = defaultLimbShape(lengths);
  const Vector3d axis = bendAxis(skeleton, rest, limb.joints, bendAxisInWorld);
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const Eigen::Isometry3d& worldFromJoint = rest[limb.joints[i]];
    Matrix3d worldFromLink;
    const Vector3d z = (rest[limb.joints[i + 1]].translation() - worldFromJoint.translation()) / lengths[i];
    const Vector3d x = axis.cross(z);
    if (x.norm() < 1e-6)
      throw std::invalid_argument("limb '" + limb.name + "': the bend axis runs along a bone");
    worldFromLink << x.normalized(), z.cross(x.normalized()), z;
    limb.jointFromLink.push_back(worldFromJoint.linear().transpose() * worldFromLink);
  }
  limb.parent = skeleton.parent(limb.joints.front());
  const Matrix3d worldFromParent =
      limb.parent < 0 ? Matrix3d(Matrix3d::Identity()) : Matrix3d(rest[limb.parent].linear());
  limb.parentFromFirstLinkAtRest =
      worldFromParent.transpose() * rest[limb.joints.front()].linear() * limb.jointFromLink.front();
  limb.lastLinkFromTipAtRest =
      (rest[limb.joints.rbegin()[1]].linear() * limb.jointFromLink.back()).transpose() *
      rest[limb.joints.back()].linear();
  for (std::size_t j = 0; j < limb.joints.size(); ++j) {
    const std::size_t link = std::min(j, lengths.size() - 1);
    limb.twistCoordinates.push_back(coordinateAbout(
        skeleton, rest, limb.joints[j], rest[limb.joints[link]].linear() * limb.jointFromLink[link].col(2)));
  }
  const LimbFrames frames = limbFrames(limb, rest);
  for (std::size_t j = 1; j + 1 < limb.joints.size(); ++j) {
    const JointBend bend = jointBend(frames, static_cast<int>(j));
    limb.bendAtRest.push_back(bend.bend);
    limb.twistAtRest.push_back(bend.twist);
  }
  return limb;
}

LimbFrames limbFrames(const Limb& limb, const Frames& worldFromJoint, const Eigen::VectorXd* q) {
  LimbFrames frames;
  for (const int joint : limb.joints) frames.joints.push_back(worldFromJoint[joint].translation());
  for (std::size_t i = 0; i < limb.jointFromLink.size(); ++i)
    frames.rotations.push_back(worldFromJoint[limb.joints[i]].linear() * limb.jointFromLink[i]);
  if (limb.spreadNearTwist && limb.parent >= 0) {
    const Matrix3d sinceRest = limb.parentFromFirstLinkAtRest.transpose() *
                               worldFromJoint[limb.parent].linear().transpose() * frames.rotations.front();
    frames.nearTwist = -withWholeTurns(twistAboutZ(sinceRest), limb.twistCoordinates.front(), q);
  }
  const Matrix3d tipSinceRest = frames.rotations.back().transpose() *
                                worldFromJoint[limb.joints.back()].linear() *
                                limb.lastLinkFromTipAtRest.transpose();
  frames.farTwist = withWholeTurns(twistAboutZ(tipSinceRest), limb.twistCoordinates.back(), q);
  if (q)
    for (std::size_t j = 1; j + 1 < limb.joints.size(); ++j) {
      const double since = jointBend(frames, static_cast<int>(j)).twist - limb.twistAtRest[j - 1];
      frames.wholeTurns.push_back(withWholeTurns(since, limb.twistCoordinates[j], q) - since);
    }
  return frames;
}

MuscleSkin bindMuscles(Skin skin, std::vector<Limb> limbs, const Frames& restFrames) {
  for (const Limb& limb : limbs) validate(limb.shape);
  MuscleSkin body{
      .skin = std::move(skin), .limbs = std::move(limbs), .vertices = {}, .outside = {}, .unbound = 0};
  const std::size_t count = body.skin.mesh.positions.size();
  body.vertices.resize(count);
  body.outside = body.skin.influences;

  std::vector<LimbPose> rest;
  for (Limb& limb : body.limbs) rest.push_back(poseLimb(limb.shape, limbFrames(limb, restFrames)));

  // First with a provisional rectangle, then with the one that contains every vertex of the limb.
  std::vector<Eigen::AlignedBox2d> sections(body.limbs.size());
  for (std::size_t v = 0; v < count; ++v) {
    const LimbShare share = heaviestLimb(body.skin.influences[v], body.limbs);
    if (share.limb < 0) continue;
    LimbVertex vertex{.limb = share.limb, .weight = share.weight};
    if (!bindVertex(rest[share.limb], body.skin.mesh.positions[v], body.skin.mesh.normals[v], vertex)) {
      ++body.unbound;
      continue;
    }
    body.vertices[v] = vertex;
    const LimbShape& shape = body.limbs[share.limb].shape;
    if (vertex.volume >= 0 && vertex.weight >= mainlyOnLimb)
      sections[share.limb].extend(Vector2d(
          shape.sectionLower + vertex.uvw.head<2>().cwiseProduct(shape.sectionUpper - shape.sectionLower)));
  }
  for (std::size_t l = 0; l < body.limbs.size(); ++l) {
    if (sections[l].isEmpty()) continue;
    LimbShape& shape = body.limbs[l].shape;
    const Vector2d lower = shape.sectionLower, size = shape.sectionUpper - shape.sectionLower;
    const Vector2d margin = Vector2d::Constant(1e-3 * shape.links.front().length);
    shape.sectionLower = sections[l].min() - margin;
    shape.sectionUpper = sections[l].max() + margin;
    const Vector2d newSize = shape.sectionUpper - shape.sectionLower;
    for (LimbVertex& vertex : body.vertices) {
      if (vertex.limb != static_cast<int>(l) || vertex.volume < 0) continue;
      const Vector2d p = lower + vertex.uvw.head<2>().cwiseProduct(size);
      vertex.uvw.head<2>() = (p - shape.sectionLower).cwiseQuotient(newSize);
      vertex.normal.head<2>() = vertex.normal.head<2>().cwiseQuotient(size).cwiseProduct(newSize);
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    if (body.vertices[v].limb < 0) continue;
    const std::vector<int>& joints = body.limbs[body.vertices[v].limb].joints;
    Influences& out = body.outside[v];
    for (int k = 0; k < 4; ++k)
      if (std::find(joints.begin(), joints.end() - 1, out.joints[k]) != joints.end() - 1)
        out.weights[k] = 0.0;
  }
  return body;
}

std::vector<LimbPose> poseLimbs(const MuscleSkin& body, const Frames& worldFromJoint,
                                const Eigen::VectorXd* q) {
  std::vector<LimbPose> poses;
  for (const Limb& limb : body.limbs)
    poses.push_back(poseLimb(limb.shape, limbFrames(limb, worldFromJoint, q)));
  return poses;
}

Vector3d deformLimbPoint(const LimbPose& pose, const LimbVertex& vertex) {
  if (vertex.volume == LimbVertex::beyondNear) return pose.worldFromNearEnd * vertex.uvw;
  if (vertex.volume == LimbVertex::beyondFar) return pose.worldFromFarEnd * vertex.uvw;
  return pose.position(vertex.volume, vertex.uvw);
}

std::pair<Vector3d, Vector3d> deformLimbVertex(const LimbPose& pose, const LimbVertex& vertex) {
  if (vertex.volume < 0) {
    const Eigen::Isometry3d& end =
        vertex.volume == LimbVertex::beyondNear ? pose.worldFromNearEnd : pose.worldFromFarEnd;
    return {end * vertex.uvw, end.linear() * vertex.normal};
  }
  const FfdSample at = pose.evaluate(vertex.volume, vertex.uvw);
  return {at.position, deformedNormal(at, vertex.normal)};
}

void skinWithMuscles(const MuscleSkin& body, const Frames& worldFromJoint, const std::vector<LimbPose>& limbs,
                     SkinnedVertices& out) {
  const std::vector<Eigen::Isometry3d> matrices = skinningMatrices(body.skin, worldFromJoint);
  const std::size_t count = body.vertices.size();
  out.positions.resize(count);
  out.normals.resize(count);
  for (std::size_t v = 0; v < count; ++v) {
    Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
    double sum = 0.0;
    const Influences& in = body.outside[v];
    for (int k = 0; k < 4; ++k) {
      if (in.weights[k] == 0.0) continue;
      blend += in.weights[k] * matrices[in.joints[k]].matrix().topRows<3>();
      sum += in.weights[k];
    }
    Vector3d position = blend.leftCols<3>() * body.skin.mesh.positions[v] + blend.col(3);
    Vector3d normal = Vector3d::Zero();
    if (sum > 0.0) {  // cofactors of the blend, which carry the square of the weights' sum: back to the sum
      const Vector3d n = body.skin.mesh.normals[v];
      const Eigen::Matrix3d M = blend.leftCols<3>();
      normal << M.row(1).cross(M.row(2)).dot(n), M.row(2).cross(M.row(0)).dot(n),
          M.row(0).cross(M.row(1)).dot(n);
      normal /= sum;
    }
    const LimbVertex& vertex = body.vertices[v];
    if (vertex.limb >= 0) {
      const auto [x, n] = deformLimbVertex(limbs[vertex.limb], vertex);
      position += vertex.weight * x;
      normal += vertex.weight * n;
    }
    out.positions[v] = position;
    out.normals[v] = normal.normalized();
  }
}

}  // namespace gelenk
