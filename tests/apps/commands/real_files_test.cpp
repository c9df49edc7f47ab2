#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/notes.h"
#include "apps/document/session.h"
#include "kinematics/io/text_file.h"
#include "tests/places.h"

// What people bring, opened as the program opens it: choices, notes and refusals.

namespace gelenk {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

const std::string inputs = testing::inputFolder() + "/";

std::optional<Note> noteOf(const std::vector<Note>& notes, const std::string& kind) {
  for (const Note& note : notes)
    if (note.kind == kind) return note;
  return {};
}

std::string refusal(const std::function<void()>& act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

class RealFiles : public ::testing::Test {
 protected:
  RealFiles()
      : folder_(::testing::TempDir() + "gelenk_files_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/") {
    fs::create_directories(folder_);
  }
  ~RealFiles() override { fs::remove_all(folder_); }
  std::string path(const std::string& name) const { return folder_ + name; }

  /// As on the command line, notes and all.
  void run(std::vector<std::string> words) {
    CommandLine line("", "");
    Command program = line.root();
    addNoteOptions(program);
    addCommands(program);
    line.parse(std::move(words));
  }

 private:
  std::string folder_;
};

TEST_F(RealFiles, OneOfSeveralMotionsIsChosenByItsNameAndAllAreKeptInGltf) {
  const std::string file = inputs + "two_clips.gltf";
  const Imported first = importFiles(file), wave = importFiles(file, {.clip = "wave"});
  EXPECT_EQ(first.model.clipName, "rest");
  EXPECT_EQ(wave.model.clipName, "wave");
  EXPECT_EQ(first.model.clipNames, (std::vector<std::string>{"rest", "wave"}));
  EXPECT_GT((first.model.clip->q - wave.model.clip->q).norm(), 0.1);
  ASSERT_TRUE(noteOf(first.model.notes, "several-motions"));
  EXPECT_FALSE(noteOf(wave.model.notes, "several-motions"));
  EXPECT_THAT(refusal([&] { importFiles(file, {.clip = "run"}); }), HasSubstr("there are: rest, wave"));
  EXPECT_THAT(refusal([&] { importFiles(inputs + "forearm.bvh", {.clip = "run"}); }), HasSubstr("--clip"));
  run({"convert", file, path("both.glb")});
  EXPECT_EQ(importFiles(path("both.glb")).model.clipNames, (std::vector<std::string>{"rest", "wave"}));
  run({"motion", file, "--clip", "wave", "-o", path("wave.glb")});
  EXPECT_EQ(importFiles(path("wave.glb")).model.clipNames, std::vector<std::string>{"wave"});
}

TEST_F(RealFiles, StepsAndSplinesKeepTheirValuesWhenTheMotionIsResampled) {
  const auto tip = [&](const std::string& file, int frame) -> Eigen::Vector3d {
    const Imported written = importFiles(file);
    return forwardKinematics(written.model.skeleton, written.model.clip->q.col(frame)).back().translation();
  };
  run({"motion", inputs + "step.gltf", "--fps", "20", "-o", path("step.glb")});
  EXPECT_LT((tip(path("step.glb"), 5) - Eigen::Vector3d(0, 1, 0)).norm(), 1e-6);
  run({"motion", inputs + "cubic.gltf", "--fps", "20", "-o", path("cubic.glb")});
  EXPECT_LT((tip(path("cubic.glb"), 10) - Eigen::Vector3d(-0.998607, -0.052773, 0)).norm(), 2e-6);
}

TEST_F(RealFiles, ABodyOfTwentyFourMetresIsToldWithTheUnitThatMakesAPersonOfIt) {
  const auto noteFor = [&](double unit) {
    return noteOf(importFiles(inputs + "forearm.bvh", {}, {.metresPerUnit = unit}).model.notes,
                  "unit-suspect");
  };
  EXPECT_FALSE(noteFor(1.0));
  for (const auto& [unit, guess] : {std::pair{10.0, "with 'dm' it"},
                                    {100.0, "with 'cm' it"},
                                    {1000.0, "with 'mm' it"},
                                    {1.0 / 0.0254, "with 'in' it"}}) {
    const auto note = noteFor(unit);
    ASSERT_TRUE(note) << unit;
    EXPECT_THAT(note->text, HasSubstr(guess)) << unit;
  }
  EXPECT_TRUE(noteFor(0.01));
}

TEST_F(RealFiles, AnUnusualScaleOfACarriedPathNeedsToBeSaid) {
  const std::vector<std::string> words{"motion", inputs + "lying_zero_pose.bvh", "--unit", "cm",
                                       "--onto", inputs + "apose.bvh",           "-o",     path("out.bvh")};
  EXPECT_THAT(refusal([&] { run(words); }), HasSubstr("--scale"));
  EXPECT_FALSE(fs::exists(path("out.bvh")));
  std::vector<std::string> given = words;
  given.insert(given.end(), {"--scale", "100"});
  run(given);
  EXPECT_TRUE(fs::exists(path("out.bvh")));
}

TEST_F(RealFiles, StrictMakesEveryNoteAnErrorBeforeAnythingIsWrittenButLetsFactsPass) {
  EXPECT_THAT(refusal([&] {
                run({"--strict", "convert", inputs + "frames_less.bvh", path("a.bvh")});
              }),
              HasSubstr("'Frames:' says 1"));
  EXPECT_FALSE(fs::exists(path("a.bvh")));
  run({"--strict", "convert", inputs + "tube.obj", path("tube.glb"), "--skeleton", inputs + "tube.skel"});
  EXPECT_TRUE(fs::exists(path("tube.glb")));
  EXPECT_THROW(run({"--strict", "--quiet", "info", inputs + "tube.obj"}), UsageError);
  run({"--quiet", "convert", inputs + "frames_less.bvh", path("a.bvh")});
  EXPECT_TRUE(fs::exists(path("a.bvh")));
}

/// frames_less.bvh has a note that is no mere fact; so has a polygon that crosses itself. The sandbox and
/// render have their test in tests/sandbox/bad_input_test.cpp.
TEST_F(RealFiles, EveryCommandThatOpensAFileKnowsStrict) {
  writeFile(path("crossing.obj"), "v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n");
  writeFile(path("poses.csv"), "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,1,0,0,0\n");
  writeFile(path("poses.txt"), "0 0 0 1 0 0 0\n1 0 0 1 0 0 0\n");
  const std::string file = inputs + "frames_less.bvh";
  const std::vector<std::vector<std::string>> commands{
      {"info", file},
      {"info", file, "--json"},
      {"fk", file},
      {"fk", file, "--json"},
      {"fk", file, "--csv"},
      {"solve", "--model", file, "--target", "0", "0", "0"},
      {"solve", "--model", file, "--targets", path("poses.csv")},
      {"solutions", "--model", file, "--target", "0", "0", "0"},
      {"solutions", "--model", file, "--target", "0", "0", "0", "--json"},
      {"path", "--model", file, "--path", path("poses.txt"), "-o", path("path.csv")},
      {"compare", "--model", file, "--out", path("compare")},
      {"muscles", file, "--out", path("muscles")},
      {"skins", file, "--out", path("skins")},
      {"rig", path("crossing.obj"), "--out", path("rig")},
      {"rig", path("crossing.obj"), "--out", path("rig"), "--json"},
      {"convert", file, path("a.bvh")},
      {"motion", file, "-o", path("a.bvh")},
      {"motion", inputs + "apose.bvh", "--then", file, "-o", path("a.bvh")},
      {"motion", inputs + "forearm.bvh", "--onto", file, "-o", path("a.bvh")}};
  for (std::vector<std::string> words : commands) {
    std::string line;
    for (const std::string& word : words) line += word + " ";
    words.insert(words.begin(), "--strict");
    EXPECT_THAT(refusal([&] { run(words); }), HasSubstr("(a note, and --strict)")) << line;
  }
  for (const char* made : {"path.csv", "compare", "muscles", "skins", "rig", "a.bvh"})
    EXPECT_FALSE(fs::exists(path(made))) << made;
}

TEST_F(RealFiles, EveryPoseKeepsWhatOneJointMimicsOfAnother) {
  Session session(openModelFile(inputs + "mimic_pair.urdf"));
  session.setPose(Eigen::Vector2d(0.5, 0.0));
  EXPECT_EQ(session.q()[1], 0.5);
  session.setPose(Eigen::Vector2d(-0.25, 0.7));
  EXPECT_EQ(session.q()[1], -0.25);
}

/// Whatever the window opens: a built-in model, a scene, every kind of file, with what belongs to it.
TEST_F(RealFiles, InfoFkAndSolveTakeEverythingThatTheSandboxOpens) {
  const std::string assets = testing::assetFolder() + "/";
  run({"convert", inputs + "two_clips.gltf", path("clips.glb")});
  run({"convert", inputs + "forearm.bvh", path("forearm.asf")});
  run({"convert", inputs + "forearm.bvh", path("forearm.amc")});
  struct Openable {
    std::vector<std::string> words;  ///< the model and its options
    std::string joint;
  };
  const std::vector<Openable> all{{{"figure"}, "hand_l"},
                                  {{"planar"}, ""},
                                  {{"puma560"}, ""},
                                  {{"balls:1,0.5"}, ""},
                                  {{"lecture:two-link"}, ""},
                                  {{"lecture:rotations"}, ""},
                                  {{"lecture:leg"}, "hand_l"},
                                  {{assets + "scenes/reach.json"}, "hand_l"},
                                  {{inputs + "tube.obj", "--skeleton", inputs + "tube.skel"}, ""},
                                  {{inputs + "tube.skel"}, ""},
                                  {{inputs + "forearm.bvh"}, "LeftHand"},
                                  {{path("clips.glb"), "--clip", "wave"}, "tip"},
                                  {{inputs + "turned_root.gltf"}, ""},
                                  {{path("forearm.asf")}, "LeftHand"},
                                  {{path("forearm.amc"), "--asf", path("forearm.asf")}, "LeftHand"},
                                  {{assets + "tutorial_figure.figure"}, "joint5"},
                                  {{assets + "tutorial_stride.pose"}, "joint5"},
                                  {{inputs + "two_arms.urdf"}, "ltip"},
                                  {{inputs + "mimic_pair.urdf"}, ""},
                                  {{inputs + "five_dof.dh"}, ""}};
  for (const Openable& one : all) {
    SCOPED_TRACE(one.words[0]);
    std::vector<std::string> info = one.words, fk = one.words, solve = one.words;
    info.insert(info.begin(), "info");
    fk.insert(fk.begin(), "fk");
    solve.insert(solve.begin(), {"solve", "--model"});
    for (const char* word : {"--target", "0.1", "0.2", "0.3", "--max-iterations", "3", "--restarts", "0"})
      solve.emplace_back(word);
    if (!one.joint.empty()) solve.insert(solve.end(), {"--joint", one.joint});
    EXPECT_NO_THROW(run(info));
    EXPECT_NO_THROW(run(fk));
    try {
      run(solve);
    } catch (const ExitStatus& status) {
      EXPECT_EQ(status.status, 2);  // asked, but not reached
    }
  }
}

/// BVH says nothing of the axis against gravity.
TEST_F(RealFiles, ABodyThatStandsAlongZIsShownStandingAndTold) {
  const Imported lying = importFiles(inputs + "standing_z.bvh"),
                 standing = importFiles(inputs + "forearm.bvh");
  EXPECT_EQ(lying.model.up, Eigen::Vector3d::UnitZ());
  const auto note = noteOf(lying.model.notes, "up-axis");
  ASSERT_TRUE(note);
  EXPECT_TRUE(note->fact);
  EXPECT_THAT(note->line(), HasSubstr("--up"));
  EXPECT_THAT(note->lineWithoutRemedy(), Not(HasSubstr("--")));  // the window has no command line
  EXPECT_EQ(standing.model.up, Eigen::Vector3d::UnitY());
  EXPECT_FALSE(noteOf(standing.model.notes, "up-axis"));
  EXPECT_EQ(importFiles(inputs + "standing_z.bvh", {.up = "y"}).model.up, Eigen::Vector3d::UnitY());
  EXPECT_THAT(refusal([&] { importFiles(inputs + "two_arms.urdf", {.up = "y"}); }),
              HasSubstr("says which axis"));
  EXPECT_EQ(importFiles(inputs + "standing_z.bvh", {}, {.zUp = true}).model.up, Eigen::Vector3d::UnitY());
}

}  // namespace
}  // namespace gelenk
