#include <gtest/gtest.h>

#include <set>

#include "apps/lecture/derivations.h"
#include "apps/lecture/example.h"
#include "apps/lecture/leg_animation.h"
#include "apps/lecture/slide_data.h"
#include "apps/lecture/text.h"
#include "apps/lecture/text_table.h"
#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/notation/mannequin.h"

namespace gelenk {
namespace {

struct NamedCheck {
  std::string id;
  LectureCheck check;
};

std::vector<NamedCheck> allChecks() {
  std::vector<NamedCheck> checks;
  for (const LectureTopic& topic : lectureTopics())
    for (const LectureCheck& check : topic.checks) checks.push_back({check.id, check});
  return checks;
}

void PrintTo(const NamedCheck& check, std::ostream* out) { *out << check.id; }

class Lecture : public ::testing::TestWithParam<NamedCheck> {};

TEST_P(Lecture, AgreesToThePrintedDigit) {
  const LectureVerdict verdict = evaluate(GetParam().check);
  std::string computed;
  for (const double value : verdict.computed) computed += " " + std::to_string(value);
  EXPECT_TRUE(verdict.ok) << GetParam().check.what << ": computed" << computed << ", off by "
                          << verdict.difference;
}

INSTANTIATE_TEST_SUITE_P(Slides, Lecture, ::testing::ValuesIn(allChecks()), [](const auto& info) {
  std::string name = info.param.id;
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
});

TEST(LectureList, HasUniqueNamesSectionsAndOneToleranceAValueOrOneForAll) {
  std::set<std::string> ids;
  for (const LectureTopic& topic : lectureTopics()) {
    EXPECT_TRUE(ids.insert(topic.id).second) << topic.id;
    EXPECT_FALSE(topic.steps().empty());
    for (const LectureCheck& check : topic.checks) {
      EXPECT_TRUE(ids.insert(check.id).second) << check.id;
      EXPECT_FALSE(check.section.empty());
      EXPECT_TRUE(check.tolerance.size() == 1 || check.tolerance.size() == check.printed.size()) << check.id;
      EXPECT_EQ(&findLectureTopic(check.id), &topic);
    }
  }
  EXPECT_THROW(findLectureTopic("no-such-example"), std::invalid_argument);
}

TEST(LectureList, AValueOffByMoreThanHalfADigitIsNoticed) {
  LectureCheck check{
      .id = "probe", .section = "none", .what = "", .printed = {0.295}, .tolerance = {5e-4}, .compute = [] {
        return std::vector{0.2955};
      }};
  EXPECT_TRUE(evaluate(check).ok);  // half a digit is allowed
  check.compute = [] { return std::vector{0.29551}; };
  EXPECT_FALSE(evaluate(check).ok);
  check.compute = [] { return std::vector{std::nan("")}; };
  EXPECT_FALSE(evaluate(check).ok);
  check.compute = [] { return std::vector<double>{}; };
  EXPECT_FALSE(evaluate(check).ok);
}

TEST(LegAnimation, KeysAreMetAndTheCurveIsContinuousAroundTheCycle) {
  const LegKeys keys = lectureLegKeys();
  for (const auto* curve : {&keys.hip, &keys.knee, &keys.foot}) {
    for (const LegKey& key : *curve)
      EXPECT_NEAR(keyedAngle(*curve, key.phase), key.phase < 1.0 ? key.degrees : curve->front().degrees,
                  1e-9);
    EXPECT_NEAR(keyedAngle(*curve, 1.0 - 1e-9), keyedAngle(*curve, 0.0), 1e-5);
  }
}

TEST(LegAnimation, PinnedFeetKeepTheLimitsAndTheRestOfTheBody) {
  const Skeleton figure = mannequin();
  const LegAnimation keyed = keyframedLegs(figure, lectureLegKeys(), 1);
  const LegAnimation pinned = pinFeet(figure, keyed);
  ASSERT_EQ(keyed.q.size(), pinned.q.size());
  const int head = figure.jointIndex("head");
  for (std::size_t f = 0; f < keyed.q.size(); ++f) {
    EXPECT_LE(limitViolation(figure, pinned.q[f]), 1e-12);
    EXPECT_LE((forwardKinematics(figure, keyed.q[f])[head].matrix() -
               forwardKinematics(figure, pinned.q[f])[head].matrix())
                  .norm(),
              1e-12);
  }
}

TEST(Derivations, FollowTheValuesTheyAreGiven) {
  const PlanarChain chain{.base = {1.0, 2.0}, .lengths = {1.5, 0.5, 0.25}};
  const Eigen::Vector3d phi(0.3, -1.2, 2.5);
  const Eigen::Vector2d end = chain.base + 1.5 * Eigen::Vector2d(std::cos(0.3), std::sin(0.3)) +
                              0.5 * Eigen::Vector2d(std::cos(-0.9), std::sin(-0.9)) +
                              0.25 * Eigen::Vector2d(std::cos(1.6), std::sin(1.6));
  EXPECT_NE(forwardDerivation(chain, phi).find("X = K_3 (l_3, 0) = " + text::point(end, 15).substr(0, 12)),
            std::string::npos)
      << forwardDerivation(chain, phi);
  const NewtonRun run =
      newton([&](const Eigen::VectorXd& p) -> Eigen::VectorXd { return endEffector(chain, p); },
             [&](const Eigen::VectorXd& p) -> Eigen::MatrixXd { return jacobian(chain, p); }, phi,
             Eigen::Vector2d(2.0, 3.0), 1e-12, 50);
  const std::string newton = newtonDerivation(chain, {2.0, 3.0}, run, 0);
  EXPECT_NE(newton.find("f(phi^0) = " + text::point(end)), std::string::npos) << newton;
  EXPECT_NE(newton.find("X^neu = (2, 3)"), std::string::npos);
  EXPECT_NE(oneDimensionDerivation(0.4, 12.0, 1e-6).find("no zero is found"), std::string::npos);
  EXPECT_NE(oneDimensionDerivation(0.4, 5.0, 1e-6).find("= 30 degrees"), std::string::npos);
}

/// What the lecturer shows: a table says that it is one, and every row has a cell under each head.
TEST(Derivations, TheirTablesAreRectangles) {
  for (const LectureTopic& topic : lectureTopics()) {
    int tables = 0;
    for (const TextPiece& piece : piecesOf(topic.steps())) {
      EXPECT_EQ(piece.line.find("   "), std::string::npos)
          << topic.id << ": " << piece.line;  // padded by hand
      if (piece.kind != TextPiece::Kind::Table) continue;
      ++tables;
      ASSERT_FALSE(piece.table.rows.empty());
      for (const TextTable::Row& row : piece.table.rows)
        EXPECT_TRUE(!piece.table.hasHeads || row.size() == piece.table.rows[0].size()) << topic.id;
    }
    EXPECT_GT(tables, 0) << topic.id;
  }
}

TEST(TextTables, StandInColumnsWithTheirDecimalPointsBelowEachOther) {
  const std::string text = "Given\n" + text::heads({"i", "phi", "", ""}) +
                           text::row({"1", "-60.5", "0.25", "holds"}) +
                           text::row({"10", "120", "-3", "misses"}) + "end\n";
  EXPECT_EQ(padded(text),
            "Given\n"
            "    i   phi\n"
            "   ---------------------------\n"
            "    1   -60.5    0.25   holds\n"
            "   10   120     -3      misses\n"
            "end\n");
  const auto pieces = piecesOf(text);
  ASSERT_EQ(pieces.size(), 3u);
  EXPECT_TRUE(pieces[1].table.hasHeads);
  EXPECT_EQ(headSpan(pieces[1].table, 1), 3u);
  EXPECT_TRUE(isNumber("-1.5e-07"));
  EXPECT_FALSE(isNumber("-"));
  EXPECT_FALSE(isNumber("(1, 2)"));
  EXPECT_FALSE(isNumber("1 and 2"));
}

/// A table that is wider than its room, such as Newton's in a presentation, comes in parts that each say what
/// their rows are; columns under one head stay together, and none is lost.
TEST(TextTables, AreParted) {
  const TextTable table =
      piecesOf(text::heads({"i", "phi", "", "f", "", "|g|"}) + text::row({"0", "1", "2", "3", "4", "5"}))
          .front()
          .table;
  const std::vector<float> widths{1, 4, 4, 4, 4, 3};
  using Parts = std::vector<std::vector<std::size_t>>;
  EXPECT_EQ(partsOf(table, widths, 1, 25), (Parts{{0, 1, 2, 3, 4, 5}}));  // 20 wide and 5 gaps
  EXPECT_EQ(partsOf(table, widths, 1, 24), (Parts{{0, 1, 2, 3, 4}, {0, 5}}));
  EXPECT_EQ(partsOf(table, widths, 1, 15), (Parts{{0, 1, 2}, {0, 3, 4, 5}}));
  EXPECT_EQ(partsOf(table, widths, 1, 2), (Parts{{0, 1, 2}, {0, 3, 4}, {0, 5}}));
  const TextTable second = withColumns(table, {0, 3, 4});
  EXPECT_TRUE(second.hasHeads);
  EXPECT_EQ(second.rows, (std::vector<TextTable::Row>{{"i", "f", ""}, {"0", "3", "4"}}));
  EXPECT_EQ(headSpan(second, 1), 2u);
}

TEST(TextTables, MatricesAndIndentedLinesAreToldApart) {
  const auto pieces = piecesOf("  D =\n    [ 1  -2.5 ]\n    [ 3 4 ]\n\nx\n");
  ASSERT_EQ(pieces.size(), 4u);
  EXPECT_EQ(pieces[0].indent, 2u);
  EXPECT_EQ(pieces[1].kind, TextPiece::Kind::Matrix);
  EXPECT_EQ(pieces[1].table.rows, (std::vector<TextTable::Row>{{"1", "-2.5"}, {"3", "4"}}));
  EXPECT_EQ(text::fixed(-1e-9, 3), "0.000");
  EXPECT_EQ(text::fixed(-0.5, 3), "-0.500");
}

TEST(Derivations, TheTwoLinksSayWhenTheTargetIsOutOfReach) {
  const PlanarChain arm{.base = {0, 0}, .lengths = {10, 4}};
  const std::string outside = twoLinkDerivation(arm, {25.0, 0.0}),
                    inside = twoLinkDerivation(arm, {0.0, 9.0});
  EXPECT_NE(outside.find("out of reach"), std::string::npos) << outside;
  EXPECT_NE(outside.find("nearest"), std::string::npos) << outside;
  EXPECT_EQ(inside.find("out of reach"), std::string::npos) << inside;
  for (const std::string& text : {outside, inside, twoLinkDerivation(arm, {0.0, 0.0})})
    EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

/// One number of every derivation in space, by another route: the frames, the keys.
TEST(Derivations, InSpaceToo) {
  DhTable table{.rows = {{.a = 0.2, .alpha = 0.5, .d = 0.1, .phi = 0.3},
                         {.kind = DhJoint::Prismatic, .a = 0.0, .alpha = -0.7, .d = 0.4, .phi = 0.1}}};
  const Eigen::Vector2d q(0.25, 0.05);
  const std::string dh = dhDerivation(table, q);
  const Frames frames = forwardKinematics(toSkeleton(table), q);
  EXPECT_NE(dh.find(text::matrix(frames.back().matrix(), 6)), std::string::npos) << dh;
  EXPECT_NE(dh.find("\t0.2000\t28.65\t0.1000\t31.51\t"), std::string::npos) << dh;  // phi + q
  EXPECT_NE(dh.find("\t0.0000\t-40.11\t0.4500\t5.73\t"), std::string::npos) << dh;  // d + q

  const Eigen::Vector3d quarter(0.0, 0.0, M_PI / 2), none = Eigen::Vector3d::Zero();
  const std::string turned = rotationsDerivation({quarter, none, none});
  EXPECT_NE(turned.find("quaternions\t0.00000\t2.30000\t0.00000"), std::string::npos)
      << turned;  // all links along y

  const Skeleton figure = mannequin();
  const LegAnimation walk = keyframedLegs(figure, lectureLegKeys());
  const LegKeys keys = lectureLegKeys();
  const std::string leg =
      legDerivation(walk, {FootMeasure{.sliding = 0.25}, FootMeasure{.penetration = 0.5}}, 20);
  const double phase = 20.0 / walk.framesPerSecond / keys.cycle;
  EXPECT_NE(leg.find(fmt::format("knee\t{:.3f}", keyedAngle(keys.knee, phase))), std::string::npos) << leg;
  EXPECT_NE(leg.find("2.500e-01"), std::string::npos) << leg;
  EXPECT_NE(leg.find("5.000e-01"), std::string::npos) << leg;
}

}  // namespace
}  // namespace gelenk
