#include "apps/document/muscle_settings.h"

#include <gtest/gtest.h>

#include "apps/commands/muscle_report.h"
#include "kinematics/notation/mannequin.h"

namespace gelenk {
namespace {

const Skeleton& figure() {
  static const Skeleton skeleton = mannequin();
  return skeleton;
}
const std::vector<Limb>& figureLimbs() {
  static const std::vector<Limb> limbs = standardLimbs(figure(), restFrames(figure()));
  return limbs;
}

TEST(MuscleSettings, LimbsByJointNamesSayWhichJointIsUnknown) {
  const Frames rest = restFrames(figure());
  EXPECT_EQ(limbByNames(figure(), rest, "thigh_l,calf_l,foot_l").name,
            "thigh_l/calf_l/foot_l");  // no field of its own in a CSV row
  try {
    limbByNames(figure(), rest, "thigh_l,tail,foot_l");
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'tail'"), std::string::npos) << error.what();
  }
}

TEST(MuscleReport, BentToIsExactAndStraightIsStraight) {
  for (const Limb& limb : figureLimbs())
    for (const double bend : {0.0, 1.0, 2.0}) {
      const LimbFrames frames = limbFrames(limb, bentTo(figure(), limb, bend));
      EXPECT_NEAR(jointBend(frames, 1).bend, bend, 1e-7)
          << limb.name;  // acos-free, but the swing's norm is a root near zero
      EXPECT_NEAR((frames.joints[2] - frames.joints[1]).norm(), limb.shape.links[1].length, 1e-14);
    }
}

}  // namespace
}  // namespace gelenk
