#include "apps/document/binding_scene.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/skinning/muscles/resting_arm.h"

namespace gelenk {
namespace {

std::string messageOf(const std::string& text) {
  try {
    parseBinding(text, 10, testing::arm(0.0));
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(BindingScene, WeightsReadBackToTheLastBit) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  WeightChange change;
  for (int v = 0; v < 200; v += 3) {
    std::vector<std::pair<int, double>> row;
    for (int k = 0; k <= v % 4; ++k) row.emplace_back(k, uniform(random));
    change.emplace_back(v, exactInfluences(row));
  }
  // Weights of another origin, which are no multiples of 2^-30, too.
  change.emplace_back(201, Influences{{2, 1, 0, 0}, {2.0 / 3.0, 1.0 / 3.0, 0, 0}});
  const Skeleton skeleton = testing::arm(0.0);
  const WeightChange again = parseBinding(bindingText(change, 300, skeleton), 300, skeleton);
  ASSERT_EQ(again.size(), change.size());
  for (std::size_t i = 0; i < change.size(); ++i) {
    EXPECT_EQ(again[i].first, change[i].first);
    EXPECT_EQ(again[i].second, change[i].second);
  }
}

TEST(BindingScene, ErrorsNameTheEntry) {
  EXPECT_EQ(messageOf("{"), "binding: no valid JSON");
  EXPECT_EQ(messageOf("{}"), "binding has no entry 'vertices'");
  EXPECT_EQ(messageOf(R"({"vertices": 9, "joints": [], "changed": []})"),
            "binding.vertices: expected the body's 10 vertices, found 9");
  EXPECT_EQ(messageOf(R"({"vertices": 10, "joints": ["elbow", "tail"], "changed": []})"),
            "binding.joints[1]: expected a joint of the model, found \"tail\"");
  const auto row = [](const std::string& rows) {
    return messageOf(R"({"vertices": 10, "joints": ["elbow", "wrist"], "changed": [)" + rows + "]}");
  };
  EXPECT_EQ(row("[3, 0, 0.5, 1, 0.5]"), "accepted");
  EXPECT_EQ(row("[3, 0, 1], [10, 0, 1]"), "binding.changed[1]: expected a vertex from 0 to 9, found 10");
  EXPECT_EQ(row("[3, 0, 1], [3, 0, 1]"), "binding.changed[1]: expected vertices in ascending order, found 3");
  EXPECT_EQ(row("[3, 2, 1]"), "binding.changed[0]: expected an index into the list of 2 joints, found 2");
  EXPECT_EQ(row("[3, 0, -1]"), "binding.changed[0]: expected a weight in (0, 1], found -1");
  EXPECT_EQ(row("[3, 0, 0.5, 1, 0.25]"), "binding.changed[0]: expected weights that sum to 1, found 0.75");
  EXPECT_EQ(row("[3, 0]"),
            "binding.changed[0]: expected a vertex and one to four pairs of joint and weight, found [3,0]");
}

}  // namespace
}  // namespace gelenk
