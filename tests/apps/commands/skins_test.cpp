#include <gtest/gtest.h>

#include <algorithm>

#include "apps/commands/skins_report.h"

namespace gelenk {
namespace {

SkinTrials onlyPoses(SkinTrials trials, const std::vector<std::string>& names) {
  std::erase_if(trials.poses,
                [&](const SkinPoseCase& pose) { return std::ranges::count(names, pose.name) == 0; });
  return trials;
}

const SkinCell& cell(const SkinComparison& comparison, const std::string& method, const std::string& pose) {
  for (const SkinCell& c : comparison.cells)
    if (c.method == method && c.pose == pose) return c;
  throw std::out_of_range(method + ", " + pose);
}

TEST(Skins, StandardPosesOfTheFigureAreThirtyOne) {
  const Model figure = openModel("figure");
  EXPECT_EQ(standardTrials(figure).poses.size(), 31u);
  EXPECT_TRUE(standardTrials(openModel("planar")).poses.empty());
}

TEST(Skins, TheTableShowsWhatEachMethodIsFor) {
  const Model figure = openModel("figure");
  const SkinTrials trials = onlyPoses(standardTrials(figure), {"forearm twist 170", "elbow 90", "hip 120"});
  ASSERT_EQ(trials.poses.size(), 3u);
  std::vector<SkinChoice> methods;
  for (const char* name : {"lbs", "cor+twist+smooth"}) methods.push_back(parseSkinChoice(name));
  const SkinComparison comparison =
      compareSkins(figure, methods, trials, false, false, [](double, const std::string&) {});
  ASSERT_EQ(comparison.cells.size(), 6u);
  // The candy wrapper, and none.
  EXPECT_LE(cell(comparison, "lbs", "forearm twist 170").section, 0.3);
  EXPECT_GE(cell(comparison, "cor+twist+smooth", "forearm twist 170").section, 0.99);
  EXPECT_LE(cell(comparison, "cor+twist+smooth", "forearm twist 170").crease, 7.0);
  EXPECT_EQ(cell(comparison, "cor+twist+smooth", "elbow 90").pairs, 0);
  EXPECT_GE(cell(comparison, "cor+twist+smooth", "elbow 90").section, 0.91);
  EXPECT_LE(cell(comparison, "lbs", "hip 120").volume, -0.3);
  EXPECT_GE(cell(comparison, "cor+twist+smooth", "hip 120").volume, -0.2);
  for (const SkinCell& c : comparison.cells) {
    // Triangles of 16 mm have no better normals themselves; cheap ones are degrees off.
    EXPECT_LE(c.normalMean, 0.7) << c.method << ", " << c.pose;
    EXPECT_LE(c.normalMost, 2.0) << c.method << ", " << c.pose;
  }
  const std::string csv = toCsv(comparison.cells);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 7);
}

}  // namespace
}  // namespace gelenk
