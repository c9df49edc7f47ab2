// Every kind of goal in the window: added as the Solve tab's list adds it, seen, moved by the mouse, undone.
#include <gtest/gtest.h>

#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox_state.h"
#include "apps/sandbox/view_picture.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

constexpr int width = 420, height = 320;

struct Window {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox{{.model = "figure", .width = width, .height = height}};
  ViewPicture target;
  InputQueue queue;

  Window() { target.resize(width, height); }
  void play(const std::string& script, int frames) {
    Replay replay = Replay::parse("test", script);
    for (int i = 0; i < frames; ++i) {
      replay.play(i, sandbox, queue);
      glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
      sandbox.frame({.width = width, .height = height, .events = queue.take(sandbox.keys())}, 1.0 / 60.0);
    }
  }
  Session& session() { return *sandbox.state().session; }
  std::vector<std::uint8_t> picture() const {
    std::vector<std::uint8_t> pixels(4 * width * height);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target.framebuffer());
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    return pixels;
  }
};

bool canBeMoved(const GoalType& type) {
  for (const GoalField& field : type.fields)
    if (field.meaning == GoalField::Meaning::Target) return true;
  return false;
}

TEST(GoalKinds, AreAddedSeenMovedAndUndone) {
  Window window;
  window.play("0 tab Solve\n", 3);
  const auto before = window.picture();
  const std::size_t count = window.session().goals().size();
  for (const GoalType* type : goalTypes()) {
    SCOPED_TRACE(type->name);
    window.play("0 do Solve add " + std::string(type->name) + "\n", 3);
    ASSERT_EQ(window.session().goals().size(), count + 1);
    const GoalId id = *window.sandbox.state().selectedGoal;
    const Goal asked = window.session().goal(id).goal;
    EXPECT_EQ(asked.kind, type->kind);
    // what it asks for is what is, but for the frames that were solved since
    const GoalPlace at{window.session().skeleton(), window.session().q(), window.session().frames()};
    Eigen::VectorXd r(type->rows(at.skeleton));
    type->residual(asked, at, r);
    EXPECT_LT(r.norm(), 2e-3);
    EXPECT_NE(window.picture(), before);
    if (canBeMoved(*type) && type->kind != GoalKind::Pole) {
      const Eigen::Vector3d handle = type->handleAtTarget ? asked.target : window.session().reached(id);
      const Eigen::Vector2d pixel = window.sandbox.state().toWindow(handle).pixel;
      const std::string from = std::to_string(pixel.x()) + " " + std::to_string(pixel.y());
      const std::string to = std::to_string(pixel.x() + 25) + " " + std::to_string(pixel.y() - 15);
      window.play("0 move " + from + "\n1 press left\n2 move " + to + "\n4 release left\n", 6);
      for (const double x : window.session().q()) ASSERT_TRUE(std::isfinite(x));
    }
    for (int i = 0; i < 8 && window.session().goals().size() > count; ++i) window.session().undo();
    EXPECT_EQ(window.session().goals().size(), count);
    window.play("", 2);
  }
  for (const std::string& message : window.log.messages()) ADD_FAILURE() << message;
}

}  // namespace
}  // namespace gelenk
