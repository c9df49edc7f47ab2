#include <gtest/gtest.h>

#include "apps/sandbox/replay.h"
#include "apps/sandbox/sandbox.h"
#include "apps/sandbox/view_picture.h"
#include "kinematics/motion_clip.h"
#include "skinning/gpu/offscreen_context.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

/// An arm of two hinges whose clip turns the second one far beyond its limit.
Model swingingArm() {
  std::vector<Joint> joints{{.name = "base"}, {.name = "shoulder", .parent = 0}, {.name = "elbow", .parent = 1}, {.name = "hand", .parent = 2}};
  joints[1].axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ()}};
  joints[2].parentFromZero.translation() << 0, 0.5, 0;
  joints[2].axes = {{AxisDof::Kind::Rotation, Eigen::Vector3d::UnitZ(), 0.0, 0.5}};
  joints[3].parentFromZero.translation() << 0, 0.4, 0;
  Model model{.name = "arm", .skeleton = Skeleton(joints)};
  MotionClip clip{.framesPerSecond = 30.0, .q = Eigen::MatrixXd(2, 61)};
  for (int f = 0; f <= 60; ++f) clip.q.col(f) << 0.02 * f, 0.03 * f;
  model.clip = clip;
  return model;
}

TEST(MotionPanel, PlaysTheClipAtItsOwnPaceAndNeverClampsItToLimits) {
  OffscreenContext context;
  GlDebugLog log;
  Sandbox sandbox({.model = "planar", .width = 640, .height = 480});
  sandbox.openModel(swingingArm(), {"arm"});
  ViewPicture target;
  target.resize(640, 480);
  const Model model = swingingArm();
  for (int i = 1; i <= 100; ++i) {
    glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
    sandbox.frame({.width = 640, .height = 480, .events = {}}, 1.0 / 60.0);
    const Frames wanted = forwardKinematics(model.skeleton, sample(model.skeleton, *model.clip, i / 60.0, BeyondEnd::Loop));
    for (int j = 0; j < 4; ++j) ASSERT_LE((sandbox.shownFrames()[j].matrix() - wanted[j].matrix()).norm(), 1e-9) << "frame " << i;
  }
  EXPECT_TRUE(sandbox.playing());
  sandbox.setPlaying(false);
  const Eigen::Matrix4d still = sandbox.shownFrames()[3].matrix();
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer());
  sandbox.frame({.width = 640, .height = 480, .events = {}}, 1.0 / 60.0);
  EXPECT_LE((sandbox.shownFrames()[3].matrix() - still).norm(), 1e-12);
  EXPECT_TRUE(log.messages().empty());
}

}  // namespace
}  // namespace gelenk
