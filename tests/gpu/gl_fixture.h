#pragma once

#include <gtest/gtest.h>

#include <optional>

#include "skinning/gpu/offscreen_context.h"

namespace gelenk::testing {

/// An offscreen context a test; any message of the driver's debug output fails the test.
class GlTest : public ::testing::Test {
 protected:
  void SetUp() override {
    context_.emplace();
    log_.emplace();
    ASSERT_TRUE(log_->available()) << "the renderer has no KHR_debug";
    RecordProperty("renderer", glRenderer());
  }
  void TearDown() override {
    if (log_)
      for (const std::string& message : log_->messages()) ADD_FAILURE() << "OpenGL: " << message;
    log_.reset();
    context_.reset();
  }
  const GlDebugLog& debugLog() const { return *log_; }

 private:
  std::optional<OffscreenContext> context_;
  std::optional<GlDebugLog> log_;
};

}  // namespace gelenk::testing
