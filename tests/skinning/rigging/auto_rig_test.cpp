#include "skinning/rigging/auto_rig.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "kinematics/notation/mannequin.h"
#include "skinning/blend/linear_blend.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/rigging/fit/body_fit.h"
#include "skinning/rigging/fit/landmarks.h"
#include "skinning/rigging/fit/limbs.h"
#include "skinning/rigging/fit/template_body.h"

namespace gelenk {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double height = 1.7365, degree = M_PI / 180.0;

struct Posed {
  Mesh mesh;
  std::map<std::string, Vector3d> truth;  ///< by the rig's names
};

const std::pair<const char*, const char*> limbJoints[] = {
    {"hip", "thigh"},         {"knee", "calf"},      {"ankle", "foot"}, {"toe", "ball"},
    {"shoulder", "upperarm"}, {"elbow", "lowerarm"}, {"wrist", "hand"}};

const Skin& figureSkin() {
  static const Skin skin = makeMannequinSkin(mannequin());
  return skin;
}

struct Turn {
  const char* joint;
  Vector3d axis;
  double degrees;
};

/// The figure with some joints turned about axes of the world, and where its limb joints then are.
Posed posedFigure(const std::vector<Turn>& turns) {
  const Skeleton figure = mannequin();
  Frames frames = restFrames(figure);
  for (const Turn& turn : turns) {
    const int joint = figure.jointIndex(turn.joint);
    const Vector3d pivot = frames[joint].translation();
    const Isometry3d move = Eigen::Translation3d(pivot) *
                            AngleAxisd(turn.degrees * degree, turn.axis.normalized()) *
                            Eigen::Translation3d(-pivot);
    for (int j = 0; j < figure.jointCount(); ++j)
      if (figure.isAncestor(joint, j)) frames[j] = move * frames[j];
  }
  Posed out{.mesh = figureSkin().mesh, .truth = {}};
  out.mesh.positions = linearBlendSkin(figureSkin(), frames).positions;
  out.mesh.normals.clear();
  for (const auto& [name, figureName] : limbJoints)
    for (const char* side : {"_l", "_r"})
      out.truth[std::string(name) + side] =
          frames[figure.jointIndex(std::string(figureName) + side)].translation();
  return out;
}

const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY(), z = Vector3d::UnitZ();

struct Error {
  double mean = 0.0, max = 0.0;
  std::string worst = {};
};
/// Distances of the limb joints from the truth, in per cent of the figure's height.
Error limbError(const Skeleton& skeleton, const std::map<std::string, Vector3d>& truth,
                double size = height) {
  const Frames frames = restFrames(skeleton);
  Error error;
  for (const auto& [name, p] : truth) {
    const double e = 100.0 * (frames[skeleton.jointIndex(name)].translation() - p).norm() / size;
    error.mean += e / static_cast<double>(truth.size());
    if (e > error.max) error.max = e, error.worst = name;
  }
  return error;
}

/// Every row holds up to four joints and sums to 1, and so do its bones, each counted to its upper joint.
void expectWholeRows(const RiggedBody& body, std::size_t vertices) {
  ASSERT_EQ(body.weights.size(), vertices);
  ASSERT_EQ(body.bones.size(), vertices);
  for (const auto& row : body.weights) {
    ASSERT_LE(row.size(), 4u);
    double sum = 0.0;
    for (const auto& [joint, w] : row) {
      ASSERT_GE(w, 0.0);
      ASSERT_LT(joint, body.skeleton.jointCount());
      sum += w;
    }
    ASSERT_NEAR(sum, 1.0, 1e-9);
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    ASSERT_LE(body.bones[v].size(), 4u);
    Eigen::VectorXd left = Eigen::VectorXd::Zero(body.skeleton.jointCount());
    for (const auto& [joint, w] : body.weights[v]) left[joint] += w;
    for (const auto& [end, w] : body.bones[v]) left[body.skeleton.parent(end)] -= w;
    ASSERT_LT(left.cwiseAbs().maxCoeff(), 1e-12);
  }
}

// The marks of the issue, in per cent of the height: 1.4 mean and 3.0 at most; with the arms up 2.5 and 6.
TEST(AutoRig, FindsTheLimbJointsOfTheFigureInPosesThatBodiesAreMadeIn) {
  const std::vector<std::pair<const char*, std::vector<Turn>>> poses{
      {"rest", {}},
      {"T", {{"upperarm_l", z, 49}, {"upperarm_r", z, -49}, {"lowerarm_l", y, 45}, {"lowerarm_r", y, -45}}},
      {"arms down",
       {{"upperarm_l", z, -32}, {"upperarm_r", z, 32}, {"lowerarm_l", x, 40}, {"lowerarm_r", x, 40}}},
      // The shoulder blades go along: 2 degrees in 5 of what the arms are raised above the horizontal.
      {"arms up",
       {{"clavicle_l", z, 26},
        {"clavicle_r", z, -26},
        {"upperarm_l", z, 92},
        {"upperarm_r", z, -92},
        {"lowerarm_l", y, 45},
        {"lowerarm_r", y, -45}}}};
  for (const auto& [name, turns] : poses) {
    const Posed body = posedFigure(turns);
    const RiggedBody rigged = rigBody(body.mesh);
    const Error error = limbError(rigged.skeleton, body.truth);
    EXPECT_LT(error.mean, 1.4) << name;
    EXPECT_LT(error.max, std::string(name) == "arms up" ? 4.5 : 3.0) << name;
    std::map<std::string, Vector3d> shoulders;
    for (const char* shoulder : {"shoulder_l", "shoulder_r"}) shoulders[shoulder] = body.truth.at(shoulder);
    EXPECT_LT(limbError(rigged.skeleton, shoulders).max, 2.0) << name << ": of the shoulders";
    expectWholeRows(rigged, body.mesh.positions.size());
  }
}

TEST(AutoRig, AStrideIsNoMirrorImage) {
  const Posed body = posedFigure({{"thigh_l", x, -25},
                                  {"thigh_r", x, 18},
                                  {"calf_l", x, 12},
                                  {"calf_r", x, 25},
                                  {"upperarm_l", z, -34},
                                  {"upperarm_r", z, 34},
                                  {"upperarm_l", x, 22},
                                  {"upperarm_r", x, -22}});
  const RiggedBody rigged = rigBody(body.mesh);
  EXPECT_FALSE(rigged.report.symmetric);
  const Error error = limbError(rigged.skeleton, body.truth);
  EXPECT_LT(error.mean, 1.4);
  EXPECT_LT(error.max, 3.0) << error.worst;
}

/// Height of the left hip above the floor, in per cent of the figure's height.
double hipHeight(const Skeleton& skeleton) {
  return 100.0 * restFrames(skeleton)[skeleton.jointIndex("hip_l")].translation().y() / height;
}

// Distances across the surface say little about heights at the hips, where flank and thigh run upright: the
// crotch does. Women's lies lower than the figure's under much the same flank.
TEST(AutoRig, TheHipsFollowTheCrotch) {
  Mesh mesh = posedFigure({}).mesh;
  const double before = hipHeight(rigBody(mesh).skeleton);
  for (Vector3d& p : mesh.positions)
    p.y() -= 0.05 * std::exp(-std::pow(p.x() / 0.06, 2) - std::pow((p.y() - 0.82) / 0.1, 2));
  const double lowered = before - hipHeight(rigBody(mesh).skeleton);
  EXPECT_GT(lowered, 1.0);  // of 2.9 % that the crotch went down
  EXPECT_LT(lowered, 3.5);
}

// The marks of the issue (1.4 and 3.0), on arms of other proportions than the template's.
TEST(AutoRig, FindsTheJointsOfShortAndLongArms) {
  for (const double stretch : {0.8, 1.15}) {
    Posed body = posedFigure(
        {{"upperarm_l", z, 49}, {"upperarm_r", z, -49}, {"lowerarm_l", y, 45}, {"lowerarm_r", y, -45}});
    const auto reshaped = [&](const Vector3d& p) {
      const double beyond = std::max(0.0, std::abs(p.x()) - 0.2) * (stretch - 1.0);
      return Vector3d(p.x() + std::copysign(beyond, p.x()), p.y(), p.z());
    };
    for (Vector3d& p : body.mesh.positions) p = reshaped(p);
    for (auto& [name, p] : body.truth) p = reshaped(p);
    const Error error = limbError(rigBody(body.mesh).skeleton, body.truth);
    EXPECT_LT(error.mean, 1.4) << stretch;
    EXPECT_LT(error.max, 3.0) << stretch;
  }
}

/// A closed tube of 24 corners a ring, with rings 0.02 apart.
void addTube(Mesh& mesh, const Vector3d& from, const Vector3d& to, double radius) {
  constexpr int n = 24;
  const int rings = static_cast<int>((to - from).norm() / 0.02) + 2,
            first = static_cast<int>(mesh.positions.size());
  const Vector3d along = (to - from).normalized(), u = along.unitOrthogonal(), v = along.cross(u);
  for (int i = 0; i < rings; ++i)
    for (int k = 0; k < n; ++k)
      mesh.positions.push_back(from + (to - from) * i / (rings - 1) +
                               radius *
                                   (std::cos(2.0 * M_PI * k / n) * u + std::sin(2.0 * M_PI * k / n) * v));
  mesh.positions.push_back(from);
  mesh.positions.push_back(to);
  const int start = first + rings * n, end = start + 1;
  for (int k = 0; k < n; ++k) {
    const int next = (k + 1) % n, last = first + (rings - 1) * n;
    for (int a = first; a < last; a += n) {
      mesh.triangles.push_back({a + k, a + next, a + n + next});
      mesh.triangles.push_back({a + k, a + n + next, a + n + k});
    }
    mesh.triangles.push_back({start, first + next, first + k});
    mesh.triangles.push_back({end, last + k, last + next});
  }
}

// The marks of game characters, 1.8 and 4.0: short arms, large hands, in sleeves of one width from the
// shoulder to the wrist, in pieces of their own.
TEST(AutoRig, FindsTheWristsOfShortArmsInWideSleeves) {
  Posed body = posedFigure(
      {{"upperarm_l", z, 49}, {"upperarm_r", z, -49}, {"lowerarm_l", y, 45}, {"lowerarm_r", y, -45}});
  const double shoulder = body.truth.at("shoulder_l").x(), hand = body.truth.at("wrist_l").x();
  const auto reshaped = [&](const Vector3d& p) {
    const double x = std::abs(p.x()), arm = std::clamp(x, shoulder, hand) - shoulder,
                 beyond = std::max(0.0, x - hand);
    return Vector3d(std::copysign(std::min(x, shoulder) + 0.75 * arm + 1.3 * beyond, p.x()), p.y(), p.z());
  };
  for (Vector3d& p : body.mesh.positions) p = reshaped(p);
  for (auto& [name, p] : body.truth) p = reshaped(p);
  for (const char* side : {"_l", "_r"}) {
    const auto at = [&](const char* joint) { return body.truth.at(std::string(joint) + side); };
    const Vector3d from = at("shoulder") + 0.3 * (at("elbow") - at("shoulder"));
    addTube(body.mesh, from, at("elbow"), 0.062);
    addTube(body.mesh, at("elbow"), at("wrist"), 0.062);
  }
  const Error error = limbError(rigBody(body.mesh).skeleton, body.truth);
  EXPECT_LT(error.mean, 1.8);
  EXPECT_LT(error.max, 4.0) << error.worst;
}

TEST(Landmarks, TheCrotchIsTheLowestPlaceOfTheCutInTheMiddle) {
  const TemplateBody& human = humanTemplate();
  const Vector3d known = human.surface.positions[human.crotch];
  const auto found = findCrotch(human.surface, {}, known, 0.06);
  ASSERT_TRUE(found);
  EXPECT_LT((*found - known).norm(), 0.005);  // the cut lies 0.001 beside the vertex
  EXPECT_FALSE(findCrotch(human.surface, {}, known + Vector3d(0.0, 0.1, 0.0), 0.06)) << "too far away";
  Mesh skirt = human.surface;  // closed between the legs down to the floor
  skirt.positions.insert(skirt.positions.end(), {{-0.05, 0.05, 0.0}, {0.05, 0.05, 0.0}, {0.05, 0.4, 0.0}});
  const int n = static_cast<int>(skirt.positions.size());
  skirt.triangles.push_back({n - 3, n - 2, n - 1});
  EXPECT_FALSE(findCrotch(skirt, {}, known, 0.06));
}

// Marks of the issue: within 0.2 % of the upright answer, left and right kept.
TEST(AutoRig, TheSkeletonTurnsAndGrowsWithTheBody) {
  const Posed upright = posedFigure({});
  const RiggedBody first = rigBody(upright.mesh);
  const Frames frames = restFrames(first.skeleton);
  struct Way {
    const char* name;
    Eigen::Affine3d move;
  };
  const auto turned = [](double degrees, const Vector3d& axis) {
    return Eigen::Affine3d(AngleAxisd(degrees * degree, axis.normalized()));
  };
  const Way ways[] = {{"yaw 45", turned(45, y)},
                      {"facing back", turned(180, y)},
                      {"lying", turned(-90, x)},
                      {"upside down", turned(180, z)},
                      {"tilted", turned(30, {1, 0.3, 0.5})},
                      {"in millimetres", Eigen::Affine3d(Eigen::Scaling(1000.0))}};
  for (const Way& way : ways) {
    Mesh mesh = upright.mesh;
    for (Vector3d& p : mesh.positions) p = way.move * p;
    const RiggedBody rigged = rigBody(mesh);
    std::map<std::string, Vector3d> expected;
    for (int j = 0; j < first.skeleton.jointCount(); ++j)
      expected[first.skeleton.joint(j).name] = way.move * frames[j].translation();
    const double scale = std::cbrt(way.move.linear().determinant());
    EXPECT_LT(limbError(rigged.skeleton, expected, scale * height).max, 0.2) << way.name;
    EXPECT_NEAR((rigged.report.up - way.move.linear() * first.report.up / scale).norm(), 0.0, 0.02)
        << way.name;
  }
}

TEST(AutoRig, ASymmetricBodyGetsASymmetricSkeleton) {
  const RiggedBody rigged = rigBody(posedFigure({}).mesh);
  ASSERT_TRUE(rigged.report.symmetric);
  const Frames frames = restFrames(rigged.skeleton);
  for (int j = 0; j < rigged.skeleton.jointCount(); ++j) {
    std::string name = rigged.skeleton.joint(j).name;
    if (!name.ends_with("_l")) continue;
    Vector3d image = frames[j].translation();
    image.x() = -image.x();
    name.back() = 'r';
    const Vector3d partner = frames[rigged.skeleton.jointIndex(name)].translation();
    EXPECT_LT((partner - image).norm(), 0.001 * height) << name;
  }
}

TEST(AutoRig, BrokenSurfacesAreOrdinaryInput) {
  const Posed whole = posedFigure({});
  Mesh soup, flipped = whole.mesh, holed = whole.mesh, loose = whole.mesh;
  for (const auto& t : whole.mesh.triangles) {
    const int first = static_cast<int>(soup.positions.size());
    for (const int v : t) soup.positions.push_back(whole.mesh.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  for (std::size_t k = 0; k < flipped.triangles.size(); k += 3)
    std::swap(flipped.triangles[k][0], flipped.triangles[k][1]);
  std::erase_if(holed.triangles, [&](const auto& t) {
    return (whole.mesh.positions[t[0]] - Vector3d(0.0, 1.2, 0.12)).norm() < 0.05;
  });
  loose.positions.emplace_back(0.3, 0.2, 0.1);
  for (const auto& [name, mesh] :
       {std::pair("soup", &soup), {"flipped", &flipped}, {"hole", &holed}, {"loose vertex", &loose}}) {
    const RiggedBody rigged = rigBody(*mesh);
    EXPECT_LT(limbError(rigged.skeleton, whole.truth).max, 3.0) << name;
    expectWholeRows(rigged, mesh->positions.size());
  }
  EXPECT_FALSE(rigBody(flipped).report.repairs.empty());
}

Mesh ball(double a, double b, int rings = 24) {  // a torus of radii a, b, or a ball where a is 0
  Mesh mesh;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < rings; ++j) {
      const double u = 2.0 * M_PI * i / rings,
                   v = (a > 0.0 ? 2.0 : 1.0) * M_PI * j / (a > 0.0 ? rings : rings - 1);
      const double r = a > 0.0 ? a + b * std::cos(v) : b * std::sin(v);
      mesh.positions.emplace_back(r * std::cos(u), a > 0.0 ? b * std::sin(v) : b * std::cos(v),
                                  r * std::sin(u));
    }
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j + (a > 0.0 ? 0 : 1) < rings; ++j) {
      const int p = i * rings + j, q = (i + 1) % rings * rings + j, s = i * rings + (j + 1) % rings,
                t = (i + 1) % rings * rings + (j + 1) % rings;
      mesh.triangles.push_back({p, s, q});
      mesh.triangles.push_back({q, s, t});
    }
  return mesh;
}

TEST(AutoRig, WhatHasNoLimbsIsRefused) {
  EXPECT_THROW(rigBody(ball(0.0, 1.0)), RigRefused);
  EXPECT_THROW(rigBody(ball(1.0, 0.3)), RigRefused);
  Mesh tetrahedron;
  tetrahedron.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  tetrahedron.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  for (const RigTemplate kind : {RigTemplate::Human, RigTemplate::Quadruped})
    EXPECT_THROW(rigBody(tetrahedron, {.skeleton = kind}), RigRefused);
  Mesh flat;
  flat.positions = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  flat.triangles = {{0, 1, 2}};
  EXPECT_THROW(rigBody(flat), RigRefused) << "no area";
}

void addBox(Mesh& mesh, const Vector3d& low, const Vector3d& high) {
  const int first = static_cast<int>(mesh.positions.size());
  for (int k = 0; k < 8; ++k)
    mesh.positions.emplace_back((k & 1 ? high : low).x(), (k & 2 ? high : low).y(), (k & 4 ? high : low).z());
  for (const std::array<int, 4>& face :
       {std::array{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}) {
    mesh.triangles.push_back({first + face[0], first + face[1], first + face[2]});
    mesh.triangles.push_back({first + face[0], first + face[2], first + face[3]});
  }
}

/// A seat or a table top on four legs.
Mesh onFourLegs(double width, double depth, double height, double thick) {
  Mesh mesh;
  for (const double sx : {-1.0, 1.0})
    for (const double sz : {-1.0, 1.0}) {
      const Vector3d foot(sx * (0.5 * width - thick), 0.0, sz * (0.5 * depth - thick));
      addBox(mesh, foot - Vector3d(thick, 0.0, thick), foot + Vector3d(thick, height, thick));
    }
  addBox(mesh, {-0.5 * width, height, -0.5 * depth}, {0.5 * width, height + 2.0 * thick, 0.5 * depth});
  return mesh;
}

TEST(AutoRig, FurnitureIsNoHumanBody) {
  Mesh chair = onFourLegs(0.5, 0.5, 0.45, 0.02);
  addBox(chair, {-0.25, 0.5, -0.25}, {0.25, 1.0, -0.2});
  Mesh armchair = chair;
  for (const double side : {-0.25, 0.2}) {
    addBox(armchair, {side, 0.7, -0.25}, {side + 0.05, 0.73, 0.25});
    addBox(armchair, {side, 0.5, 0.2}, {side + 0.05, 0.7, 0.25});
  }
  for (const auto& [name, mesh] : {std::pair("chair", chair),
                                   {"armchair", armchair},
                                   {"stool", onFourLegs(0.5, 0.5, 0.45, 0.02)},
                                   {"bar stool", onFourLegs(0.4, 0.4, 0.75, 0.02)},
                                   {"table", onFourLegs(1.6, 0.8, 0.7, 0.04)}})
    EXPECT_THROW(rigBody(mesh), RigRefused) << name;
}

// As unlike people as a chair, but on two legs: a skeleton, and no confidence in it.
TEST(AutoRig, ABodyOfBlocksOnTwoLegsGetsASkeletonAndNoConfidence) {
  Mesh blocks;
  for (const double side : {-1.0, 1.0}) {
    addBox(blocks, {side * 0.25 - 0.1, 0.0, -0.1}, {side * 0.25 + 0.1, 0.8, 0.1});
    addBox(blocks, {side * 0.7 - 0.3, 1.13, -0.07}, {side * 0.7 + 0.3, 1.27, 0.07});
  }
  addBox(blocks, {-0.4, 0.8, -0.25}, {0.4, 1.5, 0.25});
  addBox(blocks, {-0.2, 1.5, -0.2}, {0.2, 1.85, 0.2});
  EXPECT_LT(rigBody(blocks).report.confidence, 0.1);
}

TEST(Limbs, LegsAreWhatABodyStandsOn) {
  EXPECT_EQ(countLegs(VoxelBody(posedFigure({}).mesh, 64), y), 2);
  EXPECT_EQ(countLegs(VoxelBody(posedFigure({{"upperarm_l", z, 120}}).mesh, 64), y), 2);
  EXPECT_EQ(countLegs(VoxelBody(onFourLegs(0.5, 0.5, 0.45, 0.02), 64), y), 4);
  EXPECT_EQ(countLegs(VoxelBody(ball(0.0, 1.0), 64), y), 1);
  EXPECT_EQ(countLegs(VoxelBody(hoofedTemplate().surface, 64), y), 4);
}

TEST(Limbs, AreTheSlenderBranchesOfABody) {
  EXPECT_EQ(countLimbs(VoxelBody(ball(0.0, 1.0), 64)), 0);
  EXPECT_EQ(countLimbs(VoxelBody(posedFigure({}).mesh, 64)), 4);  // the head is too short
  EXPECT_GE(countLimbs(VoxelBody(hoofedTemplate().surface, 64)), 4);
}

// Neck and shoulders are wide: what the bone from the trunk to the neck heats is the trunk's skin, so it
// stands in the column of the trunk's bone, and none in that of the neck.
TEST(AutoRig, TheBoneToTheNeckIsTheTrunks) {
  const RiggedBody rigged = rigBody(posedFigure({}).mesh);
  const int neck = rigged.skeleton.jointIndex("neck"), chest = rigged.skeleton.jointIndex("chest");
  double atNeck = 0.0, atChest = 0.0;
  for (const auto& row : rigged.bones)
    for (const auto& [end, w] : row) {
      if (end == neck) atNeck += w;
      if (end == chest) atChest += w;
    }
  EXPECT_EQ(atNeck, 0.0);
  EXPECT_GT(atChest, 1.0);
}

// The confidence in a joint falls where the surface around it is unlike a body's: here a crate on one hand.
TEST(AutoRig, AStrangeHandLowersTheConfidenceThere) {
  Posed body = posedFigure({});
  const Vector3d hand = body.truth.at("wrist_l") + Vector3d(0.06, -0.06, 0.05);
  for (Vector3d& p : body.mesh.positions)
    if (const double d = (p - hand).norm(); d < 0.14) p = hand + (p - hand) / std::max(d, 1e-9) * 0.14;
  const RiggedBody rigged = rigBody(body.mesh);
  const auto sure = [&](const char* name) {
    return rigged.report.jointConfidence[rigged.skeleton.jointIndex(name)];
  };
  EXPECT_LT(sure("hand_l"), 0.7 * sure("hip_l"));
  for (const double c : rigged.report.jointConfidence) EXPECT_TRUE(c >= 0.0 && c <= 1.0);
}

/// Every triangle cut into four at the middles of its edges, the last one first.
Mesh cutIntoFour(const Mesh& mesh) {
  Mesh out;
  out.positions = mesh.positions;
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [at, fresh] = middles.emplace(std::minmax(a, b), static_cast<int>(out.positions.size()));
    if (fresh) out.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    return at->second;
  };
  for (auto t = mesh.triangles.rbegin(); t != mesh.triangles.rend(); ++t) {
    const auto& [a, b, c] = *t;
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const std::array<int, 3>& part : {std::array{ab, bc, ca}, {a, ab, ca}, {b, bc, ab}, {c, ca, bc}})
      out.triangles.push_back(part);
  }
  return out;
}

TEST(AutoRig, TheConfidenceDoesNotDependOnHowFineTheTrianglesAre) {
  const Mesh mesh = posedFigure({}).mesh;
  const double before = rigBody(mesh).report.confidence;
  EXPECT_GT(before, 0.9);
  EXPECT_NEAR(rigBody(cutIntoFour(mesh)).report.confidence, before, 0.03);
}

// In per cent of the height; a finger is 5 long. The little finger's knuckle lies deep in the palm.
TEST(AutoRig, FindsTheFingersOfTheFigure) {
  const Skeleton figure = mannequin();
  const Frames rest = restFrames(figure);
  std::map<std::string, Vector3d> truth;
  for (const char* finger : {"thumb", "index", "middle", "ring", "pinky"})
    for (const char* part : {"_01", "_02", "_03"})
      for (const char* side : {"_l", "_r"}) {
        const std::string name = std::string(finger) + part + side;
        truth[name] = rest[figure.jointIndex(name)].translation();
      }
  const RiggedBody rigged = rigBody(posedFigure({}).mesh);
  const Error error = limbError(rigged.skeleton, truth);
  EXPECT_LT(error.mean, 0.5);
  EXPECT_LT(error.max, 0.8) << error.worst;
  const Frames rigFrames = restFrames(rigged.skeleton);
  for (const auto& [name, p] : truth) {  // hinges bend the way that the figure's do
    const int joint = rigged.skeleton.jointIndex(name), own = figure.jointIndex(name);
    const auto &axes = rigged.skeleton.joint(joint).axes, &ownAxes = figure.joint(own).axes;
    ASSERT_EQ(axes.size(), ownAxes.size()) << name;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      EXPECT_GT((rigFrames[joint].linear() * axes[k].axis).dot(rest[own].linear() * ownAxes[k].axis), 0.9)
          << name;
    }
  }
  Posed mitten = posedFigure({});
  const Vector3d hand = mitten.truth.at("wrist_l") + Vector3d(0.05, -0.05, 0.06);
  for (Vector3d& p : mitten.mesh.positions)
    if (const double d = (p - hand).norm(); d < 0.16) p = hand + (p - hand) / std::max(d, 1e-9) * 0.16;
  EXPECT_FALSE(rigBody(mitten.mesh).skeleton.findJoint("index_01_l"));
}

TEST(RigMending, AMovedJointLeavesTheOthersInTheirPlaces) {
  const RiggedBody rigged = rigBody(posedFigure({}).mesh);
  const Skeleton& before = rigged.skeleton;
  const int elbow = before.jointIndex("elbow_l"), other = before.jointIndex("elbow_r");
  const Frames frames = restFrames(before);
  const Vector3d place = frames[elbow].translation() + Vector3d(0.01, 0.02, -0.015);
  const Skeleton alone = withJointAt(before, elbow, place),
                 both = withJointAt(before, elbow, place, rigged.report.middle);
  const Frames aloneFrames = restFrames(alone), bothFrames = restFrames(both);
  for (int j = 0; j < before.jointCount(); ++j) {
    const Vector3d was = frames[j].translation();
    EXPECT_LT((aloneFrames[j].translation() - (j == elbow ? place : was)).norm(), 1e-12) << j;
    if (j != other) {
      EXPECT_LT((bothFrames[j].translation() - (j == elbow ? place : was)).norm(), 1e-12) << j;
    }
    EXPECT_LT((aloneFrames[j].linear() - frames[j].linear()).norm(), 1e-12) << j;
  }
  const Vector3d image(-place.x(), place.y(), place.z());
  EXPECT_LT((bothFrames[other].translation() - image).norm(), 1e-4) << "the fitted plane is x = 0 to that";
  const int neck = before.jointIndex("neck");
  const Vector3d aside = frames[neck].translation() + Vector3d(0.05, 0.02, 0.0);
  const Frames middle = restFrames(withJointAt(before, neck, aside, rigged.report.middle));
  EXPECT_NEAR(rigged.report.middle.signedDistance(middle[neck].translation()), 0.0, 1e-12);
}

TEST(AutoRig, SameInputSameBitsAndItCanBeStopped) {
  const Mesh mesh = posedFigure({}).mesh;
  const RiggedBody first = rigBody(mesh), second = rigBody(mesh);
  EXPECT_EQ(first.skeleton.rest(), second.skeleton.rest());
  EXPECT_EQ(first.weights, second.weights);
  int asked = 0;
  EXPECT_THROW(rigBody(mesh, {.progress = [&](const std::string&, double) { return ++asked < 3; }}),
               RigStopped);
  EXPECT_EQ(asked, 3);
}

TEST(AutoRig, FindsTheLegsOfALongAnimal) {
  const TemplateBody& animal = hoofedTemplate();
  const auto reshaped = [](const Vector3d& p) { return Vector3d(1.1 * p.x(), 0.85 * p.y(), 1.15 * p.z()); };
  Mesh mesh = animal.surface;
  for (Vector3d& p : mesh.positions) p = reshaped(p);
  std::map<std::string, Vector3d> truth;
  for (const TemplateJoint& joint : animal.joints)
    if (joint.name.ends_with("_l") || joint.name.ends_with("_r"))
      truth[joint.name] = reshaped(joint.position);
  const RiggedBody rigged = rigBody(mesh, {.skeleton = RigTemplate::Quadruped});
  const Error error = limbError(rigged.skeleton, truth, 1.15);
  EXPECT_LT(error.mean, 2.5);
  EXPECT_LT(error.max, 6.0);
}

/// The template with some of its pieces turned; legs as they were.
Mesh posedAnimal(const TemplateBody& animal, const std::vector<std::pair<const char*, Vector3d>>& aims) {
  PieceMaps maps = restMaps(animal);
  for (const auto& [piece, direction] : aims) aim(animal, maps, piece, direction);
  Mesh mesh = animal.surface;
  mesh.positions = deformed(animal, maps);
  mesh.normals.clear();
  return mesh;
}

std::map<std::string, Vector3d> legsOf(const TemplateBody& animal) {
  std::map<std::string, Vector3d> truth;
  for (const TemplateJoint& joint : animal.joints)
    if (joint.name.ends_with("_l") || joint.name.ends_with("_r")) truth[joint.name] = joint.position;
  return truth;
}

// Of a body with a long upright neck neither principal axis is upright: the ground under its feet is level.
TEST(AutoRig, AnUprightNeckDoesNotTiltAnAnimal) {
  const TemplateBody& animal = hoofedTemplate();
  Mesh mesh = posedAnimal(animal, {{"neck", {0.0, 1.0, 0.15}}, {"head", {0.0, 0.0, 1.0}}});
  for (Vector3d& p : mesh.positions)  // twice as long
    p.y() += std::max(0.0, p.y() - 0.55);
  const RiggedBody rigged = rigBody(mesh, {.skeleton = RigTemplate::Quadruped});
  EXPECT_GT(rigged.report.up.y(), 0.97);
  EXPECT_GT(rigged.report.front.z(), 0.97);
  const Error error = limbError(rigged.skeleton, legsOf(animal), 1.0);
  EXPECT_LT(error.mean, 2.5);
  EXPECT_LT(error.max, 6.0) << error.worst;
}

// A dog's foreleg bends under its chest, a horse's and a cow's half way down: which of them it is shows.
TEST(AutoRig, TheForelegsOfDogsHorsesAndCattleBendWhereTheyDo) {
  for (const TemplateBody* animal : {&hoofedTemplate(), &cattleTemplate(), &pawedTemplate()}) {
    Mesh mesh = animal->surface;
    std::map<std::string, Vector3d> truth = legsOf(*animal);
    const auto reshaped = [](const Vector3d& p) { return Vector3d(1.1 * p.x(), 1.1 * p.y(), 0.95 * p.z()); };
    for (Vector3d& p : mesh.positions) p = reshaped(p);
    for (auto& [name, p] : truth) p = reshaped(p);
    const RiggedBody rigged = rigBody(mesh, {.skeleton = RigTemplate::Quadruped});
    const Error error = limbError(rigged.skeleton, truth, 0.95);
    EXPECT_LT(error.mean, 2.5);
    EXPECT_LT(error.max, 4.0) << error.worst;
  }
}

}  // namespace
}  // namespace gelenk
