#include "skinning/io/stl.h"

#include <cstring>
#include <filesystem>

#include "skinning/io/urdf_body.h"
#include "tests/kinematics/io/bad_input.h"

namespace gelenk {
namespace {

const std::string facet = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const std::string facet2 = "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 -0\nendloop\nendfacet\n";

std::string binary(std::uint32_t count, const std::vector<float>& corners) {
  std::string bytes(80, ' ');
  bytes.append(reinterpret_cast<const char*>(&count), 4);
  for (std::size_t t = 0; t + 9 <= corners.size(); t += 9) {
    bytes.append(12, '\0');
    bytes.append(reinterpret_cast<const char*>(&corners[t]), 36);
    bytes.append(2, '\0');
  }
  return bytes;
}

TEST(Stl, TextAndBinaryShareCornersBetweenTriangles) {
  const Mesh text = parseStl("solid two faces\n" + facet + facet2 + "endsolid two faces\n", "two.stl");
  EXPECT_EQ(text.positions.size(), 4u);
  EXPECT_EQ(text.triangles.size(), 2u);
  const Mesh same = parseStl(binary(2, {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}), "two.stl");
  EXPECT_EQ(same.positions, text.positions);
  EXPECT_EQ(same.triangles, text.triangles);
}

TEST(Stl, BadInputIsRefused) {
  const float nan = std::nanf("");
  testing::expectRefused(
      {
          {"empty", "", 0, "84 bytes"},
          {"head alone", binary(0, {}), 0, "at least one triangle"},
          {"cut off", binary(3, {0, 0, 0, 1, 0, 0, 0, 1, 0}), 0, "3 triangles of 50 bytes, found 50 bytes"},
          {"four billion triangles", binary(4294967295u, {}), 0, "4294967295 triangles"},
          {"NaN", binary(1, {0, 0, 0, nan, 0, 0, 0, 1, 0}), 0, "NaN"},
          {"only points", binary(1, {0, 0, 0, 0, 0, 0, 0, 0, 0}), 0, "at least one triangle"},
          {"text without triangles", "solid a\nendsolid a\n", 0, "at least one triangle"},
          {"text cut off", "solid a\n" + facet, 8, "'facet', found the end"},
          {"two corners", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", 6, "'vertex'"},
          {"a word", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 x 0\n", 4, "'x'"},
          {"NaN in text", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", 4, "'nan'"},
      },
      [](const std::string& text, const std::string& file) { parseStl(text, file); });
}

TEST(UrdfBody, RobotsCarryTheirMeshesInMetres) {
  const std::string folder = std::string(GELENK_DATA_DIR) + "/robots/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no trial data at " << folder;
  const UrdfModel kuka = openUrdf(folder + "kuka_iiwa/model.urdf");
  ASSERT_TRUE(kuka.skin);
  EXPECT_NEAR(bodySize(kuka.skin->mesh), 1.3, 0.3);  // metres: the arm is 1.3 m tall when upright
  const UrdfModel panda = openUrdf(folder + "panda/urdf/panda.urdf");  // Collada is not read: collision geometry instead
  ASSERT_TRUE(panda.skin);
  EXPECT_NEAR(bodySize(panda.skin->mesh), 1.2, 0.3);
}

}  // namespace
}  // namespace gelenk
