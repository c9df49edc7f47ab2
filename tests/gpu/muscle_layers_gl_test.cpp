#include <gtest/gtest.h>

#include "kinematics/configuration.h"
#include "kinematics/rotation.h"
#include "skinning/gpu/render_target.h"
#include "skinning/gpu/skinned_mesh_gl.h"
#include "skinning/muscles/muscle_control.h"
#include "tests/gpu/gl_fixture.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;
using testing::GlTest;

class MuscleLayersGl : public GlTest {
 protected:
  Skeleton skeleton = testing::arm(0.8);
  Frames rest = restFrames(skeleton);
  MuscleRig rig{bindMuscles(testing::tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest),
                rest};

  Frames posed(double elbow, const Vector3d& shoulder, const Vector3d& wrist) const {
    VectorXd q = skeleton.rest();
    q[skeleton.qIndex(2)] = elbow;
    setBallRotation(skeleton, q, 1, expRotation(shoulder));
    setBallRotation(skeleton, q, 3, expRotation(wrist));
    return forwardKinematics(skeleton, q);
  }

  void expectShaderEqualsReference(const Frames& frames) const {
    SkinnedMeshGl mesh(rig.body());
    expectShaderEqualsReference(frames, mesh);
  }

  void expectShaderEqualsReference(const Frames& frames, SkinnedMeshGl& mesh) const {
    const std::vector<LimbPose> limbs = rig.pose(frames);
    SkinnedVertices reference;
    skinWithMuscles(rig.body(), frames, limbs, reference);
    SkinPose pose;
    poseSkin(rig.body(), frames, limbs, pose);
    const RenderTarget unseen(4, 4);  // drawing needs a complete framebuffer even where nothing is rasterised
    glBindFramebuffer(GL_FRAMEBUFFER, unseen.framebuffer());
    mesh.setSculpture(rig);
    const ReadBackVertices shader = skinOnGpu(mesh, pose);
    const double limbLength = 0.55;
    double worst = 0.0, worstNormal = 0.0;
    for (std::size_t v = 0; v < reference.positions.size(); ++v)
      for (int k = 0; k < 3; ++k) {
        worst = std::max(worst, std::abs(shader.positions[v][k] - reference.positions[v][k]));
        worstNormal = std::max(worstNormal, std::abs(shader.normals[v][k] - reference.normals[v][k]));
      }
    EXPECT_LE(worst, 1e-5 * limbLength);
    EXPECT_LE(worstNormal, 1e-4);
    RecordProperty("worst_of_limb_length", std::to_string(worst / limbLength));
  }
};

TEST_F(MuscleLayersGl, ShaderAgreesWithTheReference) {
  for (const double elbow : {0.0, 0.8, 1.6, 2.4})
    expectShaderEqualsReference(posed(elbow, {0.3, -0.5, 1.0}, {0.2, 0.1, -0.9}));
}

TEST_F(MuscleLayersGl, ShaderAgreesWithSculptedControlPoints) {
  std::mt19937_64 random(1);
  for (MuscleState& state : rig.controls()[0].sculpted)
    for (MusclePlane* plane : {&state.plane2, &state.plane4})
      for (int c = 0; c < 16; ++c)
        plane->displacement.push_back(
            0.01 * Vector3d(uniform01(random) - 0.5, uniform01(random) - 0.5, uniform01(random) - 0.5));
  for (const double elbow : {0.0, 1.2, 2.4})
    expectShaderEqualsReference(posed(elbow, {0.1, 0.2, 0.4}, {0, 0, 0.5}));
}

TEST_F(MuscleLayersGl, EveryEditOfControlPointsReachesTheMesh) {
  SkinnedMeshGl mesh(rig.body());
  const Frames bent = posed(1.2, {0.1, 0.2, 0.4}, {0, 0, 0.5});
  std::vector<MuscleState>& sculpted = rig.controls()[0].sculpted;
  expectShaderEqualsReference(bent, mesh);
  for (const double shift : {0.004, 0.011}) {
    sculpted[1].plane2.displacement.assign(16, Vector3d(shift, 0.002, -0.003));
    expectShaderEqualsReference(bent, mesh);
  }
  sculpted[0].plane4.displacement.assign(16, Vector3d(0, 0.01, 0));
  expectShaderEqualsReference(bent, mesh);
  for (MuscleState& state : sculpted) state = {};
  expectShaderEqualsReference(bent, mesh);
  sculpted[1].plane2.displacement.assign(16, Vector3d(0.011, 0.002, -0.003));  // as before all was taken back
  expectShaderEqualsReference(bent, mesh);
}

TEST_F(MuscleLayersGl, VerticesBeyondTheLimbFollowItsEndsRigidly) {
  int beyond = 0;
  for (const LimbVertex& vertex : rig.body().vertices) beyond += vertex.volume < 0;
  EXPECT_GT(beyond, 0);  // the tube begins 2 cm before the shoulder and ends 3 cm beyond the wrist: covered
                         // by the tests above
}

TEST_F(MuscleLayersGl, TooManyLimbsAreRefused) {
  const Limb limb = makeLimb(skeleton, rest, "arm", {1, 2, 3});
  const MuscleSkin body = bindMuscles(testing::tube(skeleton), std::vector<Limb>(15, limb), rest);
  EXPECT_THROW(SkinnedMeshGl{body}, std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
