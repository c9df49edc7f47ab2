#include "skinning/muscle_skin.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinematics/configuration.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

/// Shoulder ball, elbow hinge about y, wrist ball; upper arm along z, elbow resting bent by restBend.
Skeleton arm(double restBend) {
  std::vector<Joint> joints{Joint{.name = "chest"}, Joint{.name = "shoulder", .parent = 0, .ball = true},
                            Joint{.name = "elbow", .parent = 1}, Joint{.name = "wrist", .parent = 2, .ball = true}};
  joints[1].parentFromZero.translation() << 0.1, 0.2, 0.0;
  joints[2].parentFromZero.translation() << 0.0, 0.0, 0.30;
  joints[2].axes.push_back({AxisDof::Kind::Rotation, Vector3d::UnitY(), 0.0, 2.6});
  joints[3].parentFromZero.translation() << 0.0, 0.0, 0.25;
  Skeleton zero(joints);
  VectorXd rest = neutral(zero);
  rest[zero.qIndex(2)] = restBend;
  return Skeleton(joints, rest);
}

/// A tube of radius 4 cm around the resting bones, weights blended over 10 cm at the elbow and by arc length.
Skin tube(const Skeleton& skeleton) {
  const Frames rest = restFrames(skeleton);
  const double bend = skeleton.rest()[skeleton.qIndex(2)];
  Mesh mesh;
  std::vector<Influences> influences;
  constexpr int rings = 60, sides = 24;
  for (int r = 0; r < rings; ++r) {
    const double s = -0.02 + 0.60 * r / (rings - 1), fromElbow = s - 0.30;
    const double share = 0.5 * (1.0 + std::tanh(fromElbow / 0.03));
    // The elbow's frame turned back by the unbent part, so that rings do not cross on the inside.
    Eigen::Isometry3d frame = rest[1];
    if (fromElbow > 0.0) {
      frame = rest[2];
      frame.translate(Vector3d(0, 0, fromElbow));
    } else {
      frame.translate(Vector3d(0, 0, s));
    }
    const double half = bend * (fromElbow > 0.0 ? -0.5 : 0.5) * std::exp(-std::abs(fromElbow) / 0.04);
    frame.rotate(Eigen::AngleAxisd(half, Vector3d::UnitY()));
    for (int k = 0; k < sides; ++k) {
      const double a = 2.0 * M_PI * k / sides;
      mesh.positions.push_back(frame * Vector3d(0.04 * std::cos(a), 0.04 * std::sin(a), 0.0));
      influences.push_back({{1, 2, 0, 0}, {1.0 - share, share, 0.0, 0.0}});
    }
  }
  for (int r = 0; r + 1 < rings; ++r)
    for (int k = 0; k < sides; ++k) {
      const int a = r * sides + k, b = r * sides + (k + 1) % sides;
      mesh.triangles.push_back({a, b, b + sides});
      mesh.triangles.push_back({a, b + sides, a + sides});
    }
  return bindSkin(mesh, rest, influences);
}

TEST(MuscleSkin, RestPoseIsTheIdentityHoweverTheRigRests) {
  for (const double degrees : {0.0, 6.0, 47.0, 80.0}) {
    const Skeleton skeleton = arm(degrees * M_PI / 180.0);
    const Frames rest = restFrames(skeleton);
    const MuscleSkin body = bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
    EXPECT_EQ(body.unbound, 0);
    SkinnedVertices out;
    skinWithMuscles(body, rest, poseLimbs(body, rest), out);
    const double limb = 0.55;
    for (std::size_t v = 0; v < out.positions.size(); ++v) {
      EXPECT_LE((out.positions[v] - body.skin.mesh.positions[v]).norm(), 1e-12 * limb) << degrees << " vertex " << v;
      EXPECT_LE((out.normals[v] - body.skin.mesh.normals[v]).norm(), 1e-10);
    }
  }
}

TEST(MuscleSkin, SixtyFourControlPointsGiveTheSameRestPose) {
  const Skeleton skeleton = arm(0.8);
  const Frames rest = restFrames(skeleton);
  const MuscleSkin body = bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
  const LimbPose pose = poseLimbs(body, rest)[0];
  for (std::size_t v = 0; v < body.vertices.size(); ++v) {
    if (body.vertices[v].volume < 0) continue;
    const Vector3d x = pose.lattice(body.vertices[v].volume).position(body.vertices[v].uvw);
    EXPECT_LE((x - body.skin.mesh.positions[v]).norm(), 1e-13);
  }
}

TEST(MuscleSkin, RigidMotionOfTheWholeBodyMovesEveryVertexAlike) {
  const Skeleton skeleton = arm(0.3);
  const Frames rest = restFrames(skeleton);
  const MuscleSkin body = bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
  Eigen::Isometry3d motion(expRotation({0.3, 1.2, -0.7}));
  motion.translation() << 1.0, -2.0, 0.5;
  Frames moved = rest;
  for (auto& frame : moved) frame = motion * frame;
  SkinnedVertices out;
  skinWithMuscles(body, moved, poseLimbs(body, moved), out);
  for (std::size_t v = 0; v < out.positions.size(); ++v)
    EXPECT_LE((out.positions[v] - motion * body.skin.mesh.positions[v]).norm(), 1e-13);
}

TEST(MuscleSkin, AxialTwistOfTheShoulderIsSpreadAndDoesNotCollapseTheUpperArm) {
  const Skeleton skeleton = arm(0.3);
  const Frames rest = restFrames(skeleton);
  const MuscleSkin body = bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
  VectorXd q = skeleton.rest();
  setBallRotation(skeleton, q, 1, expRotation({0.0, 0.0, 170.0 * M_PI / 180.0}));
  const LimbFrames frames = limbFrames(body.limbs[0], forwardKinematics(skeleton, q));
  EXPECT_NEAR(frames.nearTwist, -170.0 * M_PI / 180.0, 1e-12);
  const LimbPose pose = poseLimb(body.limbs[0].shape, frames);
  for (double w = 0.0; w <= 1.0; w += 0.1) {
    const FfdSample at = pose.evaluate(0, {0.5, 0.5, w});
    const Eigen::Vector2d size = body.limbs[0].shape.sectionUpper - body.limbs[0].shape.sectionLower;
    const double area = at.derivatives.col(0).cross(at.derivatives.col(1)).norm() / size.prod();
    EXPECT_GT(area, 0.7);  // a candy wrapper goes to cos^2(85 degrees) = 0.008
  }
}

TEST(MuscleSkin, LimbsThatCannotBeAreNamed) {
  const Skeleton skeleton = arm(0.3);
  const Frames rest = restFrames(skeleton);
  EXPECT_THROW(makeLimb(skeleton, rest, "x", {1}), std::invalid_argument);
  EXPECT_THROW(makeLimb(skeleton, rest, "x", {1, 3}), std::invalid_argument);
  EXPECT_THROW(makeLimb(skeleton, rest, "x", {1, 9}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
