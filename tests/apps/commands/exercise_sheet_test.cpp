#include <gtest/gtest.h>

#include <filesystem>

#include "apps/document/model_files.h"
#include "kinematics/io/pinocchio_skeleton.h"
#include "kinematics/io/text_file.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/muscles/muscle_control.h"
#include "skinning/muscles/muscle_skin.h"
#include "tests/places.h"

namespace gelenk {
namespace {

/// An ASF man with an arm that hangs where the body's is held out, a body of one triangle a bone, and
/// weights; the joints' names differ in case and side only.
class SmallSheet : public ::testing::Test {
 protected:
  SmallSheet()
      : folder_(::testing::TempDir() + "gelenk_sheet_" +
                ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/") {
    std::filesystem::create_directories(folder_);
  }
  ~SmallSheet() override { std::filesystem::remove_all(folder_); }
  std::string file(const std::string& name, const std::string& text) const {
    writeFile(folder_ + name, text);
    return folder_ + name;
  }
  Model open(const std::string& skeleton, const std::string& mapping = "") const {
    Companions files;
    files.skeleton = file("fit.skel", skeleton);
    files.weights = file("fit.attachment", "1 0 0\n0 1 0\n0 0 1\n0 0 1\n");
    files.asf = file("man.asf",
                     ":units\nlength 0.0254\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n:bonedata\n"
                     "begin\nname spine\ndirection 0 1 0\nlength 0.5\naxis 0 0 0 XYZ\nend\n"
                     "begin\nname larm\ndirection 0 -1 0\nlength 0.3\naxis 0 0 0 XYZ\ndof rx\nend\n"
                     "begin\nname lhand\ndirection 0 -1 0\nlength 0.1\naxis 0 0 0 XYZ\ndof rx\nend\n"
                     "begin\nname rarm\ndirection 0 -1 0\nlength 0.3\naxis 0 0 0 XYZ\nend\n"
                     "begin\nname rhand\ndirection 0 -1 0\nlength 0.1\naxis 0 0 0 XYZ\nend\n"
                     ":hierarchy\nbegin\nroot spine\nspine larm rarm\nlarm lhand\nrarm rhand\nend\n");
    files.mapping = mapping.empty() ? "" : file("map.txt", mapping);
    return importFiles(
               file("body.obj", "v 0 1.2 0\nv 0.2 1.5 0\nv 0.6 1.5 0\nv 0.6 1.5 0.1\nf 1 2 3\nf 1 3 4\n"),
               files)
        .model;
  }

 private:
  std::string folder_;
};

const std::string equalNames =
    "Rig_Hips 0 1 0 -1\nRig_Arm_L 0.1 1.5 0 Rig_Hips\nRig_Hand_L 0.5 1.5 0 Rig_Arm_L\nRig_Finger 0.6 1.5 0 "
    "Rig_Hand_L\n";

TEST_F(SmallSheet, JointsOfEqualNamesAreMatchedAndTheRestIsListed) {
  const Model model = open(equalNames);
  const Frames bound = bindFrames(model);
  const Skeleton& skeleton = model.skeleton;
  EXPECT_LE((bound[skeleton.jointIndex("larm")].translation() - Eigen::Vector3d(0.1, 1.5, 0)).norm(), 1e-12);
  EXPECT_LE((bound[skeleton.jointIndex("lhand")].translation() - Eigen::Vector3d(0.5, 1.5, 0)).norm(), 1e-12);
  std::string notes;
  for (const Note& note : model.notes) notes += note.text + "\n";
  EXPECT_NE(notes.find("without a fitted counterpart (they follow their parent): lhand, rarm, rhand"),
            std::string::npos)
      << notes;
  EXPECT_NE(notes.find("fitted joints whose bone lies on no ASF bone: Rig_Finger"), std::string::npos)
      << notes;
}

TEST_F(SmallSheet, BindFramesAreThoseOfTheBodyNotOfTheSkeletonsZero) {
  const Model model = open(equalNames);
  EXPECT_FALSE(restsAsBound(model));
  const SkinnedVertices still = linearBlendSkin(*model.skin, bindFrames(model));
  for (std::size_t v = 0; v < still.positions.size(); ++v)
    EXPECT_LE((still.positions[v] - model.skin->mesh.positions[v]).norm(), 1e-12);
  const SkinnedVertices zero = linearBlendSkin(*model.skin, restFrames(model.skeleton));
  EXPECT_GE((zero.positions[2] - model.skin->mesh.positions[2]).norm(),
            0.1);  // the arm hangs in the ASF's zero
}

TEST_F(SmallSheet, OtherNamesNeedAMappingAndTheMessageSaysSo) {
  const std::string other = "a 0 1 0 -1\nb 0.1 1.5 0 a\nc 0.5 1.5 0 b\nd 0.6 1.5 0 c\n";
  try {
    open(other);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("--mapping"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(open(other, "spine : a b\nlarm : b c\n"));
  try {
    open(other, "spine : a b\n\nlarm : b x\n");
    FAIL() << "accepted";
  } catch (const std::exception& error) {
    EXPECT_NE(std::string(error.what())
                  .find("map.txt:3: expected a joint of the fitted skeleton (a, b, c, d), found 'x'"),
              std::string::npos)
        << error.what();
  }
}

TEST(ExerciseSheet, MuscleLayersLeaveTheBoundBodyInPlace) {
  const std::string data = testing::dataFolder();
  if (!std::filesystem::exists(data + "/mocap/asf/02.asf")) GTEST_SKIP() << "no trial data at " << data;
  Companions files;
  files.skeleton = data + "/pinocchio/mh_male.skeleton.out";
  files.weights = data + "/pinocchio/mh_male.attachment.out";
  files.asf = data + "/mocap/asf/02.asf";
  const Model model = importFiles(data + "/characters/makehuman/mh_male.obj", files).model;
  const Frames bound = bindFrames(model);
  const Limb arm = makeLimb(model.skeleton, bound, "left arm",
                            {model.skeleton.jointIndex("lhumerus"), model.skeleton.jointIndex("lradius"),
                             model.skeleton.jointIndex("lwrist")});
  const MuscleRig rig(bindMuscles(*model.skin, {arm}, bound), bound);
  SkinnedVertices vertices;
  skinWithMuscles(rig.body(), bound, rig.pose(bound), vertices);
  double worst = 0.0;
  for (std::size_t v = 0; v < vertices.positions.size(); ++v)
    worst = std::max(worst, (vertices.positions[v] - model.skin->mesh.positions[v]).norm());
  EXPECT_LE(worst, 1e-6);
}

}  // namespace
}  // namespace gelenk
