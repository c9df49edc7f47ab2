#include "skinning/blend/skin_choice.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "kinematics/notation/mannequin.h"
#include "skinning/blend/limb_chains.h"
#include "skinning/blend/skin_measures.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

TEST(SkinChoice, WhatIsWrittenReadsBackTheSame) {
  for (const char* text : {"lbs", "dqs", "cor", "lbs+twist", "cor+twist+smooth", "dqs+smooth=12.5",
                           "ddm-v2+smooth", "lbs+layers", "cor+twist+smooth+layers=muscle"})
    EXPECT_EQ(toString(parseSkinChoice(text)), text);
  const SkinChoice choice = parseSkinChoice("cor+smooth+twist");
  EXPECT_EQ(choice, (SkinChoice{.method = SkinMethodKind::Cor, .twist = true, .smoothing = 0.045}));
}

TEST(SkinChoice, WhatIsWrongIsNamed) {
  for (const auto& [text, named] : {std::pair{"", "lbs"},
                                    {"lbs+", "twist"},
                                    {"lbs+bulge", "bulge"},
                                    {"cor+smooth=", "smooth="},
                                    {"cor+smooth=-3", "200"},
                                    {"cor+smooth=nan", "200"},
                                    {"ddm-v0+twist", "twist"},
                                    {"ddm-v0+layers", "layers"},
                                    {"cor+layers=fat", "layers=fat"},
                                    {"lbs+twist+twist", "'twist' in 'lbs+twist+twist': said for the second"},
                                    {"lbs+smooth=10+smooth=20", "'smooth=20'"},
                                    {"lbs+smooth+twist+smooth", "'smooth'"},
                                    {"cor+layers+layers=muscle", "'layers=muscle'"},
                                    {"COR", "cor"}})
    try {
      parseSkinChoice(text);
      ADD_FAILURE() << "'" << text << "' was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
}

TEST(LimbChains, TheFigureHasTwoArmsAndTwoLegs) {
  const Skeleton figure = mannequin();
  const auto chains = limbChains(figure);
  ASSERT_EQ(chains.size(), 4u);
  EXPECT_EQ(figure.joint(chains[0].joints[0]).name, "upperarm_l");
  EXPECT_EQ(figure.joint(chains[3].joints[2]).name, "foot_r");
  EXPECT_TRUE(limbChains(testing::arm(3, 0.3, 0.05).skeleton).empty());
}

TEST(LimbChains, TheFiguresForearmTwistIsKnownFromItsCoordinateBeyondHalfATurn) {
  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  const auto chains = limbChains(figure);
  const TwistSpread spread = spreadTwist(figure, rest, {chains[0].joints});
  ASSERT_EQ(spread.bones.size(), 2u);
  EXPECT_GE(spread.bones[1].own.index, 0);
  Eigen::VectorXd q = figure.rest();
  q[spread.bones[1].own.index] += spread.bones[1].own.sign * 3.5;
  const Frames frames = forwardKinematics(figure, q);
  std::vector<Eigen::Isometry3d> worldFromRest;
  for (std::size_t i = 0; i < rest.size(); ++i) worldFromRest.push_back(frames[i] * rest[i].inverse());
  EXPECT_NEAR(boneTwists(spread, worldFromRest, &q)[1].atHead, -3.5, 1e-9);
  EXPECT_NEAR(boneTwists(spread, worldFromRest)[1].atHead, 2 * M_PI - 3.5,
              1e-9);  // frames alone: half a turn at most
  EXPECT_NEAR(boneTwists(spread, worldFromRest, &q)[0].atHead, 0.0, 1e-9);
}

TEST(SkinMeasures, ATubesSectionsAreItsPolygonsAndShrinkWithIt) {
  const Skin tube = testing::arm(1, 0.5, 0.04, 20, 24).skin;
  const auto sections = sectionsAlong(tube.mesh, {0, 0, 0}, {0.5, 0, 0}, 9);
  ASSERT_EQ(sections.size(), 9u);
  const double polygon = 0.5 * 24 * std::sin(2 * M_PI / 24) * 0.04 * 0.04;
  for (const SkinSection& section : sections) EXPECT_NEAR(section.restArea, polygon, 1e-9);
  auto positions = tube.mesh.positions;
  for (auto& p : positions)
    if (p.x() > 0.3) p.tail<2>() *= 0.5;
  EXPECT_NEAR(smallestSection(sections, positions), 0.25, 1e-9);
}

TEST(SkinMeasures, APartsVolumeIsThatOfTheCutTubeAndABentEdgeIsACrease) {
  const Skin tube = testing::arm(1, 0.5, 0.04, 50, 24).skin;
  const PartVolume part(tube.mesh, {0.25, 0, 0}, 0.1);
  const double area = 0.5 * 24 * std::sin(2 * M_PI / 24) * 0.04 * 0.04;
  // Rings of 10 mm within sqrt(0.1^2 - 0.04^2) = 91.7 mm of the middle: 18 steps.
  EXPECT_NEAR(part.volume(tube.mesh.positions), 0.18 * area, 1e-9);
  auto triangles = tube.mesh.triangles;
  for (auto& t : triangles)
    if (std::ranges::any_of(t, [&](int v) { return std::abs(tube.mesh.positions[v].x() - 0.2) > 0.105; }))
      t.fill(t[0]);
  EXPECT_NEAR(PartVolume(triangles).volume(tube.mesh.positions), 0.2 * area, 1e-9);

  Mesh roof{.positions = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, -1, 0}},
            .triangles = {{0, 1, 2}, {1, 0, 3}},
            .normals = {}};
  const MeshEdges edges = innerEdges(roof);
  ASSERT_EQ(edges.corners.size(), 1u);
  const auto flat = edgeAngles(edges, roof.positions);
  EXPECT_NEAR(flat[0], 0.0, 1e-12);
  roof.positions[3] = {0.5, 0.0, -1.0};
  const auto bent = edgeAngles(edges, roof.positions);
  EXPECT_NEAR(bent[0], M_PI / 2, 1e-12);  // convex: the sides fall away from their normals
  EXPECT_NEAR(crease(flat, bent), M_PI / 2, 1e-12);
}

}  // namespace
}  // namespace gelenk
