#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "kinematics/forward_kinematics.h"
#include "kinematics/io/text_file.h"
#include "kinematics/notation/robots.h"
#include "solvers/serial/serial_chain.h"
#include "tests/places.h"
#include "tests/sandbox/program.h"

namespace gelenk {
namespace {

using nlohmann::json;
using testing::Finished;

Finished solutions(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {testing::programFile(), "solutions"});
  return testing::runProgram(arguments);
}

const std::vector<std::string> pandaTarget = {"--model", "panda", "--target", "0.4", "0.1",
                                              "0.5",     "0",     "1",        "0",   "0"};

std::vector<std::string> with(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

TEST(SolutionsCommand, SevenJointsGiveCurvesInOrderThatReachThePose) {
  const Finished done = solutions(with(pandaTarget, {"--json"}));
  ASSERT_EQ(done.status, 0) << done.output;
  const json told = json::parse(done.output);
  const Skeleton panda = toSkeleton(robotTable("panda"));
  const int tip = panda.jointCount() - 1;
  const SerialChain chain = extractSerialChain(panda, tip).chain;
  const Eigen::Vector3d target(0.4, 0.1, 0.5);
  ASSERT_GT(told["curves"].size(), 0u);
  double nearest = INFINITY;
  for (const json& curve : told["curves"]) {
    ASSERT_EQ(curve["q"].size(), curve["arc_length"].size());
    for (size_t k = 0; k < curve["q"].size(); ++k) {
      const auto values = curve["q"][k].get<std::vector<double>>();
      const Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(values.data(), 7);
      const Frames frames = forwardKinematics(panda, q);
      EXPECT_LT((frames[tip].translation() - target).norm(), 1e-9);
      EXPECT_LT((frames[tip].linear() - Eigen::Vector3d(1, -1, -1).asDiagonal().toDenseMatrix()).norm(),
                1e-8);
      for (int i = 0; i < 7; ++i) {
        EXPECT_GE(q[i], chain.lower[i] - 1e-9);
        EXPECT_LE(q[i], chain.upper[i] + 1e-9);
      }
      nearest = std::min(nearest, (q - panda.rest()).norm());
      if (k > 0) EXPECT_GT(curve["arc_length"][k], curve["arc_length"][k - 1]);
    }
  }
  // The nearest of all solutions is no farther than the chains' poses, and lies between two of them.
  EXPECT_LE(told["nearest"]["distance"].get<double>(), nearest + 1e-9);
  EXPECT_GT(told["nearest"]["distance"].get<double>(), nearest - 0.04);
  EXPECT_LT(told["nearest"]["position_error"].get<double>(), 1e-9);
}

TEST(SolutionsCommand, CurvesAreWrittenAsATable) {
  const std::string file = ::testing::TempDir() + "curves.csv";
  const Finished done = solutions(with(pandaTarget, {"--json", "-o", file}));
  ASSERT_EQ(done.status, 0) << done.output;
  size_t poses = 0;
  const json told = json::parse(done.output);
  for (const json& curve : told["curves"]) poses += curve["q"].size();
  const std::string table = readFile(file);
  EXPECT_EQ(table.substr(0, table.find('\n')), "curve,arc_length,q1,q2,q3,q4,q5,q6,q7");
  EXPECT_EQ(static_cast<size_t>(std::count(table.begin(), table.end(), '\n')), poses + 1);
}

TEST(SolutionsCommand, WhatCannotBeReachedIsToldWithTheClosestPose) {
  for (const char* model : {"panda", "ur5"}) {
    const Finished done = solutions({"--model", model, "--target", "3", "0", "0", "1", "0", "0", "0"});
    EXPECT_EQ(done.status, 2);
    EXPECT_NE(done.output.find("not reachable"), std::string::npos) << done.output;
    EXPECT_NE(done.output.find("closest: q = ("), std::string::npos) << done.output;
  }
}

TEST(SolutionsCommand, OptionsThatHaveNoMeaningAreRefused) {
  const Finished done =
      solutions({"--model", "ur5", "--target", "0.4", "0.1", "0.5", "0", "1", "0", "0", "-o", "curves.csv"});
  EXPECT_EQ(done.status, 1);
  EXPECT_NE(done.output.find("-o writes the curves of an arm of seven joints"), std::string::npos)
      << done.output;
  const Finished place = solutions({"--model", "panda", "--target", "0.4", "0.1", "0.5"});
  EXPECT_EQ(place.status, 1);
  EXPECT_NE(place.output.find("7 joints for 3 conditions"), std::string::npos) << place.output;
}

}  // namespace
}  // namespace gelenk
