#include <gtest/gtest.h>

#include <limits>

#include "apps/commands/solver_colour.h"
#include "apps/render/lab_marks.h"
#include "apps/render/label_places.h"
#include "apps/render/label_writer.h"
#include "apps/sandbox/plots.h"
#include "apps/sandbox/sandbox_state.h"
#include "skinning/mesh_look.h"
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

TEST(LabPanel, PlotsAndTablesHaveShortNames) {
  LabSettings lab;
  lab.solvers = {"lm-gain-ratio", "dls[lambda=0.2]", "dls[lambda=0.3]", "drag"};
  EXPECT_EQ(comparedNames(lab), (std::vector<std::string>{"lm-gain-ratio", "dls", "dls (2)", "drag"}));
}

/// The blue and violet of solvers on the dark of the plots: 4.5 to 1 is what WCAG 2 asks of text.
TEST(Plots, TheNameOfEverySolverIsReadInTheDark) {
  const Palette& dark = palette(Theme::Dark);
  const auto luminance = [](const ImVec4& c) {
    return 0.2126f * linearFromSrgb(c.x) + 0.7152f * linearFromSrgb(c.y) + 0.0722f * linearFromSrgb(c.z);
  };
  for (const std::string& name : frameSolverNames()) {
    const ImVec4 ink = inkOf(toImVec4(solverColour(name)), dark);
    for (const ImVec4& behind : {dark.plotBackground, dark.panel})
      EXPECT_GT((luminance(ink) + 0.05f) / (luminance(behind) + 0.05f), 4.5f) << name;
  }
}

/// Labels of curves that end in one place moved above each other, out of the plot at its top.
TEST(Plots, EveryLabelStandsWholeWithinItsPlotAndOnNoOther) {
  Stage stage;
  stage.play("", 1);
  const Fonts& fonts = stage.sandbox.state().gui.fonts();
  for (const double last : {1.0, 0.5, 1e-6})
    for (const ImVec2 size : {ImVec2(290, 150), ImVec2(180, 130), ImVec2(600, 300)}) {
      std::vector<Curve> curves;
      for (const char* name : {"lm-gain-ratio", "exact-hessian", "task-priority", "dls (2)"}) {
        const float hue = 0.2f * static_cast<float>(curves.size());
        curves.push_back({.values = {1.0, 0.9, last}, .colour = {hue, 0.5f, 0.9f, 0.4f}, .label = name});
      }
      ImGui::NewFrame();
      ImGui::SetNextWindowPos({0, 0});
      ImGui::SetNextWindowSize({640, 480});
      ImGui::Begin("plot alone");
      drawPlot({.title = "t", .xLabel = "i", .logarithmic = true, .lowest = 1e-6}, curves, {10, 30}, size,
               palette(Theme::Light), fonts, 1.0f);
      std::vector<LabelBox> boxes;
      for (const Curve& curve : curves) {
        const ImU32 ink = colour32({curve.colour.x, curve.colour.y, curve.colour.z, 1.0f});
        constexpr float far = std::numeric_limits<float>::max();
        ImVec2 low{far, far}, high{-far, -far};
        int corners = 0;
        for (const ImDrawVert& v : ImGui::GetWindowDrawList()->VtxBuffer) {
          if (v.col != ink) continue;
          ++corners;
          low = {std::min(low.x, v.pos.x), std::min(low.y, v.pos.y)};
          high = {std::max(high.x, v.pos.x), std::max(high.y, v.pos.y)};
        }
        const auto glyphs = std::ranges::count_if(curve.label, [](char c) { return c != ' '; });
        EXPECT_EQ(corners, 4 * glyphs) << curve.label;  // none was clipped away
        EXPECT_GE(low.x, 10.0f);
        EXPECT_GE(low.y, 30.0f + fonts.small->FontSize) << curve.label;  // below the title
        EXPECT_LE(high.x, 10.0f + size.x) << curve.label;
        EXPECT_LE(high.y, 30.0f + size.y) << curve.label;
        const LabelBox box{low.x, low.y, high.x - low.x, high.y - low.y};
        for (const LabelBox& other : boxes) EXPECT_FALSE(box.overlaps(other)) << curve.label;
        boxes.push_back(box);
      }
      ImGui::End();
      ImGui::EndFrame();
    }
}

}  // namespace
}  // namespace gelenk
