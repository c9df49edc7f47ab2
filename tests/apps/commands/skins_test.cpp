#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "apps/commands/command_line.h"
#include "apps/commands/commands.h"
#include "apps/commands/skins_report.h"
#include "skinning/blend/skin_measures.h"

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
  EXPECT_GE(cell(comparison, "cor+twist+smooth", "elbow 90").section, 0.905);
  EXPECT_LE(cell(comparison, "lbs", "hip 120").volume, -0.3);
  EXPECT_GE(cell(comparison, "cor+twist+smooth", "hip 120").volume, -0.2);
  for (const SkinCell& c : comparison.cells) {
    // Triangles of 10 mm have no better normals themselves, least of all where a section collapses; cheap
    // ones are degrees off.
    EXPECT_LE(c.normalMean, 0.7) << c.method << ", " << c.pose;
    EXPECT_LE(c.normalMost, c.method == "lbs" ? 2.7 : 1.5) << c.method << ", " << c.pose;
  }
  const std::string csv = toCsv(comparison.cells);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 7);
}

TEST(Skins, WhatWasNotMeasuredIsAnEmptyCell) {
  SkinCost cost{.method = "lbs", .prepareSeconds = 0.25, .bytes = 12};
  const auto row = [&] {
    const std::string csv = toCsv(std::vector{cost});
    return csv.substr(csv.find('\n') + 1);
  };
  EXPECT_EQ(row(), "lbs,0.250,,,,12,\n");
  cost.timesLbs = 1.5;
  cost.timesLbsCheap = 1.25;
  cost.nanoseconds = 3.0;
  EXPECT_EQ(row(), "lbs,0.250,1.50,1.25,3.00,12,\n");  // no forearm
  cost.largestStep = 0.0;
  EXPECT_EQ(row(), "lbs,0.250,1.50,1.25,3.00,12,0.000\n");
}

TEST(Skins, EachMethodIsComparedOnce) {
  const auto error = [](const std::string& methods) -> std::string {
    CommandLine line("", "");
    Command program = line.root();
    addCommands(program);
    try {
      line.parse({"skins", "figure", "--method", methods, "--out", "/dev/null/nowhere"});
    } catch (const std::exception& problem) {
      return problem.what();
    }
    return "";
  };
  for (const auto& [methods, said] : {std::pair{"lbs,cor,lbs", "'lbs' and 'lbs' are both lbs"},
                                      {"lbs+smooth=0,lbs", "'lbs+smooth=0' and 'lbs' are both lbs"},
                                      {"cor+smooth+twist,cor+twist+smooth=45", "are both cor+twist+smooth"},
                                      {"lbs,lbs+twist", "cannot make the folder"}})  // taken
    EXPECT_NE(error(methods).find(said), std::string::npos) << methods << ": " << error(methods);
}

TEST(Skins, CentresOfRotationThatGoUpKeepARaisedShouldersVolume) {
  const Model figure = openModel("figure");
  const SkinTrials trials = onlyPoses(standardTrials(figure), {"shoulder up", "shoulder cross", "elbow 90"});
  ASSERT_EQ(trials.poses.size(), 3u);
  const Frames bound = bindFrames(figure);
  PreparedSkin with = prepareSkin(*figure.skin, parseSkinChoice("cor+twist+smooth"), figure.skeleton, bound);
  PreparedSkin without = prepareSkin(with.skin, skinMethodNamed("cor"), with.spread);
  std::map<std::string, std::pair<double, double>> change;  // of the ball of 0.2 m, with and without
  for (const SkinPoseCase& pose : trials.poses) {
    const PartVolume ball(figure.skin->mesh, pose.centre, 0.2);
    const auto volume = [&](const PreparedSkin& skin) {
      return ball.volume(blendSkin(skin, pose.frames).positions) / ball.volume(figure.skin->mesh.positions) -
             1;
    };
    change[pose.name] = {volume(with), volume(without)};
  }
  EXPECT_GT(change["shoulder up"].second, 0.09);
  EXPECT_LT(change["shoulder up"].first, 0.05);
  EXPECT_NEAR(change["shoulder cross"].first, change["shoulder cross"].second, 0.01);
  EXPECT_NEAR(change["elbow 90"].first, change["elbow 90"].second, 1e-3);
  // Slopes of the centres are the lifted ones': normals stay those of the skin.
  const SkinComparison comparison =
      compareSkins(figure, {parseSkinChoice("cor+twist+smooth")}, onlyPoses(trials, {"shoulder up"}), false,
                   false, [](double, const std::string&) {});
  EXPECT_LE(comparison.cells[0].normalMean, 0.7);
}

}  // namespace
}  // namespace gelenk
