#include <fmt/format.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/sandbox/sandbox_state.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using testing::Stage;

nlohmann::json pathOf(Sandbox& sandbox) {
  return nlohmann::json::parse(sandbox.status()).at("panels").value("Path", nlohmann::json());
}

/// The mouse draws, the tool follows: in every frame its point lies on the line that was drawn, and its
/// orientation is that of the beginning.
TEST(PathPanel, TheToolFollowsTheLineThatTheMouseDrew) {
  for (const char* model : {"ur5", "panda"}) {
    SCOPED_TRACE(model);
    Stage stage({.model = model, .width = 800, .height = 480});
    stage.frame();
    Sandbox& sandbox = stage.sandbox;
    const Goal& goal = sandbox.session().goals().front().goal;
    const int tool = goal.joint;
    const Eigen::Vector3d point = goal.pointInJoint;
    const Eigen::Matrix3d before = sandbox.session().frames()[tool].linear();
    stage.play("0 tab Path\n1 do Path draw on", 3);
    const Vector2d from = sandbox.state().toWindow(sandbox.session().frames()[tool] * point).pixel;
    // Two strokes of one line, with a corner.
    stage.play(
        fmt::format(
            "0 move {:.1f} {:.1f}\n1 press left\n2 shift-by -30 24 12\n16 shift-by 26 20 12\n30 release left",
            from.x(), from.y()),
        0);
    const auto corner = [&](const Vector2d& p) {
      const Vector2d a = from, b = from + Vector2d(-30, 24), c = from + Vector2d(-4, 44);
      const auto away = [&](const Vector2d& s, const Vector2d& t) {
        const double share = std::clamp((p - s).dot(t - s) / (t - s).squaredNorm(), 0.0, 1.0);
        return (s + share * (t - s) - p).norm();
      };
      return std::min(away(a, b), away(b, c));
    };
    const auto onTheLine = [&] {
      const Eigen::Isometry3d now = sandbox.session().frames()[tool];
      EXPECT_LT(corner(sandbox.state().toWindow(now * point).pixel),
                2.5);  // pixels: a spline round the corner
      EXPECT_LT((now.linear() - before).norm(), 1e-6);
    };
    for (int frame = 0; frame < 8; ++frame) {  // it goes by itself
      stage.frame();
      onTheLine();
    }
    EXPECT_GT(pathOf(sandbox).at("pose"), 0);
    const int last = pathOf(sandbox).at("poses").get<int>() - 1;
    Eigen::VectorXd q = sandbox.session().q();
    for (int pose = 2; pose <= last; pose += pose + 3 > last && pose < last ? last - pose : 3) {
      stage.play(fmt::format("0 do Path pose {}", pose), 0);
      onTheLine();
      EXPECT_LT((sandbox.session().q() - q).cwiseAbs().maxCoeff(), 0.5);
      q = sandbox.session().q();
    }
    const auto path = pathOf(sandbox);
    EXPECT_EQ(path.at("reason"), "");
    EXPECT_EQ(path.at("jumps"), 0);
    EXPECT_EQ(path.at("pose"), last);
    EXPECT_EQ(path.at("branch").get<std::string>().empty(), std::string(model) == "panda");
    EXPECT_LT(
        (sandbox.state().toWindow(sandbox.session().frames()[tool] * point).pixel - (from + Vector2d(-4, 44)))
            .norm(),
        2.0);
  }
}

/// The line was drawn to its end before the reason came; now the tool is grey, and the mouse drags the body.
TEST(PathPanel, AModelWithoutASerialChainKeepsTheMouse) {
  for (const char* model : {"figure", "ur5"}) {
    testing::Stage stage({.model = model, .width = 900, .height = 640});
    stage.play("0 tab Path\n1 do Path draw on\n", 3);
    const auto& panels = stage.sandbox.state().panels;
    const bool takes =
        std::ranges::any_of(panels, [&](const auto& p) { return p->takesMouse(stage.sandbox); });
    EXPECT_EQ(takes, std::string(model) == "ur5") << model;
  }
}

TEST(PathPanel, WhatCannotBeFollowedIsSaid) {
  Stage stage({.model = "ur5", .width = 800, .height = 480});
  stage.frame();
  Sandbox& sandbox = stage.sandbox;
  const Goal& goal = sandbox.session().goals().front().goal;
  stage.play("0 tab Path\n1 do Path draw on", 3);
  const Vector2d from =
      sandbox.state().toWindow(sandbox.session().frames()[goal.joint] * goal.pointInJoint).pixel;
  const Eigen::VectorXd q = sandbox.session().q();
  stage.play(fmt::format("0 move {:.1f} {:.1f}\n1 press left\n2 shift-by 0 -2000 20\n24 release left",
                         from.x(), from.y()),
             10);
  EXPECT_NE(pathOf(sandbox).at("reason").get<std::string>().find("no joint angles"), std::string::npos);
  EXPECT_EQ((sandbox.session().q() - q).norm(), 0.0);
}

}  // namespace
}  // namespace gelenk
