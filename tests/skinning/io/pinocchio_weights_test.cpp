#include "skinning/io/pinocchio_weights.h"

#include <cmath>
#include <filesystem>
#include <random>

#include "kinematics/io/pinocchio_skeleton.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/io/obj.h"
#include "tests/kinematics/io/bad_input.h"
#include "tests/places.h"

namespace gelenk {
namespace {

TEST(PinocchioWeights, AColumnBelongsToTheBoneFromTheNextJointToItsParentAndIsCarriedByTheParent) {
  const Skeleton skeleton =
      parsePinocchioSkeleton("a 0 0 0 -1\nb 1 0 0 a\nc 2 0 0 b\nd 0 1 0 a\n", "tree.skel");
  const BoneWeights bones = parsePinocchioWeights("0.5 0.25 0.25\n0 1 0\r\n\n", "tree.attachment", 3, 2);
  const SparseWeights joints = jointWeights(bones, skeleton);
  // Bones a-b and a-d both turn about joint a.
  EXPECT_EQ(joints[0], (std::vector<std::pair<int, double>>{{0, 0.5}, {1, 0.25}, {0, 0.25}}));
  EXPECT_EQ(joints[1], (std::vector<std::pair<int, double>>{{1, 1.0}}));
  const auto influences = fourLargest(joints, skeleton.jointCount());
  EXPECT_DOUBLE_EQ(influences[0].weights[0], 0.75);
}

TEST(PinocchioWeights, WrittenAndReadAgainIsTheSameToTheLastBit) {
  const std::string text = "0.0128 0.9872 0\n0 0.0343 0.9656\n1 0 0\n";
  EXPECT_EQ(formatPinocchioWeights(parsePinocchioWeights(text, "sheet.attachment", 3, 3)), text);
}

TEST(PinocchioWeights, JointWeightsOnOneBoneAJointSurviveTheWayThroughTheFile) {
  const Skeleton skeleton =
      parsePinocchioSkeleton("a 0 0 0 -1\nb 1 0 0 a\nc 2 0 0 b\nd 0 1 0 a\n", "tree.skel");
  const SparseWeights weights{{{0, 0.75}, {1, 0.25}}, {{1, 1.0}}};
  EXPECT_EQ(jointWeights(boneWeights(weights, skeleton), skeleton), weights);
}

/// A joint's weight at a vertex.
double weightOn(const Influences& in, int joint) {
  double sum = 0.0;
  for (int k = 0; k < 4; ++k) sum += in.joints[k] == joint ? in.weights[k] : 0.0;
  return sum;
}

TEST(PinocchioWeights, ASkinsWeightsComeBackExactly) {
  const Skeleton skeleton = parsePinocchioSkeleton(
      "a 0 0 0 -1\nb 1 0 0 a\nc 2 0 0 b\nd 3 0 0 c\ne 4 0 0 d\nf 2 1 0 b\ng 3 1 0 f\n", "tree.skel");
  const int inner[] = {0, 1, 2, 3, 5};  // joints with a child
  std::mt19937_64 random(7);
  std::vector<Influences> skin;
  for (int v = 0; v < 500; ++v) {  // edited weights: multiples of 2^-30 with sum 1
    const int first = static_cast<int>(random() % 5),
              second = (first + 1 + static_cast<int>(random() % 4)) % 5;
    const double share = std::ldexp(static_cast<double>(random() % (1u << 30)), -30);
    skin.push_back({{inner[first], inner[second], 0, 0}, {1.0 - share, share, 0.0, 0.0}});
  }
  const std::string text = formatPinocchioWeights(boneWeights(skin, skeleton));
  const auto again = fourLargest(
      jointWeights(parsePinocchioWeights(text, "tree.attachment", 6, 500), skeleton), skeleton.jointCount());
  for (int v = 0; v < 500; ++v)
    for (int j = 0; j < skeleton.jointCount(); ++j)
      EXPECT_EQ(weightOn(again[v], j), weightOn(skin[v], j)) << v << " " << j;

  const std::vector<Influences> onTip{
      {{4, 0, 0, 0}, {1.0, 0.0, 0.0, 0.0}}};  // a tip has no column: its bone turns about the parent
  EXPECT_EQ(weightOn(fourLargest(jointWeights(boneWeights(onTip, skeleton), skeleton), 7)[0], 3), 1.0);
}

TEST(PinocchioWeights, BadInputIsRefusedWithItsLine) {
  const auto parse = [](const std::string& text, const std::string& file) {
    parsePinocchioWeights(text, file, 3, 2);
  };
  testing::expectRefused(
      {
          {"empty", "", 0, "rows of weights, found none"},
          {"too few rows", "1 0 0\n", 0, "2 rows, one for each vertex of the mesh, found 1"},
          {"too many rows", "1 0 0\n1 0 0\n1 0 0\n", 0, "found 3"},
          {"too few columns", "1 0\n1 0 0\n", 1, "3 weights, one for each joint but the root, found 2"},
          {"too many columns", "1 0 0\n1 0 0 0\n", 2, "found 4"},
          {"one column a joint", "0 1 0 0\n0 1 0 0\n", 1, "joint but the root, found 4"},
          {"negative", "1 0 0\n1.1 -0.1 0\n", 2, "'-0.1'"},
          {"NaN", "1 0 0\nnan 0 0\n", 2, "'nan'"},
          {"infinite", "inf 0 0\n1 0 0\n", 1, "'inf'"},
          {"overflow", "1 0 0\n1e309 0 0\n", 2, "'1e309'"},
          {"a sum that overflows", "1 0 0\n1.7e308 1.7e308 0\n", 2, "finite sum"},
          {"only zeros", "1 0 0\n0 0 0\n", 2, "only zeros"},
          {"a word", "1 0 0\n1 x 0\n", 2, "'x'"},
          {"comma as decimal point", "0,5 0,5 0\n1 0 0\n", 1, "'0,5'"},
          {"cut off", "1 0 0\n0.5 0.", 2, "found 2"},
          {"a header", "2 3\n1 0 0\n", 1, "found 2"},
          {"a skeleton instead", "0 0 0 0 -1\n1 1 0 0 0\n", 1, "found 5"},
          {"binary", std::string("\0\1\2\n\3\4", 6), 1, "found 1"},
          {"CRLF keeps line numbers", "1 0 0\r\n\r\n1 0\r\n", 3, "found 2"},
          {"hexadecimal", "0x1 0 0\n1 0 0\n", 1, "'0x1'"},
          {"only blanks", " \n\t\r\n\n", 0, "rows of weights, found none"},
          {"minus infinity", "1 0 0\n-inf 0 0\n", 2, "'-inf'"},
          {"Windows NaN", "1 0 0\n-1.#IND 0 0\n", 2, "'-1.#IND'"},
          {"a trailing letter", "1f 0 0\n1 0 0\n", 1, "'1f'"},
          {"a sign alone", "1 0 0\n0.5 - 0.5\n", 2, "'-'"},
          {"two points", "0.5.5 0 0\n1 0 0\n", 1, "'0.5.5'"},
          {"a comment", "# weights\n1 0 0\n", 1, "found 2"},
          {"separated by commas", "1,0,0\n1,0,0\n", 1, "found 1"},
          {"separated by semicolons", "1; 0; 0\n1; 0; 0\n", 1, "'1;'"},
          {"rows in one line", "1 0 0 0 1 0\n\n1 0 0\n", 1, "found 6"},
          {"bare CR as line end", "1 0 0\r1 0 0\r", 0, "2 rows, one for each vertex of the mesh, found 1"},
          {"zeros and minus zeros", "1 0 0\n-0 0 0\n", 2, "only zeros"},
          {"an OBJ instead", "v 0 0 0\nv 1 0 0\n", 1, "found 4"},
          {"a million rows",
           [] {
             std::string text;
             for (int k = 0; k < 1000000; ++k) text += "1 0 0\n";
             return text;
           }(),
           0, "found 1000000"},
      },
      parse);
}

TEST(PinocchioWeights, RowsThatMissTheMeshesLooseVerticesAreExplained) {
  Mesh mesh = parseObj("v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n", "loose.obj");
  const std::string path = ::testing::TempDir() + "loose.attachment";
  FILE* file = fopen(path.c_str(), "w");
  fputs("1\n1\n1\n", file);
  fclose(file);
  try {
    readPinocchioWeights(path, 1, mesh);
    FAIL() << "three rows for four vertices were accepted";
  } catch (const ParseError& error) {
    EXPECT_NE(std::string(error.what()).find("1 vertex without a face"), std::string::npos) << error.what();
  }
  std::filesystem::remove(path);
}

TEST(PinocchioWeights, TrioOfTheSheetSkinsInPlaceAndLosesWhatTheFactsSay) {
  const std::string data = testing::dataFolder();
  if (!std::filesystem::exists(data + "/pinocchio/mh_male.attachment.out"))
    GTEST_SKIP() << "no trial data at " << data;
  const Mesh mesh = readObj(data + "/characters/makehuman/mh_male.obj");
  const Skeleton skeleton = readPinocchioSkeleton(data + "/pinocchio/mh_male.skeleton.out");
  const BoneWeights bones =
      readPinocchioWeights(data + "/pinocchio/mh_male.attachment.out", skeleton.jointCount() - 1, mesh);
  EXPECT_TRUE(topology(mesh).closed());
  EXPECT_TRUE(topology(mesh).manifold());
  for (Eigen::Index v = 0; v < bones.rows(); ++v)
    EXPECT_NEAR(bones.row(v).sum(), 1.0, 4.1e-4);  // four decimals, 17 columns
  WeightLoss loss;
  const Skin skin = bindSkin(mesh, restFrames(skeleton),
                             fourLargest(jointWeights(bones, skeleton), skeleton.jointCount(), &loss));
  // 0.7-3.6 % mean and 19-52 % at most were measured over several bodies, before bones of one joint are
  // joined.
  EXPECT_LT(loss.mean, 0.036);
  EXPECT_LT(loss.max, 0.52);
  const SkinnedVertices rest = linearBlendSkin(skin, restFrames(skeleton));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    ASSERT_LE((rest.positions[v] - mesh.positions[v]).norm(), 1e-14);
}

}  // namespace
}  // namespace gelenk
