#include "skinning/io/collada.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <filesystem>

#include "kinematics/io/parse_error.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/urdf_body.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
namespace fs = std::filesystem;

const std::string file = testing::inputFolder() + "/corner_cm.dae";

TEST(Collada, IsInMetresByItsOwnUnitWithItsNodesInPlaceAndZLeftUp) {
  if (!readsCollada()) GTEST_SKIP() << "built without Assimp";
  const Mesh mesh = readCollada(file);  // a corner of 100 cm edges at (10, 20, 30) cm, z up
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : mesh.positions) box.extend(p);
  EXPECT_LT((box.min() - Vector3d(0.1, 0.2, 0.3)).norm(), 1e-6);
  EXPECT_LT((box.max() - Vector3d(1.1, 1.2, 1.3)).norm(), 1e-6);
  EXPECT_NEAR(enclosedVolume(mesh), 1.0 / 6.0, 1e-6);
}

TEST(Collada, WhatIsNoneIsRefused) {
  const std::string bad = ::testing::TempDir() + "gelenk_bad.dae";
  for (const char* text :
       {"", "<COLLADA", "<?xml version=\"1.0\"?><COLLADA></COLLADA>", "solid\nendsolid\n"}) {
    writeFile(bad, text);
    EXPECT_THROW(readCollada(bad), ParseError) << text;
  }
  fs::remove(bad);
}

TEST(UrdfBody, PackagesAreFoundByWalkingUpFromTheFileHoweverDeepItLies) {
  if (!readsCollada()) GTEST_SKIP() << "built without Assimp";
  const fs::path root = fs::path(::testing::TempDir()) / "gelenk_packages";
  fs::remove_all(root);
  fs::create_directories(root / "arm_description/meshes/visual");
  fs::create_directories(root / "arm_description/urdf/a/b/c/d/e/f");
  fs::copy_file(file, root / "arm_description/meshes/visual/corner.dae");
  const auto urdf = [&](const fs::path& at, const std::string& mesh) {
    writeFile(at.string(), "<robot name=\"r\"><link name=\"a\"><visual><geometry><mesh filename=\"" + mesh +
                               "\"/></geometry></visual></link></robot>");
    return openUrdf(at.string());
  };
  const std::string package = "package://arm_description/meshes/visual/corner.dae";
  for (const fs::path& at : {root / "arm.urdf", root / "arm_description/urdf/arm.urdf",
                             root / "arm_description/urdf/a/b/c/d/e/f/arm.urdf"}) {
    const UrdfModel model = urdf(at, package);
    ASSERT_TRUE(model.skin) << at;
    EXPECT_TRUE(model.notes.empty()) << at;
    EXPECT_NEAR(enclosedVolume(model.skin->mesh), 1.0 / 6.0, 1e-6);
  }
  const UrdfModel missing = urdf(root / "arm.urdf", "package://arm_description/meshes/none.dae");
  EXPECT_FALSE(missing.skin);
  ASSERT_EQ(missing.notes.size(), 1u);
  EXPECT_EQ(missing.notes[0].kind, "mesh-missing");
  fs::remove_all(root);
}

}  // namespace
}  // namespace gelenk
