// One limb alone in the window, with other skins beside it.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "apps/sandbox/sandbox_state.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using testing::Stage;

int seen(const std::vector<std::array<int, 3>>& triangles) {
  return static_cast<int>(std::ranges::count_if(triangles, [](const auto& t) { return t[0] != t[1]; }));
}

class LimbAlone : public ::testing::Test {
 protected:
  Stage stage_{{.model = "figure", .width = 640, .height = 480}};
  Sandbox::State& state_ = stage_.sandbox.state();

  const std::vector<std::array<int, 3>>& triangles() { return state_.view->triangles(*state_.session); }
  bool canTake(const std::string& name) {
    const auto id = state_.session->findGoal(name);
    if (!id) ADD_FAILURE() << "no goal " << name;
    return id && state_.view->shows(*state_.session, state_.session->goal(*id));
  }
};

TEST_F(LimbAlone, IsAPartOfTheBodyWithTwoSkinsBesideItAndTheBodyComesBack) {
  stage_.play("0 do Muscles layers on\n", 3);
  const auto whole = triangles();
  EXPECT_EQ(seen(whole), static_cast<int>(whole.size()));
  const double bodyHeight = state_.view->bounds().sizes().y();
  stage_.play("0 do Muscles alone on\n1 do Muscles bend 90\n", 3);
  ASSERT_EQ(triangles().size(), whole.size());
  EXPECT_GT(seen(triangles()), 1000);
  EXPECT_LT(seen(triangles()), static_cast<int>(whole.size()) / 4);
  EXPECT_LT(state_.view->bounds().sizes().y(), 0.5 * bodyHeight);
  EXPECT_EQ(state_.view->skinFacts().size(), 3u);
  EXPECT_TRUE(canTake("hand_l"));
  EXPECT_FALSE(canTake("head"));
  EXPECT_TRUE(canTake("foot_l"));  // a pin is told of, wherever it is
  stage_.play("0 do Muscles alone off\n", 3);
  EXPECT_EQ(triangles(), whole);
  EXPECT_TRUE(canTake("head"));
}

/// The volume told was that of the whole body, of which a bent elbow is little.
TEST_F(LimbAlone, WhatIsToldOfItsSkinsIsOfTheLimb) {
  stage_.play("0 do Muscles layers on\n1 do Muscles alone on\n2 do Muscles bend 120\n", 3);
  const auto limb = state_.view->skinFacts();
  ASSERT_EQ(limb.size(), 3u);
  ASSERT_EQ(toString(limb[1].choice), "lbs");
  const auto chosen = state_.session->lab().skins;
  stage_.play("0 do Muscles alone off\n", 3);
  state_.session->lab().skins = chosen;
  stage_.play("", 3);
  const auto body = state_.view->skinFacts();
  ASSERT_EQ(body.size(), 3u);
  EXPECT_LT(limb[1].volume, -0.01);                 // linear blending loses at the elbow
  EXPECT_LT(limb[1].volume, 3.0 * body[1].volume);  // of an arm, a twentieth of the body
  EXPECT_GE(limb[1].section, body[1].section);      // one limb's sections are some of all
}

/// "LBS" and "FFD" lay on the chests, of one limb alone beside the elbow, and the body's own skin had two
/// names.
TEST_F(LimbAlone, EveryBodyHasOneNameAboveIt) {
  const auto names = [&](const char* script) {
    stage_.play(script, 3);
    std::map<std::string, Eigen::Vector3d> names;
    for (const SceneLabel& label : state_.view->compose(*state_.session).labels)
      if (label.isAbove) names[label.text] = label.at;
    return names;
  };
  const std::string plain = "cor+twist+smooth", own = plain + "+layers=muscle";
  const auto expectAbove = [&](const std::map<std::string, Eigen::Vector3d>& all) {
    const Eigen::AlignedBox3d box = state_.view->bounds();
    for (const auto& [name, at] : all) {
      EXPECT_GT(at.y(), box.max().y()) << name;
      EXPECT_LT(at.y(), box.max().y() + 0.2 * box.sizes().y()) << name;
    }
    EXPECT_NEAR(all.at(own).x(), box.center().x(), 1e-6);
    EXPECT_GT(std::abs(all.at(plain).x() - box.center().x()), 0.5 * box.sizes().x());
  };
  stage_.play("0 do Muscles layers on\n", 3);
  MuscleSettings beside = *state_.session->edits().muscles;
  beside.split = true;
  state_.session->setMuscles(std::make_shared<const MuscleSettings>(beside));
  const auto whole = names("");
  ASSERT_EQ(whole.size(), 2u);
  expectAbove(whole);
  const auto several = names("0 do Muscles alone on\n");
  EXPECT_EQ(several.size(), 1 + state_.view->skinFacts().size());  // the plain one, and those told of
  EXPECT_EQ(several.count(own), 1u);
  state_.session->lab().skins.clear();
  const auto limb = names("0 do Muscles bend 90\n");
  ASSERT_EQ(limb.size(), 2u);
  expectAbove(limb);
}

/// Bent arms lay through each other, and the outermost left the view.
TEST_F(LimbAlone, BodiesBesideABentOneStandApartAndInView) {
  stage_.play("0 do Muscles layers on\n1 do Muscles bend 114\n2 do Muscles alone on\n", 60);
  for (const std::size_t others : {1, 2, 3}) {
    auto& skins = state_.session->lab().skins;
    skins.clear();
    for (const char* name : {"lbs", "dqs", "cor"})
      if (skins.size() < others) skins.push_back(parseSkinChoice(name));
    frameEverything(stage_.sandbox, false);
    stage_.play("", 3);
    const auto facts = state_.view->skinFacts();
    ASSERT_EQ(facts.size(), others + 1);
    const Eigen::AlignedBox3d box = state_.view->bounds();
    const double wide = levelRight(state_.camera(), state_.session->model().up).cwiseAbs().dot(box.sizes());
    for (std::size_t i = 0; i < facts.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) EXPECT_GT((facts[i].above - facts[j].above).norm(), 1.05 * wide);
      const Eigen::Vector3d shift = facts[i].above - facts[0].above;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d at = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner)) + shift;
        const Eigen::Vector2d pixel = project(state_.camera(), state_.viewport(), at).pixel;
        EXPECT_GT(pixel.x(), 0) << others << " " << i;
        EXPECT_LT(pixel.x(), state_.viewport().width) << others << " " << i;
      }
    }
  }
}

/// Every mesh is made anew by another skinning method and by other proportions of a limb.
TEST_F(LimbAlone, StaysAloneWhateverIsMadeAnewAndWhichLimbItIs) {
  stage_.play("0 do Muscles layers on\n1 do Muscles alone on\n", 3);
  const auto arm = triangles();
  state_.session->chooseSkin(parseSkinChoice("lbs"));
  stage_.play("", 3);
  EXPECT_EQ(triangles(), arm);
  const auto picture = [&](const char* script) {
    stage_.play(script, 20);
    return readPixels(stage_.target.framebuffer(), stage_.width, stage_.height);
  };
  const auto lonely = picture("");
  const auto body = picture("0 do Muscles alone off\n");
  int differ = 0;
  for (std::size_t i = 0; i < body.size(); i += 4) differ += body[i] != lonely[i];
  EXPECT_GT(differ, 2000);
  stage_.play("0 do Muscles alone on\n1 do Muscles limb right leg\n", 3);
  EXPECT_NE(triangles(), arm);
  EXPECT_TRUE(canTake("foot_r"));
  EXPECT_FALSE(canTake("hand_l"));
}

TEST_F(LimbAlone, WhatIsNotSeenIsNotTouched) {
  stage_.play("0 do Muscles layers on\n", 3);
  const int joint = *state_.session->skeleton().findJoint("head");
  const Eigen::Vector3d head = state_.session->frames()[joint].translation();
  const auto hits = [&] {
    const Projected p = project(state_.camera(), state_.viewport(), head);
    return pickSurface(triangles(), stage_.sandbox.surface().positions,
                       rayThroughPixel(state_.camera(), state_.viewport(), p.pixel))
        .has_value();
  };
  EXPECT_TRUE(hits());
  stage_.play("0 do Muscles alone on\n", 3);
  EXPECT_FALSE(hits());
}

}  // namespace
}  // namespace gelenk
