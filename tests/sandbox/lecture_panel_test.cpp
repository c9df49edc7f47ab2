#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/document/chain_models.h"
#include "apps/document/scene_file.h"
#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/lecture_model.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/planar_chain.h"
#include "kinematics/notation/robots.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

struct Stage : testing::Stage {
  Stage() : testing::Stage({.model = "planar", .width = 640, .height = 480}) {}
  void frames(int count) {
    for (int i = 0; i < count; ++i) frame();
  }
};

TEST(LectureScenes, EveryTopicOpensDrawsAndLeavesNoGlMessage) {
  Stage stage;
  for (const LectureTopic& topic : lectureTopics()) {
    ASSERT_TRUE(stage.sandbox.open("lecture:" + topic.id)) << topic.id;
    stage.frames(3);
    EXPECT_TRUE(stage.sandbox.session().q().allFinite()) << topic.id;
    EXPECT_EQ(stage.sandbox.document().lecture.topic, topic.id);
  }
  EXPECT_TRUE(stage.log.messages().empty()) << stage.log.messages().front();
  EXPECT_FALSE(stage.sandbox.open("lecture:no-such-example"));
  EXPECT_TRUE(stage.sandbox.open("planar"));  // another model ends the example
  EXPECT_EQ(stage.sandbox.document().lecture.topic, "");
}

TEST(LectureScenes, TheCommandsOpenWhatTheWindowBeginsWith) {
  Stage stage;
  for (const LectureTopic& topic : lectureTopics()) {
    ASSERT_TRUE(stage.sandbox.open("lecture:" + topic.id)) << topic.id;
    const Model model = lectureModel(topic.id);
    const Skeleton &ours = model.skeleton, &shown = stage.sandbox.session().skeleton();
    ASSERT_EQ(ours.jointCount(), shown.jointCount()) << topic.id;
    for (int i = 0; i < ours.jointCount(); ++i)
      EXPECT_TRUE(ours.joint(i).parentFromZero.isApprox(shown.joint(i).parentFromZero, 0.0)) << topic.id;
    EXPECT_LE((ours.rest() - stage.sandbox.session().q()).cwiseAbs().maxCoeff(), 1e-15)
        << topic.id;  // one normalises
  }
}

void actOn(Sandbox& sandbox, const std::string& words) {
  for (const auto& panel : sandbox.state().panels)
    if (panel->name() == "Lecture") panel->act(sandbox, {words});
}

/// "Live": the derivation is that of the arm as it stands; "slide": the slide's, wherever the arm is.
TEST(LectureScenes, TheDerivationFollowsTheArmOrStaysWithTheSlide) {
  Stage stage;
  const auto shown = [&] {
    stage.frames(1);
    return nlohmann::json::parse(stage.sandbox.status())["panels"]["Lecture"]["derivation"]
        .get<std::string>();
  };
  for (const LectureTopic& topic : lectureTopics()) {
    ASSERT_TRUE(stage.sandbox.open("lecture:" + topic.id)) << topic.id;
    actOn(stage.sandbox, "slide");
    EXPECT_EQ(shown(), topic.steps());
    actOn(stage.sandbox, "live");
    EXPECT_GT(shown().size(), 100u) << topic.id;
    EXPECT_NE(shown(), topic.steps()) << topic.id;
  }
  ASSERT_TRUE(stage.sandbox.open("lecture:planar-fk"));
  const Eigen::Vector3d phi(0.1, 0.2, 0.3);
  stage.sandbox.session().setPose(phi);
  EXPECT_EQ(shown(), forwardDerivation({.base = {0, 0}, .lengths = {4, 6, 2}}, phi));
  ASSERT_TRUE(stage.sandbox.open("lecture:two-link"));
  stage.sandbox.session().setTarget(*stage.sandbox.session().findGoal("end-effector"), {-3.0, 12.0, 0.0});
  EXPECT_NE(shown().find("X = (-3, 12)"), std::string::npos) << shown();
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
  EXPECT_EQ(stage.sandbox.document().lecture.topic, "planar-fk");
}

/// All that its picture follows from, also where it is not the slide's.
TEST(LectureScenes, TheStateOfADrawingComesBack) {
  Stage stage;
  const auto savedAgain = [&](const LectureDrawing& drawing, const std::string& topic) {
    const auto other = makeLectureDrawing(topic);
    other->load(stage.sandbox.session(), drawing.save());
    return other->save();
  };
  for (const char* topic : {"newton-square", "pseudo-inverse", "shortest"}) {
    const auto drawing = makeLectureDrawing(topic);
    auto& newton = dynamic_cast<NewtonDrawing&>(*drawing);
    newton.target += Eigen::Vector2d(0.1, -0.2) * newton.target.norm();
    newton.start *= 1.0 / 3.0;
    newton.restart();
    newton.at = 2;
    EXPECT_EQ(savedAgain(newton, topic), newton.save());
    const auto slide = makeLectureDrawing(topic);
    EXPECT_NE(slide->save(), newton.save());
    slide->load(stage.sandbox.session(), "1");  // as it was written once
    EXPECT_EQ(slide->save()[0], '1');
  }
  TwoLinkDrawing twoLink;
  twoLink.lastTarget = {-3.0, 1.0 / 3.0};
  twoLink.candidates = false;
  EXPECT_EQ(savedAgain(twoLink, "two-link"), twoLink.save());
  OneDimensionDrawing oneLink;
  oneLink.start = 1.0 / 7.0, oneLink.delta = 1e-4;
  oneLink.restart();
  oneLink.at = 3;
  EXPECT_EQ(savedAgain(oneLink, "newton-1d"), oneLink.save());
  RotationsDrawing rotations;
  rotations.joint = 2, rotations.order = 7;
  rotations.typed[1] = {0.1, -0.2, 1.0 / 3.0};
  EXPECT_EQ(savedAgain(rotations, "rotations"), rotations.save());
  ForwardDrawing forward;
  forward.frames = false;
  EXPECT_EQ(savedAgain(forward, "planar-fk"), forward.save());
}

/// A file can name any model beside any example.
TEST(LectureScenes, AnExampleWithAnotherModelIsLeftOut) {
  Stage stage;
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk_other_" + std::to_string(getpid()) + ".json"))
          .string();
  for (const LectureTopic& topic : lectureTopics()) {
    if (topic.id == "dh") continue;
    ASSERT_TRUE(stage.sandbox.open("panda"));
    Document document = stage.sandbox.document();
    document.lecture = {.topic = topic.id, .state = "1 2 3 4 5"};
    writeScene(path, document, stage.sandbox.session().model());
    ASSERT_TRUE(stage.sandbox.open(path)) << topic.id;
    stage.frames(2);
    EXPECT_EQ(stage.sandbox.document().lecture.topic, "") << topic.id;
  }
  std::filesystem::remove(path);
}

TEST(LectureScenes, AnEditedRobotComesBackWithItsTable) {
  Stage stage;
  ASSERT_TRUE(stage.sandbox.open("lecture:dh"));
  DhTable table = robotTable("panda");
  table.rows.pop_back();
  table.rows.pop_back();
  table.rows[1].a = 0.1 + 0.2;
  table.rest.reset();
  stage.sandbox.openModel(dhModel(table), {.nameOrFile = dhDescription(table)});
  const Model opened = openModel(dhDescription(table));
  EXPECT_EQ(opened.skeleton.nq(), stage.sandbox.session().skeleton().nq());
  EXPECT_EQ(dhTableNamed(dhDescription(table))->rows[1].a, 0.1 + 0.2);
  stage.frames(1);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("gelenk_dh_" + std::to_string(getpid()) + ".json")).string();
  ASSERT_TRUE(stage.sandbox.saveSceneTo(path));
  ASSERT_TRUE(stage.sandbox.open("planar"));
  ASSERT_TRUE(stage.sandbox.open(path));
  EXPECT_EQ(stage.sandbox.session().skeleton().nq(), opened.skeleton.nq());
  ASSERT_TRUE(stage.sandbox.open("lecture:dh"));
  stage.frames(1);
  ASSERT_TRUE(stage.sandbox.saveSceneTo(path));
  ASSERT_TRUE(stage.sandbox.open("planar"));
  ASSERT_TRUE(stage.sandbox.open(path));
  EXPECT_EQ(stage.sandbox.document().lecture.topic, "dh");
  stage.frames(2);
  std::filesystem::remove(path);
}

/// What a model opens with, but for the theme, is its own: nothing of what was open before.
TEST(LectureScenes, WhatIsOpenedAfterAnExampleBeginsAsIfItHadBeenFirst) {
  for (const char* next : {"figure", "planar", "panda"}) {
    std::optional<Document> alone;
    for (const LectureTopic& topic : lectureTopics()) {
      Stage stage;
      stage.frames(1);  // the layout is known
      if (!alone) {
        ASSERT_TRUE(stage.sandbox.open(next));
        alone = stage.sandbox.document();
      }
      stage.sandbox.session().theme() = Theme::Dark;
      ASSERT_TRUE(stage.sandbox.open("lecture:" + topic.id));
      stage.frames(1);
      stage.sandbox.session().view().show.limits = false;
      stage.sandbox.session().setSolver("dls");
      stage.sandbox.session().lab().compare = true;
      ASSERT_TRUE(stage.sandbox.open(next));
      Document after = stage.sandbox.document();
      EXPECT_EQ(after.theme, Theme::Dark);
      after.theme = alone->theme;
      const Model& model = stage.sandbox.session().model();
      EXPECT_EQ(formatScene(after, model), formatScene(*alone, model)) << next << " after " << topic.id;
      if (std::string(next) != "planar") break;  // the figure is large: once for one example
    }
  }
}

}  // namespace
}  // namespace gelenk
