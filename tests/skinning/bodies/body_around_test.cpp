#include "skinning/bodies/body_around.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kinematics/configuration.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/notation/planar_chain.h"
#include "kinematics/notation/robots.h"
#include "skinning/rigging/bone.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/sanitized.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr int trees = testing::sanitized ? 2 : 6;

/// Closed, manifold, one piece, and every joint of a bone inside.
void expectBody(const Skeleton& skeleton, const Mesh& mesh, const std::string& what) {
  const MeshTopology facts = topology(mesh);
  EXPECT_TRUE(facts.closed()) << what;
  EXPECT_TRUE(facts.manifold()) << what;
  EXPECT_EQ(facts.components, 1) << what;
  EXPECT_EQ(facts.degenerateTriangles, 0) << what;
  EXPECT_GT(enclosedVolume(mesh), 0.0) << what;
  const BodyShape shape = shapeAround(skeleton);
  for (const Bone& bone : bonesOf(skeleton, restFrames(skeleton)))
    EXPECT_LT(shape.value(bone.from, shape.everywhere()), 0.0)
        << what << ", " << skeleton.joint(bone.joint).name;
}

TEST(BodyAround, ThePlanarArmGetsAFlatBodyAtItsOwnScale) {
  const Skeleton arm = toSkeleton(lecturePlanarChain());  // links of 150, 200 and 100 units
  const Mesh mesh = bodyAround(arm);
  expectBody(arm, mesh, "planar arm");
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  EXPECT_GT(box.sizes().head<2>().maxCoeff(), 250.0);
  EXPECT_LT(box.sizes().z(), 60.0);
  EXPECT_GT(box.sizes().z(), 20.0);
}

TEST(BodyAround, ItIsFreeOfUnits) {
  std::vector<Joint> joints = toSkeleton(lecturePlanarChain()).joints();
  const Mesh large = bodyAround(Skeleton(joints));
  for (Joint& joint : joints) joint.parentFromZero.translation() *= 1.0 / 1024.0;  // exact in binary
  const Mesh small = bodyAround(Skeleton(joints));
  ASSERT_NEAR(small.positions.size(), large.positions.size(), 0.01 * large.positions.size());
  EXPECT_NEAR(enclosedVolume(small) * std::pow(1024.0, 3), enclosedVolume(large),
              1e-3 * enclosedVolume(large));
}

TEST(BodyAround, EveryBuiltInRobotGetsAClosedManifoldBody) {
  for (const Robot& robot : robots()) {
    const Skeleton skeleton = toSkeleton(robot.table());
    expectBody(skeleton, bodyAround(skeleton), std::string(robot.name));
  }
}

TEST(BodyAround, SoDoesTheFigureAndItsFingersStayApart) {
  const Skeleton figure = mannequin();
  const Mesh mesh = bodyAround(figure);
  expectBody(figure, mesh, "figure");
  EXPECT_EQ(topology(mesh).eulerCharacteristic(), 2);
}

TEST(BodyAround, SoDoRandomTrees) {
  for (int seed = 1; seed <= trees; ++seed) {
    std::mt19937_64 random(seed);
    const Skeleton tree = testing::randomSkeleton(random, 3 + 4 * seed);
    expectBody(tree, bodyAround(tree), "seed " + std::to_string(seed));
  }
}

TEST(BodyAround, SoDoesTheFigureWhateverPoseItRestsIn) {
  const Skeleton figure = mannequin();
  for (int seed = 1; seed <= trees; ++seed) {
    std::mt19937_64 random(seed);
    const Frames posed = forwardKinematics(figure, randomWithinLimits(figure, random));
    std::vector<Joint> joints = figure.joints();  // hands and feet, where the lenses are, anywhere
    for (int i = 0; i < figure.jointCount(); ++i)
      joints[i].parentFromZero =
          i == 0 ? posed[0] : posed[figure.parent(i)].inverse(Eigen::Isometry) * posed[i];
    const Skeleton crouched(joints);
    const Mesh mesh = bodyAround(crouched);
    EXPECT_TRUE(topology(mesh).closed() && topology(mesh).manifold()) << "seed " << seed;
    Eigen::AlignedBox3d box;
    for (const Vector3d& p : mesh.positions) box.extend(p);
    for (const Bone& bone : bonesOf(crouched, restFrames(crouched)))
      EXPECT_TRUE(box.contains(bone.from) && box.contains(bone.to)) << "seed " << seed;
  }
}

TEST(BodyAround, AJointAloneIsABall) {
  const Skeleton lone({{.name = "only", .ball = true}});
  const Mesh mesh = bodyAround(lone);
  expectBody(lone, mesh, "lone joint");
}

TEST(BodyAround, SkinsMoveWithTheirBones) {
  const Skeleton arm = toSkeleton(lecturePlanarChain());
  const Skin skin = bodySkin(arm);
  EXPECT_EQ(skin.influences.size(), skin.mesh.positions.size());
  for (const Influences& in : skin.influences) {
    EXPECT_NEAR(in.weights[0] + in.weights[1] + in.weights[2] + in.weights[3], 1.0, 1e-12);
    EXPECT_GT(arm.vCount(in.joints[0]), 0) << "only moving joints carry the arm";
  }
}

}  // namespace
}  // namespace gelenk
