// How often the pose that made a target is missing from its complete set. In the suite a few thousand
// targets; GELENK_RECALL=1000000 makes that many for each arm, and as many of 1,000 random arms: the table of
// docs/solutions.md.
#include "tests/solvers/solutions/recall.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace gelenk {
namespace {

using testing::Recall;

int targets() {
  const char* wanted = std::getenv("GELENK_RECALL");
  return wanted ? std::atoi(wanted) : 2000;
}

void expectAsFewMissesAsAsked(const std::string& arm, const Recall& r) {
  std::printf("| %s | %d | %d | %d | %d | %.1e |\n", arm.c_str(), r.targets, r.missed, r.missedSingular,
              r.incomplete, r.worst);
  std::fflush(stdout);
  EXPECT_LE(r.missed, r.targets / 1000000) << arm;
  EXPECT_LE(r.missedSingular, r.targets / 10000) << arm;
  EXPECT_LE(r.incomplete, r.targets / 100) << arm;
  EXPECT_LT(r.worst, 1e-9) << arm;  // metres and sines
}

class RecallOf : public ::testing::TestWithParam<const char*> {};

TEST_P(RecallOf, ThePoseThatMadeTheTargetIsInTheSet) {
  const std::string name = GetParam();
  const bool table = name == "ur5" || name == "puma560";
  const SixJointArm arm(testing::chainOf(table ? robotTable(name) : testing::generalArm(name)));
  expectAsFewMissesAsAsked(name, testing::recall(arm, targets(), 2026));
}

INSTANTIATE_TEST_SUITE_P(Arms, RecallOf, ::testing::Values("ur5", "puma560", "jaco2", "xarm6", "crx10ia"));

TEST(Recall, OfRandomArms) {
  std::mt19937_64 random(2027);
  const int arms = std::min(1000, targets() / 100);
  Recall all;
  for (int k = 0; k < arms; ++k) {
    const SixJointArm arm(testing::chainOf(testing::randomArm(random)));
    all += testing::recall(arm, targets() / arms, random());
  }
  expectAsFewMissesAsAsked(std::to_string(arms) + " random arms", all);
}

}  // namespace
}  // namespace gelenk
