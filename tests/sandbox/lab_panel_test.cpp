#include <gtest/gtest.h>

#include "apps/sandbox/sandbox_state.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

struct Stage : testing::Stage {
  Stage() : testing::Stage({.model = "planar", .width = 640, .height = 480, .solver = "dls"}) {}

  /// Plays the script; the ghosts of the last frame.
  std::vector<Ghost> play(const std::string& script, int frames) {
    Replay replay = Replay::parse("script", script);
    for (int i = 0; i < frames; ++i) {
      replay.play(i, sandbox, queue);
      frame();
    }
    return sandbox.state().view->ghosts();
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

TEST(LabPanel, ItsChoiceIsThatOfTheDocument) {
  Stage stage;
  stage.sandbox.session().lab() = {.compare = true, .sideBySide = true, .solvers = {"sdls", "qp"}};
  EXPECT_EQ(stage.play(targetOf(stage), 12).size(), 2u);  // side by side both are shown
  EXPECT_EQ(stage.sandbox.document().lab.solvers, (std::vector<std::string>{"sdls", "qp"}));
  ASSERT_TRUE(stage.sandbox.open("planar"));
  EXPECT_TRUE(stage.play("0 move 5 5\n", 3).empty());
}

}  // namespace
}  // namespace gelenk
