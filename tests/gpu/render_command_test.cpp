#include "apps/render/render_command.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <filesystem>

#include "apps/image.h"
#include "apps/render/video.h"
#include "kinematics/io/text_file.h"

namespace gelenk {
namespace {

namespace fs = std::filesystem;

/// A folder of its own, removed afterwards.
class RenderCommand : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "gelenk-render-XXXXXX").string();
    ASSERT_NE(mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  void run(const std::string& arguments) const {
    CLI::App app;
    addRenderCommand(app);
    app.parse("render " + arguments);
  }
  std::string complaintOf(const std::string& arguments) const {
    try {
      run(arguments);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  fs::path folder_;
};

/// Width and height from the header of a PNG.
std::pair<int, int> pngSize(const std::string& path) {
  const std::string bytes = readFile(path);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  const auto number = [&bytes](int at) {
    int value = 0;
    for (int i = 0; i < 4; ++i) value = 256 * value + static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  return {number(16), number(20)};
}

TEST_F(RenderCommand, WritesAPictureOfTheSizeAsked) {
  run("planar -o " + path("a.png") + " --size 160x100 --scale 2 --theme dark --bones --joint-frames");
  EXPECT_EQ(pngSize(path("a.png")), std::pair(320, 200));
}

TEST_F(RenderCommand, ErrorsAreSentences) {
  const std::string out = " -o " + path("a.png");
  EXPECT_NE(complaintOf("no-such-model" + out).find("no model is called 'no-such-model'"), std::string::npos);
  EXPECT_NE(complaintOf("planar" + out + " --size 10").find("expected WIDTHxHEIGHT"), std::string::npos);
  EXPECT_NE(complaintOf("planar" + out + " --q 1 2").find("configuration values, 2 are given"), std::string::npos);
  EXPECT_NE(complaintOf("planar -o " + path("a.jpg")).find("ending in .png or .mp4"), std::string::npos);
  EXPECT_NE(complaintOf("planar" + out + " --size 1000000x10").find("is not possible"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RenderCommand, AFolderThatCannotBeWrittenIsASentenceAndLeavesNothing) {
  const std::string complaint = complaintOf("planar --size 32x20 -o /proc/gelenk/a.png");
  EXPECT_NE(complaint.find("cannot write /proc/gelenk/a.png"), std::string::npos) << complaint;
  EXPECT_NE(complaintOf("planar --size 32x20 -o /proc/gelenk/a.mp4").find("cannot write"), std::string::npos);
}

TEST_F(RenderCommand, WritesATurntable) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  run("planar -o " + path("turn.mp4") + " --size 64x40 --frames 3");
  EXPECT_EQ(readFile(path("turn.mp4")).substr(4, 4), "ftyp");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1);
}

TEST_F(RenderCommand, WithoutFfmpegTheWayOutIsTold) {
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder_.c_str(), 1);
  std::string complaint;
  try {
    VideoWriter video(path("a.mp4"), 64, 40, 30);
  } catch (const std::runtime_error& error) {
    complaint = error.what();
  }
  setenv("PATH", before.c_str(), 1);
  EXPECT_NE(complaint.find("apt install ffmpeg"), std::string::npos) << complaint;
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RenderCommand, AnUnfinishedVideoLeavesNoFile) {
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  { VideoWriter video(path("a.mp4"), 64, 40, 30); }
  EXPECT_TRUE(fs::is_empty(folder_));
}

}  // namespace
}  // namespace gelenk
