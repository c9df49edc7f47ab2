#include "apps/document/muscle_scene.h"

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

/// Every entry of the left arm set to something that is no default and has no short decimal form.
MuscleSettings someSettings() {
  LimbSettings arm = defaultLimbSettings(figureLimbs()[0]);
  arm.jointGap = 0.1 + 1.0 / 30.0;
  arm.wedge = 1.0 / 7.0;
  arm.control.activation = 1.0 / 3.0;
  arm.control.keepVolume = false;
  arm.control.curves[1] = {
      .flexor = 0.1 / 3, .extensor = -0.1 / 7, .nearJoint = 1.0 / 9, .tendon = 0.3 / 7, .fullBend = 7.0 / 3};
  arm.control.sculpted[0].plane4.stretch << 1.0 / 0.9, 0.1 / 3, 0.1 / 7, 0.7;
  arm.control.sculpted[0].plane4.offset << 0.001 / 3, -0.002 / 7;
  for (int c = 0; c < 16; ++c)
    arm.control.sculpted[1].plane2.displacement.emplace_back(0.001 * c / 7, -0.01 / (c + 1), 1e-17 * c);
  return {.enabled = true, .lattice = false, .split = true, .limbs = {{"left arm", arm}}};
}

TEST(MuscleScene, SettingsReadBackToTheLastBit) {
  const std::string text = muscleSettingsText(someSettings());
  EXPECT_EQ(muscleSettingsText(parseMuscleSettings(text, figureLimbs())), text);
  const LimbSettings read = parseMuscleSettings(text, figureLimbs()).limbs[0].second,
                     wrote = someSettings().limbs[0].second;
  EXPECT_EQ(read.jointGap, wrote.jointGap);
  EXPECT_EQ(read.control.curves[1].fullBend, wrote.control.curves[1].fullBend);
  EXPECT_EQ(read.control.sculpted[0].plane4.stretch, wrote.control.sculpted[0].plane4.stretch);
  EXPECT_EQ(read.control.sculpted[1].plane2.displacement, wrote.control.sculpted[1].plane2.displacement);
}

std::string complaintOf(const std::string& text) {
  try {
    parseMuscleSettings(text, figureLimbs());
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MuscleScene, ErrorsNameTheEntry) {
  const std::string good = muscleSettingsText(someSettings());
  EXPECT_EQ(complaintOf(good), "accepted");
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from << " in " << good;
    return complaintOf(text.replace(at, from.size(), to));
  };
  EXPECT_EQ(
      replaced("left arm", "tail"),
      "muscles.limbs[0]: the model has no limb 'tail'; it has: left arm, right arm, left leg, right leg");
  EXPECT_EQ(replaced("\"activation\":0.3333333333333333", "\"activation\":2"),
            "muscles.limbs[0].activation: expected a number from 0 to 1, found 2");
  EXPECT_EQ(replaced("\"activation\":0.3333333333333333", "\"activation\":\"full\""),
            "muscles.limbs[0].activation: expected a number, found \"full\"");
  EXPECT_EQ(replaced("\"keep_volume\":false", "\"keep_volume\":0"),
            "muscles.limbs[0].keep_volume: expected true or false, found 0");
  EXPECT_EQ(replaced("\"wedge\"", "\"wegde\""), "muscles.limbs[0] has no entry 'wedge'");
  EXPECT_EQ(replaced("\"curves\":[", "\"curves\":[{},"),
            "muscles.limbs[0].curves: expected a list of 2 entries, found 3");
  EXPECT_EQ(replaced("\"displacement\":[[", "\"displacement\":[[0,0,0],["),
            "muscles.limbs[0].sculpted[1].plane2.displacement: expected a list of 16 entries, found 17");
  EXPECT_EQ(replaced("\"offset\":[0", "\"offset\":[NaN,0"), "muscles: no valid JSON");
  EXPECT_EQ(replaced("\"offset\":[0", "\"offset\":[1e999,0"), "muscles: no valid JSON");
  EXPECT_EQ(complaintOf(""), "muscles: no valid JSON");
  EXPECT_EQ(complaintOf("[]"), "muscles has no entry 'enabled'");
}

TEST(MuscleScene, NoTruncatedTextIsAccepted) {
  const std::string good = muscleSettingsText(someSettings());
  for (std::size_t length = 0; length < good.size(); length += 7)
    EXPECT_EQ(complaintOf(good.substr(0, length)), "muscles: no valid JSON");
}

TEST(MuscleScene, LimbsByJointNamesSayWhichJointIsUnknown) {
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
