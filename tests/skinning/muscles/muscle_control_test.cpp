#include "skinning/muscles/muscle_control.h"

#include <gtest/gtest.h>

#include "skinning/bodies/self_intersection.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::VectorXd;
using testing::arm;
using testing::tube;

struct Fixture {
  Skeleton skeleton = arm(0.3);
  Frames rest = restFrames(skeleton);
  MuscleRig rig{bindMuscles(tube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest), rest};

  Frames bent(double degrees) const {
    VectorXd q = skeleton.rest();
    q[skeleton.qIndex(2)] = degrees * M_PI / 180.0;
    return forwardKinematics(skeleton, q);
  }
  double volume(double degrees) const {
    return limbVolume(rig.body(), rig.surface(0), bent(degrees), rig.pose(bent(degrees))[0]);
  }
};

TEST(MuscleControl, RestIsLeftAlone) {
  const Fixture f;
  SkinnedVertices out;
  skinWithMuscles(f.rig.body(), f.rest, f.rig.pose(f.rest), out);
  for (std::size_t v = 0; v < out.positions.size(); ++v)
    EXPECT_LE((out.positions[v] - f.rig.body().skin.mesh.positions[v]).norm(), 1e-12);
}

TEST(MuscleControl, LimbSurfaceIsClosed) {
  const Fixture f;
  Mesh mesh{.positions = {}, .triangles = f.rig.surface(0).triangles, .normals = {}};
  for (const int v : f.rig.surface(0).vertices) mesh.positions.push_back(f.rig.body().skin.mesh.positions[v]);
  EXPECT_TRUE(topology(mesh).closed());
  EXPECT_EQ(topology(mesh).nonManifoldEdges, 0);
  EXPECT_NEAR(enclosedVolume(mesh), f.rig.restVolume(0), 1e-15);
}

TEST(MuscleControl, VolumeRuleKeepsTheVolumeAtEveryBend) {
  Fixture f;
  for (int degrees = 0; degrees <= 150; degrees += 10)
    EXPECT_NEAR(f.volume(degrees) / f.rig.restVolume(0), 1.0, 1e-9) << degrees;
  f.rig.controls()[0].keepVolume = false;
  EXPECT_GT(std::abs(f.volume(120) / f.rig.restVolume(0) - 1.0), 1e-3);
}

TEST(MuscleControl, VolumeIsQuadraticInTheCommonScale) {
  const Fixture f;
  const LimbFrames frames = limbFrames(f.rig.body().limbs[0], f.bent(100));
  const auto states = muscleStates(f.rig.body().limbs[0], frames, f.rig.controls()[0]);
  const auto volume = [&](double s) {
    return limbVolume(f.rig.body(), f.rig.surface(0), f.bent(100),
                      poseLimb(f.rig.body().limbs[0].shape, frames, scaled(states, s)));
  };
  const double thirdDifference = volume(1.3) - 3.0 * volume(1.1) + 3.0 * volume(0.9) - volume(0.7);
  EXPECT_LE(std::abs(thirdDifference),
            1e-10 * volume(1.0));  // thousands of triple products cancel to the volume
}

TEST(MuscleControl, FlexorSwellsTheInsideAndActivationContractsWithoutMotion) {
  Fixture f;
  f.rig.controls()[0].keepVolume = false;
  const LimbFrames frames = limbFrames(f.rig.body().limbs[0], f.bent(120));
  const auto bent = muscleStates(f.rig.body().limbs[0], frames, f.rig.controls()[0]);
  EXPECT_GT(bent[0].plane2.stretch(0, 0), 1.0);
  EXPECT_GT(bent[0].plane2.offset.x(), 0.0);
  f.rig.controls()[0].activation = 1.0;
  const auto active =
      muscleStates(f.rig.body().limbs[0], limbFrames(f.rig.body().limbs[0], f.rest), f.rig.controls()[0]);
  EXPECT_GT(active[0].plane2.stretch(0, 0), 1.0);
}

TEST(MuscleControl, LayerStaysFreeOfSelfIntersectionWhereLinearBlendingHasIt) {
  const Fixture f;
  const auto intersections = [&](const SkinnedVertices& at) {
    return selfIntersections(at.positions, f.rig.body().skin.mesh.triangles).size();
  };
  const Frames bent = f.bent(110);
  SkinnedVertices layer;
  skinWithMuscles(f.rig.body(), bent, f.rig.pose(bent), layer);
  EXPECT_EQ(intersections(layer), 0u);
  EXPECT_GT(intersections(linearBlendSkin(f.rig.body().skin, bent)), 0u);
}

}  // namespace
}  // namespace gelenk
