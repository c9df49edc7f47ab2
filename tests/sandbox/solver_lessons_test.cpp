#include "apps/sandbox/solver_lessons.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "apps/document/session.h"
#include "apps/render/mathematics.h"
#include "apps/sandbox/sandbox_state.h"
#include "tests/places.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

TEST(SolverLessons, EverySolverOfTheListIsExplainedAndItsPageIsThere) {
  for (const std::string& name : frameSolverNames()) {
    const SolverLesson* lesson = solverLesson(name);
    ASSERT_NE(lesson, nullptr) << name;
    EXPECT_FALSE(lesson->formula.empty()) << name;
    EXPECT_GT(lesson->sentence.size(), 30u) << name;
    EXPECT_TRUE(std::filesystem::exists(std::filesystem::path(testing::assetFolder()) / "../docs/solvers" /
                                        (std::string(lesson->page) + ".md")))
        << name << ": " << lesson->page;
  }
  EXPECT_EQ(solverLesson("of another program"), nullptr);
}

/// At 1280 x 800, where the inspector is narrow.
TEST(SolverLessons, FormulasFitTheInspector) {
  testing::Stage stage({.model = "planar", .width = 1280, .height = 800});
  stage.play("0 tab Solve\n", 2);
  const Sandbox::State& s = stage.sandbox.state();
  const float room = s.layout.inspector.width - 28.0f;
  for (const std::string& name : frameSolverNames()) {
    ImFont* font = s.gui.fonts().small;
    const std::string formula(solverLesson(name)->formula);
    EXPECT_LT(mathExtent(font, font->FontSize, formula).width, room) << name;
  }
}

}  // namespace
}  // namespace gelenk
