#include <random>

#include "apps/document/model_files.h"
#include "apps/document/muscle_settings.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/gpu/skinned_mesh_gl.h"
#include "skinning/muscles/layered_blend.h"
#include "tests/gpu/gl_fixture.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

using testing::Arm;
using testing::GlTest;
class SkinMethodsGl : public GlTest {};

/// Single precision resolves 6e-8 of a coordinate, and slopes of weights (tens a metre) multiply places of a
/// body up to its size from the origin: 1e-5 of the size is what a picture could never show, 2e-3 a tenth of
/// a degree of a normal.
constexpr double positionTolerance = 1e-5, normalTolerance = 2e-3;

void expectAgreement(const ReadBackVertices& onGpu, const SkinnedVertices& reference, double size) {
  ASSERT_EQ(onGpu.positions.size(), reference.positions.size());
  double position = 0.0, normal = 0.0;
  for (std::size_t v = 0; v < reference.positions.size(); ++v) {
    const Eigen::Map<const Eigen::Vector3f> p(onGpu.positions[v].data()), n(onGpu.normals[v].data());
    position = std::max(position, (p.cast<double>() - reference.positions[v]).norm() / size);
    normal = std::max(normal, (n.cast<double>() - reference.normals[v]).norm());
  }
  EXPECT_LE(position, positionTolerance);
  EXPECT_LE(normal, normalTolerance);
}

const char* const everyChoice[] = {
    "lbs", "dqs", "cor", "lbs+twist", "dqs+twist", "cor+twist", "cor+twist+smooth"};

TEST_F(SkinMethodsGl, EveryMethodAgreesWithTheDoublePrecisionReferenceOnTheFigure) {
  const Model model = openModel("figure");
  for (const char* name : everyChoice) {
    SCOPED_TRACE(name);
    const PreparedSkin prepared =
        prepareSkin(*model.skin, parseSkinChoice(name), model.skeleton, bindFrames(model));
    const SkinnedMeshGl mesh(prepared);
    std::mt19937_64 random(21);
    for (int trial = 0; trial < 3; ++trial) {
      const Eigen::VectorXd q = testing::bent(model.skeleton, random, 0.7);
      const PosedBones bones = poseBones(prepared, forwardKinematics(model.skeleton, q), &q);
      SkinPose pose;
      poseSkin(prepared, bones, pose);
      ASSERT_EQ(poseStorage(pose), PoseStorage::UniformBlock);
      SkinnedVertices reference;
      blendSkin(prepared, bones, reference);
      expectAgreement(skinOnGpu(mesh, pose), reference, bodySize(prepared.skin.mesh));
    }
  }
}

TEST_F(SkinMethodsGl, FourHundredJointsGoThroughATextureByEveryMethod) {
  const Arm arm = testing::arm(400, 0.01, 0.005, 1, 5);
  std::vector<std::vector<int>> chains;
  for (int j = 1; j + 2 < 400; j += 3) chains.push_back({j, j + 1, j + 2});
  const TwistSpread spread = spreadTwist(arm.skeleton, restFrames(arm.skeleton), chains);
  std::mt19937_64 random(22);
  const Frames frames = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 0.05));
  for (const SkinMethod* method : skinMethods()) {
    if (method->shader.empty()) continue;
    for (const bool twist : {false, true}) {
      SCOPED_TRACE(std::string(method->name) + (twist ? " + twist" : ""));
      const PreparedSkin prepared = prepareSkin(arm.skin, *method, twist ? spread : TwistSpread{});
      SkinPose pose;
      poseSkin(prepared, poseBones(prepared, frames), pose);
      ASSERT_EQ(poseStorage(pose), PoseStorage::Texture);
      const ReadBackVertices onGpu = skinOnGpu(SkinnedMeshGl(prepared), pose);
      const SkinnedVertices reference = blendSkin(prepared, frames);
      double position = 0.0;
      for (std::size_t v = 0; v < reference.positions.size(); ++v)
        position =
            std::max(position, (Eigen::Map<const Eigen::Vector3f>(onGpu.positions[v].data()).cast<double>() -
                                reference.positions[v])
                                   .norm());
      EXPECT_LE(position, positionTolerance * bodySize(arm.skin.mesh));
    }
  }
}

TEST_F(SkinMethodsGl, MuscleLayersOverEveryMethodAgreeToo) {
  const Model model = openModel("figure");
  const Frames bound = bindFrames(model);
  const MuscleSettings settings = defaultMuscleSettings(limbsOf(model));
  const MuscleRig rig = makeMuscleRig(model, *model.skin, settings);
  std::mt19937_64 random(23);
  const Eigen::VectorXd q = testing::bent(model.skeleton, random, 0.6);
  const Frames frames = forwardKinematics(model.skeleton, q);
  const std::vector<LimbPose> limbs = rig.pose(frames);
  for (const SkinMethod* method : skinMethods()) {
    if (method->shader.empty()) continue;
    SCOPED_TRACE(method->name);
    const LayeredSkin layered = prepareLayers(rig.body(), *method, bound);
    SkinPose pose;
    poseSkin(layered, poseBones(layered.outside, withEnds(frames, limbs)), limbs, pose);
    SkinnedVertices reference;
    skinWithMuscles(layered, frames, limbs, reference);
    expectAgreement(skinOnGpu(SkinnedMeshGl(layered, rig.body()), pose), reference,
                    bodySize(model.skin->mesh));
  }
}

TEST_F(SkinMethodsGl, AMethodOfTheProcessorIsRefused) {
  const Arm arm = testing::arm(3, 0.3, 0.05);
  EXPECT_THROW(SkinnedMeshGl(prepareSkin(arm.skin, skinMethodNamed("ddm-v2"))), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
