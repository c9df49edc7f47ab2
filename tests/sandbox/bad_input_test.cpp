// The real program, given what it cannot use: one sentence that says what is wrong, exit status 1, no file
// left behind.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "kinematics/io/text_file.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"

namespace gelenk {
namespace {

using testing::Finished;
using testing::runProgram;

class BadInput : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("gelenk_bad_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    std::filesystem::permissions(folder_, std::filesystem::perms::owner_all);
    std::filesystem::remove_all(folder_);
  }
  std::string file(const std::string& name, const std::string& content) const {
    writeFile(folder_ / name, content);
    return folder_ / name;
  }
  /// Runs `gelenk sandbox ...` and expects a sentence that holds the words.
  void expectRefusal(std::vector<std::string> arguments, const std::string& words,
                     const std::vector<std::string>& environment = {}) {
    arguments.insert(arguments.begin(), {testing::programFile(), "sandbox"});
    const Finished finished = runProgram(arguments, environment);
    EXPECT_EQ(finished.status, 1) << finished.output;
    EXPECT_NE(finished.output.find(words), std::string::npos)
        << "wanted '" << words << "' in: " << finished.output;
    EXPECT_EQ(finished.output.find("what():"), std::string::npos) << finished.output;
  }
  const std::string skeleton_ = "0 0 0 0 -1\n1 0 1 0 0\n";

  std::filesystem::path folder_;
};

const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

TEST_F(BadInput, AMissingModelNamesTheFile) {
  expectRefusal({folder_ / "none.obj", "--offscreen"}, "none.obj");
  expectRefusal({"nosuchmodel", "--offscreen"}, "no model is called 'nosuchmodel'; there are: figure");
}

TEST_F(BadInput, WithStrictEveryNoteIsAnError) {
  const std::string odd = testing::inputFolder() + "/frames_less.bvh", picture = folder_ / "strict.png";
  expectRefusal({odd, "--offscreen", "--strict", "--screenshot", picture}, "(a note, and --strict)");
  const Finished render =
      runProgram({testing::programFile(), "render", odd, "--output", picture, "--strict"});
  EXPECT_EQ(render.status, 1) << render.output;
  EXPECT_NE(render.output.find("(a note, and --strict)"), std::string::npos) << render.output;
  EXPECT_FALSE(std::filesystem::exists(picture));
  const Finished told = runProgram({testing::programFile(), "sandbox", odd, "--offscreen"}),
                 quiet = runProgram({testing::programFile(), "sandbox", odd, "--offscreen", "--quiet"});
  EXPECT_NE(told.output.find("note: 'Frames:' says 1"), std::string::npos) << told.output;
  EXPECT_EQ(quiet.output, "");
}

TEST_F(BadInput, BadBodies) {
  const std::string bones = file("two.skel", skeleton_);
  expectRefusal({file("empty.obj", ""), "--skeleton", bones, "--offscreen"}, "empty.obj");
  expectRefusal(
      {file("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), "--skeleton", bones, "--offscreen"},
      "range.obj:4");
  expectRefusal(
      {file("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"), "--skeleton", bones, "--offscreen"},
      "nan.obj:2");
}

TEST_F(BadInput, BadWeightsAndSkeletons) {
  const std::string body = file("body.obj", tetrahedron);
  const std::string bones = file("two.skel", skeleton_);
  expectRefusal({body, "--weights", bones, "--offscreen"}, "--weights needs --skeleton");
  expectRefusal({body, "--skeleton", bones, "--weights", file("short.attachment", "1\n"), "--offscreen"},
                "short.attachment");
  expectRefusal({body, "--skeleton", file("later.skel", "0 0 0 0 1\n1 0 1 0 -1\n"), "--offscreen"},
                "later.skel:1");
  expectRefusal({body, "--skeleton", file("roots.skel", "0 0 0 0 -1\n1 0 1 0 -1\n"), "--offscreen"},
                "roots.skel:2");
}

TEST_F(BadInput, BadScenesAndReplays) {
  expectRefusal({file("scene.json", "{"), "--offscreen"}, "scene.json:1: expected JSON");
  expectRefusal({file("list.json", "[]"), "--offscreen"}, "list.json");
  expectRefusal({"planar", "--replay", file("replay.txt", "0 jump\n"), "--offscreen"},
                "replay.txt:1: expected a command");
  expectRefusal({"planar", "--replay", file("tab.txt", "0 tab Nowhere\n1 move 1 1\n"), "--offscreen"},
                "there are: Solve");
  expectRefusal({"planar", "--replay", file("do.txt", "0 do Nowhere play\n"), "--offscreen"},
                "no panel is called 'Nowhere'");
  expectRefusal({"planar", "--replay", file("goal.txt", "0 grab tail\n"), "--offscreen"},
                "no goal or joint is called 'tail'");
}

TEST_F(BadInput, BadValues) {
  expectRefusal({"planar", "--solver", "magic", "--offscreen"}, "magic");
  expectRefusal({"planar", "--size", "big", "--offscreen"}, "expected WIDTHxHEIGHT");
}

TEST_F(BadInput, AFolderThatCannotBeWrittenIsToldBeforeTheWork) {
  expectRefusal({"planar", "--offscreen", "--status", folder_ / "none" / "status.json"}, "cannot write");
  if (geteuid() == 0) return;  // root may write everywhere
  std::filesystem::permissions(folder_,
                               std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  expectRefusal({"planar", "--offscreen", "--screenshot", folder_ / "picture.png"}, "cannot write");
}

TEST_F(BadInput, WithoutADisplayTheWayOutIsTold) {
  expectRefusal({"planar"}, "--offscreen", {"DISPLAY", "WAYLAND_DISPLAY"});
  expectRefusal({"planar"}, "--offscreen", {"DISPLAY=:4242", "WAYLAND_DISPLAY"});
}

TEST_F(BadInput, AnOpenGlOlderThan33IsTold) {
  expectRefusal({"planar", "--offscreen"}, "3.3",
                {"MESA_GL_VERSION_OVERRIDE=3.1", "LIBGL_ALWAYS_SOFTWARE=1"});
}

/// They were dropped where the pipe ended before the first frame.
TEST_F(BadInput, RequestsOfAPipeThatHasEndedAreAnswered) {
  const std::string requests = file("requests", R"({"gelenk": 1, "id": 1, "do": "get"}
{"gelenk": 1, "id": 2, "do": "dance"}
)");
  const Finished finished =
      runProgram({"sh", "-c", testing::programFile() + " sandbox planar --remote --offscreen < " + requests});
  EXPECT_EQ(finished.status, 0);
  EXPECT_NE(finished.output.find(R"("id":1,)"), std::string::npos) << finished.output;
  EXPECT_NE(finished.output.find("no message is called 'dance'"), std::string::npos) << finished.output;
  EXPECT_NE(finished.output.find(R"("event":"closed")"), std::string::npos) << finished.output;
}

}  // namespace
}  // namespace gelenk
