#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/lecture/example.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/planar_chain.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

using nlohmann::json;

struct Stage {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox{{.model = "planar", .width = 640, .height = 480}};
  ViewPicture target;

  Stage() { target.resize(640, 480); }
  void frames(int count) {
    for (int i = 0; i < count; ++i) {
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
      sandbox.frame({.width = 640, .height = 480, .events = {}}, 1.0 / 60.0);
    }
  }
};

TEST(LectureScenes, EveryTopicOpensDrawsAndLeavesNoGlMessage) {
  Stage stage;
  for (const LectureTopic& topic : lectureTopics()) {
    ASSERT_TRUE(stage.sandbox.open("lecture:" + topic.id)) << topic.id;
    stage.frames(3);
    EXPECT_TRUE(stage.sandbox.session().q().allFinite()) << topic.id;
    EXPECT_TRUE(stage.sandbox.scene().panels.contains("Lecture")) << topic.id;
  }
  EXPECT_TRUE(stage.log.messages().empty()) << stage.log.messages().front();
  EXPECT_FALSE(stage.sandbox.open("lecture:no-such-example"));
  EXPECT_TRUE(stage.sandbox.open("planar"));  // another model ends the example
  EXPECT_FALSE(stage.sandbox.scene().panels.contains("Lecture"));
}

TEST(LectureScenes, TheTwoLinkArmFollowsItsTargetByTheClosedForm) {
  Stage stage;
  ASSERT_TRUE(stage.sandbox.open("lecture:two-link"));
  stage.frames(2);
  const auto goal = stage.sandbox.session().findGoal("end-effector");
  ASSERT_TRUE(goal);
  EXPECT_NEAR(stage.sandbox.session().q()[1], -2.0 * M_PI / 3.0, 1e-12);  // the slide's branch
  stage.sandbox.session().setTarget(*goal, {-3.0, 12.0, 0.0});
  stage.frames(1);
  EXPECT_LE(stage.sandbox.session().error(*goal), 1e-12);
  EXPECT_EQ(stage.sandbox.session().lastSolve().iterations, 1);
}

TEST(LectureScenes, SavedExampleComesBack) {
  Stage stage;
  ASSERT_TRUE(stage.sandbox.open("lecture:planar-fk"));
  Eigen::VectorXd q = Eigen::Vector3d(0.1, 0.2, 0.3);
  stage.sandbox.session().setPose(q);
  stage.frames(1);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk_lecture_" + std::to_string(getpid()) + ".json"))
          .string();
  ASSERT_TRUE(stage.sandbox.saveSceneTo(path));
  ASSERT_TRUE(stage.sandbox.open("planar"));
  ASSERT_TRUE(stage.sandbox.open(path));
  std::filesystem::remove(path);
  EXPECT_LE((stage.sandbox.session().q() - q).norm(), 1e-15);
  EXPECT_EQ(json::parse(stage.sandbox.scene().panels.at("Lecture"))["topic"], "planar-fk");
}

}  // namespace
}  // namespace gelenk
