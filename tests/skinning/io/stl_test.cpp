#include "skinning/io/stl.h"

#include <cstring>
#include <filesystem>
#include <limits>

#include "skinning/io/urdf_body.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

namespace gelenk {
namespace {

const std::string facet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";
const std::string facet2 =
    "facet normal 0 0 1\nouter loop\nvertex 1 0 0\nvertex 1 1 0\nvertex 0 1 -0\nendloop\nendfacet\n";

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
  const float nan = std::nanf(""), infinite = std::numeric_limits<float>::infinity();
  const std::string head = "solid a\nfacet normal 0 0 1\nouter loop\n";  // three lines
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
          {"two corners", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nendloop\n", 6,
           "'vertex'"},
          {"a word", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 x 0\n", 4, "'x'"},
          {"one byte", "s", 0, "84 bytes, found 1 bytes"},
          {"a byte short of a head", std::string(83, ' '), 0, "84 bytes, found 83 bytes"},
          {"cut in a triangle", binary(1, {0, 0, 0, 1, 0, 0, 0, 1, 0}).substr(0, 120), 0,
           "1 triangles of 50 bytes, found 36 bytes"},
          {"one triangle more than there is", binary(2, {0, 0, 0, 1, 0, 0, 0, 1, 0}), 0,
           "2 triangles of 50 bytes, found 50 bytes"},
          {"infinite", binary(1, {0, 0, 0, infinite, 0, 0, 0, 1, 0}), 0, "NaN or infinity in triangle 0"},
          {"minus infinite in the second",
           binary(2, {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, -infinite, 0, 0, 0, 1, 0}), 0, "in triangle 1"},
          {"only lines", binary(1, {0, 0, 0, 1, 0, 0, 1, 0, 0}), 0, "at least one triangle"},
          {"another binary", "glTF" + std::string(96, '\xff'), 0, "4294967295 triangles"},
          {"solid alone", "solid", 1, "'facet', found the end"},
          {"another format", "solid.obj\nv 0 0 0\n", 1, "'solid', found 'solid.obj'"},
          {"cut off, in upper case", "SOLID a\n" + facet, 8, "'facet', found the end"},
          {"no facet", "solid a\nouter loop\n", 2, "'facet', found 'outer'"},
          {"no normal", "solid a\nfacet 0 0 1\n", 2, "'normal', found '0'"},
          {"two loops", head + "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nouter loop\n", 8,
           "'endfacet', found 'outer'"},
          {"no loop", "solid a\nfacet normal 0 0 1\nvertex 0 0 0\n", 3, "'outer', found 'vertex'"},
          {"four corners", head + "vertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nvertex 0 2 0\n", 7,
           "'endloop', found 'vertex'"},
          {"two coordinates", head + "vertex 0 0\nvertex 1 0 0\n", 5, "a finite number, found 'vertex'"},
          {"four coordinates", head + "vertex 0 0 0 1\n", 4, "'vertex', found '1'"},
          {"infinite in text", head + "vertex inf 0 0\n", 4, "'inf'"},
          {"overflow in text", head + "vertex 0 0 0\nvertex 1e309 0 0\n", 5, "'1e309'"},
          {"decimal comma", head + "vertex 0,5 0 0\n", 4, "'0,5'"},
          {"a second solid", "solid a\n" + facet + "solid b\n", 9, "'facet', found 'solid'"},
          {"mixed case and CRLF keep line numbers",
           "solid a\r\nFacet Normal 0 0 1\r\nOUTER Loop\r\nVertex 0 y 0\r\n", 4, "'y'"},
          {"NaN in text", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 nan 0\n", 4, "'nan'"},
      },
      [](const std::string& text, const std::string& file) { parseStl(text, file); });
}

TEST(UrdfBody, RobotsCarryTheirMeshesInMetres) {
  const std::string folder = testing::dataFolder() + "/robots/";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no trial data at " << folder;
  const UrdfModel kuka = openUrdf(folder + "kuka_iiwa/model.urdf");
  ASSERT_TRUE(kuka.skin);
  EXPECT_NEAR(bodySize(kuka.skin->mesh), 1.3, 0.3);  // metres: the arm is 1.3 m tall when upright
  const UrdfModel panda =
      openUrdf(folder + "panda/urdf/panda.urdf");  // Collada is not read: collision geometry instead
  ASSERT_TRUE(panda.skin);
  EXPECT_NEAR(bodySize(panda.skin->mesh), 1.2, 0.3);
}

}  // namespace
}  // namespace gelenk
