#include "skinning/io/nurbs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "skinning/muscles/nurbs_surface.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"
#include "tests/skinning/muscles/nurbs_arm.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// The exact cylinder of radius 2, height 3 about z: rational quadratic circle of nine points in v (Piegl,
/// Tiller, 7.5).
NurbsSurface cylinder() {
  NurbsSurface s{.degreeU = 1,
                 .degreeV = 2,
                 .countU = 2,
                 .countV = 9,
                 .knotsU = {0, 0, 1, 1},
                 .knotsV = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4},
                 .points = {},
                 .weights = {}};
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 9; ++j) {
      const double angle = j * M_PI / 4.0, corner = j % 2 ? std::sqrt(2.0) : 1.0;
      // u runs down, v counter-clockwise: du x dv points outwards
      s.points.emplace_back(2.0 * corner * std::cos(angle), 2.0 * corner * std::sin(angle), 3.0 * (1 - i));
      s.weights.push_back(j % 2 ? std::sqrt(0.5) : 1.0);
    }
  return s;
}

TEST(Nurbs, RationalCircleIsExact) {
  const NurbsSurface s = cylinder();
  for (double v = 0.0; v <= 4.0; v += 0.037) {
    const NurbsPoint at = evaluate(s, 0.3, v);
    EXPECT_NEAR(at.position.head<2>().norm(), 2.0, 1e-14);
    EXPECT_NEAR(at.position.z(), 2.1, 1e-14);
    EXPECT_NEAR(at.dv.head<2>().dot(at.position.head<2>()), 0.0, 1e-12);
  }
}

TEST(Nurbs, DerivativesMatchCentralDifferences) {
  NurbsSurface s = cylinder();
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    s.points[i] += 0.3 * Vector3d(std::sin(3.0 * i), std::cos(5.0 * i), std::sin(7.0 * i));
    s.weights[i] *= 1.0 + 0.4 * std::sin(2.0 * i);
  }
  constexpr double h = 1e-6;
  for (double u = 0.1; u < 1.0; u += 0.17)
    for (double v = 0.13; v < 4.0; v += 0.31) {  // never on a double knot, where the surface has a corner
      const NurbsPoint at = evaluate(s, u, v);
      EXPECT_LE((at.du - (evaluate(s, u + h, v).position - evaluate(s, u - h, v).position) / (2 * h)).norm(),
                1e-8);
      EXPECT_LE((at.dv - (evaluate(s, u, v + h).position - evaluate(s, u, v - h).position) / (2 * h)).norm(),
                1e-7);
    }
}

TEST(Nurbs, ClosedSurfaceIsTessellatedWithoutASeam) {
  const Mesh tube = tessellate(cylinder(), 6, 32);
  EXPECT_EQ(tube.positions.size(), 7u * 32u);
  const MeshTopology facts = topology(tube);
  EXPECT_TRUE(facts.manifold());
  EXPECT_EQ(facts.boundaryEdges, 64);
  for (std::size_t v = 0; v < tube.positions.size(); ++v)
    EXPECT_NEAR(tube.normals[v].dot(Vector3d(tube.positions[v].x(), tube.positions[v].y(), 0).normalized()),
                1.0, 1e-12);
}

TEST(Nurbs, AClosedTubeHasPolesRoundEndsAndExactEllipses) {
  std::vector<TubeRing> rings;
  for (int i = 0; i < 6; ++i)
    rings.push_back({Vector3d(0.1, 0.2, 0.3 * i), Vector3d(0.4, 0, 0), Vector3d(0, 0.2, 0)});
  const NurbsSurface s = closedTube(rings);
  validate(s);
  const double middle = 0.5 * (s.lowerU() + s.upperU());
  for (double v = 0.0; v <= 4.0; v += 0.1) {
    const Vector3d p = evaluate(s, middle, v).position - Vector3d(0.1, 0.2, 0.0);
    EXPECT_NEAR(std::hypot(p.x() / 0.4, p.y() / 0.2), 1.0, 1e-14);
    EXPECT_NEAR(evaluate(s, s.lowerU(), v).du.z(), 0.0,
                1e-14);  // the tangent plane at the pole is that of the ring
  }
  const Mesh tube = tessellate(s, 60, 48);
  const MeshTopology facts = topology(tube);
  EXPECT_TRUE(facts.closed());
  EXPECT_TRUE(facts.manifold());
  EXPECT_EQ(facts.eulerCharacteristic(), 2);
  const double cylinderAndHalf = M_PI * 0.4 * 0.2 * 1.5;   // between the outermost rings
  EXPECT_GT(enclosedVolume(tube), 0.7 * cylinderAndHalf);  // positive: the triangles face outwards
  EXPECT_LT(enclosedVolume(tube), cylinderAndHalf);
}

TEST(Nurbs, TheArmThatComesWithTheProgramIsItsTableOfRings) {
  const NurbsSurface file = readNurbs(testing::assetFolder() + "/nurbs_arm.nurbs"),
                     made = closedTube(testing::armRings());
  EXPECT_EQ(file.knotsU, made.knotsU);
  EXPECT_EQ(file.knotsV, made.knotsV);
  EXPECT_EQ(file.weights, made.weights);
  ASSERT_EQ(file.points.size(), made.points.size());
  for (std::size_t i = 0; i < made.points.size(); ++i)
    EXPECT_LE((file.points[i] - made.points[i]).cwiseAbs().maxCoeff(),
              0.51e-6);  // the file's coordinates are rounded to 1e-6
}

TEST(Nurbs, TextReadsBackExactly) {
  NurbsSurface s = cylinder();
  s.points[3].x() = 0.1 + 0.2;
  const NurbsSurface again = parseNurbs(nurbsText(s), "memory");
  EXPECT_EQ(again.knotsV, s.knotsV);
  EXPECT_EQ(again.weights, s.weights);
  EXPECT_EQ(again.points, s.points);
}

TEST(Nurbs, BadInputIsRefusedWithItsLine) {
  const std::string good = nurbsText(cylinder());
  EXPECT_NO_THROW(parseNurbs(good, "good.nurbs"));
  const auto with = [&](const std::string& old, const std::string& replacement) {
    std::string text = good;
    const std::size_t at = text.find(old);
    EXPECT_NE(at, std::string::npos) << old;
    return text.replace(at, old.size(), replacement);
  };
  const int last = static_cast<int>(std::count(good.begin(), good.end(), '\n'));
  testing::expectRefused(
      {
          {"empty", "", 0, "expected 'nurbs 1', the format's name and version, found the end of the file"},
          {"only comments", "# nothing\n", 0, "the end of the file"},
          {"another format", "v 0 0 0\n", 1, "expected 'nurbs 1'"},
          {"another version", with("nurbs 1", "nurbs 7"), 1, "version 1, found '7'"},
          {"no version", with("nurbs 1", "nurbs"), 1, "(1 values), found 0 values"},
          {"name in other case", with("nurbs 1", "NURBS 1"), 1, "found 'NURBS'"},
          {"no degree", with("degree 1 2\n", ""), 2, "'degree' with two integers, found 'points'"},
          {"one degree", with("degree 1 2", "degree 1"), 2, "(2 values), found 1 values"},
          {"degree a word", with("degree 1 2", "degree 1 x"), 2, "an integer from 1 to 9, found 'x'"},
          {"degree 0", with("degree 1 2", "degree 0 2"), 2, "found '0'"},
          {"degree 10", with("degree 1 2", "degree 1 10"), 2, "found '10'"},
          {"degree a fraction", with("degree 1 2", "degree 1.5 2"), 2, "found '1.5'"},
          {"one point in u", with("points 2 9", "points 1 9"), 3, "an integer from 2 to 10000, found '1'"},
          {"minus two points", with("points 2 9", "points -2 9"), 3, "found '-2'"},
          {"a million points in u", with("points 2 9", "points 1000000 9"), 3, "found '1000000'"},
          {"a hundred million points", with("points 2 9", "points 10000 10000"), 3,
           "at most 1000000 control points, found 100000000"},
          {"counts that overflow", with("points 2 9", "points 99999999999 9"), 3, "'99999999999'"},
          {"knots missing", with("knots_u 0 0 1 1\n", ""), 4, "found 'knots_v'"},
          {"a knot too few", with("knots_u 0 0 1 1", "knots_u 0 0 1"), 4,
           "'knots_u' with points + degree + 1 = 4 knots (4 values), found 3 values"},
          {"a knot too many", with("knots_u 0 0 1 1", "knots_u 0 0 1 1 1"), 4, "found 5 values"},
          {"knots that decrease", with("knots_u 0 0 1 1", "knots_u 0 1 0 1"), 4,
           "do not decrease, found '0'"},
          {"all knots equal", with("knots_u 0 0 1 1", "knots_u 1 1 1 1"), 0, "empty domain"},
          {"a knot NaN", with("knots_u 0 0 1 1", "knots_u 0 nan 1 1"), 4, "'nan'"},
          {"a knot infinite", with("knots_u 0 0 1 1", "knots_u 0 0 1 inf"), 4, "'inf'"},
          {"more points than there are knots for", with("points 2 9", "points 2 10"), 5,
           "points + degree + 1 = 13 knots"},
          {"weight zero", with("point 2 0 3 1", "point 2 0 3 0"), 6, "a positive weight, found '0'"},
          {"weight negative", with("point 2 0 3 1", "point 2 0 3 -1"), 6, "a positive weight, found '-1'"},
          {"no weight", with("point 2 0 3 1", "point 2 0 3"), 6,
           "point 1 of 18 as 'point x y z weight' (4 values), found 3 values"},
          {"point NaN", with("point 2 0 3 1", "point 2 0 nan 1"), 6, "a finite number, found 'nan'"},
          {"point overflow", with("point 2 0 3 1", "point 2 0 1e400 1"), 6, "'1e400'"},
          {"decimal comma", with("point 2 0 3 1", "point 2 0 3,5 1"), 6, "'3,5'"},
          {"unknown keyword", with("point 2 0 3 1", "vertex 2 0 3 1"), 6, "found 'vertex'"},
          {"cut off", good.substr(0, good.rfind("point")), last - 1,
           "point 18 of 18 as 'point x y z weight', found the end of the file"},
          {"a point too many", good + "point 0 0 0 1\n", last + 1,
           "the end of the file after 18 points, found 'point'"},
          {"CRLF keeps line numbers", "nurbs 1\r\n\r\ndegree 1 x\r\n", 3, "'x'"},
          {"binary",
           std::string("\x7f"
                       "ELF\0\1",
                       6),
           1, "expected 'nurbs 1'"},
      },
      [](const std::string& text, const std::string& file) { parseNurbs(text, file); });
}

}  // namespace
}  // namespace gelenk
