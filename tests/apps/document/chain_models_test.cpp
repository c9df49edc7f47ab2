#include "apps/document/chain_models.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <map>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/robots.h"

namespace gelenk {
namespace {

/// Vertices in one place become one: a robot's sharp edges have a vertex for each side.
Mesh welded(const Mesh& mesh) {
  std::map<std::array<double, 3>, int> known;
  Mesh out;
  std::vector<int> to;
  for (const Eigen::Vector3d& p : mesh.positions) {
    const auto [at, isNew] = known.emplace(std::array{p.x(), p.y(), p.z()}, static_cast<int>(known.size()));
    if (isNew) out.positions.push_back(p);
    to.push_back(at->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) out.triangles.push_back({to[a], to[b], to[c]});
  return out;
}

TEST(ChainModels, EveryBuiltInChainHasABodyAroundItsBones) {
  for (const std::string& name : builtInModels()) {
    if (name == "figure") continue;
    const Model model = openModel(name);
    ASSERT_TRUE(model.skin) << name;
    EXPECT_EQ(model.skin->jointCount(), model.skeleton.jointCount()) << name;
    EXPECT_TRUE(topology(welded(model.skin->mesh)).closed()) << name;
    EXPECT_EQ(model.handles.size(), 1u);
    EXPECT_TRUE(model.skeleton.findJoint(model.handles[0])) << name;
  }
}

TEST(ChainModels, BuiltInModelsAndDescriptionsStandInNoFile) {
  for (const std::string& name : builtInModels()) EXPECT_TRUE(standsInNoFile(name)) << name;
  for (const char* name : {"planar:0,0:1,1", "balls:1,0.5", "lecture:two-link"})
    EXPECT_TRUE(standsInNoFile(name)) << name;
  EXPECT_TRUE(standsInNoFile(dhDescription(robotTable("ur5"))));
  for (const char* name : {"", "arm.urdf", "planar.obj", "/home/planar:0,0:1.json"})
    EXPECT_FALSE(standsInNoFile(name)) << name;
}

TEST(ChainModels, ThePlanarArmIsTheLecturesAndMovesInTheXyPlane) {
  const Model model = openModel("planar");
  EXPECT_TRUE(model.planar);
  const Frames frames = forwardKinematics(model.skeleton, Eigen::Vector3d(0.6, 1.0, -0.7));
  EXPECT_NEAR(frames.back().translation().x(), 230.0, 0.5);  // the slide's whole numbers
  EXPECT_NEAR(frames.back().translation().y(), 763.0, 0.5);
  EXPECT_EQ(frames.back().translation().z(), 0.0);
}

TEST(ChainModels, AnyPlanarArmIsDescribedByItsNumbers) {
  const auto chain = parsePlanarChain("planar:1,-2:4,6,2");
  ASSERT_TRUE(chain);
  EXPECT_EQ(chain->base, Eigen::Vector2d(1, -2));
  EXPECT_EQ(chain->lengths, (std::vector<double>{4, 6, 2}));
  EXPECT_FALSE(parsePlanarChain("planar"));
  EXPECT_EQ(openModel("balls:1,0.5").skeleton.nv(), 6);
  for (const char* bad : {"planar:", "planar:1:2", "planar:0,0:", "planar:0,0:1,x", "planar:0,0:1,-1",
                          "planar:0,0:1:2", "balls:", "balls:1:2", "balls:0"})
    EXPECT_THROW(openModel(bad), std::invalid_argument) << bad;
}

TEST(ChainModels, ATableWithoutExtentOpensWithoutABody) {
  const std::string path = (std::filesystem::temp_directory_path() / "gelenk_point.dh").string();
  writeFile(path, "dh modified\nrevolute 0 pi/2 0 0\nrevolute 0 0 0 0\n");
  const Model model = openModel(path);
  EXPECT_FALSE(model.skin);
  EXPECT_EQ(model.skeleton.nv(), 2);
  EXPECT_EQ(model.name, "gelenk_point");
  writeFile(path, "dh modified\nrevolute 0 pi/2 0\n");
  EXPECT_THROW(openModel(path), ParseError);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace gelenk
