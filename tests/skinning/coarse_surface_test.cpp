#include "skinning/coarse_surface.h"

#include <gtest/gtest.h>

#include "skinning/bodies/polygonise.h"

namespace gelenk {
namespace {

Mesh ball() {
  BodyPart part{.form = BodyPart::Form::RoundCone};
  part.b = part.a;
  part.radiusA = part.radiusB = 1.0;
  return polygonise(BodyShape({part}), {.cell = 0.1});
}

bool enclosesItsInside(const Mesh& mesh) {
  return gelenk::enclosesItsInside(mesh.triangles, static_cast<int>(mesh.positions.size()),
                                   [&](int v) { return Eigen::Vector3f(mesh.positions[v].cast<float>()); });
}

TEST(CoarseSurface, IsTheSameSurfaceWithAboutAQuarterOfTheTriangles) {
  Mesh mesh = ball();
  const double volume = enclosedVolume(mesh);
  const std::size_t before = mesh.triangles.size();
  mesh.triangles = coarseTriangles(mesh.triangles, static_cast<int>(mesh.positions.size()));
  EXPECT_LT(mesh.triangles.size(), 3 * before / 10);
  EXPECT_GT(mesh.triangles.size(), before / 10);
  const MeshTopology facts = topology(mesh);
  EXPECT_TRUE(facts.closed());
  EXPECT_EQ(facts.eulerCharacteristic(), 2);
  EXPECT_NEAR(enclosedVolume(mesh), volume, 0.03 * volume);  // chords of edges of about 0.25
}

TEST(CoarseSurface, OnlyWhatIsClosedAndFacesOutwardsEnclosesItsInside) {
  Mesh mesh = ball();
  EXPECT_TRUE(enclosesItsInside(mesh));
  Mesh open = mesh, inward = mesh, turned = mesh;
  open.triangles.pop_back();
  EXPECT_FALSE(enclosesItsInside(open));
  for (auto& t : inward.triangles) std::swap(t[1], t[2]);
  EXPECT_FALSE(enclosesItsInside(inward));
  std::swap(turned.triangles[5][1], turned.triangles[5][2]);
  EXPECT_FALSE(enclosesItsInside(turned));
}

}  // namespace
}  // namespace gelenk
