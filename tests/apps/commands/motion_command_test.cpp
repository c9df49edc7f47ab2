#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/second_clip.h"
#include "kinematics/io/text_file.h"
#include "kinematics/rotation.h"

namespace gelenk {
namespace {

using ::testing::HasSubstr;

/// Runs `gelenk motion ...` in the process, in a folder of its own.
class MotionCommand : public ::testing::Test {
 protected:
  MotionCommand()
      : folder_(::testing::TempDir() + "gelenk_motion_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/") {
    std::filesystem::create_directories(folder_);
  }
  ~MotionCommand() override { std::filesystem::remove_all(folder_); }

  void run(const std::string& command, std::vector<std::string> words) {
    CommandLine line("", "");
    Command program = line.root();
    addCommands(program);
    words.insert(words.begin(), command);
    line.parse(std::move(words));
  }
  std::string path(const std::string& name) const { return folder_ + name; }

  /// Two arms on a root, bent by constant angles (degrees).
  std::string bvh(const std::string& name, double left, double right, int frames, double frameTime = 0.05,
                  const Eigen::Vector3d& arm = {0.5, 0, 0}) const {
    std::string text =
        "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
        "Yrotation\n";
    for (const auto& [joint, x] : {std::pair{"arm_l", arm.x()}, std::pair{"arm_r", -arm.x()}})
      text += std::string("JOINT ") + joint + "\n{\nOFFSET " + exactNumber(x) + " " + exactNumber(arm.y()) +
              " " + exactNumber(arm.z()) +
              "\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd Site\n{\nOFFSET " + exactNumber(x) +
              " 0 0\n}\n}\n";
    text += "}\nMOTION\nFrames: " + std::to_string(frames) + "\nFrame Time: " + exactNumber(frameTime) + "\n";
    for (int f = 0; f < frames; ++f)
      text += "0 1 0 0 0 0 " + exactNumber(left) + " 0 0 " + exactNumber(right) + " 0 0\n";
    writeFile(path(name), text);
    return path(name);
  }
  /// Angle of an arm in a frame of a written file, degrees.
  double angle(const std::string& file, const std::string& joint, int frame) const {
    const BvhMotion motion = readBvh(file);
    return logRotation(
               jointRotation(motion.skeleton, motion.clip.q.col(frame), motion.skeleton.jointIndex(joint)))
               .norm() *
           180.0 / M_PI;
  }

 private:
  std::string folder_;
};

TEST_F(MotionCommand, LaysASecondMotionOverOneLimbWithItsWeight) {
  const std::string base = bvh("base.bvh", 10, 10, 20), wave = bvh("wave.bvh", 50, 50, 7),
                    out = path("out.bvh");
  run("motion", {base, "--layer", wave, "--limbs", "arm_l", "--weight", "0.25", "-o", out});
  EXPECT_NEAR(angle(out, "arm_l", 19), 10 + 0.25 * 40, 1e-9);
  EXPECT_NEAR(angle(out, "arm_r", 19), 10, 1e-9);
  run("motion", {base, "--layer", wave, "--bones", "arm_r", "--weight", "0.5", "--additive", "-o", out});
  EXPECT_NEAR(angle(out, "arm_r", 19), 10 + 0.5 * 50, 1e-9);
  EXPECT_NEAR(angle(out, "arm_l", 19), 10, 1e-9);
}

TEST_F(MotionCommand, FadesIntoAMotionOfAnotherRate) {
  const std::string first = bvh("a.bvh", 10, 10, 20), second = bvh("b.bvh", 50, 50, 39, 0.025),
                    out = path("out.bvh");
  run("motion", {first, "--then", second, "--fade", "0.5", "-o", out});
  EXPECT_EQ(readBvh(out).clip.frameCount(), 20 + 20 - 10);
  EXPECT_NEAR(angle(out, "arm_l", 29), 50, 1e-9);
}

TEST_F(MotionCommand, CarriesAMotionToTheFigureByNames) {
  const std::string out = path("figure.glb");
  const Skeleton own = openModel("figure").skeleton;
  const Frames rest = restFrames(own);
  const Eigen::Vector3d arm =
      rest[own.jointIndex("upperarm_l")].translation() - rest[own.jointIndex("pelvis")].translation();
  run("motion", {bvh("a.bvh", 30, 0, 5, 0.05, arm), "--onto", "figure", "-o", out});
  const Imported figure = importFiles(out);
  ASSERT_TRUE(figure.model.clip);
  const Frames frames = forwardKinematics(figure.model.skeleton, figure.model.clip->q.col(4));
  const Skeleton& skeleton = figure.model.skeleton;
  const auto along = [&](const char* a, const char* b) -> Eigen::Vector3d {
    return (frames[skeleton.jointIndex(b)].translation() - frames[skeleton.jointIndex(a)].translation())
        .normalized();
  };
  // The arm's end is no matched joint: the figure's arm keeps its rest direction, turned by the motion's 30
  // degrees about z.
  const Eigen::Vector3d before =
      (rest[own.jointIndex("lowerarm_l")].translation() - rest[own.jointIndex("upperarm_l")].translation())
          .normalized();
  EXPECT_LE(
      (along("upperarm_l", "lowerarm_l") - expRotation(Eigen::Vector3d(0, 0, M_PI / 6)) * before).norm(),
      1e-6);
}

TEST_F(MotionCommand, RefusesWhatDoesNotFit) {
  const std::string base = bvh("base.bvh", 10, 10, 20), wave = bvh("wave.bvh", 50, 50, 7),
                    out = path("out.bvh");
  EXPECT_THROW(run("motion", {base, "--weight", "0.5", "-o", out}), UsageError);
  EXPECT_THROW(run("motion", {base, "--layer", wave, "--bones", "tail", "-o", out}), std::invalid_argument);
  EXPECT_THROW(run("motion", {base, "--layer", wave, "--weight", "2", "-o", out}), std::invalid_argument);
  EXPECT_THROW(run("motion", {base, "--layer", path("none.bvh"), "-o", out}), std::exception);
  EXPECT_THROW(run("motion", {base, "--onto", "planar", "-o", out}), std::invalid_argument);
  EXPECT_THROW(run("motion", {base, "--low-pass", "2"}), std::invalid_argument);  // it would go nowhere
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(MotionCommand, ConvertWritesTheChainToAnEndAsADhTable) {
  const std::string file = path("arm.urdf"), out = path("arm.dh");
  writeFile(
      file,
      "<robot name=\"two arms\"><link name=\"base\"/><link name=\"a\"/><link name=\"b\"/><link name=\"c\"/>"
      "<joint name=\"first\" type=\"continuous\"><origin xyz=\"0 0 1\"/><parent link=\"base\"/><child "
      "link=\"a\"/><axis xyz=\"0 0 1\"/></joint>"
      "<joint name=\"second\" type=\"prismatic\"><origin xyz=\"1 0 0\"/><parent link=\"a\"/><child "
      "link=\"b\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"2\"/></joint>"
      "<joint name=\"third\" type=\"continuous\"><origin xyz=\"0 1 0\"/><parent link=\"a\"/><child "
      "link=\"c\"/><axis xyz=\"1 0 0\"/></joint></robot>");
  EXPECT_THROW(run("convert", {file, out}), std::invalid_argument);  // two branches
  run("convert", {file, out, "--end", "second"});
  const Imported robot = importFiles(file), table = importFiles(out);
  Eigen::VectorXd q = robot.model.skeleton.rest(), variables(2);
  variables << 0.7, 1.5;
  q[robot.model.skeleton.qIndex(robot.model.skeleton.jointIndex("first"))] = 0.7;
  q[robot.model.skeleton.qIndex(robot.model.skeleton.jointIndex("second"))] = 1.5;
  const auto end =
      forwardKinematics(robot.model.skeleton, q)[robot.model.skeleton.jointIndex("second")].matrix();
  EXPECT_LE((forwardKinematics(table.model.skeleton, variables).back().matrix() - end).norm(), 1e-9);
}

}  // namespace
}  // namespace gelenk
