#include "skinning/io/obj.h"

#include <random>

#include "kinematics/configuration.h"
#include "tests/kinematics/io/bad_input.h"

namespace gelenk {
namespace {

TEST(Obj, PolygonsBecomeFansAndEveryCornerFormIsRead) {
  const Mesh mesh = parseObj(
      "# a square and a triangle\n"
      "mtllib none.mtl\no thing\n"
      "v 0 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0 0.5 0.5 0.5\n"
      "vt 0 0\nvn 0 0 1\ng square\nusemtl skin\ns off\n"
      "f 1/1/1 2//1 3/1 4\n"
      "f -4 -3 \\\n -1 # counted back\n",
      "forms.obj");
  ASSERT_EQ(mesh.positions.size(), 4u);
  ASSERT_EQ(mesh.triangles.size(), 3u);
  EXPECT_EQ(mesh.triangles[0], (std::array{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (std::array{0, 2, 3}));
  EXPECT_EQ(mesh.triangles[2], (std::array{0, 1, 3}));
  EXPECT_EQ(mesh.positions[2], Eigen::Vector3d(1, 1, 0));
}

TEST(Obj, VerticesWithoutFacesKeepTheirPlace) {
  const Mesh mesh = parseObj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n", "loose.obj");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(topology(mesh).unreferencedVertices, 1);
}

TEST(Obj, WrittenAndReadAgainIsTheSameToTheLastBit) {
  std::mt19937_64 random(7);
  Mesh mesh;
  for (int v = 0; v < 200; ++v)
    mesh.positions.push_back(std::pow(10.0, 6.0 * uniform01(random) - 3.0) *
                             Eigen::Vector3d(uniform01(random) - 0.5, uniform01(random), -uniform01(random)));
  for (int t = 0; t < 300; ++t)
    mesh.triangles.push_back({int(random() % 200), int(random() % 200), int(random() % 200)});
  const Mesh again = parseObj(formatObj(mesh), "again.obj");
  EXPECT_EQ(again.positions, mesh.positions);
  EXPECT_EQ(again.triangles, mesh.triangles);
}

TEST(Obj, BadInputIsRefusedWithItsLine) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";  // three lines
  testing::expectRefused(
      {
          {"empty", "", 0, "at least one vertex"},
          {"only comments", "# nothing\n\n#\n", 0, "at least one vertex"},
          {"faces alone", "f 1 2 3\n", 0, "at least one vertex"},
          {"vertices alone", triangle, 0, "at least one face"},
          {"index too large", triangle + "f 1 2 4\n", 4, "at most 3, found 4"},
          {"index too large in a later polygon", triangle + "f 1 2 3\nf 1 2 3 9\n", 5, "found 9"},
          {"index zero", triangle + "f 0 1 2\n", 4, "from 1"},
          {"counted back too far", triangle + "f -4 1 2\n", 4, "counts back at most 3"},
          {"counted back before any vertex", "f -1 -2 -3\n" + triangle, 1, "counts back at most 0"},
          {"huge index", triangle + "f 1 2 99999999999\n", 4, "'99999999999'"},
          {"largest int", triangle + "f 1 2 2147483647\n", 4, "found 2147483647"},
          {"smallest int", triangle + "f 1 2 -2147483648\n", 4, "counts back"},
          {"fraction as index", triangle + "f 1 2 2.5\n", 4, "'2.5'"},
          {"two corners", triangle + "f 1 2\n", 4, "three corners, found 2"},
          {"no corner", triangle + "f\n", 4, "three corners, found 0"},
          {"four indices in a corner", triangle + "f 1/1/1/1 2 3\n", 4, "three indices"},
          {"empty vertex index", triangle + "f /1 2 3\n", 4, "'/1'"},
          {"hanging slash", triangle + "f 1/1/ 2 3\n", 4, "'1/1/'"},
          {"word as corner", triangle + "f a b c\n", 4, "'a'"},
          {"NaN", "v 0 nan 0\n", 1, "'nan'"},
          {"-nan(ind)", "v 0 -nan(ind) 0\n", 1, "'-nan(ind)'"},
          {"infinite", "v inf 0 0\n", 1, "'inf'"},
          {"overflow", "v 1e400 0 0\n", 1, "'1e400'"},
          {"comma as decimal point", "v 0,1 0 0\n", 1, "'0,1'"},
          {"two coordinates", "v 0 0\n", 1, "three coordinates after 'v', found 2"},
          {"eight numbers", "v 0 0 0 1 1 1 1 1\n", 1, "at most seven"},
          {"rational weight", "v 0 0 0 2\n", 1, "1 as a vertex's fourth value"},
          {"unknown keyword", triangle + "face 1 2 3\n", 4, "'face'"},
          {"another format", "ply\nformat ascii 1.0\n", 1, "'ply'"},
          {"binary", std::string("glTF\2\0\0\0", 8), 1, "an OBJ keyword"},
          {"cut in the middle of a vertex", "v 0 0 0\r\nv 1 0", 2, "found 2"},
          {"CRLF keeps line numbers", "v 0 0 0\r\n\r\n\r\nv x 0 0\r\n", 4, "'x'"},
      },
      [](const std::string& text, const std::string& file) { parseObj(text, file); });
}

}  // namespace
}  // namespace gelenk
