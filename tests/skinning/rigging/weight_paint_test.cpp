#include "skinning/rigging/weight_paint.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "skinning/muscles/muscle_control.h"
#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Weights = std::vector<Influences>;

Weights randomWeights(std::size_t count, int joints, std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Weights weights;
  for (std::size_t v = 0; v < count; ++v) {
    std::vector<std::pair<int, double>> row;
    for (int k = 0; k < 5; ++k) row.emplace_back(static_cast<int>(random() % joints), uniform(random));
    weights.push_back(exactInfluences(row));
  }
  return weights;
}

/// Sums to exactly 1 in every order, not negative, descending, no joint twice.
void expectSound(const Influences& in) {
  std::array<double, 4> w = in.weights;
  std::sort(w.begin(), w.end());
  do EXPECT_EQ(w[0] + w[1] + w[2] + w[3], 1.0);
  while (std::next_permutation(w.begin(), w.end()));
  std::set<int> joints;
  for (int k = 0; k < 4; ++k) {
    EXPECT_GE(in.weights[k], 0.0);
    if (k > 0) {
      EXPECT_LE(in.weights[k], in.weights[k - 1]);
    }
    if (in.weights[k] > 0.0) {
      EXPECT_TRUE(joints.insert(in.joints[k]).second);
    }
  }
}

/// A strip of 2 x n squares in the plane z = 0, and the same once more at z = 0.01 that no edge joins to the
/// first.
Mesh twoSheets(int n) {
  Mesh mesh;
  for (const double z : {0.0, 0.01}) {
    const int base = static_cast<int>(mesh.positions.size());
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j < 3; ++j) mesh.positions.emplace_back(0.01 * i, 0.01 * j, z);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < 2; ++j) {
        const int a = base + 3 * i + j;
        mesh.triangles.push_back({a, a + 3, a + 4});
        mesh.triangles.push_back({a, a + 4, a + 1});
      }
  }
  return mesh;
}

void put(Weights& weights, const WeightChange& change) {
  for (const auto& [vertex, influences] : change) weights[vertex] = influences;
}

VertexSelection everything(std::size_t count, double share) {
  VertexSelection all;
  for (std::size_t v = 0; v < count; ++v) all.push_back({static_cast<int>(v), share});
  return all;
}

TEST(WeightPaint, EveryOperationLeavesAtMostFourWeightsThatSumToExactlyOne) {
  constexpr int seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  const Mesh mesh = twoSheets(20);
  const VertexNeighbours edges = vertexNeighbours(mesh);
  Weights weights = randomWeights(mesh.positions.size(), 9, random);
  for (const Influences& in : weights) expectSound(in);
  const auto check = [](const WeightChange& change) {
    EXPECT_FALSE(change.empty());
    for (const auto& entry : change) expectSound(entry.second);
  };
  const VertexSelection all = everything(weights.size(), 0.37);
  check(painted(weights, all, {.joints = {3}}, mesh.positions));
  check(painted(weights, all, {.joints = {1, 4, 7}}, mesh.positions));
  check(erased(weights, all, {.joints = {2, 3}}));
  check(smoothed(weights, all, edges));
}

TEST(WeightPaint, PaintingMovesTheShareTowardsTheJoint) {
  const Weights before{exactInfluences({{0, 0.75}, {1, 0.25}})};
  const WeightChange change = painted(before, {{0, 0.5}}, {.joints = {1}}, {Vector3d::Zero()});
  ASSERT_EQ(change.size(), 1u);
  EXPECT_EQ(change[0].second, (Influences{{1, 0, 0, 0}, {0.625, 0.375, 0, 0}}));  // 0.25 + 0.5 (1 - 0.25)
  const WeightChange whole = painted(before, {{0, 1.0}}, {.joints = {1}}, {Vector3d::Zero()});
  EXPECT_EQ(whole[0].second, (Influences{{1, 0, 0, 0}, {1, 0, 0, 0}}));
}

TEST(WeightPaint, PaintingALayerKeepsTheProportionsWithinIt) {
  const Weights before{exactInfluences({{0, 0.5}, {1, 0.125}, {2, 0.375}})};
  const PaintTarget layer{.joints = {1, 2}};
  const Influences after = painted(before, {{0, 0.5}}, layer, {Vector3d::Zero()})[0].second;
  EXPECT_EQ(weightOn(after, layer), 0.75);
  EXPECT_EQ(weightOn(after, {.joints = {2}}), 3.0 * weightOn(after, {.joints = {1}}));
}

TEST(WeightPaint, AVertexNewOnALayerBeginsAtItsNearestBone) {
  const PaintTarget layer{.joints = {1, 2},
                          .bones = {{.joint = 1, .from = Vector3d(0, 0, 0), .to = Vector3d(0, 0, 1)},
                                    {.joint = 2, .from = Vector3d(0, 0, 1), .to = Vector3d(0, 0, 2)}}};
  const Weights before(2, exactInfluences({{0, 1.0}}));
  const WeightChange change =
      painted(before, everything(2, 1.0), layer, {Vector3d(0.1, 0, 0.3), Vector3d(0.1, 0, 1.7)});
  EXPECT_EQ(change[0].second.joints[0], 1);
  EXPECT_EQ(change[1].second.joints[0], 2);
}

TEST(WeightPaint, ErasingGivesTheShareToTheOthersAndLeavesASoleCarrier) {
  const Weights before{exactInfluences({{0, 0.5}, {1, 0.25}, {2, 0.25}}), exactInfluences({{0, 1.0}})};
  const WeightChange change = erased(before, everything(2, 1.0), {.joints = {0}});
  ASSERT_EQ(change.size(), 1u);
  EXPECT_EQ(change[0].second, (Influences{{1, 2, 0, 0}, {0.5, 0.5, 0, 0}}));
}

TEST(WeightPaint, TheBrushFadesToItsRadiusAndStaysOnConnectedSkin) {
  const Mesh mesh = twoSheets(20);
  const Brush brush{.radius = 0.035, .strength = 0.8};
  EXPECT_EQ(brush.share(0.0), 0.8);
  EXPECT_EQ(brush.share(brush.radius), 0.0);
  EXPECT_NEAR((brush.share(0.0350) - brush.share(0.0349)) / 1e-4, 0.0,
              0.5);  // no kink at the rim: the slope there is 0
  const Vector3d centre(0.1, 0.01, 0.0);
  const VertexSelection under =
      underBrush(brush, centre, mesh.triangles[40], mesh.positions, vertexNeighbours(mesh));
  std::set<int> expected;
  for (int v = 0; v < 63; ++v)  // the first sheet
    if ((mesh.positions[v] - centre).norm() < brush.radius) expected.insert(v);
  std::set<int> found;
  for (const auto& [v, share] : under) {
    found.insert(v);
    EXPECT_DOUBLE_EQ(share, brush.share((mesh.positions[v] - centre).norm()));
  }
  EXPECT_EQ(found, expected);  // the second sheet is only 1 cm away, and not touched
}

TEST(WeightPaint, SmoothingKeepsWhatIsConstantAndLowersDifferencesAlongEdges) {
  std::mt19937_64 random(5);
  const Mesh mesh = twoSheets(20);
  const VertexNeighbours edges = vertexNeighbours(mesh);
  const Weights constant(mesh.positions.size(), exactInfluences({{0, 0.7}, {2, 0.3}}));
  EXPECT_TRUE(smoothed(constant, everything(constant.size(), 0.5), edges).empty());
  Weights weights = randomWeights(mesh.positions.size(), 3, random);
  const auto roughness = [&] {
    double sum = 0.0;
    for (int v = 0; v < static_cast<int>(mesh.positions.size()); ++v)
      for (const int n : edges.of(v))
        for (int j = 0; j < 3; ++j) {
          const PaintTarget joint{.joints = {j}};
          sum += std::pow(weightOn(weights[v], joint) - weightOn(weights[n], joint), 2);
        }
    return sum;
  };
  double before = roughness();
  for (int i = 0; i < 5; ++i) {
    put(weights, smoothed(weights, everything(mesh.positions.size(), 0.5), edges));
    EXPECT_LT(roughness(), before);
    before = roughness();
  }
}

TEST(WeightPaint, TheMirrorImageIsExactAndStable) {
  std::mt19937_64 random(7);
  std::vector<Vector3d> rest;
  std::uniform_real_distribution<double> uniform(0.01, 1.0);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p(uniform(random), uniform(random), uniform(random));
    rest.push_back(p);
    rest.emplace_back(-p.x(), p.y(), p.z());
  }
  for (int i = 0; i < 20; ++i) rest.emplace_back(0.0, uniform(random), uniform(random));
  rest.emplace_back(3.0, 0.0, 0.0);  // without a partner
  const std::vector<int> vertices = mirrorVertices(rest, 1e-6), joints{0, 2, 1, 4, 3};
  EXPECT_EQ(vertices[0], 1);
  EXPECT_EQ(vertices[1], 0);
  EXPECT_EQ(vertices[405], 405);
  EXPECT_EQ(vertices.back(), -1);
  const Weights start = randomWeights(rest.size(), 5, random);
  Weights weights = start;
  put(weights, mirrored(weights, rest, vertices, joints, MirrorFrom::NegativeX));
  for (std::size_t v = 0; v + 1 < rest.size(); ++v)
    for (int j = 0; j < 5; ++j)
      EXPECT_EQ(weightOn(weights[v], {.joints = {j}}),
                weightOn(weights[vertices[v]], {.joints = {joints[j]}}));
  for (int i = 0; i < 200; ++i) EXPECT_EQ(weights[2 * i + 1], start[2 * i + 1]);  // the side copied from
  EXPECT_TRUE(mirrored(weights, rest, vertices, joints, MirrorFrom::PositiveX).empty());
}

TEST(WeightPaint, TheDifferenceLeadsFromOneToTheOther) {
  std::mt19937_64 random(3);
  const Mesh mesh = twoSheets(20);
  const Weights from = randomWeights(mesh.positions.size(), 6, random);
  Weights to = from;
  put(to, painted(from, everything(20, 0.4), {.joints = {2}}, mesh.positions));
  const WeightChange change = difference(from, to);
  EXPECT_LE(change.size(), 20u);
  EXPECT_NE(to, from);
  Weights again = from;
  put(again, change);
  EXPECT_EQ(again, to);
  EXPECT_TRUE(difference(to, to).empty());
}

TEST(WeightPaint, ALassoTakesWhatLiesInsideAConcavePolygon) {
  const std::vector<Vector2d> letterU{{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  EXPECT_TRUE(insideLasso(letterU, {0.5, 2.0}));
  EXPECT_TRUE(insideLasso(letterU, {2.5, 2.0}));
  EXPECT_FALSE(insideLasso(letterU, {1.5, 2.0}));
  EXPECT_FALSE(insideLasso(letterU, {4.0, 0.5}));
  EXPECT_FALSE(insideLasso({}, {0.0, 0.0}));
}

TEST(WeightPaint, LayersBoundToPaintedWeightsStillLeaveTheRestPoseInPlace) {
  const Skeleton skeleton = testing::arm(0.8);
  const Frames rest = restFrames(skeleton);
  Skin skin = testing::tube(skeleton);
  const Limb limb = makeLimb(skeleton, rest, "arm", {1, 2, 3});
  const WeightChange change =
      painted(skin.influences, everything(300, 0.6), {.joints = {0}}, skin.mesh.positions);
  for (const auto& [v, influences] : change) skin.influences[v] = influences;
  const MuscleRig rig(bindMuscles(skin, {limb}, rest), rest);
  EXPECT_NEAR(rig.body().vertices[0].weight, 0.4, 1e-9);
  SkinnedVertices out;
  skinWithMuscles(rig.body(), rest, rig.pose(rest), out);
  for (std::size_t v = 0; v < out.positions.size(); ++v)
    EXPECT_LE((out.positions[v] - skin.mesh.positions[v]).norm(), 1e-12);
}

}  // namespace
}  // namespace gelenk
