#include "skinning/bodies/polygonise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "skinning/bodies/mannequin_body.h"

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
