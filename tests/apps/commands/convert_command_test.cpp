// `gelenk convert` as a person types it.
#include <gtest/gtest.h>

#include <filesystem>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/document/model_files.h"
#include "apps/document/scene_file.h"
#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "skinning/io/obj.h"
#include "skinning/rigging/weight_paint.h"

namespace gelenk {
namespace {

class ConvertCommand : public ::testing::Test {
 protected:
  ConvertCommand()
      : folder_(::testing::TempDir() + "gelenk_convert_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/") {
    std::filesystem::create_directories(folder_);
  }
  ~ConvertCommand() override { std::filesystem::remove_all(folder_); }

  void convert(std::vector<std::string> words) const {
    CommandLine line("", "");
    Command program = line.root();
    addCommands(program);
    words.insert(words.begin(), "convert");
    line.parse(std::move(words));
  }
  std::string path(const std::string& name) const { return folder_ + name; }
  std::string file(const std::string& name, const std::string& content) const {
    writeFile(path(name), content);
    return path(name);
  }

  const std::string tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

 private:
  std::string folder_;
};

TEST_F(ConvertCommand, AMeshAloneChangesItsUnitAndItsAxes) {
  const std::string cm = file("cm.obj", tetrahedron), out = path("out.obj");
  convert({cm, out, "--unit-in", "cm"});
  EXPECT_LE((readObj(out).positions[3] - Eigen::Vector3d(0, 0, 0.03)).norm(), 1e-16);
  convert({cm, out, "--unit-out", "mm"});
  EXPECT_LE((readObj(out).positions[2] - Eigen::Vector3d(0, 2000, 0)).norm(), 1e-9);
  convert({cm, out, "--up-in",
           "z"});  // what pointed up (z) points up (y); what pointed along y now comes towards -z
  EXPECT_LE((readObj(out).positions[3] - Eigen::Vector3d(0, 3, 0)).norm(), 1e-15);
  EXPECT_LE((readObj(out).positions[2] - Eigen::Vector3d(0, 0, -2)).norm(), 1e-15);
  convert({out, out, "--up-out", "z"});
  for (int v = 0; v < 4; ++v) EXPECT_LE((readObj(out).positions[v] - readObj(cm).positions[v]).norm(), 1e-15);
  EXPECT_EQ(readObj(out).triangles.size(), 4u);
}

TEST_F(ConvertCommand, AFrameOfWhatHasNoMotionIsRefusedInThoseWords) {
  const auto complaint = [&](std::vector<std::string> words) -> std::string {
    try {
      convert(std::move(words));
      return "none";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  };
  const std::string out = path("x.obj");
  EXPECT_EQ(complaint({"figure", out, "--frame", "1"}),
            "'figure' has no motion, of which frame 1 was asked for");
  EXPECT_EQ(complaint({"figure", path("x.bvh"), "--frame", "2"}),
            "'figure' has no motion, of which frame 2 was asked for");
  const std::string mesh = file("alone.obj", tetrahedron);
  EXPECT_NE(complaint({mesh, out, "--frame", "1"}).find("mesh alone and has no motion"), std::string::npos);
  const std::string bvh =
      file("two.bvh",
           "HIERARCHY\nROOT a\n{\nOFFSET 0 0 0\nCHANNELS 1 Zrotation\nEnd Site\n{\nOFFSET 0 1 0\n}\n}\n"
           "MOTION\nFrames: 2\nFrame Time: 0.1\n0\n1\n");
  EXPECT_EQ(complaint({bvh, path("x.skel"), "--frame", "3"}),
            "the motion has frames 1 to 2, 3 was asked for");
  EXPECT_EQ(complaint({bvh, path("x.bvh"), "--frame", "2"}), "none");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(ConvertCommand, TheUnitOfABodyHoldsForItsMeshAndForASkeletonWithoutOne) {
  const std::string obj = file("b.obj", tetrahedron),
                    skeleton = file("s.skel", "a 0 0 0 -1\nb 0 1 0 a\nc 0 2 0 b\n"), out = path("b.glb");
  convert({obj, out, "--skeleton", skeleton, "--weights", file("w.attachment", "1 0\n0.5 0.5\n0 1\n1 0\n"),
           "--unit-in", "cm"});
  const Imported body = importFiles(out);
  EXPECT_LE((restFrames(body.model.skeleton)[2].translation() - Eigen::Vector3d(0, 0.02, 0)).norm(), 1e-7);
  EXPECT_LE((body.model.skin->mesh.positions[3] - Eigen::Vector3d(0, 0, 0.03)).norm(),
            1e-8);  // 32-bit floats
  EXPECT_THROW(
      convert({file("arm.dh", "dh standard\nrevolute 1 0 0 0\n"), path("arm.bvh"), "--unit-in", "cm"}),
      std::invalid_argument);
}

TEST_F(ConvertCommand, JointsInTheirParentsPlacesAreNoBones) {
  const std::string bvh = file("hips.bvh",
                               "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition "
                               "Zposition Zrotation Xrotation Yrotation\n"
                               "JOINT turn\n{\nOFFSET 0 0 0\nCHANNELS 3 Zrotation Xrotation Yrotation\n"
                               "JOINT leg\n{\nOFFSET 0 -0.5 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd "
                               "Site\n{\nOFFSET 0 -0.5 0\n}\n}\n}\n}\n"
                               "MOTION\nFrames: 1\nFrame Time: 0.1\n0 1 0 0 0 0 0 0 0 0 0 0\n");
  for (const char* name : {"hips.skel", "hips.figure"}) {
    convert({bvh, path(name)});
    const Skeleton bones = importFiles(path(name)).model.skeleton;  // refuses bones of no length
    ASSERT_EQ(bones.jointCount(), 3) << name;
    EXPECT_EQ(bones.parent(1), 0);
    EXPECT_LE((restFrames(bones)[2].translation() -
               restFrames(importFiles(bvh).model.skeleton).back().translation())
                  .norm(),
              1e-12)
        << name;
  }
  EXPECT_THROW(convert({bvh, path("hips.pose")}),
               std::invalid_argument);  // the two joints' angles are not one's
}

TEST_F(ConvertCommand, ATutorialFigureKeepsItsNumbersAndSoFitsItsPose) {
  const std::string figure = file(
      "f.figure",
      "NumJoints: 3\nNonAnimatedJointPositions:\n0, 2, 0,\n0, 1, 0,\n0, 0, 0,\nNumBones: 2\n2, 1,\n1, 0,\n"
      "NumJointHierarchies: 1\nNumJoints-Arm: 3\n2, 1, 0,\n");
  const std::string pose = file("p.pose", "NumJoints: 3\nJointAngles:\n0, 0, 0,\n0.5, 0, 0,\n0, 0, 0.25,\n");
  std::filesystem::create_directories(path("there"));
  convert({figure, path("there/f.figure")});
  convert({pose, path("there/p.pose")});
  const Imported before = importFiles(pose), after = importFiles(path("there/p.pose"));
  const auto tip = [](const Imported& imported) {
    return Eigen::Vector3d(forwardKinematics(imported.model.skeleton,
                                             imported.model.clip->q.col(0))[imported.figure->jointOfIndex[0]]
                               .translation());
  };
  EXPECT_EQ(before.figure->jointOfIndex, after.figure->jointOfIndex);
  EXPECT_EQ(tip(before), tip(after));
  EXPECT_GT((tip(before) - Eigen::Vector3d(0, 2, 0)).norm(), 0.1);
}

TEST_F(ConvertCommand, ASceneBringsItsPoseAndItsEditedWeights) {
  const std::string obj = file("b.obj", tetrahedron),
                    bones = file("s.skel", "a 0 0 0 -1\nb 0 1 0 a\nc 0 2 0 b\n");
  const ModelReference reference{
      .nameOrFile = obj,
      .files = {.skeleton = bones, .weights = file("w.attachment", "1 0\n0.5 0.5\n0 1\n1 0\n")}};
  const Model model = readModel(reference);
  Document scene = newDocument(model, reference);
  setBallRotation(model.skeleton, scene.edits.q, 1,
                  Eigen::Quaterniond(Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitX())));
  Influences quarter{};
  quarter.joints = {0, 1, 0, 0};
  quarter.weights = {0.25, 0.75, 0.0, 0.0};
  scene.edits.weights.set(3, quarter);
  writeScene(path("scene.json"), scene, model);

  convert({path("scene.json"), path("out.attachment")});
  const auto edited = openBody(obj, bones, path("out.attachment")).skin->influences;
  EXPECT_EQ(weightOn(edited[3], {.joints = {1}}), 0.75);
  EXPECT_EQ(weightOn(edited[1], {.joints = {1}}), 0.5);
  convert({path("scene.json"), path("posed.obj")});
  EXPECT_GT((readObj(path("posed.obj")).positions[3] - model.skin->mesh.positions[3]).norm(), 0.1);

  EXPECT_THROW(convert({path("scene.json"), path("out.attachment"), "--unit-in", "cm"}),
               std::invalid_argument);
  std::string text = readFile(path("scene.json"));
  text.replace(text.find("0.75"), 4, "0.85");
  const std::string before = readFile(path("out.attachment"));
  EXPECT_THROW(convert({file("bad.json", text), path("out.attachment")}), std::runtime_error);
  EXPECT_EQ(readFile(path("out.attachment")), before);
}

TEST_F(ConvertCommand, PositionsThatStandStillAreNoObstacleForAsf) {
  const auto bvh = [](double second) {
    return std::string(
               "HIERARCHY\nROOT hips\n{\nOFFSET 0 1 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation "
               "Xrotation Yrotation\n"
               "JOINT leg\n{\nOFFSET 0.1 0 0\nCHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation "
               "Yrotation\n"
               "JOINT foot\n{\nOFFSET 0 -0.5 0\nCHANNELS 3 Zrotation Xrotation Yrotation\nEnd "
               "Site\n{\nOFFSET 0 0 0.2\n}\n}\n}\n}\n"
               "MOTION\nFrames: 2\nFrame Time: 0.1\n0 1 0 10 0 0  0.1 0.02 0 0 30 0  5 0 0\n0.5 1 0 20 0 0  "
               "0.1 ") +
           exactNumber(second) + " 0 0 40 0  6 0 0\n";
  };
  const std::string still = file("still.bvh", bvh(0.02));
  convert({still, path("still.asf")});
  convert({still, path("still.amc")});
  const Imported before = importFiles(still),
                 after = importFiles(path("still.amc"), {.skeleton = {},
                                                         .weights = {},
                                                         .asf = path("still.asf"),
                                                         .amc = {},
                                                         .mapping = {},
                                                         .figure = {}});
  for (int f = 0; f < 2; ++f) {
    const Frames was = forwardKinematics(before.model.skeleton, before.model.clip->q.col(f)),
                 is = forwardKinematics(after.model.skeleton, after.model.clip->q.col(f));
    const Eigen::Vector3d foot = was[before.model.skeleton.jointIndex("foot")].translation(),
                          end = was[before.model.skeleton.jointIndex("foot_end")].translation();
    EXPECT_LE((is[after.model.skeleton.jointIndex("foot")].translation() - foot).norm(), 1e-9) << f;
    EXPECT_LE((is[after.model.skeleton.jointIndex("foot_end")].translation() - end).norm(), 1e-9) << f;
  }
  EXPECT_THROW(convert({file("moves.bvh", bvh(0.03)), path("moves.asf")}), std::invalid_argument);
}

TEST_F(ConvertCommand, AFrameRateIsOfAnAmcOnly) {
  const std::string skeleton = file("s.skel", "a 0 0 0 -1\nb 0 1 0 a\n");
  EXPECT_THROW(convert({skeleton, path("s.bvh"), "--fps", "60"}), std::invalid_argument);
}

}  // namespace
}  // namespace gelenk
