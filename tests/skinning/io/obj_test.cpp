#include "skinning/io/obj.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <random>

#include "kinematics/configuration.h"
#include "kinematics/io/text_file.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

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

double areaOf(const Mesh& mesh) {
  double area = 0.0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += 0.5 * (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).norm();
  return area;
}

TEST(Obj, ConcavePolygonsDoNotFold) {
  std::vector<Note> notes;
  const Mesh quad = readObj(testing::inputFolder() + "/concave.obj", &notes);
  EXPECT_EQ(quad.triangles, (std::vector<std::array<int, 3>>{{2, 3, 0}, {1, 2, 0}}));  // 3 4 1 and 3 1 2
  EXPECT_NEAR(areaOf(quad), 1.0, 1e-12);
  EXPECT_TRUE(notes.empty());
}

TEST(Obj, PolygonsOfAnyShapeAndStartKeepTheirAreaAndSense) {
  // Stars, combs and an L in a turned plane; area by the shoelace formula in that plane.
  std::vector<std::vector<Eigen::Vector2d>> shapes;
  for (const int points : {3, 5, 12}) {
    std::vector<Eigen::Vector2d> star;
    for (int k = 0; k < 2 * points; ++k)
      star.push_back((k % 2 ? 0.3 : 1.0) *
                     Eigen::Vector2d(std::cos(M_PI * k / points), std::sin(M_PI * k / points)));
    shapes.push_back(star);
  }
  shapes.push_back({{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}});  // with corners on one line
  shapes.push_back({{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {1, 1}, {0.9, 1}, {0.9, 2}, {0, 2}});
  std::vector<Eigen::Vector2d> comb;
  for (int k = 0; k < 8; ++k) comb.insert(comb.end(), {{k, 0.0}, {k, 2.0}, {k + 0.5, 2.0}, {k + 0.5, 0.0}});
  comb.insert(comb.end(), {{8, -1}, {0, -1}});
  shapes.push_back(comb);
  const Eigen::Matrix3d turn = Eigen::Quaterniond(0.3, 0.5, -0.7, 0.2).normalized().toRotationMatrix();
  for (std::size_t s = 0; s < shapes.size(); ++s)
    for (std::size_t start = 0; start < shapes[s].size(); ++start)
      for (const bool backwards : {false, true}) {
        std::vector<Eigen::Vector2d> shape = shapes[s];
        std::rotate(shape.begin(), shape.begin() + static_cast<std::ptrdiff_t>(start), shape.end());
        if (backwards) std::reverse(shape.begin(), shape.end());
        double area = 0.0;
        std::string text, face = "f";
        for (std::size_t k = 0; k < shape.size(); ++k) {
          const Eigen::Vector2d &a = shape[k], &b = shape[(k + 1) % shape.size()];
          area += 0.5 * (a.x() * b.y() - a.y() * b.x());
          const Eigen::Vector3d p = turn * Eigen::Vector3d(a.x(), a.y(), 4.0);
          text += "v " + exactNumber(p.x()) + " " + exactNumber(p.y()) + " " + exactNumber(p.z()) + "\n";
          face += " " + std::to_string(k + 1);
        }
        std::vector<Note> notes;
        const Mesh mesh = parseObj(text + face + "\n", "shape.obj", &notes);
        EXPECT_EQ(mesh.triangles.size(), shape.size() - 2);
        EXPECT_NEAR(areaOf(mesh), std::abs(area), 1e-9) << "shape " << s << " from corner " << start;
        const Eigen::Vector3d normal = turn.col(2) * (area > 0.0 ? 1.0 : -1.0);
        for (const auto& [a, b, c] : mesh.triangles)
          EXPECT_GE((mesh.positions[b] - mesh.positions[a])
                        .cross(mesh.positions[c] - mesh.positions[a])
                        .dot(normal),
                    -1e-12);
        EXPECT_TRUE(notes.empty()) << "shape " << s << " from corner " << start;
      }
}

TEST(Obj, CrossingPolygonsAreTold) {
  std::vector<Note> notes;
  const Mesh mesh = parseObj(
      "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1.5 0\nf 1 2 3 4\nv 0 0 1\nv 2 0 1\nv 3 0 1\nv 1 0 1\nf 5 6 7 8\n",
      "bow.obj", &notes);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].kind, "polygon-crossing");
  EXPECT_EQ(notes[0].count, 2);  // a bow tie, and one without area
}

TEST(Obj, VerticesWithoutFacesKeepTheirPlace) {
  const Mesh mesh = parseObj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n", "loose.obj");
  EXPECT_EQ(mesh.positions.size(), 4u);
  EXPECT_EQ(topology(mesh).unreferencedVertices, 1);
}

/// A roof of two squares, by its normals sharp at the ridge and round at one gutter, where two equal ones are
/// told twice; one corner asks for a normal that is not there.
TEST(Obj, NormalsOfTheFileAreKeptAndCutTheSurface) {
  const std::string path = (std::filesystem::temp_directory_path() / "roof.obj").string();
  writeFile(path,
            "v 0 0 0\nv 1 0 0\nv 1 1 1\nv 0 1 1\nv 0 2 0\nv 1 2 0\n"
            "vn 0 -1 1\nvn 0 1 1\nvn 0 0 2\nvn 0 0 1\nvn 0 0 0\n"
            "f 1//3 2//3 3//1 4//1\nf 4//-4 3//-4 6//4 5//4\nf 1//4 4//1 5//5\n");
  const Mesh mesh = readObj(path);
  std::vector<Note> notes;
  const auto look = readObjLook(path, mesh, &notes);
  ASSERT_TRUE(look);
  EXPECT_TRUE(look->look.materials.empty());
  EXPECT_EQ(look->copyOf, (std::vector<int>{3, 2, 4}));  // the ridge, and the corner without a normal
  Mesh cut = mesh;
  cutSurface(*look, cut);
  const double h = std::sqrt(0.5);
  for (std::size_t t = 0; t < 4; ++t)
    for (const int v : cut.triangles[t]) {
      const Eigen::Vector3d& p = cut.positions[v];
      const Eigen::Vector3d expected =
          p.z() == 0.0 ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, t < 2 ? -h : h, h);
      EXPECT_NEAR((cut.normals[v] - expected).norm(), 0.0, 1e-15) << t;
    }
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0].kind, "normals-missing");
  EXPECT_EQ(notes[0].count, 1);
  EXPECT_NEAR(look->normals.back().norm(), 1.0, 1e-12);

  EXPECT_EQ(readObjLook(path, mesh)->normals.size(), 9u);
  writeObj(path, cut);
  const auto again = readObjLook(path, readObj(path));
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->copyOf.empty());
  EXPECT_EQ(again->normals, cut.normals);
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
