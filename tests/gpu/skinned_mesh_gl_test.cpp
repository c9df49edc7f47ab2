#include "skinning/gpu/skinned_mesh_gl.h"

#include <filesystem>
#include <random>

#include "apps/document/model_files.h"
#include "tests/gpu/gl_fixture.h"
#include "tests/gpu/test_bodies.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using testing::Arm;
using testing::GlTest;
class SkinnedMesh : public GlTest {};

struct Difference {
  double position = 0.0;  ///< largest, as a share of the body's size
  double normal = 0.0;    ///< largest, of unit vectors
};

/// The vertex shader, read back, against the double-precision reference.
Difference shaderAgainstReference(const Skin& skin, const Frames& frames) {
  const ReadBackVertices onGpu = skinOnGpu(SkinnedMeshGl(skin), poseSkin(skin, frames));
  const SkinnedVertices reference = linearBlendSkin(skin, frames);
  const double size = bodySize(skin.mesh);
  Difference worst;
  for (std::size_t v = 0; v < reference.positions.size(); ++v) {
    const Eigen::Map<const Eigen::Vector3f> p(onGpu.positions[v].data()), n(onGpu.normals[v].data());
    worst.position = std::max(worst.position, (p.cast<double>() - reference.positions[v]).norm() / size);
    worst.normal = std::max(worst.normal, (n.cast<double>() - reference.normals[v]).norm());
  }
  return worst;
}

// Single precision resolves 6e-8 of a coordinate; a blend of four products and sums of coordinates up to the
// body's size from the origin loses a few of these. 1e-5 is what a picture could never show.
constexpr double positionTolerance = 1e-5;
// Where rotations nearly cancel in a blend the normal's error grows with the inverse of what is left.
constexpr double normalTolerance = 1e-3;

void expectAgreement(const Skin& skin, const Skeleton& skeleton, int seed, double radians) {
  std::mt19937_64 random(seed);
  for (int trial = 0; trial < 5; ++trial) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", trial " + std::to_string(trial));
    const Frames frames = forwardKinematics(skeleton, testing::bent(skeleton, random, radians));
    const Difference difference = shaderAgainstReference(skin, frames);
    EXPECT_LE(difference.position, positionTolerance);
    EXPECT_LE(difference.normal, normalTolerance);
  }
}

TEST_F(SkinnedMesh, BindPoseLeavesEveryVertexInPlace) {
  const Arm arm = testing::arm(4, 0.3, 0.05);
  const ReadBackVertices at =
      skinOnGpu(SkinnedMeshGl(arm.skin), poseSkin(arm.skin, restFrames(arm.skeleton)));
  for (std::size_t v = 0; v < at.positions.size(); ++v)
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(at.positions[v][k], arm.skin.mesh.positions[v][k], 1e-6);  // float of a number near 1
      EXPECT_NEAR(at.normals[v][k], arm.skin.mesh.normals[v][k], 1e-6);
    }
}

TEST_F(SkinnedMesh, ShaderAgreesWithTheDoublePrecisionReferenceOnAPlanarArm) {
  const Arm arm = testing::arm(3, 150.0, 20.0);  // the slides' lengths: hundreds of units
  expectAgreement(arm.skin, arm.skeleton, 1, 1.5);
}

TEST_F(SkinnedMesh, ShaderAgreesOnTheBuiltInFigureArmAndRobot) {
  int seed = 10;
  for (const char* name : {"figure", "planar", "panda"}) {
    SCOPED_TRACE(name);
    const Model model = openModel(name);
    expectAgreement(*model.skin, model.skeleton, ++seed, 0.8);
  }
}

TEST_F(SkinnedMesh, AThousandBonesGoThroughATextureAndAgreeToo) {
  const Arm arm = testing::arm(1000, 0.01, 0.004, 2, 6);
  ASSERT_EQ(poseStorage(poseSkin(arm.skin, restFrames(arm.skeleton))), PoseStorage::Texture);
  expectAgreement(arm.skin, arm.skeleton, 2, 0.05);
}

TEST_F(SkinnedMesh, TheUniformBlockHoldsExactly341Joints) {
  EXPECT_EQ(poseStorage(unposed(341)), PoseStorage::UniformBlock);
  EXPECT_EQ(poseStorage(unposed(342)), PoseStorage::Texture);
  for (const int joints : {341, 342}) {
    const Arm arm = testing::arm(joints, 0.02, 0.01, 1, 5);
    expectAgreement(arm.skin, arm.skeleton, joints, 0.05);
  }
}

TEST_F(SkinnedMesh, OnePoseBufferServesPosesOfBothStorages) {
  const Arm few = testing::arm(3, 0.3, 0.05), many = testing::arm(400, 0.01, 0.005, 1, 5);
  PoseGl pose;
  for (const Arm* arm : {&few, &many, &few}) {
    pose.upload(poseSkin(arm->skin, restFrames(arm->skeleton)));
    pose.bind();
  }
}

TEST_F(SkinnedMesh, VerticesDeformedOutsideAreDrawnWhereTheyAre) {
  const Arm arm = testing::arm(2, 0.4, 0.05);
  SkinnedMeshGl mesh(arm.skin);
  SkinnedVertices moved{.positions = arm.skin.mesh.positions, .normals = arm.skin.mesh.normals};
  for (auto& p : moved.positions) p += Eigen::Vector3d(0.5, 0.25, -1.0);
  mesh.setShape(moved);
  const ReadBackVertices at = skinOnGpu(mesh, unposed(2));
  for (std::size_t v = 0; v < moved.positions.size(); ++v)
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(at.positions[v][k], moved.positions[v][k], 1e-6);
  moved.positions.pop_back();
  EXPECT_THROW(mesh.setShape(moved), std::invalid_argument);
}

TEST_F(SkinnedMesh, APoseOfAnotherLengthIsRejected) {
  const Arm arm = testing::arm(3, 0.3, 0.05);
  EXPECT_THROW(poseSkin(arm.skin, Frames(2, Eigen::Isometry3d::Identity())), std::invalid_argument);
}

TEST_F(SkinnedMesh, ShaderAgreesOnTheMakeHumanBodyWithPinocchioWeights) {
  const std::string data = testing::dataFolder();
  if (!std::filesystem::exists(data + "/pinocchio/mh_male.skeleton.out"))
    GTEST_SKIP() << "no trial data in " << data;
  const Model model =
      openBody(data + "/characters/makehuman/mh_male.obj", data + "/pinocchio/mh_male.skeleton.out",
               data + "/pinocchio/mh_male.attachment.out");
  expectAgreement(*model.skin, model.skeleton, 3, 1.0);
}

TEST(ShaderProgram, ABadShaderIsReportedWithItsNameAndLine) {
  const OffscreenContext
      context;  // without the fixture's log: drivers report the compiler's complaint there too
  static constexpr ShaderText files[] = {{"broken.vert", "void main() { gl_Position = nonsense; }\n"}};
  try {
    ShaderProgram program({.folder = files, .vertex = "broken.vert"});
    FAIL() << "it compiled";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("broken.vert"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("nonsense"), std::string::npos);
  }
}

}  // namespace
}  // namespace gelenk
