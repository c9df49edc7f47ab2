#include "skinning/io/prepared_cache.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/io/text_file.h"
#include "skinning/rigging/weight_paint.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

TEST(PreparedCache, WhatIsKeptIsWhatWasMadeAndDamageIsMadeAnew) {
  const testing::Arm arm = testing::arm(3, 0.3, 0.05, 12, 12);
  const std::string folder = ::testing::TempDir() + "prepared_cache_test";
  std::filesystem::remove_all(folder);
  const SkinChoice choice = parseSkinChoice("cor+smooth");
  const Frames rest = restFrames(arm.skeleton);
  const auto made = [&](const std::string& where) {
    return cachedPreparedSkin(where, "an arm/3", arm.skin, choice, arm.skeleton, rest);
  };
  const PreparedSkin fresh = made(""), first = made(folder), kept = made(folder);
  ASSERT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  const std::string path = std::filesystem::directory_iterator(folder)->path().string();
  const auto expectSame = [&](const PreparedSkin& other) {
    EXPECT_EQ(other.method, fresh.method);
    EXPECT_EQ(other.centres, fresh.centres);
    EXPECT_EQ(other.centreSlopes, fresh.centreSlopes);
    EXPECT_EQ(other.slopes, fresh.slopes);
    EXPECT_EQ(other.skin.influences, fresh.skin.influences);
  };
  expectSame(first);
  expectSame(kept);
  const std::string file = readFile(path);
  for (const std::string& damaged : {file.substr(0, file.size() / 2), std::string("x"), file + "x",
                                     file.substr(0, 100) + '\x7f' + file.substr(101)}) {
    writeFile(path, damaged);
    expectSame(made(folder));
    EXPECT_EQ(readFile(path), file);
  }
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace gelenk
