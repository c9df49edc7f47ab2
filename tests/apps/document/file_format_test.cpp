#include "apps/document/file_format.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <sstream>

#include "kinematics/io/text_file.h"
#include "skinning/io/gltf.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using ::testing::HasSubstr;

#define GELENK_KIND(Kind, format) FileKind::Kind,
constexpr FileKind kinds[] = {GELENK_FILE_FORMATS(GELENK_KIND)};
#undef GELENK_KIND

std::vector<std::string> endingsOf(const FileFormat& format) {
  std::istringstream words{std::string(format.endings)};
  return {std::istream_iterator<std::string>(words), {}};
}

TEST(FileFormats, AnEndingBelongsToOneFormatAndTellsIt) {
  std::map<std::string, FileKind> owner;
  for (const FileKind kind : kinds) {
    const FileFormat& format = fileFormat(kind);
    EXPECT_FALSE(format.description.empty());
    EXPECT_NE(format.read, nullptr) << format.description;
    ASSERT_FALSE(endingsOf(format).empty()) << format.description;
    for (const std::string& ending : endingsOf(format)) {
      EXPECT_TRUE(owner.emplace(ending, kind).second) << ending;
      EXPECT_EQ(fileKind("nowhere/x.y" + ending), kind) << ending;
      EXPECT_THAT(knownExtensions(), HasSubstr(ending));
    }
  }
  EXPECT_EQ(fileKind("x.nothing"), std::nullopt);
}

TEST(FileFormats, TheDocumentNamesEveryEnding) {
  const std::string page = readFile(testing::assetFolder() + "/../docs/formats/README.md");
  for (const FileKind kind : kinds)
    for (const std::string& ending : endingsOf(fileFormat(kind)))
      EXPECT_THAT(page, HasSubstr("`" + ending + "`"));
}

TEST(FileFormats, OneFrameOfAMotionIsOneFrameInEveryFormatOfMotions) {
  Imported walk = importFiles(testing::inputFolder() + "/apose.bvh");
  ASSERT_TRUE(walk.model.clip);
  MotionClip& clip = *walk.model.clip;
  clip.q = clip.q.col(0).replicate(1, 3).eval();
  clip.q.row(0) << 0.0, 0.25, 0.5;  // the root's path
  for (const char* ending : {".bvh", ".glb"}) {
    const auto path =
        (std::filesystem::temp_directory_path() / (std::string("gelenk_one_frame") + ending)).string();
    exportFile(path, walk, {.frame = 2});
    const Imported back = importFiles(path);
    std::filesystem::remove(path);
    ASSERT_TRUE(back.model.clip) << ending;
    ASSERT_EQ(back.model.clip->frameCount(), 1) << ending;
    const auto rootOf = [](const Imported& model) {
      return Eigen::Vector3d(
          forwardKinematics(model.model.skeleton, Eigen::VectorXd(model.model.clip->q.col(0)))[0]
              .translation());
    };
    const Eigen::Vector3d wanted =
        forwardKinematics(walk.model.skeleton, Eigen::VectorXd(clip.q.col(1)))[0].translation();
    EXPECT_LT((rootOf(back) - wanted).norm(), 1e-6) << ending;
  }
  EXPECT_THROW(exportFile("x.glb", walk, {.frame = 4}), std::invalid_argument);
  EXPECT_THROW(exportMotion("x.obj", walk.model.skeleton, nullptr, "walk", clip), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
