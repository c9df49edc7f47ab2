#include "skinning/muscles/muscle_layer.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "kinematics/rotation.h"

namespace gelenk {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

using Axes = Eigen::Matrix<double, 3, 2>;

/// A plane in section coordinates p: centre + axes p.
struct SectionPlane {
  Vector3d centre;
  Axes axes;
};

FfdPlane onRectangle(const SectionPlane& plane, const LimbShape& shape) {
  return {plane.centre + plane.axes * shape.sectionLower,
          plane.axes * (shape.sectionUpper - shape.sectionLower).asDiagonal()};
}

Matrix2d turn(double angle) { return Eigen::Rotation2Dd(angle).toRotationMatrix(); }

const Matrix2d quarterTurn = (Matrix2d() << 0.0, -1.0, 1.0, 0.0).finished();  // J p = z x p

Matrix3d aboutZ(double angle) { return Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix(); }

double jointTwist(const LimbFrames& frames, int joint) {
  return jointBend(frames, joint).twist + (frames.wholeTurns.empty() ? 0.0 : frames.wholeTurns[joint - 1]);
}

/// At the seam between links that turn at these rates: the harmonic mean, 0 where they turn against each
/// other or only one does. The turn then never overshoots.
double meanRate(double before, double after) {
  return before * after > 0.0 ? 2.0 * before * after / (before + after) : 0.0;
}

/// The plane where two links meet, or where the limb begins or ends.
struct Seam {
  Matrix3d Q;                           ///< world from the plane without twist, z normal to it
  double wedge = 0.0;                   ///< tan(beta theta)
  Vector2d inside = Vector2d::UnitX();  ///< seam coordinates
  double turn = 0.0;                    ///< of the section against that plane
};

/// twist: of the links up to this joint, summed; the section coordinates of link i without twist are those of
/// R_i Rz(-twist_i).
Seam seamAt(const LimbShape& shape, const LimbFrames& frames, int joint, double twist) {
  const int links = static_cast<int>(shape.links.size());
  if (joint == 0) return {.Q = frames.rotations[0], .turn = frames.nearTwist};
  if (joint == links)
    return {.Q = frames.rotations[links - 1] * aboutZ(-twist), .turn = twist + frames.farTwist};

  const JointBend bend = jointBend(frames, joint);
  const double share =
      joint - 1 < static_cast<int>(shape.seamTwistShare.size()) ? shape.seamTwistShare[joint - 1] : 0.0;
  const Vector3d inside(bend.inside.x(), bend.inside.y(), 0.0);
  const Vector3d axis = Vector3d::UnitZ().cross(inside);  // turning z about it leads to the inside
  const Eigen::AngleAxisd halfSwing(0.5 * bend.bend, axis);
  return {.Q = frames.rotations[joint - 1] * halfSwing.toRotationMatrix() * aboutZ(-twist),
          .wedge = std::tan(shape.wedge * bend.bend),
          .inside = turn(twist) * bend.inside,
          .turn = twist + share * jointTwist(frames, joint)};
}

}  // namespace

LimbShape defaultLimbShape(const std::vector<double>& lengths) {
  LimbShape shape;
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const double L = lengths[i];
    if (!(L > 0.0) || !std::isfinite(L))
      throw std::invalid_argument("link " + std::to_string(i) + " of the limb has length " +
                                  std::to_string(L) + ", it must be positive");
    shape.links.push_back(
        {.length = L, .middle = 0.5 * L, .inner = L / 10.0, .nearGap = L / 6.0, .farGap = L / 6.0});
  }
  setJointGap(shape, elbowGap);
  validate(shape);
  return shape;
}

void setJointGap(LimbShape& shape, double share) {
  for (std::size_t i = 0; i + 1 < shape.links.size(); ++i)
    shape.links[i].farGap = shape.links[i + 1].nearGap =
        share * std::min(shape.links[i].length, shape.links[i + 1].length);
}

double jointGap(const LimbShape& shape) {
  return shape.links.size() < 2
             ? elbowGap
             : shape.links[0].farGap / std::min(shape.links[0].length, shape.links[1].length);
}

void validate(const LimbShape& shape) {
  if (shape.links.empty()) throw std::invalid_argument("a limb needs at least one link");
  for (std::size_t i = 0; i < shape.links.size(); ++i) {
    const LimbShape::Link& link = shape.links[i];
    const auto require = [i](bool holds, const char* rule) {
      if (!holds) throw std::invalid_argument("link " + std::to_string(i) + " of the limb violates " + rule);
    };
    require(link.length > 0.0 && std::isfinite(link.length), "length > 0");
    require(link.inner > 0.0, "inner > 0");
    require(link.nearGap > 0.0 && link.nearGap < link.middle - link.inner, "0 < nearGap < middle - inner");
    require(link.farGap > 0.0 && link.middle + link.inner < link.length - link.farGap,
            "0 < farGap, middle + inner < length - farGap");
    require(i == 0 || std::abs(shape.links[i - 1].farGap - link.nearGap) <= 1e-12 * link.length,
            "nearGap equal to farGap of the link before (C1 needs the ratio 1:1)");
  }
  if (!((shape.sectionUpper - shape.sectionLower).minCoeff() > 0.0))
    throw std::invalid_argument("the limb's section rectangle is empty");
  if (!(shape.wedge >= 0.0 && shape.wedge < 0.5))
    throw std::invalid_argument("the limb's wedge must lie in [0, 1/2)");
}

JointBend jointBend(const LimbFrames& frames, int joint) {
  Quaterniond q(frames.rotations[joint - 1].transpose() * frames.rotations[joint]);
  if (q.w() < 0.0) q.coeffs() *= -1.0;
  const SwingTwist split = splitSwingTwist(q);
  JointBend bend;
  const Vector2d axis(split.swing.x(), split.swing.y());
  bend.bend = 2.0 * std::atan2(axis.norm(), split.swing.w());
  bend.twist = 2.0 * std::atan2(split.twist.z(), split.twist.w());
  if (bend.twist > M_PI) bend.twist -= 2.0 * M_PI;
  if (bend.twist <= -M_PI) bend.twist += 2.0 * M_PI;
  // The swing about a carries z towards a x z = (a.y, -a.x). Straight: any side will do, the wedge vanishes.
  if (axis.norm() > 0.0) bend.inside = Vector2d(axis.y(), -axis.x()).normalized();
  return bend;
}

LimbPose poseLimb(const LimbShape& shape, const LimbFrames& frames, const std::vector<MuscleState>& muscles) {
  const int links = static_cast<int>(shape.links.size());
  std::vector<double> twist(links, 0.0);  // of each link against the first, along the limb
  for (int i = 1; i < links; ++i) twist[i] = twist[i - 1] + jointTwist(frames, i);
  std::vector<Seam> seams;
  for (int j = 0; j <= links; ++j) seams.push_back(seamAt(shape, frames, j, j > 0 ? twist[j - 1] : 0.0));
  std::vector<double> rate(links);  // of the turn along each bone, radians a metre
  for (int i = 0; i < links; ++i) rate[i] = (seams[i + 1].turn - seams[i].turn) / shape.links[i].length;

  LimbPose pose;
  pose.sectionLower = shape.sectionLower;
  pose.sectionSize = shape.sectionUpper - shape.sectionLower;
  pose.planes.resize(6 * links + 1);
  pose.turns.resize(pose.planes.size());
  const bool displaced = std::any_of(muscles.begin(), muscles.end(), [](const MuscleState& m) {
    return !m.plane2.displacement.empty() || !m.plane4.displacement.empty();
  });

  for (int j = 0; j <= links; ++j) {  // the seam and the connecting planes before and after it
    const Seam& seam = seams[j];
    const bool end = j == 0 || j == links;
    const double gap = j == 0 ? shape.links[0].nearGap : shape.links[j - 1].farGap;
    const double turnOverGap = end ? 0.0 : gap * meanRate(rate[j - 1], rate[j]);
    const Vector3d N = seam.Q.col(2);
    const SectionPlane at{frames.joints[j], seam.Q.leftCols<2>()};
    const Axes tangentAxes =
        -seam.wedge * N * seam.inside.transpose();  // T(p) = [gap - wedge (inside . p)] N
    const auto put = [&](int plane, double side) {
      pose.planes[plane] = onRectangle({at.centre + side * gap * N, at.axes + side * tangentAxes}, shape);
      pose.turns[plane] = seam.turn + side * turnOverGap;
    };
    put(6 * j, 0.0);
    if (j > 0) put(6 * j - 1, -1.0);
    if (j < links) put(6 * j + 1, 1.0);
  }

  for (int i = 0; i < links; ++i) {  // the inner planes
    const LimbShape::Link& link = shape.links[i];
    const Matrix3d& R = frames.rotations[i];
    const double middleTurn = 0.5 * (seams[i].turn + seams[i + 1].turn);
    for (const int k : {-1, 0, 1}) pose.turns[6 * i + 3 + k] = middleTurn + k * link.inner * rate[i];
    // Muscles stretch and shift the section as it is turned in the middle: S and t in its own coordinates.
    const Matrix3d turned = R * aboutZ(middleTurn - twist[i]);
    const MuscleState muscle = i < static_cast<int>(muscles.size()) ? muscles[i] : MuscleState{};
    const auto inner = [&](const MusclePlane& control, double side) {
      const Axes axes = turned.leftCols<2>();
      return SectionPlane{
          frames.joints[i] + (link.middle + side * link.inner) * R.col(2) + axes * control.offset,
          axes * control.stretch * turn(-middleTurn)};
    };
    const SectionPlane second = inner(muscle.plane2, -1.0), fourth = inner(muscle.plane4, +1.0);
    pose.planes[6 * i + 2] = onRectangle(second, shape);
    pose.planes[6 * i + 3] =
        onRectangle({0.5 * (second.centre + fourth.centre), 0.5 * (second.axes + fourth.axes)}, shape);
    pose.planes[6 * i + 4] = onRectangle(fourth, shape);

    pose.worldFromDisplacement.push_back(turned * Vector3d(muscle.swell, muscle.swell, 1.0).asDiagonal());
    if (!displaced) continue;
    for (const int half : {0, 1}) {
      pose.displacement.push_back(displacementLattice(muscle, half));
      for (Vector3d& p : pose.displacement.back().points) p = pose.worldFromDisplacement.back() * p;
    }
  }

  const auto endFrame = [](const Seam& seam, const Vector3d& origin) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() = seam.Q * aboutZ(seam.turn);
    frame.translation() = origin;
    return frame;
  };
  pose.worldFromNearEnd = endFrame(seams.front(), frames.joints.front());
  pose.worldFromFarEnd = endFrame(seams.back(), frames.joints.back());
  return pose;
}

FfdLattice displacementLattice(const MuscleState& muscle, int half) {
  FfdLattice lattice;
  lattice.points.fill(Vector3d::Zero());
  const auto add = [&](const MusclePlane& control, int plane, double share) {  // plane of the half's four
    if (!control.displacement.empty() && control.displacement.size() != 16)
      throw std::invalid_argument("a muscle plane has " + std::to_string(control.displacement.size()) +
                                  " displaced control points, expected 16");
    for (std::size_t c = 0; c < control.displacement.size(); ++c)
      lattice.points[16 * plane + c] += share * control.displacement[c];
  };
  const int middle = half == 0 ? 3 : 0;
  add(muscle.plane2, middle, 0.5);
  add(muscle.plane4, middle, 0.5);
  add(half == 0 ? muscle.plane2 : muscle.plane4, half == 0 ? 2 : 1, 1.0);
  return lattice;
}

FfdPlane LimbPose::turnedPlane(int plane) const {
  const Matrix2d T = turn(turns[plane]);
  const FfdPlane& from = planes[plane];
  const Vector2d corner = (T * sectionLower - sectionLower).cwiseQuotient(sectionSize);
  return {from.point(corner.x(), corner.y()),
          from.axes * sectionSize.cwiseInverse().asDiagonal() * T * sectionSize.asDiagonal()};
}

std::array<Vector3d, 16> LimbPose::controlPoints(int plane) const {
  const FfdPlane at = turnedPlane(plane);
  const int volume = std::min(plane / 3, volumeCount() - 1);
  std::array<Vector3d, 16> points;
  for (int c = 0; c < 16; ++c) {
    points[c] = at.point(c % 4 / 3.0, c / 4 / 3.0);
    if (!displacement.empty()) points[c] += displacement[volume].points[16 * (plane - 3 * volume) + c];
  }
  return points;
}

Vector3d LimbPose::turned(int volume, const Vector3d& uvw, double sign) const {
  const double angle = bernstein(uvw.z()).dot(Eigen::Map<const Eigen::Vector4d>(&turns[3 * volume]));
  const Vector2d p = sectionLower + uvw.head<2>().cwiseProduct(sectionSize);
  Vector3d out = uvw;
  out.head<2>() = (turn(sign * angle) * p - sectionLower).cwiseQuotient(sectionSize);
  return out;
}

Vector3d LimbPose::position(int volume, const Vector3d& uvw) const {
  const Vector3d x = evaluateAffine(&planes[3 * volume], turned(volume, uvw)).position;
  return displacement.empty() ? x : Vector3d(x + displacement[volume].position(uvw));
}

FfdSample LimbPose::evaluate(int volume, const Vector3d& uvw) const {
  const Eigen::Map<const Eigen::Vector4d> angles(&turns[3 * volume]);
  const double rate = bernsteinDerivative(uvw.z()).dot(angles);
  const Matrix2d T = turn(bernstein(uvw.z()).dot(angles));
  const Vector2d p = T * (sectionLower + uvw.head<2>().cwiseProduct(sectionSize)),
                 uv = (p - sectionLower).cwiseQuotient(sectionSize);
  FfdSample at = evaluateAffine(&planes[3 * volume], {uv.x(), uv.y(), uvw.z()});
  const Axes perMetre = at.derivatives.leftCols<2>() * sectionSize.cwiseInverse().asDiagonal();
  at.derivatives.leftCols<2>() = perMetre * T * sectionSize.asDiagonal();
  at.derivatives.col(2) += rate * perMetre * (quarterTurn * p);
  if (displacement.empty()) return at;
  const FfdSample displaced = displacement[volume].evaluate(uvw);
  at.position += displaced.position;
  at.derivatives += displaced.derivatives;
  return at;
}

}  // namespace gelenk
