#include "skinning/blend/skin_method.h"

#include <gtest/gtest.h>

#include <random>

#include "kinematics/rotation.h"
#include "skinning/blend/rotation_centres.h"
#include "skinning/blend/surface_slopes.h"
#include "skinning/blend/weight_smoothing.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double link = 0.3;

/// A tube along x with three joints: shoulder (ball), elbow (hinge about z, then twist about the bone), hand
/// (ball).
struct TwistedArm {
  Skeleton skeleton;
  Skin skin;
  TwistSpread spread;
};
TwistedArm twistedArm() {
  const auto at = [](double x) { return Isometry3d(Eigen::Translation3d(x, 0.0, 0.0)); };
  TwistedArm arm{.skeleton = Skeleton(
                     {{.name = "chest"},
                      {.name = "shoulder", .parent = 0, .ball = true},
                      {.name = "elbow",
                       .parent = 1,
                       .parentFromZero = at(link),
                       .axes = {AxisDof{.axis = Vector3d::UnitZ()}, AxisDof{.axis = Vector3d::UnitX()}}},
                      {.name = "hand", .parent = 2, .parentFromZero = at(link), .ball = true}}),
                 .skin = {},
                 .spread = {}};
  Skin tube = testing::arm(3, link, 0.04, 24, 24).skin;
  for (Influences& in : tube.influences)
    for (int k = 0; k < 4; ++k)
      if (in.weights[k] > 0.0) ++in.joints[k];
  arm.skin = bindSkin(tube.mesh, restFrames(arm.skeleton), tube.influences);
  arm.spread = spreadTwist(arm.skeleton, restFrames(arm.skeleton), {{1, 2, 3}});
  return arm;
}

/// Every method with and without spread twist, on a body.
template <class Check>
void forEveryMethod(const Skin& skin, const TwistSpread& spread, const Check& check) {
  for (const SkinMethod* method : skinMethods())
    for (const bool twist : {false, true}) {
      SCOPED_TRACE(std::string(method->name) + (twist ? " + twist" : ""));
      check(prepareSkin(skin, *method, twist ? spread : TwistSpread{}));
    }
}

/// Methods with a polar rotation of nearly flat patches, or with twenty solves, lose digits.
double positionTolerance(const PreparedSkin& prepared) {
  return !prepared.method->shader.empty() ? 1e-12 : 1e-9;
}
double normalTolerance(const PreparedSkin& prepared) {
  return !prepared.method->shader.empty() ? 1e-11 : 1e-6;
}

double largestDistance(const SkinnedVertices& a, const SkinnedVertices& b) {
  double largest = 0.0;
  for (std::size_t v = 0; v < a.positions.size(); ++v)
    largest = std::max(largest, (a.positions[v] - b.positions[v]).norm());
  return largest;
}

double largestTurn(const SkinnedVertices& a, const SkinnedVertices& b) {
  double largest = 0.0;
  for (std::size_t v = 0; v < a.normals.size(); ++v)
    largest = std::max(largest, (a.normals[v] - b.normals[v]).norm());
  return largest;
}

TEST(SkinMethods, TheBindPoseLeavesEveryVertexAndNormal) {
  const TwistedArm arm = twistedArm();
  forEveryMethod(arm.skin, arm.spread, [&](const PreparedSkin& prepared) {
    const SkinnedVertices at = blendSkin(prepared, restFrames(arm.skeleton));
    for (std::size_t v = 0; v < at.positions.size(); ++v) {
      EXPECT_LE((at.positions[v] - arm.skin.mesh.positions[v]).norm(), positionTolerance(prepared));
      EXPECT_LE((at.normals[v] - arm.skin.mesh.normals[v]).norm(), normalTolerance(prepared));
    }
  });
}

TEST(SkinMethods, ARigidMotionOfAllBonesMovesTheSkinRigidly) {
  const TwistedArm arm = twistedArm();
  std::mt19937_64 random(5);
  const Frames bent = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 1.2));
  forEveryMethod(arm.skin, arm.spread, [&](const PreparedSkin& prepared) {
    const SkinnedVertices still = blendSkin(prepared, bent);
    for (const double angle : {0.7, 3.0, 6.0}) {
      Isometry3d motion(expRotation(angle * Vector3d(0.36, 0.48, 0.8)));
      motion.translation() << 1.0, -2.0, 0.5;
      Frames moved = bent;
      for (Isometry3d& frame : moved) frame = motion * frame;
      const SkinnedVertices at = blendSkin(prepared, moved);
      for (std::size_t v = 0; v < at.positions.size(); ++v) {
        EXPECT_LE((at.positions[v] - motion * still.positions[v]).norm(), positionTolerance(prepared));
        EXPECT_LE((at.normals[v] - motion.linear() * still.normals[v]).norm(), normalTolerance(prepared));
      }
    }
  });
}

TEST(SkinMethods, AVertexOfOneBoneMovesWithIt) {
  const TwistedArm arm = twistedArm();
  std::mt19937_64 random(6);
  const Frames bent = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 1.5));
  forEveryMethod(arm.skin, {}, [&](const PreparedSkin& prepared) {
    if (prepared.method->shader.empty()) return;  // those smooth over single bones too
    const PosedBones bones = poseBones(prepared, bent);
    const SkinnedVertices at = blendSkin(prepared, bent);
    int alone = 0;
    for (std::size_t v = 0; v < at.positions.size(); ++v) {
      if (arm.skin.influences[v].weights[0] < 1.0) continue;
      ++alone;
      const Isometry3d& T = bones.worldFromRest[arm.skin.influences[v].joints[0]];
      EXPECT_LE((at.positions[v] - T * arm.skin.mesh.positions[v]).norm(), 1e-14);
    }
    EXPECT_GT(alone, 50);
  });
}

TEST(SkinMethods, CentresOfRotationEqualLinearBlendingWhereAllBonesTurnAlike) {
  const TwistedArm arm = twistedArm();
  Frames frames = restFrames(arm.skeleton);
  const Eigen::Matrix3d R = expRotation({0.4, -0.9, 0.3}).toRotationMatrix();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].linear() = R * frames[i].linear();
    frames[i].translation() += Vector3d(0.1, 0.02, -0.05) * static_cast<double>(i);
  }
  const SkinnedVertices cor = blendSkin(prepareSkin(arm.skin, skinMethodNamed("cor")), frames);
  EXPECT_LE(largestDistance(cor, linearBlendSkin(arm.skin, frames)), 1e-14);
}

TEST(SkinMethods, LbsWithCheapNormalsIsLinearBlendSkin) {
  const TwistedArm arm = twistedArm();
  std::mt19937_64 random(7);
  const Frames frames = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 1.0));
  const SkinnedVertices at =
      blendSkin(prepareSkin(arm.skin, skinMethodNamed("lbs")), frames, nullptr, SkinNormals::Cheap);
  EXPECT_LE(largestDistance(at, linearBlendSkin(arm.skin, frames)), 1e-14);
  EXPECT_LE(largestTurn(at, linearBlendSkin(arm.skin, frames)), 1e-12);
}

/// T_j Rot(a, h; phi(s)) with rotations as angle and axis: the formula of the header, term by term.
Isometry3d twistedMotion(const PreparedSkin& prepared, const PosedBones& bones, int joint,
                         const Vector3d& x) {
  Isometry3d motion = bones.worldFromRest[joint];
  for (std::size_t b = 0; b < prepared.spread.bones.size(); ++b) {
    const TwistBone& bone = prepared.spread.bones[b];
    if (bone.joint != joint) continue;
    const double s = std::clamp(bone.axis.dot(x - bone.head) / bone.length, 0.0, 1.0);
    const double phi = (1.0 - s) * bones.twists[b].atHead + s * bones.twists[b].atEnd;
    motion = motion * Eigen::Translation3d(bone.head) * Eigen::AngleAxisd(phi, bone.axis) *
             Eigen::Translation3d(-bone.head);
  }
  return motion;
}

Vector3d formula(const PreparedSkin& prepared, const PosedBones& bones, std::size_t v) {
  const Influences& in = prepared.skin.influences[v];
  const Vector3d x = prepared.skin.mesh.positions[v];
  const bool cor = prepared.method->name == "cor";
  Vector3d linear = Vector3d::Zero();
  Quaterniond q(0, 0, 0, 0), first;
  Eigen::Vector4d dual = Eigen::Vector4d::Zero();  // (x, y, z, w)
  for (int k = 0; k < 4 && in.weights[k] > 0.0; ++k) {
    const Isometry3d T = twistedMotion(prepared, bones, in.joints[k], x);
    linear += in.weights[k] * (T * (cor ? prepared.centres[v] : x));
    const Quaterniond turn(T.linear());
    if (k == 0) first = turn;
    const double w = turn.dot(first) < 0.0 ? -in.weights[k] : in.weights[k];
    q.coeffs() += w * turn.coeffs();
    dual += 0.5 * w *
            (Quaterniond(0, T.translation().x(), T.translation().y(), T.translation().z()) * turn).coeffs();
  }
  if (prepared.method->name == "lbs") return linear;
  if (cor) return linear + q.normalized() * (x - prepared.centres[v]);
  const Quaterniond p(dual);
  return q.normalized() * x + 2.0 * (p * q.conjugate()).vec() / q.squaredNorm();
}

TEST(SkinMethods, PositionsAreTheFormulasWrittenOut) {
  const TwistedArm arm = twistedArm();
  std::mt19937_64 random(8);
  for (int trial = 0; trial < 3; ++trial) {
    const Eigen::VectorXd q = testing::bent(arm.skeleton, random, 1.5);
    forEveryMethod(arm.skin, arm.spread, [&](const PreparedSkin& prepared) {
      if (prepared.method->shader.empty()) return;  // moments have a test of their own
      const PosedBones bones = poseBones(prepared, forwardKinematics(arm.skeleton, q), &q);
      SkinnedVertices at;
      blendSkin(prepared, bones, at);
      for (std::size_t v = 0; v < at.positions.size(); ++v)
        EXPECT_LE((at.positions[v] - formula(prepared, bones, v)).norm(), 1e-13);
    });
  }
}

/// The prepared skin where each vertex has gone h along a tangent, its weights and centre with it.
PreparedSkin displaced(PreparedSkin prepared, int tangent, double h) {
  for (std::size_t v = 0; v < prepared.skin.mesh.positions.size(); ++v) {
    prepared.skin.mesh.positions[v] += h * surfaceTangents(prepared.skin.mesh.normals[v]).col(tangent);
    for (int k = 0; k < 4; ++k) prepared.skin.influences[v].weights[k] += h * prepared.slopes[v](k, tangent);
    if (!prepared.centres.empty()) prepared.centres[v] += h * prepared.centreSlopes[v].col(tangent);
  }
  return prepared;
}

TEST(SkinMethods, GradientNormalsAreThoseOfTheSkinsOwnDifferences) {
  const TwistedArm arm = twistedArm();
  std::mt19937_64 random(9);
  const Eigen::VectorXd q = testing::bent(arm.skeleton, random, 1.0);
  const Frames frames = forwardKinematics(arm.skeleton, q);
  constexpr double h = 1e-6;  // metres: differences good to 1e-9
  forEveryMethod(arm.skin, arm.spread, [&](const PreparedSkin& prepared) {
    if (prepared.method->shader.empty()) return;  // on the processor only: normals of triangles
    std::array<std::vector<Vector3d>, 2> tangents;
    for (int t = 0; t < 2; ++t) {
      const SkinnedVertices after = blendSkin(displaced(prepared, t, h), frames, &q);
      const SkinnedVertices before = blendSkin(displaced(prepared, t, -h), frames, &q);
      for (std::size_t v = 0; v < after.positions.size(); ++v)
        tangents[t].push_back((after.positions[v] - before.positions[v]) / (2.0 * h));
    }
    const SkinnedVertices at = blendSkin(prepared, frames, &q);
    int checked = 0;
    for (std::size_t v = 0; v < at.positions.size(); ++v) {
      // Not at the ends of a bone's spread, where phi has a kink.
      const double x = prepared.skin.mesh.positions[v].x();
      if (std::min({std::abs(x), std::abs(x - link), std::abs(x - 2 * link)}) < 10 * h) continue;
      const Vector3d normal = tangents[0][v].cross(tangents[1][v]).normalized();
      EXPECT_LE((normal - at.normals[v]).norm(), 1e-6) << "vertex " << v;
      ++checked;
    }
    EXPECT_GT(checked, 1000);
  });
}

/// Largest step of a vertex per 0.1 degree of forearm twist, metres; NaN never.
double largestStep(const TwistedArm& arm, const PreparedSkin& prepared, double fromDegrees,
                   double toDegrees) {
  SkinnedVertices before, at;
  double largest = 0.0;
  bool finite = true;
  for (double degrees = fromDegrees; degrees <= toDegrees; degrees += 0.1) {
    Eigen::VectorXd q = arm.skeleton.rest();
    q[arm.skeleton.qIndex(2) + 1] = degrees * M_PI / 180.0;
    blendSkin(prepared, poseBones(prepared, forwardKinematics(arm.skeleton, q), &q), at);
    for (std::size_t v = 0; v < at.positions.size(); ++v)
      finite = finite && at.positions[v].allFinite() && at.normals[v].allFinite();
    if (!before.positions.empty()) largest = std::max(largest, largestDistance(before, at));
    std::swap(before, at);
  }
  EXPECT_TRUE(finite);
  return largest;
}

TEST(SkinMethods, SpreadTwistIsSmoothBeyondHalfATurnAndQuaternionsAloneFlipThere) {
  const TwistedArm arm = twistedArm();
  const double rigid = 0.1 * M_PI / 180.0 * 0.04;  // of the surface about the bone
  for (const char* name : {"lbs", "cor"}) {
    const PreparedSkin spread = prepareSkin(arm.skin, skinMethodNamed(name), arm.spread);
    EXPECT_LE(largestStep(arm, spread, -200.0, 200.0), 1.02 * rigid) << name;
  }
  // One rotation has two quaternions: at half a turn the nearer one changes, and the skin goes round the
  // other way. A fact of the method (docs/skinning/dqs.md).
  for (const char* name : {"dqs", "cor"})
    EXPECT_GE(largestStep(arm, prepareSkin(arm.skin, skinMethodNamed(name)), 179.0, 181.0), 100.0 * rigid)
        << name;
  EXPECT_LE(largestStep(arm, prepareSkin(arm.skin, skinMethodNamed("lbs")), 179.0, 181.0), 1.1 * rigid);
}

/// Smallest radius of the tube over all of its rings, as a share of the rest's.
double narrowest(const SkinnedVertices& at) {
  double least = 1.0;
  for (const Vector3d& p : at.positions)
    if (p.x() > 0.02 && p.x() < 3 * link - 0.02)
      least = std::min(least, Vector3d(0, p.y(), p.z()).norm() / 0.04);
  return least;
}

TEST(SkinMethods, TwistNeitherCollapsesDualQuaternionsNorCentresNorAnySpreadTwist) {
  const TwistedArm arm = twistedArm();
  Eigen::VectorXd q = arm.skeleton.rest();
  q[arm.skeleton.qIndex(2) + 1] = 170.0 * M_PI / 180.0;
  const Frames frames = forwardKinematics(arm.skeleton, q);
  EXPECT_LE(narrowest(blendSkin(prepareSkin(arm.skin, skinMethodNamed("lbs")), frames)), 0.1);
  for (const char* name : {"dqs", "cor"})
    EXPECT_GE(narrowest(blendSkin(prepareSkin(arm.skin, skinMethodNamed(name)), frames)), 0.999) << name;
  for (const char* name : {"lbs", "dqs", "cor"}) {
    const PreparedSkin prepared = prepareSkin(arm.skin, skinMethodNamed(name), arm.spread);
    // The tube's weights overlap over half of each bone, far more than a body's: what linear blending still
    // loses.
    EXPECT_GE(narrowest(blendSkin(prepared, frames, &q)), std::string(name) == "lbs" ? 0.93 : 0.99) << name;
  }
}

TEST(SkinMethods, AnUnknownNameListsThoseThereAre) {
  try {
    skinMethodNamed("implicit");
    FAIL();
  } catch (const std::invalid_argument& error) {
    for (const SkinMethod* method : skinMethods())
      EXPECT_NE(std::string(error.what()).find(method->name), std::string::npos);
  }
  const TwistedArm arm = twistedArm();
  EXPECT_THROW(poseBones(prepareSkin(arm.skin, skinMethodNamed("cor")), Frames(2, Isometry3d::Identity())),
               std::invalid_argument);
}

TEST(RotationCentres, LieOnTheAxisOfATubeAndBinsMoveTheSkinByLessThanHalfAMillimetre) {
  const TwistedArm arm = twistedArm();
  std::vector<bool> blended;
  const std::vector<Vector3d> centres = rotationCentres(arm.skin, &blended);
  int count = 0;
  for (std::size_t v = 0; v < centres.size(); ++v) {
    if (!blended[v]) continue;
    ++count;
    EXPECT_LE(Vector3d(0, centres[v].y(), centres[v].z()).norm(), 1e-4);
  }
  EXPECT_GT(count, 500);
  Eigen::VectorXd q = arm.skeleton.rest();
  q[arm.skeleton.qIndex(2)] = 1.6;
  const Frames frames = forwardKinematics(arm.skeleton, q);
  PreparedSkin binned = prepareSkin(arm.skin, skinMethodNamed("cor")), exact = binned;
  exact.centres = rotationCentres(arm.skin, nullptr, 0);
  EXPECT_LE(largestDistance(blendSkin(binned, frames), blendSkin(exact, frames)), 5e-4);
}

TEST(SurfaceSlopes, ALinearWeightHasItsSlope) {
  const TwistedArm arm = twistedArm();
  const auto slopes = weightSlopes(arm.skin);
  // Weights go from 0 to 1 within a link, along x: |dw/dx| = 1 / link where both neighbours lie in the ramp.
  int checked = 0;
  for (std::size_t v = 0; v < slopes.size(); ++v) {
    EXPECT_LE(slopes[v].colwise().sum().norm(), 1e-12);
    const Vector3d& p = arm.skin.mesh.positions[v];
    if (std::abs(p.x() - link) > 0.4 * link) continue;
    const Vector3d along = surfaceTangents(arm.skin.mesh.normals[v]) * slopes[v].row(0).transpose();
    EXPECT_NEAR(std::abs(along.x()), 1.0 / link, 1e-9);
    EXPECT_LE(along.tail<2>().norm(), 1e-9);
    ++checked;
  }
  EXPECT_GT(checked, 100);
}

TEST(SurfaceSlopes, TangentsAreRightHandedAndUnit) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 200; ++i) {
    Vector3d n =
        testing::bent(Skeleton({{.name = "ball", .ball = true}}), random, 3.0).tail<3>().normalized();
    if (i == 0) n = -Vector3d::UnitZ();
    if (i == 1) n = Vector3d::UnitX();
    const auto t = surfaceTangents(n);
    EXPECT_LE((t.transpose() * t - Eigen::Matrix2d::Identity()).norm(), 1e-14);
    EXPECT_LE((Vector3d(t.col(0)).cross(Vector3d(t.col(1))) - n).norm(), 1e-14);
  }
}

/// A tube along x whose weights step from its first joint to its second, smoothed: how far they are from what
/// two steps of heat over the length `spread` make of the step.
double farFromHeat(double radius, double length, double spread) {
  Skin tube = testing::arm(2, 0.3, radius, 60, 40).skin;  // rings 5 mm apart
  constexpr double step = 0.2975;
  for (std::size_t v = 0; v < tube.influences.size(); ++v)
    tube.influences[v] = {.joints = {tube.mesh.positions[v].x() < step ? 0 : 1, 0, 0, 0},
                          .weights = {1, 0, 0, 0}};
  const Skin smooth = smoothWeights(tube, length);
  double most = 0.0;
  for (std::size_t v = 0; v < smooth.influences.size(); ++v) {
    const Influences& in = smooth.influences[v];
    double sum = 0.0, second = 0.0;
    for (int k = 0; k < 4; ++k) {
      sum += in.weights[k];
      if (in.joints[k] == 1) second += in.weights[k];
    }
    EXPECT_NEAR(sum, 1.0, 1e-9);
    const double x = smooth.mesh.positions[v].x() - step;
    // One implicit step spreads by exp(-|x| / a) / (2 a), a = length / 2, two by that with itself:
    // integrated, 1 - (2 + x / a) exp(-x / a) / 4 beside the step.
    const double far = std::abs(x) / (0.5 * spread), beyond = 0.25 * (2.0 + far) * std::exp(-far);
    most = std::max(most, std::abs(second - (x > 0.0 ? 1.0 - beyond : beyond)));
  }
  return most;
}

TEST(WeightSmoothing, AStepBecomesWhatTwoStepsOfHeatMakeOfItAndConstantsStay) {
  constexpr double length = 0.03;
  EXPECT_LE(farFromHeat(0.05, length, length), 0.02);  // rings of 5 mm are coarse against a
  Skin tube = testing::arm(2, 0.3, 0.05, 60, 40).skin;
  for (Influences& in : tube.influences) in = {.joints = {1, 0, 0, 0}, .weights = {1, 0, 0, 0}};
  for (const Influences& in : smoothWeights(tube, length).influences) EXPECT_EQ(in.weights[0], 1.0);
  EXPECT_THROW(smoothWeights(tube, -1.0), std::invalid_argument);
}

TEST(WeightSmoothing, AThinLimbIsSmoothedOverItsRadius) {
  EXPECT_LE(farFromHeat(0.02, 0.045, 0.02), 0.02);
  EXPECT_GE(farFromHeat(0.02, 0.045, 0.045), 0.05);  // and the measure tells one from the other
  EXPECT_LE(farFromHeat(0.06, 0.045, 0.045), 0.02);
}

}  // namespace
}  // namespace gelenk
