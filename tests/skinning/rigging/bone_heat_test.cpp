#include "skinning/rigging/bone_heat.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "kinematics/configuration.h"
#include "kinematics/notation/mannequin.h"
#include "kinematics/symmetry.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/bodies/polygonise.h"
#include "skinning/rigging/short_edges.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

double weightOf(const std::vector<std::pair<int, double>>& row, int joint) {
  double sum = 0.0;
  for (const auto& [j, w] : row) sum += j == joint ? w : 0.0;
  return sum;
}

/// A straight bar along z from -1 to 1, radius 0.1.
Mesh bar() {
  BodyPart part{
      .form = BodyPart::Form::RoundCone, .a = {0, 0, -1}, .b = {0, 0, 1}, .radiusA = 0.1, .radiusB = 0.1};
  return polygonise(BodyShape({part}), {.cell = 0.03});
}

const std::vector<Bone> twoBones{{0, {0, 0, -1}, {0, 0, 0}}, {1, {0, 0, 0}, {0, 0, 1}}};

void expectPartition(const SparseWeights& weights) {
  for (const auto& row : weights) {
    double sum = 0.0;
    for (const auto& [joint, w] : row) {
      EXPECT_GE(w, 0.0);
      sum += w;
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
  }
}

TEST(BoneHeat, ABarOfTwoBonesIsRigidAtItsEndsAndHalfAndHalfInTheMiddle) {
  const Mesh mesh = bar();
  const SparseWeights weights = boneHeatWeights(mesh, twoBones);
  expectPartition(weights);
  // On a cylinder of radius d the transition between two sources solves w'' = (c / d^2) (w - p):
  // w = 1/2 exp(-sqrt(c) z / d) for z > 0 on the other side.
  const double c = BoneHeatOptions{}.strength, d = 0.1;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double z = mesh.positions[v].z(), far = 0.5 * std::exp(-std::sqrt(c) * std::abs(z) / d);
    EXPECT_NEAR(weightOf(weights[v], z > 0 ? 0 : 1), far, 0.12) << z;  // cells of 0.03: p jumps within one
    EXPECT_LT(weightOf(weights[v], z > 0 ? 0 : 1), std::abs(z) > 0.5 ? 1e-4 : 0.7);
  }
}

/// An open tube around z of radius 0.1, sixteen corners a ring.
Mesh tube(const std::vector<double>& rings) {
  constexpr int n = 16;
  Mesh mesh;
  for (const double z : rings)
    for (int k = 0; k < n; ++k)
      mesh.positions.emplace_back(0.1 * std::cos(2.0 * M_PI * k / n), 0.1 * std::sin(2.0 * M_PI * k / n), z);
  for (int i = 0; i + 1 < static_cast<int>(rings.size()); ++i)
    for (int k = 0; k < n; ++k) {
      const int a = i * n + k, b = i * n + (k + 1) % n;
      mesh.triangles.push_back({a, b, b + n});
      mesh.triangles.push_back({a, b + n, a + n});
    }
  return mesh;
}

// The same solution as above, between rings three radii apart: a slope, not a step from ring to ring.
TEST(BoneHeat, CoarseTrianglesGetTheWeightsOfFineOnes) {
  const Mesh mesh = tube({-0.88, -0.58, -0.28, 0.02, 0.32, 0.62, 0.92});
  const SparseWeights weights = boneHeatWeights(mesh, twoBones);
  ASSERT_EQ(weights.size(), mesh.positions.size());
  expectPartition(weights);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double z = mesh.positions[v].z(),
                 far = 0.5 * std::exp(-std::sqrt(BoneHeatOptions{}.strength) * std::abs(z) / 0.1);
    EXPECT_NEAR(weightOf(weights[v], z > 0 ? 0 : 1), far, 0.05) << z;  // voxels and pieces of 0.02 to 0.04
  }
}

TEST(ShortEdges, TheSurfaceStaysAndNoGapOpens) {
  const Mesh mesh = bar();
  for (const double longest : {1.0, 0.04, 0.02, 0.01}) {
    const Mesh fine = withShortEdges(mesh, longest);
    for (const auto& t : fine.triangles)
      for (int k = 0; k < 3; ++k)
        EXPECT_LE((fine.positions[t[k]] - fine.positions[t[(k + 1) % 3]]).norm(), longest);
    for (std::size_t v = 0; v < mesh.positions.size(); ++v) EXPECT_EQ(fine.positions[v], mesh.positions[v]);
    EXPECT_TRUE(topology(fine).closed() && topology(fine).manifold());
    EXPECT_NEAR(enclosedVolume(fine), enclosedVolume(mesh), 1e-12);
    if (longest == 1.0) {
      EXPECT_EQ(fine.triangles, mesh.triangles);
    }
  }
  EXPECT_LT(withShortEdges(mesh, 1e-9, 10000).triangles.size(), 40000u) << "there is an end";
}

TEST(BoneHeat, UnweldedOpenAndBrokenMeshesKeepTheirOrderAndEveryVertexIsWeighted) {
  const Mesh whole = bar();
  const SparseWeights expected = boneHeatWeights(whole, twoBones);
  Mesh soup;  // every triangle on its own
  std::vector<int> source;
  for (const auto& t : whole.triangles) {
    soup.triangles.push_back({static_cast<int>(source.size()), static_cast<int>(source.size()) + 1,
                              static_cast<int>(source.size()) + 2});
    for (const int v : t) source.push_back(v), soup.positions.push_back(whole.positions[v]);
  }
  const SparseWeights soupWeights = boneHeatWeights(soup, twoBones);
  ASSERT_EQ(soupWeights.size(), source.size());
  for (std::size_t v = 0; v < source.size(); ++v)
    EXPECT_NEAR(weightOf(soupWeights[v], 0), weightOf(expected[source[v]], 0),
                1e-9);  // another order of elimination

  Mesh broken = whole;
  broken.triangles.resize(broken.triangles.size() - 20);        // a hole
  std::swap(broken.triangles[5][0], broken.triangles[5][1]);    // a flipped face
  broken.triangles.push_back({3, 3, 4});                        // degenerate
  broken.triangles.push_back(broken.triangles[7]);              // twice: not manifold
  broken.positions.emplace_back(0.0, 0.5, 0.5);                 // loose
  const int apart = static_cast<int>(broken.positions.size());  // a second component
  for (const Vector3d& p : {Vector3d(0.3, 0, -0.5), Vector3d(0.3, 0.1, -0.5), Vector3d(0.3, 0, -0.4)})
    broken.positions.push_back(p);
  broken.triangles.push_back({apart, apart + 1, apart + 2});
  const SparseWeights weights = boneHeatWeights(broken, twoBones);
  expectPartition(weights);
  EXPECT_GT(weightOf(weights[apart - 1], 1), 0.99);
  EXPECT_GT(weightOf(weights[apart], 0), 0.9);
}

TEST(BoneHeat, ABoneBesideTheBodyDoesNotTakeHoldOfItThroughTheAir) {
  // A bar of radius 0.1 and another one beside it, 0.05 away, joined by a bow at the far end. The surface of
  // the thick one between the two is nearer to the thin one's bone than to its own.
  std::vector<BodyPart> parts{
      {.form = BodyPart::Form::RoundCone, .a = {0, 0, 0}, .b = {0, 0, 2}, .radiusA = 0.3, .radiusB = 0.3},
      {.form = BodyPart::Form::RoundCone,
       .parent = 0,
       .blend = 0.01,
       .a = {0, 0, 2},
       .b = {0.42, 0, 2},
       .radiusA = 0.1,
       .radiusB = 0.05},
      {.form = BodyPart::Form::RoundCone,
       .parent = 1,
       .blend = 0.01,
       .a = {0.42, 0, 2},
       .b = {0.42, 0, 0},
       .radiusA = 0.05,
       .radiusB = 0.05}};
  const Mesh mesh = polygonise(BodyShape(parts), {.cell = 0.025});
  const std::vector<Bone> bones{{0, {0, 0, 0}, {0, 0, 2}}, {1, {0.42, 0, 2}, {0.42, 0, 0}}};
  const SparseWeights weights = boneHeatWeights(mesh, bones);
  int between = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vector3d& p = mesh.positions[v];
    if (p.z() < 0.3 || p.z() > 1.2 || std::hypot(p.x(), p.y()) > 0.31 || p.x() < 0.28) continue;
    ++between;
    EXPECT_LT(distanceTo(bones[1], p), distanceTo(bones[0], p));
    EXPECT_GT(weightOf(weights[v], 0), 0.99) << p.transpose();
  }
  EXPECT_GT(between, 10);
}

TEST(BoneHeat, AMeshInOnePointHasTheNearestBone) {
  Mesh point;
  point.positions = {{0, 0, 0.5}, {0, 0, 0.5}, {0, 0, 0.5}};
  point.triangles = {{0, 1, 2}};
  for (const auto& row : boneHeatWeights(point, twoBones)) EXPECT_EQ(weightOf(row, 1), 1.0);
  Mesh loose;  // no area at all, in light years
  loose.positions = {{0, 0, -1e16}, {0, 0, 1e16}};
  loose.triangles = {{0, 0, 1}};
  const std::vector<Bone> bones{{0, {0, 0, -1e16}, {0, 0, 0}}, {1, {0, 0, 0}, {0, 0, 1e16}}};
  const SparseWeights weights = boneHeatWeights(loose, bones);
  EXPECT_EQ(weightOf(weights[0], 0), 1.0);
  EXPECT_EQ(weightOf(weights[1], 1), 1.0);
}

TEST(BoneHeat, InvalidInputIsRefused) {
  EXPECT_THROW(boneHeatWeights(bar(), {}), std::invalid_argument);
  EXPECT_THROW(boneHeatWeights({}, twoBones), std::invalid_argument);
  EXPECT_THROW(boneHeatWeights(bar(), twoBones, {.strength = 0.0}), std::invalid_argument);
}

TEST(Bones, OfTheFigureRunFromEveryMovingJointButTheRoot) {
  const Skeleton figure = mannequin();
  const std::vector<Bone> bones = bonesOf(figure, restFrames(figure));
  EXPECT_EQ(bones.size(), 64u);  // one for each of the 65 parent-child pairs but Root-pelvis
  for (const Bone& bone : bones) {
    EXPECT_NE(bone.joint, 0);
    EXPECT_GT(figure.vCount(bone.joint), 0);
  }
}

TEST(MannequinSkin, WeightsAreSymmetricSmoothAndDoNotLeakBetweenLegsOrFingers) {
  const Skeleton figure = mannequin();
  WeightLoss loss;
  const Skin skin = makeMannequinSkin(figure, &loss);
  EXPECT_LE(loss.mean, 0.005);
  EXPECT_LE(loss.max, 0.15);

  const std::vector<int> jointPartner = mirrorPartners(figure);
  std::map<std::array<double, 3>, int> at;
  for (std::size_t v = 0; v < skin.mesh.positions.size(); ++v) {
    const Vector3d& p = skin.mesh.positions[v];
    at[{p.x(), p.y(), p.z()}] = static_cast<int>(v);
  }
  const auto weight = [&](int v, int joint) {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k)
      sum += skin.influences[v].joints[k] == joint ? skin.influences[v].weights[k] : 0.0;
    return sum;
  };
  const auto sumOf = [&](int v, const std::string& part, const std::string& side) {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) {
      const std::string& name = figure.joint(skin.influences[v].joints[k]).name;
      if (name.find(part) != std::string::npos && name.ends_with(side)) sum += skin.influences[v].weights[k];
    }
    return sum;
  };
  for (int v = 0; v < static_cast<int>(skin.mesh.positions.size()); ++v) {
    const Vector3d& p = skin.mesh.positions[v];
    const int image = at.at({p.x() == 0.0 ? 0.0 : -p.x(), p.y(), p.z()});
    for (int k = 0; k < 4; ++k) {
      const double w = skin.influences[v].weights[k];
      const double mirrored = weight(image, jointPartner[skin.influences[v].joints[k]]);
      EXPECT_TRUE(w == 0.0 || std::abs(mirrored - w) < 1e-12)
          << p.transpose() << ": " << w << " " << mirrored;
    }
    if (p.y() < 0.65 && std::abs(p.x()) < 0.35) {  // a leg, a hand below the crotch
      const std::string other = p.x() > 0.0 ? "_r" : "_l";
      for (const char* part : {"thigh", "calf", "foot", "ball"})
        EXPECT_LT(sumOf(v, part, other), 3e-3) << p.transpose();
    }
    const std::vector<std::string> fingers{"thumb_03", "index_03", "middle_03", "ring_03", "pinky_03"};
    for (const std::string& finger : fingers) {  // a finger tip belongs to its own finger
      if (sumOf(v, finger, "_l") < 0.5) continue;
      for (const char* other : {"thumb", "index", "middle", "ring", "pinky"}) {
        const double leaked = finger.starts_with(other) ? 0.0 : sumOf(v, other, "_l");
        EXPECT_LT(leaked, 0.02) << finger << " " << other;
      }
    }
  }
  // Smooth: along an edge of 8-12 mm of body and limbs no weight changes by more than 0.3; fingers, 5 mm
  // thick, turn over within two edges of 4 mm.
  double steepest = 0.0, steepestOnHands = 0.0;
  for (const auto& t : skin.mesh.triangles)
    for (int k = 0; k < 3; ++k)
      for (int n = 0; n < 4; ++n) {
        const int joint = skin.influences[t[k]].joints[n];
        double& worst = std::abs(skin.mesh.positions[t[k]].x()) > 0.49 || skin.mesh.positions[t[k]].z() > 0.2
                            ? steepestOnHands
                            : steepest;
        worst = std::max(worst, std::abs(weight(t[k], joint) - weight(t[(k + 1) % 3], joint)));
      }
  // Along an edge: on the hands of 5 mm, else of 8.
  EXPECT_LE(steepest, 0.32);
  EXPECT_LE(steepestOnHands, 0.82);
}

/// Half the L1 distance between two rows, the share of weight that differs.
TEST(BoneHeat, ComesNearAnArtistsWeightsOnTheMakeHumanBody) {
  const std::string folder = testing::dataFolder() + "/characters/makehuman/";
  std::ifstream obj(folder + "mh_male.obj"), rig(folder + "mh_male.game_engine.skel.txt"),
      painted(folder + "weights.game_engine.txt");
  if (!obj || !rig || !painted) GTEST_SKIP() << "the MakeHuman body is not here";
  Mesh mesh;
  for (std::string line; std::getline(obj, line);) {
    std::istringstream words(line);
    std::string kind, word;
    words >> kind;
    Vector3d p;
    if (kind == "v" && words >> p.x() >> p.y() >> p.z()) mesh.positions.push_back(p);
    std::vector<int> face;
    while (kind == "f" && words >> word) face.push_back(std::stoi(word) - 1);
    for (std::size_t k = 2; k < face.size(); ++k) mesh.triangles.push_back({face[0], face[k - 1], face[k]});
  }
  std::vector<Bone> bones;
  for (std::string line; std::getline(rig, line);) {
    if (line[0] == '#') continue;
    std::istringstream words(line);
    Bone bone;
    std::string name;
    int parent;
    words >> bone.joint >> name >> parent >> bone.from.x() >> bone.from.y() >> bone.from.z() >> bone.to.x() >>
        bone.to.y() >> bone.to.z();
    if (parent >= 0) bones.push_back(bone);
  }
  const SparseWeights weights = boneHeatWeights(mesh, bones);
  expectPartition(weights);
  double sum = 0.0;
  std::size_t v = 0;
  for (std::string line; std::getline(painted, line);) {
    if (line[0] == '#') continue;
    std::istringstream words(line);
    std::map<int, double> difference;
    for (const auto& [joint, w] : weights.at(v)) difference[joint] += w;
    int count = 0, joint = 0;
    double w = 0.0;
    words >> count;
    while (words >> joint >> w) difference[joint] -= w;
    for (const auto& [j, d] : difference) sum += 0.5 * std::abs(d);
    ++v;
  }
  ASSERT_EQ(v, mesh.positions.size());
  const double mean = sum / static_cast<double>(v);
  RecordProperty("half_l1", std::to_string(mean));
  std::printf("half L1 against the artist's weights, mean over %zu vertices: %.4f\n", v, mean);
  EXPECT_LE(mean, 0.24);
}

}  // namespace
}  // namespace gelenk
