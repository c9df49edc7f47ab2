// Pictures that explain an arm, against what they claim.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "apps/render/scene_view.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/jacobian.h"
#include "tests/sandbox/stage.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

Session sessionOf(const std::string& name, std::initializer_list<const char*> shown) {
  auto model = std::make_shared<const Model>(openModel(name));
  Session session(model, ModelReference{.nameOrFile = name});
  for (const char* option : shown) session.view().show.*viewOption(option) = true;
  return session;
}

struct Drawn {
  TeachingPictures pictures;
  Overlay inScene, onTop;
  std::vector<Ghost> ghosts;
  void draw(const Session& session, bool whole = true) {
    inScene.clear(), onTop.clear(), ghosts.clear();
    pictures.add(session, session.frames(),
                 {.size = 1.0, .colours = &markColours(Theme::Light), .selected = {}, .whole = whole},
                 inScene, onTop, ghosts);
  }
};

TEST(TeachingPictures, EveryOtherSolutionPutsTheToolInTheSamePlace) {
  for (const char* name : {"ur5", "puma560"}) {
    const Session session = sessionOf(name, {"solutions"});
    Drawn drawn;
    drawn.draw(session);
    EXPECT_GE(drawn.pictures.solutions().size(), 1u) << name;  // the PUMA's limits leave two of eight
    EXPECT_EQ(drawn.ghosts.size(), drawn.pictures.solutions().size());
    const int tool = session.goals().front().goal.joint;
    for (const VectorXd& q : drawn.pictures.solutions()) {
      const Frames frames = forwardKinematics(session.skeleton(), q);
      EXPECT_LT((frames[tool].matrix() - session.frames()[tool].matrix()).cwiseAbs().maxCoeff(), 1e-8)
          << name;
      EXPECT_GT((q - session.q()).norm(), 1e-3);
    }
  }
}

TEST(TeachingPictures, TheSelfMotionLeavesTheToolWhereItIs) {
  Session session = sessionOf("panda", {"null_space"});
  Drawn drawn;
  drawn.draw(session);
  ASSERT_GT(drawn.pictures.selfMotion().size(), 20u);
  const int tool = session.goals().front().goal.joint;
  double farthest = 0.0;
  for (const VectorXd& q : drawn.pictures.selfMotion()) {
    const Frames frames = forwardKinematics(session.skeleton(), q);
    EXPECT_LT((frames[tool].matrix() - session.frames()[tool].matrix()).cwiseAbs().maxCoeff(), 1e-6);
    farthest = std::max(farthest, (q - session.q()).norm());
  }
  EXPECT_GT(farthest, 0.5);
  // Along it nothing changes but where the arm stands on it.
  const std::size_t count = drawn.pictures.selfMotion().size();
  const int at = static_cast<int>(count) / 3;
  session.setPose(VectorXd(drawn.pictures.selfMotion()[at]));
  drawn.draw(session);
  EXPECT_EQ(drawn.pictures.selfMotion().size(), count);
  EXPECT_NEAR(drawn.pictures.selfMotionAt(), at, 1);
}

TEST(TeachingPictures, TheVelocityEllipsoidIsWhereUnitJointSpeedsLead) {
  const Session session = sessionOf("panda", {"velocity_ellipsoid"});
  Drawn drawn;
  drawn.draw(session);
  const SceneGoal& goal = session.goals().front();
  const Vector3d centre = session.reached(goal.id);
  const Eigen::Matrix3Xd J = pointJacobian(session.skeleton(), session.q(), session.frames(), goal.goal.joint,
                                           goal.goal.pointInJoint);
  const Eigen::Matrix3d inverse = (J * J.transpose()).inverse();
  ASSERT_FALSE(drawn.onTop.lines.empty());
  int onSurface = 0;
  for (const Overlay::Line& line : drawn.onTop.lines) {
    const Vector3d p = (Eigen::Map<const Eigen::Vector3f>(line.a.position).cast<double>() - centre) / 0.2;
    const double level = p.dot(inverse * p);  // 1 on {J dq : |dq| = 1}
    EXPECT_LT(level, 1.0 + 1e-3);
    onSurface += std::abs(level - 1.0) < 1e-3;
  }
  EXPECT_GT(onSurface, 150);
}

TEST(TeachingPictures, TheConvergenceMapAgreesWithWhatCanBeReached) {
  Session session = sessionOf("planar", {"convergence"});
  session.setSolver("exact-hessian");
  Drawn drawn;
  drawn.draw(session);
  const ConvergenceMap& map = drawn.pictures.map();
  ASSERT_EQ(map.rows.size(), static_cast<std::size_t>(map.cells * map.cells));
  EXPECT_FALSE(drawn.pictures.isWorking());
  // Two equal links about the origin: all within l1 + l2 can be reached, nothing beyond.
  double reach = 0.0;
  for (int j = 1; j < session.skeleton().jointCount(); ++j)
    reach += session.skeleton().joint(j).parentFromZero.translation().norm();
  const Vector3d base = map.corner + 0.5 * (map.u + map.v);
  int within = 0, reachedWithin = 0;
  for (int y = 0; y < map.cells; ++y)
    for (int x = 0; x < map.cells; ++x) {
      const Vector3d p = map.corner + (x + 0.5) / map.cells * map.u + (y + 0.5) / map.cells * map.v;
      const double distance = (p - base).head<2>().norm();
      const ConvergenceMap::Cell& cell = map.rows[y * map.cells + x];
      EXPECT_TRUE(cell.solved);
      EXPECT_FALSE(distance > 1.01 * reach && cell.reached) << p.transpose();
      if (distance < 0.95 * reach && distance > 0.1 * reach) ++within, reachedWithin += cell.reached;
    }
  EXPECT_GT(reachedWithin, 0.9 * within);
}

TEST(TeachingPictures, TheMapIsCoarseFirstAndTheSameInTheEnd) {
  const Session session = sessionOf("planar", {"convergence"});
  Drawn once, bit;
  once.draw(session);
  int frames = 0;
  do bit.draw(session, false);
  while (bit.pictures.isWorking() && ++frames < 200);
  EXPECT_GT(frames, 5);
  EXPECT_EQ(once.inScene.fills.size(), bit.inScene.fills.size());
  for (std::size_t i = 0; i < once.pictures.map().rows.size(); ++i)
    EXPECT_EQ(once.pictures.map().rows[i].iterations, bit.pictures.map().rows[i].iterations);
}

/// What the legend says of the map is what is drawn: three kinds of cells, their shares, their colours.
TEST(TeachingPictures, TheMapsLegendHasItsColoursAndShares) {
  Session session = sessionOf("planar", {"convergence"});
  session.setPose(VectorXd::Constant(session.q().size(), 0.5));  // bent: there is another way
  Drawn drawn;
  drawn.draw(session);
  const ConvergenceMap& map = drawn.pictures.map();
  double same = 0, other = 0, missed = 0;
  for (const ConvergenceMap::Cell& cell : map.rows)
    (!cell.reached ? missed : cell.otherBranch ? other : same) += 1;
  const double all = static_cast<double>(map.rows.size());
  const ConvergenceMap::Shares shares = map.shares();
  EXPECT_DOUBLE_EQ(shares.sameBranch, same / all);
  EXPECT_DOUBLE_EQ(shares.otherBranch, other / all);
  EXPECT_DOUBLE_EQ(shares.notReached, missed / all);
  EXPECT_GT(std::min({same, other, missed}), 0.02 * all);  // all three are there

  using Seen = Eigen::Vector4f;
  const auto seen = [](const Colour& c) { return Seen(c.r, c.g, c.b, c.a); };
  ASSERT_EQ(drawn.inScene.fills.size(), 6 * map.rows.size());  // two triangles a cell
  for (std::size_t i = 0; i < map.rows.size(); ++i)
    EXPECT_LT((seen(drawn.inScene.fills[6 * i].colour) - seen(map.colour(map.rows[i]))).norm(), 1e-6) << i;
  // The ends of the legend's scales are those of the cells, and no two kinds look alike.
  for (const bool otherBranch : {false, true}) {
    const auto of = [&](int iterations) {
      return seen(map.colour(
          {.solved = true, .reached = true, .otherBranch = otherBranch, .iterations = iterations}));
    };
    EXPECT_EQ(of(map.fewestIterations), seen(ConvergenceMap::reachedColour(0.0, otherBranch)));
    EXPECT_EQ(of(map.mostIterations), seen(ConvergenceMap::reachedColour(1.0, otherBranch)));
    const auto apart = [&](const Colour& a, const Colour& b) { return (seen(a) - seen(b)).head<3>().norm(); };
    for (double t = 0.0; t <= 1.0; t += 0.02) {
      EXPECT_GT(apart(ConvergenceMap::reachedColour(t, otherBranch), ConvergenceMap::notReachedColour()),
                0.2f)
          << t;
      for (double u = 0.0; u <= 1.0; u += 0.02)
        EXPECT_GT(apart(ConvergenceMap::reachedColour(t, otherBranch),
                        ConvergenceMap::reachedColour(u, !otherBranch)),
                  0.2f)
            << t << " " << u;
    }
  }
}

TEST(TeachingPictures, WhatCannotBeDrawnSaysWhy) {
  const Session session = sessionOf("figure", {"solutions", "null_space", "convergence"});
  Drawn drawn;
  drawn.draw(session);
  EXPECT_EQ(drawn.pictures.reasons().size(), 3u);
  EXPECT_TRUE(drawn.ghosts.empty());
}

/// What the tab shows grey is what would not be drawn, and nothing else.
TEST(TeachingPictures, WhetherAModelHasThemIsKnownBeforehand) {
  for (const char* model : {"figure", "planar", "ur5", "panda", "scara"}) {
    constexpr const char* names[] = {"solutions", "null_space", "convergence"};
    const Session session = sessionOf(model, {});
    const auto at = TeachingPictures::effectorOf(session, {});
    ASSERT_TRUE(at) << model;
    const std::string whys[] = {TeachingPictures::whyNoSolutions(session.skeleton(), *at),
                                TeachingPictures::whyNoSelfMotion(session.skeleton(), *at),
                                TeachingPictures::whyNoMap(session.skeleton(), *at)};
    for (std::size_t i = 0; i < std::size(names); ++i) {
      const Session one = sessionOf(model, {names[i]});
      Drawn drawn;
      drawn.draw(one);
      EXPECT_EQ(drawn.pictures.reasons().empty(), whys[i].empty()) << model << " " << names[i];
    }
  }
}

TEST(TeachingPictures, ReachStaysWithinTheArmsLength) {
  const Session session = sessionOf("ur5", {"reachable"});
  Drawn drawn;
  drawn.draw(session);
  EXPECT_EQ(drawn.inScene.points.size(), 5000u);
  double length = 0.0;
  for (int j = 0; j < session.skeleton().jointCount(); ++j)
    length += session.skeleton().joint(j).parentFromZero.translation().norm();
  for (const Overlay::Point& point : drawn.inScene.points)
    EXPECT_LT(Eigen::Map<const Eigen::Vector3f>(point.at.position).norm(), length + 1e-5);
}

// ---- taking one of them

struct Stage : testing::Stage {
  explicit Stage(const std::string& model) : testing::Stage({.model = model, .width = 800, .height = 600}) {
    sandbox.session().view().show.solutions = true;
    play("0 move 5 5\n");
  }
  void play(const std::string& script) { testing::Stage::play(script, 1); }
  const TeachingPictures& pictures() { return sandbox.state().view->teaching(); }
};

/// Whole turns left out.
double apart(const VectorXd& a, const VectorXd& b) {
  double most = 0.0;
  for (Eigen::Index i = 0; i < a.size(); ++i)
    most = std::max(most, std::abs(std::remainder(a[i] - b[i], 2.0 * M_PI)));
  return most;
}

TEST(Branches, TheKeyGoesThroughAllOfThemAndComesBack) {
  Stage stage("puma560");
  const VectorXd start = stage.sandbox.session().q();
  const std::size_t count = stage.pictures().solutions().size();
  ASSERT_GE(count, 1u);
  std::vector<VectorXd> met{start};
  for (std::size_t k = 0; k < count; ++k) {
    stage.play("0 key n\n");
    for (const VectorXd& q : met) EXPECT_GT(apart(stage.sandbox.session().q(), q), 1e-2) << k;
    met.push_back(stage.sandbox.session().q());
  }
  stage.play("0 key n\n");
  EXPECT_LT(apart(stage.sandbox.session().q(), start), 1e-4);
  stage.play("0 keydown shift\n1 key n\n2 keyup shift\n");
  EXPECT_LT(apart(stage.sandbox.session().q(), met[count]), 1e-4);
  stage.play("0 keydown ctrl\n1 key z\n2 keyup ctrl\n");  // a step is one entry of the history
  EXPECT_LT(apart(stage.sandbox.session().q(), start), 1e-4);
}

TEST(Branches, TheKeyGoesAlongTheCurveOfASevenJointArm) {
  Stage stage("panda");
  stage.sandbox.session().view().show.nullSpace = true;
  stage.play("0 move 5 5\n");
  const int tool = stage.sandbox.session().goals().front().goal.joint;
  const Eigen::Matrix4d pose = stage.sandbox.session().frames()[tool].matrix();
  const VectorXd start = stage.sandbox.session().q();
  stage.play("0 key n\n");
  EXPECT_GT((stage.sandbox.session().q() - start).norm(), 1e-2);
  EXPECT_LT((stage.sandbox.session().frames()[tool].matrix() - pose).cwiseAbs().maxCoeff(), 1e-6);
}

/// Elbows of ghosts that stand well beside the arm itself.
TEST(Branches, AClickOnAGhostTakesIt) {
  Stage stage("ur5");
  Sandbox::State& s = stage.sandbox.state();
  const Skeleton& skeleton = stage.sandbox.session().skeleton();
  const std::vector<VectorXd> solutions = stage.pictures().solutions();
  const VectorXd start = stage.sandbox.session().q();
  const Frames own = stage.sandbox.session().frames();
  const auto click = [&](const Eigen::Vector2d& at) {
    stage.play("0 move " + std::to_string(at.x()) + " " + std::to_string(at.y()) +
               "\n1 press left\n2 release left\n");
  };
  const auto besideTheArm = [&](const Eigen::Vector2d& pixel) {
    for (int j = 1; j < skeleton.jointCount(); ++j)
      for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const Vector3d on = (1.0 - share) * own[j - 1].translation() + share * own[j].translation();
        if ((s.toWindow(on).pixel - pixel).norm() < 60.0) return false;
      }
    return true;
  };
  int tried = 0;
  for (const VectorXd& q : solutions) {
    const Frames frames = forwardKinematics(skeleton, q);
    for (int j = 1; j < skeleton.jointCount() && tried < 1; ++j) {
      const Eigen::Vector2d pixel = s.toWindow(frames[j].translation()).pixel;
      if (!besideTheArm(pixel)) continue;
      ++tried;
      click(pixel);
      const VectorXd now = stage.sandbox.session().q();
      EXPECT_GT((now - start).norm(), 0.1);
      EXPECT_TRUE(std::ranges::any_of(solutions, [&](const VectorXd& x) { return (x - now).norm() < 1e-9; }));
      stage.play("0 keydown ctrl\n1 key z\n2 keyup ctrl\n");
      EXPECT_LT((stage.sandbox.session().q() - start).norm(), 1e-9);
      break;
    }
  }
  EXPECT_EQ(tried, 1);
  click({20, 60});  // where there is none nothing is taken
  EXPECT_LT((stage.sandbox.session().q() - start).norm(), 1e-9);
}

}  // namespace
}  // namespace gelenk
