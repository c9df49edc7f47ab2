#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

struct Stage {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox{{.model = "planar", .width = 640, .height = 480, .solver = "dls"}};
  ViewPicture target;
  InputQueue queue;

  /// Plays the script; the ghosts of the last frame.
  std::vector<Ghost> play(const std::string& script, int frames) {
    target.resize(640, 480);
    Replay replay = Replay::parse("script", script);
    for (int i = 0; i < frames; ++i) {
      replay.play(i, sandbox, queue);
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
      sandbox.frame({.width = 640, .height = 480, .events = queue.take()}, 1.0 / 60.0);
    }
    return sandbox.ghosts();
  }
};

std::string targetOf(Stage& stage) {
  return "3 target " + stage.sandbox.session().goals().front().goal.name + " 150 500 0\n";
}

TEST(LabPanel, WithoutComparisonThereAreNoGhosts) {
  Stage stage;
  EXPECT_TRUE(stage.play(targetOf(stage), 12).empty());
}

TEST(LabPanel, GhostsReachTheGoalInPosesOfTheirOwn) {
  Stage stage;
  // three links, many solutions: where a solver's pose differs from the session's it stands there as a ghost
  const std::vector<Ghost> ghosts = stage.play("1 key L\n" + targetOf(stage), 12);
  ASSERT_FALSE(ghosts.empty());
  const Goal& goal = stage.sandbox.session().goals().front().goal;
  double nearest = 1e300;
  for (const Ghost& ghost : ghosts)
    nearest = std::min(nearest, (ghost.worldFromJoint[goal.joint].translation() - goal.target).norm());
  EXPECT_LE(nearest, 1e-3);
  EXPECT_TRUE(stage.log.messages().empty());
}

TEST(LabPanel, ItsStateGoesThroughASceneAndBadStatesAreRefused) {
  Stage stage;
  const auto panel = makeLabPanel(), copy = makeLabPanel();
  copy->load(stage.sandbox, R"({"compare": true, "side_by_side": false, "solvers": ["sdls", "qp"]})");
  panel->load(stage.sandbox, copy->save());
  EXPECT_EQ(panel->save(), copy->save());
  EXPECT_THROW(
      panel->load(stage.sandbox, R"({"compare": true, "side_by_side": false, "solvers": ["newtonn"]})"),
      std::exception);
  EXPECT_THROW(panel->load(stage.sandbox, R"({"compare": true})"), std::exception);
}

}  // namespace
}  // namespace gelenk
