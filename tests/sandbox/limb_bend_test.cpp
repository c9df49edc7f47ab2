#include "apps/sandbox/limb_bend.h"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/document/model.h"
#include "kinematics/forward_kinematics.h"
#include "skinning/muscles/muscle_control.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using testing::Stage;

constexpr double degree = M_PI / 180.0;

double bendOf(const Skeleton& skeleton, const Limb& limb, const Eigen::VectorXd& q) {
  return jointBend(limbFrames(limb, forwardKinematics(skeleton, q)), 1).bend;
}

TEST(LimbBend, ElbowsAndKneesBendByOneCoordinateToWhatWasAsked) {
  Stage stage({.model = "figure", .width = 640, .height = 480});
  stage.play("0 do Muscles layers on\n", 3);
  const Session& session = stage.sandbox.session();
  ASSERT_NE(stage.sandbox.muscles(), nullptr);
  for (const Limb& limb : stage.sandbox.muscles()->body().limbs) {
    const auto range = limbBend(session.skeleton(), limb, session.q());
    ASSERT_TRUE(range) << limb.name;
    EXPECT_LT(range->least, 15 * degree) << limb.name;
    EXPECT_GT(range->most, 110 * degree) << limb.name;
    for (const double bend : {20.0, 60.0, 110.0}) {
      const Eigen::VectorXd q = bentBy(session.skeleton(), limb, *range, session.q(), bend * degree);
      EXPECT_NEAR(bendOf(session.skeleton(), limb, q), bend * degree, 1e-9) << limb.name;
      Eigen::VectorXd rest = q - session.q();
      rest[range->coordinate] = 0.0;
      EXPECT_EQ(rest.norm(), 0.0) << limb.name;
    }
    const Eigen::VectorXd most = bentBy(session.skeleton(), limb, *range, session.q(), 4.0);
    EXPECT_NEAR(most[range->coordinate], range->fullest, 1e-9);
  }
}

TEST(LimbBend, ThePanelBendsTheLimbThatItShowsAndUndoTakesItBack) {
  Stage stage({.model = "figure", .width = 640, .height = 480});
  stage.play("0 do Muscles layers on\n", 3);
  Session& session = stage.sandbox.session();
  const Limb& limb = stage.sandbox.muscles()->body().limbs[0];
  const double before = bendOf(session.skeleton(), limb, session.q());
  stage.play("0 do Muscles bend 95\n", 10);
  EXPECT_NEAR(bendOf(session.skeleton(), limb, session.q()), 95 * degree, 1e-3);
  ASSERT_TRUE(session.undo());
  EXPECT_NEAR(bendOf(session.skeleton(), limb, session.q()), before, 1e-9);
}

}  // namespace
}  // namespace gelenk
