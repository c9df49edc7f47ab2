#include "skinning/muscles/layered_blend.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using testing::arm;
using testing::tube;

/// The tube of an arm whose first 6 cm the chest holds with up to half of the weight.
Skin heldTube(const Skeleton& skeleton) {
  Skin skin = tube(skeleton);
  const Vector3d shoulder = restFrames(skeleton)[1].translation();
  for (std::size_t v = 0; v < skin.influences.size(); ++v) {
    const double chest = 0.5 - (skin.mesh.positions[v] - shoulder).norm() / 0.12;
    Influences& in = skin.influences[v];
    if (chest > 0.0)
      in = {.joints = {1, 0, 2, 0},
            .weights = {(1 - chest) * in.weights[0], chest, (1 - chest) * in.weights[1], 0}};
  }
  return skin;
}

struct Layered {
  Skeleton skeleton = arm(0.3);
  Frames rest = restFrames(skeleton);
  MuscleSkin body = bindMuscles(heldTube(skeleton), {makeLimb(skeleton, rest, "arm", {1, 2, 3})}, rest);
};

Frames bent(const Layered& l, std::mt19937_64& random, double radians) {
  Eigen::VectorXd dq(l.skeleton.nv());
  for (int i = 0; i < dq.size(); ++i) dq[i] = radians * (2.0 * uniform01(random) - 1.0);
  return forwardKinematics(l.skeleton, integrate(l.skeleton, l.skeleton.rest(), dq));
}

TEST(LayeredBlend, WithLinearBlendingOutsideItIsTheSumOfMuscleSkin) {
  const Layered l;
  const LayeredSkin layered = prepareLayers(l.body, skinMethodNamed("lbs"), l.rest);
  std::mt19937_64 random(3);
  double mixed = 0.0;  // the test's own premise: vertices on limb and body both
  for (const LimbVertex& v : l.body.vertices) mixed = std::max(mixed, std::min(v.weight, 1.0 - v.weight));
  ASSERT_GT(mixed, 0.1);
  for (int trial = 0; trial < 5; ++trial) {
    const Frames frames = bent(l, random, 1.0);
    const auto limbs = poseLimbs(l.body, frames);
    SkinnedVertices sum, displaced;
    skinWithMuscles(l.body, frames, limbs, sum);
    skinWithMuscles(layered, frames, limbs, displaced);
    for (std::size_t v = 0; v < sum.positions.size(); ++v)
      EXPECT_LE((sum.positions[v] - displaced.positions[v]).norm(), 1e-13)
          << "trial " << trial << " vertex " << v;
  }
}

TEST(LayeredBlend, RestStaysAndARigidMotionMovesAllAlikeByEveryMethod) {
  const Layered l;
  Eigen::Isometry3d motion(expRotation({0.3, 1.2, -0.7}));
  motion.translation() << 1.0, -2.0, 0.5;
  Frames moved = l.rest;
  for (auto& frame : moved) frame = motion * frame;
  for (const SkinMethod* method : skinMethods()) {
    if (method->shader.empty()) continue;
    SCOPED_TRACE(method->name);
    const LayeredSkin layered = prepareLayers(l.body, *method, l.rest);
    SkinnedVertices at;
    skinWithMuscles(layered, moved, poseLimbs(l.body, moved), at);
    for (std::size_t v = 0; v < at.positions.size(); ++v)
      EXPECT_LE((at.positions[v] - motion * l.body.skin.mesh.positions[v]).norm(), 1e-12);
  }
}

TEST(LayeredBlend, InsideTheLimbTheLayersAloneCountWhateverTheMethod) {
  const Layered l;
  std::mt19937_64 random(4);
  const Frames frames = bent(l, random, 1.0);
  const auto limbs = poseLimbs(l.body, frames);
  for (const SkinMethod* method : skinMethods()) {
    if (method->shader.empty()) continue;
    SkinnedVertices at;
    skinWithMuscles(prepareLayers(l.body, *method, l.rest), frames, limbs, at);
    int inside = 0;
    for (std::size_t v = 0; v < at.positions.size(); ++v) {
      if (l.body.vertices[v].weight < 1.0) continue;
      ++inside;
      EXPECT_LE((at.positions[v] - deformLimbPoint(limbs[0], l.body.vertices[v])).norm(), 1e-12)
          << method->name;
    }
    EXPECT_GT(inside, 50);
  }
}

TEST(LayeredBlend, AFewVerticesAloneAreWhereTheWholeSkinHasThem) {
  const Layered l;
  std::mt19937_64 random(5);
  const Frames frames = bent(l, random, 1.0);
  const auto limbs = poseLimbs(l.body, frames);
  const int vertices[] = {700, 40, 3};
  for (const char* name : {"lbs", "dqs", "cor"}) {
    const LayeredSkin layered = prepareLayers(l.body, skinMethodNamed(name), l.rest);
    SkinnedVertices all, some;
    skinWithMuscles(layered, frames, limbs, all);
    skinWithMuscles(verticesOf(layered, vertices), frames, limbs, some);
    ASSERT_EQ(some.positions.size(), 3u);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(some.positions[k], all.positions[vertices[k]]) << name;
      EXPECT_EQ(some.normals[k], all.normals[vertices[k]]) << name;
    }
  }
}

}  // namespace
}  // namespace gelenk
