#include "apps/render/render_command.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <sstream>

#include "apps/commands/command_line.h"
#include "apps/commands/image.h"
#include "apps/document/model.h"
#include "apps/render/lettering.h"
#include "apps/render/video.h"
#include "kinematics/configuration.h"
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
    CommandLine line("", "");
    Command program = line.root();
    addRenderCommand(program);
    std::vector<std::string> words{"render"};
    std::istringstream rest(arguments);
    for (std::string word; rest >> std::quoted(word, '\'');) words.push_back(word);
    line.parse(std::move(words));
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
  EXPECT_NE(complaintOf("planar" + out + " --q 1 2").find("configuration values, 2 are given"),
            std::string::npos);
  EXPECT_NE(complaintOf("planar -o " + path("a.jpg")).find("ending in .png, .ppm, .mp4 or .gif"),
            std::string::npos);
  EXPECT_NE(complaintOf("planar" + out + " --size 1000000x10").find("is not possible"), std::string::npos);
  EXPECT_NE(complaintOf("planar" + out + " --frame 3").find("has no motion, of which frame 3 was asked for"),
            std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RenderCommand, TurnIsTheAngleInTheConfiguration) {
  const Skeleton skeleton = openModel("figure").skeleton;
  const auto written = [&](const std::string& options) {
    run("figure --size 96x60 --smoothing 1 -o " + path("a.png") + " " + options);
    return readFile(path("a.png"));
  };
  const auto configuration = [](const Eigen::VectorXd& q) {
    std::string text = "--q";
    for (const double x : q) text += fmt::format(" {:.17g}", x);
    return text;
  };
  Eigen::VectorXd hinge = skeleton.rest();
  hinge[skeleton.qIndex(skeleton.jointIndex("lowerarm_l"))] = 60.0 * M_PI / 180.0;
  const std::string turned = written("--turn lowerarm_l=60");
  EXPECT_EQ(turned, written(configuration(hinge)));
  EXPECT_NE(turned, written(""));

  const int shoulder = skeleton.jointIndex("upperarm_l");
  ASSERT_TRUE(skeleton.joint(shoulder).ball);
  Eigen::VectorXd ball = skeleton.rest();
  setBallRotation(skeleton, ball, shoulder,
                  ballRotation(skeleton, ball, shoulder) *
                      Eigen::AngleAxisd(-40.0 * M_PI / 180.0, Eigen::Vector3d::UnitY()));
  EXPECT_EQ(written("--turn upperarm_l.y=-40"), written(configuration(ball)));
}

TEST_F(RenderCommand, LayersChangeABentArmAndNothingElse) {
  const auto written = [&](const std::string& options) {
    run("figure --size 160x120 --smoothing 1 --focus lowerarm_l -o " + path("a.png") + " " + options);
    return readFile(path("a.png"));
  };
  const std::string bent = "--turn lowerarm_l=120 ";
  const std::string plain = written(bent), volumes = written(bent + "--layers ffd"),
                    muscle = written(bent + "--layers muscle");
  EXPECT_EQ(plain, written(bent + "--layers none"));
  EXPECT_NE(plain, volumes);
  EXPECT_NE(volumes, muscle);
  EXPECT_NE(muscle, written(bent + "--layers muscle --lattice"));
}

TEST_F(RenderCommand, WrongTurnsAndLayersAreNamed) {
  const std::string out = " --size 32x20 -o " + path("a.png");
  EXPECT_NE(complaintOf("figure --turn lowerarm_l" + out)
                .find("expected JOINT=DEGREES such as lowerarm_l=60, found 'lowerarm_l'"),
            std::string::npos);
  EXPECT_NE(complaintOf("figure --turn lowerarm_l=much" + out).find("found 'lowerarm_l=much'"),
            std::string::npos);
  EXPECT_NE(complaintOf("figure --turn tail=10" + out).find("tail"), std::string::npos);
  EXPECT_NE(complaintOf("planar --layers ffd" + out).find("no limb of a known name"), std::string::npos);
  EXPECT_NE(complaintOf("figure --lattice" + out).find("add --layers"), std::string::npos);
  EXPECT_FALSE(complaintOf("figure --layers fat" + out).empty());
  EXPECT_NE(complaintOf("figure --muscle-sheet left,arm" + out).find("left"), std::string::npos);
  EXPECT_NE(complaintOf("figure --muscle-sheet lowerarm_l,hand_l" + out).find("bend axis must be given"),
            std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(RenderCommand, AMuscleSheetHasThreeRowsOfThreeDifferentPictures) {
  run("figure --muscle-sheet 'left leg' --scale 0.15 --smoothing 1 -o " + path("sheet.png"));
  EXPECT_EQ(pngSize(path("sheet.png")), std::pair(13 + 3 * 73, 11 + 3 * 85 + 7));
}

TEST(Lettering, LettersStandOnTheirBaselineAndStayInThePicture) {
  Image page{.width = 120, .height = 40, .pixels = std::vector<std::uint8_t>(4 * 120 * 40, 255)};
  const Lettering type(20);
  EXPECT_GT(type.width("60°"), type.width("0°"));
  EXPECT_NEAR(type.width("60°"), type.width("6") + type.width("0") + type.width("°"), 2);
  type.write(page, 10, 30, "H", {0, 0, 0, 1});
  const auto darkRow = [&](int y) {
    int dark = 0;
    for (int x = 0; x < page.width; ++x) dark += page.at(x, y)[0] < 128;
    return dark;
  };
  EXPECT_GT(darkRow(29), 0);                          // the feet of the H
  EXPECT_EQ(darkRow(31), 0);                          // nothing below the baseline
  EXPECT_EQ(darkRow(8), 0);                           // capitals are lower than the type's size
  type.write(page, 110, 5, "cut off", {0, 0, 0, 1});  // beyond two edges
  type.write(page, -10, 45, "cut off", {0, 0, 0, 1});
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
