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

/// One end of a link's stretch of twist: the plane where it begins or ends and the tangent there.
struct Seam {
  Matrix3d Q;                           ///< worldFromSeam, z normal to the plane
  double wedge = 0.0;                   ///< tan(beta theta)
  Vector2d inside = Vector2d::UnitX();  ///< seam coordinates
  double twistBefore = 0.0;             ///< of the plane against the link before, about its z
  double twistAfter = 0.0;              ///< against the link after
};

Seam seamAt(const LimbShape& shape, const LimbFrames& frames, int joint) {
  const int links = static_cast<int>(shape.links.size());
  if (joint == 0)
    return {.Q = frames.rotations[0] * Eigen::AngleAxisd(frames.nearTwist, Vector3d::UnitZ()),
            .twistAfter = frames.nearTwist};
  if (joint == links)
    return {.Q = frames.rotations[links - 1] * Eigen::AngleAxisd(frames.farTwist, Vector3d::UnitZ()),
            .twistBefore = frames.farTwist};

  const JointBend bend = jointBend(frames, joint);
  const double share =
      joint - 1 < static_cast<int>(shape.seamTwistShare.size()) ? shape.seamTwistShare[joint - 1] : 0.5;
  const Vector3d inside(bend.inside.x(), bend.inside.y(), 0.0);
  const Vector3d axis = Vector3d::UnitZ().cross(inside);  // turning z about it leads to the inside
  const Eigen::AngleAxisd halfSwing(0.5 * bend.bend, axis);
  const Eigen::AngleAxisd partTwist(share * bend.twist, Vector3d::UnitZ());
  return {.Q = frames.rotations[joint - 1] * (halfSwing * partTwist).toRotationMatrix(),
          .wedge = std::tan(shape.wedge * bend.bend),
          .inside = turn(-share * bend.twist) * bend.inside,
          .twistBefore = share * bend.twist,
          .twistAfter = (share - 1.0) * bend.twist};
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
  std::vector<Seam> seams;
  for (int j = 0; j <= links; ++j) seams.push_back(seamAt(shape, frames, j));

  std::vector<double> twistRate(links);  // radians a metre along each bone
  for (int i = 0; i < links; ++i)
    twistRate[i] = (seams[i + 1].twistBefore - seams[i].twistAfter) / shape.links[i].length;

  LimbPose pose;
  pose.planes.resize(6 * links + 1);
  const bool displaced = std::any_of(muscles.begin(), muscles.end(), [](const MuscleState& m) {
    return !m.plane2.displacement.empty() || !m.plane4.displacement.empty();
  });
  if (displaced) {
    std::array<Vector3d, 16> none;
    none.fill(Vector3d::Zero());
    pose.displacement.assign(pose.planes.size(), none);
  }

  for (int j = 0; j <= links; ++j) {  // the seam and the connecting planes before and after it
    const Seam& seam = seams[j];
    const bool end = j == 0 || j == links;
    const double rate = end ? 0.0 : 0.5 * (twistRate[j - 1] + twistRate[j]);
    const double gap = j == 0 ? shape.links[0].nearGap : shape.links[j - 1].farGap;
    const Vector3d N = seam.Q.col(2);
    const SectionPlane at{frames.joints[j], seam.Q.leftCols<2>()};
    // T(p) = [gap - wedge (inside . p)] N + gap rate (N x Q p)
    const Axes tangentAxes = -seam.wedge * N * seam.inside.transpose() + gap * rate * at.axes * quarterTurn;
    pose.planes[6 * j] = onRectangle(at, shape);
    if (j > 0) pose.planes[6 * j - 1] = onRectangle({at.centre - gap * N, at.axes - tangentAxes}, shape);
    if (j < links) pose.planes[6 * j + 1] = onRectangle({at.centre + gap * N, at.axes + tangentAxes}, shape);
  }

  for (int i = 0; i < links; ++i) {  // the inner planes
    const LimbShape::Link& link = shape.links[i];
    const Matrix3d& R = frames.rotations[i];
    const double middleTwist = 0.5 * (seams[i].twistAfter + seams[i + 1].twistBefore);
    const MuscleState muscle = i < static_cast<int>(muscles.size()) ? muscles[i] : MuscleState{};
    const auto inner = [&](const MusclePlane& control, double side) {
      const Matrix2d section =
          (Matrix2d::Identity() + side * link.inner * twistRate[i] * quarterTurn) * turn(middleTwist);
      const Axes axes = R.leftCols<2>() * section;
      return SectionPlane{
          frames.joints[i] + (link.middle + side * link.inner) * R.col(2) + axes * control.offset,
          axes * control.stretch};
    };
    const SectionPlane second = inner(muscle.plane2, -1.0), fourth = inner(muscle.plane4, +1.0);
    pose.planes[6 * i + 2] = onRectangle(second, shape);
    pose.planes[6 * i + 3] =
        onRectangle({0.5 * (second.centre + fourth.centre), 0.5 * (second.axes + fourth.axes)}, shape);
    pose.planes[6 * i + 4] = onRectangle(fourth, shape);

    const Matrix3d turned = R * Eigen::AngleAxisd(middleTwist, Vector3d::UnitZ()) *
                            Vector3d(muscle.swell, muscle.swell, 1.0).asDiagonal();
    pose.worldFromDisplacement.push_back(turned);
    if (!displaced) continue;
    const auto displace = [&](const MusclePlane& control, int plane) {
      if (!control.displacement.empty() && control.displacement.size() != 16)
        throw std::invalid_argument("a muscle plane has " + std::to_string(control.displacement.size()) +
                                    " displaced control points, expected 16");
      for (std::size_t c = 0; c < control.displacement.size(); ++c)
        pose.displacement[plane][c] = turned * control.displacement[c];
    };
    displace(muscle.plane2, 6 * i + 2);
    displace(muscle.plane4, 6 * i + 4);
    for (int c = 0; c < 16; ++c)
      pose.displacement[6 * i + 3][c] =
          0.5 * (pose.displacement[6 * i + 2][c] + pose.displacement[6 * i + 4][c]);
  }

  const auto endFrame = [](const Seam& seam, const Vector3d& origin) {
    Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
    frame.linear() = seam.Q;
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
    for (std::size_t c = 0; c < control.displacement.size(); ++c)
      lattice.points[16 * plane + c] += share * control.displacement[c];
  };
  const int middle = half == 0 ? 3 : 0;
  add(muscle.plane2, middle, 0.5);
  add(muscle.plane4, middle, 0.5);
  add(half == 0 ? muscle.plane2 : muscle.plane4, half == 0 ? 2 : 1, 1.0);
  return lattice;
}

std::array<Vector3d, 16> LimbPose::controlPoints(int plane) const {
  std::array<Vector3d, 16> points;
  for (int c = 0; c < 16; ++c) {
    points[c] = planes[plane].point(c % 4 / 3.0, c / 4 / 3.0);
    if (!displacement.empty()) points[c] += displacement[plane][c];
  }
  return points;
}

FfdLattice LimbPose::lattice(int volume) const {
  FfdLattice lattice;
  for (int k = 0; k < 4; ++k) {
    const auto points = controlPoints(3 * volume + k);
    std::copy(points.begin(), points.end(), lattice.points.begin() + 16 * k);
  }
  return lattice;
}

FfdSample LimbPose::evaluate(int volume, const Vector3d& uvw) const {
  return displacement.empty() ? evaluateAffine(&planes[3 * volume], uvw) : lattice(volume).evaluate(uvw);
}

}  // namespace gelenk
