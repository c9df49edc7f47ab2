#include "skinning/bodies/polygonise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "kinematics/configuration.h"
#include "skinning/bodies/mannequin_body.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

double smallestAngle(const Mesh& mesh) {
  double least = M_PI;
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Vector3d a = mesh.positions[t[(k + 1) % 3]] - mesh.positions[t[k]],
                     b = mesh.positions[t[(k + 2) % 3]] - mesh.positions[t[k]];
      least = std::min(least, std::atan2(a.cross(b).norm(), a.dot(b)));
    }
  return least;
}

TEST(Polygonise, ABallBecomesAClosedMeshOfItsVolume) {
  BodyPart part{.form = BodyPart::Form::RoundCone, .radiusA = 0.5, .radiusB = 0.5};
  part.b = part.a;
  const BodyShape ball({part});
  for (const bool symmetric : {false, true}) {
    const Mesh mesh = polygonise(ball, {.cell = 0.05, .symmetric = symmetric});
    const MeshTopology facts = topology(mesh);
    EXPECT_TRUE(facts.closed() && facts.manifold());
    EXPECT_EQ(facts.eulerCharacteristic(), 2);
    for (const Vector3d& p : mesh.positions) EXPECT_NEAR(p.norm(), 0.5, 1e-6);
    const double exact = 4.0 / 3.0 * M_PI * 0.125;
    EXPECT_NEAR(enclosedVolume(mesh), exact, 0.005 * exact);  // chords of 0.05 lie up to 0.6 mm inside
    EXPECT_GT(smallestAngle(mesh), 25.0 * M_PI / 180.0);
  }
}

TEST(Polygonise, AnyPatternOfTouchingBallsGivesAManifold) {
  std::vector<BodyPart> parts;  // a lattice of balls that nearly touch: ambiguous faces in plenty
  for (int i = 0; i < 27; ++i) {
    BodyPart part{.form = BodyPart::Form::RoundCone, .parent = i - 1, .radiusA = 0.5, .radiusB = 0.5};
    part.a = part.b = Vector3d(i % 3, i / 3 % 3, i / 9) * 0.97;
    part.blend = 1e-6;
    parts.push_back(part);
  }
  for (const double cell : {0.11, 0.17, 0.23}) {
    const MeshTopology facts = topology(polygonise(BodyShape(parts), {.cell = cell, .relaxationRounds = 0}));
    EXPECT_TRUE(facts.closed()) << cell;
    EXPECT_TRUE(facts.manifold()) << cell;
  }
}

TEST(Polygonise, NoLensMakesTheGridLoseAPieceOfTheBody) {
  for (int seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::vector<BodyPart> parts;  // a star of thin rods whose tips, at the rim, lie under two lenses each
    std::vector<GridLens> lenses;
    for (int i = 0; i < 4; ++i) {
      BodyPart part{.form = BodyPart::Form::RoundCone, .parent = i == 0 ? -1 : 0};
      part.b = (0.5 + 0.5 * uniform01(random)) * testing::randomUnit(random);
      part.radiusA = part.radiusB = 0.03;
      part.blend = part.siblingBlend = 0.01;
      parts.push_back(part);
      for (int k = 0; k < 2; ++k)
        lenses.push_back(
            {{part.b + 0.01 * testing::randomUnit(random)}, 2.5, 0.08 + 0.04 * uniform01(random)});
    }
    const BodyShape shape(parts);
    const PolygoniseOptions coarse{.cell = 0.015, .relaxationRounds = 1};
    PolygoniseOptions magnified = coarse;
    magnified.lenses = lenses;
    const Mesh plain = polygonise(shape, coarse), through = polygonise(shape, magnified);
    EXPECT_TRUE(topology(through).closed() && topology(through).manifold());
    Eigen::AlignedBox3d plainBox, throughBox;
    for (const Vector3d& p : plain.positions) plainBox.extend(p);
    for (const Vector3d& p : through.positions) throughBox.extend(p);
    // Both lie on F = 0: the boxes differ by what a chord of a cell cuts off a tip of radius 0.03.
    EXPECT_LT((plainBox.max() - throughBox.max()).cwiseAbs().maxCoeff(), 0.005);
    EXPECT_LT((plainBox.min() - throughBox.min()).cwiseAbs().maxCoeff(), 0.005);
    EXPECT_NEAR(enclosedVolume(through), enclosedVolume(plain), 0.1 * enclosedVolume(plain));
  }
}

TEST(Polygonise, ABlendThatBulgesOutOfItsPartsStaysClosed) {
  for (const double blend : {0.5, 2.0, 8.0}) {
    std::vector<BodyPart> parts;  // ten balls of radius 0.5 in one place, each blended with the one before
    for (int i = 0; i < 10; ++i) {
      parts.push_back({.form = BodyPart::Form::RoundCone, .parent = i - 1, .blend = i == 0 ? 0.0 : blend});
      parts.back().b = parts.back().a;
      parts.back().radiusA = parts.back().radiusB = 0.5;
    }
    // By hand: F = |p| - 0.5 - k s, s the sum of (1 - s / 1.5)^3 / 4 over the nine blends.
    double s = 0.0;
    for (int i = 1; i < 10; ++i) s += std::pow(1.0 - s / 1.5, 3) / 4.0;
    const double radius = 0.5 + blend * s;
    const Mesh mesh = polygonise(BodyShape(parts), {.cell = radius / 10.0});
    EXPECT_TRUE(topology(mesh).closed() && topology(mesh).manifold()) << blend;
    EXPECT_EQ(topology(mesh).eulerCharacteristic(), 2) << blend;
    for (const Vector3d& p : mesh.positions) ASSERT_NEAR(p.norm(), radius, 1e-6 * radius) << blend;
  }
}

TEST(Polygonise, TheFigureIsClosedManifoldOfGenusZeroAndExactlySymmetric) {
  const BodyShape shape = mannequinShape();
  std::vector<int> partner;
  const Mesh mesh = polygonise(shape, mannequinGrid(), &partner);
  const MeshTopology facts = topology(mesh);
  EXPECT_TRUE(facts.closed());
  EXPECT_TRUE(facts.manifold());
  EXPECT_EQ(facts.eulerCharacteristic(), 2);
  EXPECT_EQ(facts.components, 1);
  EXPECT_EQ(facts.degenerateTriangles, 0);
  EXPECT_GE(facts.vertices, 20000);
  EXPECT_LE(facts.vertices, 40000);
  EXPECT_GT(smallestAngle(mesh), 15.0 * M_PI / 180.0);
  EXPECT_NEAR(enclosedVolume(mesh), 0.066, 0.002);  // the measured body: 66.4 litres

  const auto all = shape.everywhere();
  double farthest = 0.0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vector3d& p = mesh.positions[v];
    EXPECT_EQ(mesh.positions[partner[v]], Vector3d(-p.x(), p.y(), p.z()));
    EXPECT_EQ(partner[partner[v]], static_cast<int>(v));
    if (v % 20 == 0) farthest = std::max(farthest, std::abs(shape.value(p, all)));
  }
  EXPECT_LE(farthest, 5e-4);  // metres; one Newton step from a smoothed place
}

TEST(Polygonise, ThreadsDoNotChangeTheMesh) {
  PolygoniseOptions options = mannequinGrid();
  options.cell = 0.03;
  options.threads = 1;
  const Mesh one = polygonise(mannequinShape(), options);
  options.threads = 3;
  const Mesh three = polygonise(mannequinShape(), options);
  EXPECT_EQ(one.positions, three.positions);
  EXPECT_EQ(one.triangles, three.triangles);
}

TEST(Polygonise, GridsThatCannotBeAreRefused) {
  EXPECT_THROW(polygonise(mannequinShape(), {.cell = 0.0}), std::invalid_argument);
  EXPECT_THROW(polygonise(mannequinShape(), {.cell = 1e-5}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
