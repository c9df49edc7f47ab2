#include "skinning/io/skin_cache.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "kinematics/io/text_file.h"
#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

Skin tetrahedronSkin() {
  Mesh mesh{.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}},
            .triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}},
            .normals = {}};
  std::mt19937_64 random(4);
  const Skeleton skeleton = testing::randomSkeleton(random, 3);
  return bindSkin(mesh, restFrames(skeleton),
                  fourLargest({{{0, 1.0}}, {{1, 0.5}, {2, 0.5}}, {{2, 1.0}}, {{1, 1.0}}}, 3));
}

struct SkinCache : ::testing::Test {
  std::string folder =
      (std::filesystem::temp_directory_path() / ("gelenk-cache-" + std::to_string(getpid()))).string();
  std::string path = folder + "/body.skin";
  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }
};

TEST_F(SkinCache, ASkinComesBackToTheLastBit) {
  const Skin skin = tetrahedronSkin();
  writeCachedSkin(path, 17, skin);
  const auto back = readCachedSkin(path, 17);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->mesh.positions, skin.mesh.positions);
  EXPECT_EQ(back->mesh.normals, skin.mesh.normals);
  EXPECT_EQ(back->mesh.triangles, skin.mesh.triangles);
  for (std::size_t v = 0; v < 4; ++v) EXPECT_EQ(back->influences[v].weights, skin.influences[v].weights);
  for (int j = 0; j < 3; ++j)
    EXPECT_EQ(back->jointFromRestWorld[j].matrix(), skin.jointFromRestWorld[j].matrix());
}

TEST_F(SkinCache, EveryDamagedByteAndEveryCutIsNoticed) {
  writeCachedSkin(path, 17, tetrahedronSkin());
  const std::string whole = readFile(path);
  for (std::size_t k = 0; k < whole.size(); k += k < 64 ? 1 : 7) {
    std::string damaged = whole;
    damaged[k] = static_cast<char>(damaged[k] ^ 4);
    writeFile(path, damaged);
    EXPECT_FALSE(readCachedSkin(path, 17)) << k;
    writeFile(path, whole.substr(0, k));
    EXPECT_FALSE(readCachedSkin(path, 17)) << k;
  }
  writeFile(path, whole + " ");
  EXPECT_FALSE(readCachedSkin(path, 17));
  writeFile(path, whole);
  EXPECT_TRUE(readCachedSkin(path, 17));
  EXPECT_FALSE(readCachedSkin(path, 18)) << "made from something else";
}

TEST_F(SkinCache, ASkinIsMadeOnceAndAgainWhereTheFileIsDamaged) {
  int made = 0;
  const auto make = [&] { return ++made, tetrahedronSkin(); };
  cachedSkin(folder + "/new", "body", 17, make);
  cachedSkin(folder + "/new", "body", 17, make);
  EXPECT_EQ(made, 1);
  writeFile(folder + "/new/body.skin", "nonsense");
  EXPECT_EQ(cachedSkin(folder + "/new", "body", 17, make).mesh.positions.size(), 4u);
  EXPECT_EQ(made, 2);
  cachedSkin(folder + "/new", "body", 17, make);
  EXPECT_EQ(made, 2);
}

TEST_F(SkinCache, WithoutAFolderToWriteToTheSkinIsMadeEachTime) {
  int made = 0;
  const auto make = [&] { return ++made, tetrahedronSkin(); };
  cachedSkin("", "body", 17, make);
  cachedSkin("/proc/no/such/folder", "body", 17, make);
  writeFile(folder + "/file", "a file where the folder should be");
  cachedSkin(folder + "/file", "body", 17, make);
  EXPECT_EQ(made, 3);
}

}  // namespace
}  // namespace gelenk
