#include "skinning/muscles/muscle_skin.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::arm;
using testing::tube;

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
      EXPECT_LE((out.positions[v] - body.skin.mesh.positions[v]).norm(), 1e-12 * limb)
          << degrees << " vertex " << v;
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
    const int volume = body.vertices[v].volume;
    const FfdPlane* planes = &pose.planes[3 * volume];
    const Vector3d x = latticeOf({planes[0], planes[1], planes[2], planes[3]})
                           .position(pose.turned(volume, body.vertices[v].uvw));
    EXPECT_LE((x - body.skin.mesh.positions[v]).norm(), 1e-13);
  }
}

TEST(MuscleSkin, ALimbThatRestsTwistedStaysAtRestAndKeepsItsSections) {
  const Skeleton straight = arm(0.3);
  const Frames rest = restFrames(straight);
  MuscleSkin reference = bindMuscles(tube(straight), {makeLimb(straight, rest, "arm", {1, 2, 3})}, rest);
  Frames bound = rest;  // a rig whose forearm was bound turned about its bone
  Limb limb = reference.limbs[0];
  limb.jointFromLink[1] = limb.jointFromLink[1] * Eigen::AngleAxisd(1.1, Vector3d::UnitZ());
  const MuscleSkin body = bindMuscles(tube(straight), {limb}, bound);
  EXPECT_EQ(body.unbound, 0);
  SkinnedVertices out;
  skinWithMuscles(body, bound, poseLimbs(body, bound), out);
  for (std::size_t v = 0; v < out.positions.size(); ++v) {
    EXPECT_LE((out.positions[v] - body.skin.mesh.positions[v]).norm(), 1e-12);
    EXPECT_LE((out.normals[v] - body.skin.mesh.normals[v]).norm(), 1e-10);
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
    EXPECT_NEAR(area, 1.0, 1e-12);  // a candy wrapper goes to cos^2(85 degrees) = 0.008
  }
}

/// Turned by the wrist alone, the forearm's skin turns the way of the hand: not at the elbow, and more and
/// more towards the wrist.
TEST(MuscleSkin, TheForearmTurnsTheWayOfTheHand) {
  const Skeleton skeleton = arm(0.3);
  const Frames rest = restFrames(skeleton);
  const MuscleSkin body = bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
  for (const double twist : {2.0, -2.0}) {
    VectorXd q = skeleton.rest();
    setBallRotation(skeleton, q, 3, expRotation({0.0, 0.0, twist}));
    const Frames frames = forwardKinematics(skeleton, q);
    SkinnedVertices out;
    skinWithMuscles(body, frames, poseLimbs(body, frames), out);
    double last = 0.0;
    for (std::size_t v = 0; v < out.positions.size(); v += 24) {
      const Vector3d before = rest[2].inverse() * body.skin.mesh.positions[v],
                     after = rest[2].inverse() * out.positions[v];
      if (before.z() < 0.05) continue;
      const double turned = std::atan2(after.y(), after.x()) - std::atan2(before.y(), before.x());
      const double share = std::remainder(turned, 2.0 * M_PI) / twist;
      EXPECT_GE(share, last - 1e-9) << before.z();
      EXPECT_LE(share, 1.0 + 1e-9) << before.z();
      last = share;
    }
    EXPECT_GT(last, 0.9) << twist;
  }
}

/// Four joints in a row, the last at the given place seen from the one before.
Skeleton chain(const Vector3d& last, const Vector3d& hingeAxis) {
  std::vector<Joint> joints{Joint{.name = "root"}, Joint{.name = "hip", .parent = 0},
                            Joint{.name = "knee", .parent = 1}, Joint{.name = "ankle", .parent = 2}};
  joints[2].parentFromZero.translation() << 0.0, 0.0, 0.4;
  joints[3].parentFromZero.translation() = last;
  if (hingeAxis.norm() > 0.0) joints[2].axes.push_back({AxisDof::Kind::Rotation, hingeAxis, 0.0, 2.0});
  return Skeleton(joints);
}

TEST(MuscleSkin, LimbsThatCannotBeAreNamed) {
  const auto complaint = [](const Skeleton& skeleton, std::vector<int> joints) -> std::string {
    try {
      makeLimb(skeleton, restFrames(skeleton), "leg", std::move(joints));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  const Vector3d below(0.0, 0.0, 0.4), y = Vector3d::UnitY();
  EXPECT_EQ(complaint(chain(below, y), {1, 2, 3}), "accepted");
  EXPECT_EQ(complaint(chain(below, y), {1}), "limb 'leg' needs at least two joints");
  EXPECT_EQ(complaint(chain(below, y), {1, 3}), "limb 'leg': joint 'ankle' is no child of 'hip'");
  EXPECT_EQ(complaint(chain(below, y), {1, 9}), "limb 'leg' names joint 9, which does not exist");
  EXPECT_EQ(complaint(chain(Vector3d::Zero(), y), {1, 2, 3}),
            "limb 'leg': the link from 'knee' to 'ankle' has no length");
  EXPECT_EQ(complaint(chain(below, Vector3d::UnitZ()), {1, 2, 3}),
            "limb 'leg': the bend axis runs along a bone");
  EXPECT_EQ(complaint(chain(below, Vector3d::Zero()), {1, 2, 3}),
            "the limb of joint 'hip' rests straight and has no hinge: its bend axis must be given");
}

TEST(MuscleSkin, ALatticeWhosePlanesCrossIsNotBoundTo) {
  const Skeleton skeleton = arm(0.3);
  const Frames rest = restFrames(skeleton);
  Limb limb = makeLimb(skeleton, rest, "arm", {1, 2, 3});
  setJointGap(limb.shape, 0.6);
  EXPECT_THROW(bindMuscles(tube(skeleton), {limb}, rest), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
