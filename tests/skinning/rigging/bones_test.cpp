#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinematics/io/pinocchio_skeleton.h"
#include "skinning/bodies/polygonise.h"
#include "skinning/io/obj.h"
#include "skinning/rigging/bone_heat.h"
#include "skinning/winding_number.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;

const std::string inputs = testing::inputFolder() + "/";

/// Joints at places, every one free to turn, the root free to move as well; the last ones are fixed ends
/// where they have no child, as Pinocchio's are.
Skeleton joints(const std::vector<std::pair<int, Vector3d>>& list) {
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const auto& [parent, p] = list[i];
    text += std::to_string(i) + " " + std::to_string(p.x()) + " " + std::to_string(p.y()) + " " +
            std::to_string(p.z()) + " " + std::to_string(parent) + "\n";
  }
  return parsePinocchioSkeleton(text, "test.skel");
}

/// Round bones of that radius between joints, blended into one body. links: (from, to).
Mesh flesh(const std::vector<std::pair<Vector3d, Vector3d>>& links, double radius) {
  std::vector<BodyPart> parts;
  for (const auto& [a, b] : links)
    parts.push_back({.form = BodyPart::Form::RoundCone,
                     .parent = parts.empty() ? -1 : 0,
                     .blend = 0.02,
                     .a = a,
                     .b = b,
                     .radiusA = radius,
                     .radiusB = radius});
  return polygonise(BodyShape(parts), {.cell = radius / 3.0});
}

double weightNear(const Mesh& mesh, const SparseWeights& weights, const Vector3d& place, int joint) {
  std::size_t nearest = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v)
    if ((mesh.positions[v] - place).norm() < (mesh.positions[nearest] - place).norm()) nearest = v;
  double sum = 0.0;
  for (const auto& [j, w] : weights[nearest]) sum += j == joint ? w : 0.0;
  return sum;
}

SparseWeights weightsOf(const Mesh& mesh, const Skeleton& skeleton) {
  return boneHeatWeights(mesh, bonesOf(skeleton, restFrames(skeleton), mesh));
}

TEST(Bones, ATubesFirstBoneCarriesItsOwnSkinWithAndWithoutASecondChildOfTheRoot) {
  const Mesh mesh = readObj(inputs + "tube.obj");
  for (const char* file : {"tube.skel", "tube_with_twig.skel"}) {
    const Skeleton skeleton = readPinocchioSkeleton(inputs + file);
    const SparseWeights weights = weightsOf(mesh, skeleton);
    // An own cotangent heat solve with H = 1 / d^2 gives 0.93 at y = 0.15; with this one's c = 10 the border
    // between the bones at 0.35, two radii away, reaches less far: exp(-sqrt(10) 2) / 2 = 0.0009.
    EXPECT_GT(weightNear(mesh, weights, {0.1, 0.15, 0}, 0), 0.99) << file;
    EXPECT_GT(weightNear(mesh, weights, {0.1, 0.0, 0}, 0), 0.99) << file;
    EXPECT_NEAR(weightNear(mesh, weights, {0.1, 0.35, 0}, 0), 0.5, 0.35) << file;  // a tie, rings 0.05 apart
    EXPECT_GT(weightNear(mesh, weights, {0.1, 0.5, 0}, 1), 0.9) << file;
    EXPECT_GT(weightNear(mesh, weights, {0.1, 0.8, 0}, 2), 0.9) << file;
  }
}

TEST(Bones, LimbsFingersTailsAndTentaclesOfAnyDirectionKeepTheirFirstBone) {
  struct Limb {
    const char* name;
    std::vector<Vector3d> places;
  };
  const std::vector<Limb> limbs{
      {"an arm to the side", {{0, 0, 0}, {0.3, 0, 0}, {0.6, 0, 0}}},
      {"a leg hanging down", {{0, 1, 0}, {0, 0.6, 0.02}, {0, 0.2, 0}, {0, 0.15, 0.2}}},
      {"a bent finger", {{0, 0, 0}, {0.4, 0, 0}, {0.6, -0.2, 0}, {0.62, -0.4, 0}}},
      {"a finger bent back on itself", {{0, 0, 0}, {0.5, 0, 0}, {0.6, -0.25, 0}, {0.1, -0.3, 0}}},
      {"a tentacle",
       {{0, 0, 0}, {0.2, 0.1, 0}, {0.4, 0.1, 0.1}, {0.6, 0, 0.2}, {0.8, -0.1, 0.2}, {1, 0, 0.3}}},
      {"one bone", {{0, 0, 0}, {0.5, 0.5, 0}}}};
  for (const Limb& limb : limbs) {
    std::vector<std::pair<int, Vector3d>> list;
    std::vector<std::pair<Vector3d, Vector3d>> links;
    for (std::size_t i = 0; i < limb.places.size(); ++i) {
      list.emplace_back(static_cast<int>(i) - 1, limb.places[i]);
      if (i > 0) links.emplace_back(limb.places[i - 1], limb.places[i]);
    }
    Mesh mesh = flesh(links, 0.06);
    const Skeleton skeleton = joints(list);
    const Vector3d middle = 0.5 * (limb.places[0] + limb.places[1]) + Vector3d(0, 0, 0.06);
    EXPECT_GT(weightNear(mesh, weightsOf(mesh, skeleton), middle, 0), 0.8) << limb.name;
    std::erase_if(mesh.triangles, [&](const auto& t) {  // cut open where it would join a body
      return (mesh.positions[t[0]] - limb.places[0]).dot(limb.places[1] - limb.places[0]) < 0.0;
    });
    EXPECT_GT(weightNear(mesh, weightsOf(mesh, skeleton), middle, 0), 0.8) << limb.name << ", open";
  }
}

/// A trunk on two legs; the joints stand on a root on the floor between the feet.
struct Biped {
  std::vector<std::pair<int, Vector3d>> list{
      {-1, {0, 0, 0}},       {0, {0, 0.9, 0}},      {1, {0.15, 0.85, 0}},
      {2, {0.15, 0.45, 0}},  {3, {0.15, 0.05, 0}},  {1, {-0.15, 0.85, 0}},
      {5, {-0.15, 0.45, 0}}, {6, {-0.15, 0.05, 0}}, {1, {0, 1.5, 0}}};
  Mesh mesh = flesh({{{0, 0.85, 0}, {0, 1.5, 0}},
                     {{0.15, 0.8, 0}, {0.15, 0.05, 0}},
                     {{-0.15, 0.8, 0}, {-0.15, 0.05, 0}},
                     {{-0.15, 0.85, 0}, {0.15, 0.85, 0}}},
                    0.09);
};

TEST(Bones, ARootOnTheFloorTakesNoSkinWhateverHangsOnIt) {
  Biped biped;
  const auto expectFree = [&](const Skeleton& skeleton, const char* what) {
    for (const Bone& bone : bonesOf(skeleton, restFrames(skeleton), biped.mesh))
      EXPECT_NE(bone.joint, 0) << what;
  };
  expectFree(joints(biped.list), "hips alone");
  biped.list.push_back({0, {0.5, 0.4, 0.6}});  // a target of the rig's own IK, outside the body
  expectFree(joints(biped.list), "and a pole");
  biped.list.pop_back();
  biped.list.insert(biped.list.begin() + 1, {0, {0, 0, 0.2}});  // armature -> root -> hips
  for (std::size_t i = 2; i < biped.list.size(); ++i) ++biped.list[i].first;
  for (const Bone& bone : bonesOf(joints(biped.list), restFrames(joints(biped.list)), biped.mesh))
    EXPECT_GE(bone.joint, 2);
}

TEST(Bones, WithoutASkinTheOtherJointsTellWhetherTheRootIsABone) {
  const auto hasRootBone = [](const Skeleton& skeleton) {
    return bonesOf(skeleton, restFrames(skeleton))[0].joint == 0;
  };
  EXPECT_FALSE(hasRootBone(joints(Biped().list)));
  EXPECT_TRUE(hasRootBone(readPinocchioSkeleton(inputs + "tube.skel")));
}

TEST(Bones, BonesOutsideAndOtherUnitsAreTold) {
  const Mesh mesh = readObj(inputs + "tube.obj");
  const auto notesFor = [&](const Vector3d& shift, double scale) {
    const Skeleton skeleton = joints({{-1, scale * Vector3d(0, 0.05, 0) + shift},
                                      {0, scale * Vector3d(0, 0.35, 0) + shift},
                                      {1, scale * Vector3d(0, 0.95, 0) + shift}});
    return rigNotes(skeleton, bonesOf(skeleton, restFrames(skeleton), mesh), mesh);
  };
  EXPECT_TRUE(notesFor(Vector3d::Zero(), 1.0).empty());
  for (const auto& [scale, text] : {std::pair{100.0, "about 100 times"},
                                    {0.01, "about 0.01 times"},
                                    {1000.0, "about 1e+03 times"},
                                    {39.37, "times as large"}}) {
    const auto notes = notesFor(Vector3d::Zero(), scale);
    ASSERT_FALSE(notes.empty()) << scale;
    EXPECT_EQ(notes[0].kind, "rig-unit");
    EXPECT_THAT(notes[0].text, HasSubstr(text));
  }
  const auto outside = notesFor({0.5, 0, 0}, 1.0);
  ASSERT_EQ(outside.size(), 1u);
  EXPECT_EQ(outside[0].kind, "bone-outside");
  EXPECT_THAT(outside[0].text, HasSubstr("2 joints"));
}

TEST(WindingNumber, IsOneInsideZeroOutsideAndTheSolidAngleOfAnOpenSurface) {
  const Mesh mesh = readObj(inputs + "tube.obj");
  EXPECT_NEAR(windingNumber(mesh, {0, 0.5, 0}), 1.0, 2e-3);
  EXPECT_NEAR(windingNumber(mesh, {0.09, 0.5, 0}), 1.0, 2e-3);
  EXPECT_NEAR(windingNumber(mesh, {0.2, 0.5, 0}), 0.0, 2e-3);
  EXPECT_NEAR(windingNumber(mesh, {5, 0.5, 3}), 0.0, 2e-3);
  // A square seen from the centre of the cube it is a face of fills a sixth of all directions.
  const Mesh square{.positions = {{-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}},
                    .triangles = {{0, 1, 2}, {0, 2, 3}},
                    .normals = {}};
  EXPECT_NEAR(windingNumber(square, Vector3d::Zero()), 1.0 / 6.0, 1e-12);
}

}  // namespace
}  // namespace gelenk
