#include "skinning/gpu/offscreen_context.h"

#include <gtest/gtest.h>

#include <cstdlib>

#include "skinning/gpu/render_target.h"
#include "tests/gpu/gl_fixture.h"

namespace gelenk {
namespace {

TEST(OffscreenContext, OlderVersionsAreRejectedInASentence) {
  EXPECT_NO_THROW(requireOpenGl33(3, 3, "any"));
  EXPECT_NO_THROW(requireOpenGl33(4, 0, "any"));
  try {
    requireOpenGl33(3, 1, "Old Card");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(),
                 "OpenGL 3.3 is needed, but Old Card offers 3.1; a newer driver, or the software renderer "
                 "(LIBGL_ALWAYS_SOFTWARE=1), would do");
  }
}

TEST(OffscreenContext, ContextsFollowEachOtherAndTheLaterIsCurrent) {
  for (int i = 0; i < 3; ++i) {
    const OffscreenContext context;
    EXPECT_FALSE(glRenderer().empty());
    EXPECT_NE(glRenderer(), "unknown renderer");
  }
}

TEST(OffscreenContext, TheDebugLogHearsAnInvalidCall) {
  const OffscreenContext context;
  const GlDebugLog log;
  glBindBuffer(GL_TEXTURE_2D, 0);  // not a buffer target
  ASSERT_EQ(log.messages().size(), 1u);
  EXPECT_NE(log.messages()[0].find("GL_INVALID_ENUM"), std::string::npos) << log.messages()[0];
}

class Targets : public testing::GlTest {};

TEST_F(Targets, PixelsAreReadTopRowFirst) {
  const RenderTarget target(4, 3);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glEnable(GL_SCISSOR_TEST);
  glScissor(0, 2, 1, 1);  // OpenGL's upper left
  glClearColor(1, 0.5, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  glDisable(GL_SCISSOR_TEST);
  const auto pixels = target.readPixels();
  EXPECT_EQ(pixels[0], 255);
  EXPECT_EQ(pixels[1], 128);
  EXPECT_EQ(pixels[4 * 4 * 2], 0);
}

TEST_F(Targets, ASizeThatTheRendererCannotMakeIsASentence) {
  try {
    RenderTarget target(1 << 20, 16);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("1048576 x 16 pixels is not possible"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace gelenk
