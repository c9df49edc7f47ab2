#include "skinning/muscles/muscle_layer.h"

#include <gtest/gtest.h>

#include "tests/kinematics/random_skeleton.h"

namespace gelenk {
namespace {

using Eigen::AngleAxisd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// A chain of 2 to 4 links of different length, swing to 150 and twist to 170 degrees at every joint.
struct RandomLimb {
  LimbShape shape;
  LimbFrames frames;
  std::vector<MuscleState> muscles;
};

double uniform(std::mt19937_64& random, double lower, double upper) {
  return lower + (upper - lower) * uniform01(random);
}

RandomLimb randomLimb(std::mt19937_64& random) {
  const int links = 2 + static_cast<int>(random() % 3);
  std::vector<double> lengths;
  for (int i = 0; i < links; ++i) lengths.push_back(uniform(random, 0.15, 0.5));
  RandomLimb limb{.shape = defaultLimbShape(lengths), .frames = {}, .muscles = {}};
  for (int i = 0; i + 1 < links; ++i) limb.shape.seamTwistShare.push_back(uniform01(random));
  limb.frames.joints.push_back(testing::randomUnit(random));
  limb.frames.rotations.push_back(expRotation(3.0 * testing::randomUnit(random)).toRotationMatrix());
  limb.frames.nearTwist = uniform(random, -1.0, 1.0);
  limb.frames.farTwist = uniform(random, -1.0, 1.0);
  for (int i = 0; i < links; ++i) {
    const Matrix3d R = limb.frames.rotations.back();
    limb.frames.joints.push_back(limb.frames.joints.back() + lengths[i] * R.col(2));
    if (i + 1 == links) break;
    const double side = uniform(random, 0.0, 2.0 * M_PI);
    const AngleAxisd swing(uniform(random, 0.0, 150.0 * M_PI / 180.0),
                           Vector3d(std::cos(side), std::sin(side), 0.0));
    const AngleAxisd twist(uniform(random, -170.0, 170.0) * M_PI / 180.0, Vector3d::UnitZ());
    limb.frames.rotations.push_back(R * swing * twist);
  }
  for (int i = 0; i < links; ++i) {
    const auto muscle = [&] {
      Eigen::Matrix2d S;
      S << uniform(random, 0.7, 1.5), uniform(random, -0.2, 0.2), 0.0, uniform(random, 0.7, 1.5);
      S(1, 0) = S(0, 1);
      return MusclePlane{S, {uniform(random, -0.02, 0.02), uniform(random, -0.02, 0.02)}};
    };
    limb.muscles.push_back({muscle(), muscle()});
  }
  return limb;
}

/// Largest jump of position and of the three first derivatives between volume v at w = 1 and volume v + 1 at
/// w = 0.
double seamJump(const LimbPose& pose) {
  double worst = 0.0;
  for (int v = 0; v + 1 < pose.volumeCount(); ++v)
    for (const Vector2d& uv :
         {Vector2d(0.1, 0.2), Vector2d(0.5, 0.5), Vector2d(0.9, 0.3), Vector2d(0.0, 1.0)}) {
      const FfdSample before = pose.evaluate(v, {uv.x(), uv.y(), 1.0});
      const FfdSample after = pose.evaluate(v + 1, {uv.x(), uv.y(), 0.0});
      worst = std::max({worst, (before.position - after.position).norm(),
                        (before.derivatives - after.derivatives).norm()});
    }
  return worst;
}

TEST(MuscleLayer, PositionAndFirstDerivativesAgreeAcrossEverySeam) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const RandomLimb limb = randomLimb(random);
    EXPECT_LE(seamJump(poseLimb(limb.shape, limb.frames, limb.muscles)), 1e-11) << "chain " << i;
  }
}

TEST(MuscleLayer, FreeControlPointsOfTheMuscleKeepTheSeamsSmooth) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 200; ++i) {
    RandomLimb limb = randomLimb(random);
    for (MuscleState& muscle : limb.muscles)
      for (MusclePlane* plane : {&muscle.plane2, &muscle.plane4})
        for (int c = 0; c < 16; ++c) plane->displacement.push_back(0.02 * testing::randomUnit(random));
    EXPECT_LE(seamJump(poseLimb(limb.shape, limb.frames, limb.muscles)), 1e-11);
  }
}

TEST(MuscleLayer, EachOfTheTwoConstraintsIsNeeded) {
  std::mt19937_64 random(3);
  const RandomLimb limb = randomLimb(random);
  LimbPose unequalRatio = poseLimb(limb.shape, limb.frames, limb.muscles);
  unequalRatio.planes[7].origin +=
      0.01 * (unequalRatio.planes[7].origin - unequalRatio.planes[6].origin);  // plane 1'
  EXPECT_GT(seamJump(unequalRatio), 1e-4);
  LimbPose unevenInner = poseLimb(limb.shape, limb.frames, limb.muscles);
  unevenInner.planes[3].origin += Vector3d(0.001, 0.0, 0.0);  // plane 3 off the middle of 2 and 4
  EXPECT_GT(seamJump(unevenInner), 1e-4);
}

TEST(MuscleLayer, SeamKeepsItsAreaAndItsDistanceToTheTips) {
  std::mt19937_64 random(4);
  for (int i = 0; i < 300; ++i) {
    const RandomLimb limb = randomLimb(random);
    const LimbPose pose = poseLimb(limb.shape, limb.frames, limb.muscles);
    const Vector2d size = limb.shape.sectionUpper - limb.shape.sectionLower;
    for (std::size_t j = 1; j < limb.shape.links.size(); ++j) {
      const FfdPlane& seam = pose.planes[6 * j];
      EXPECT_NEAR(seam.axes.col(0).cross(seam.axes.col(1)).norm(), size.x() * size.y(), 1e-12);
      const Vector2d middle = -limb.shape.sectionLower.cwiseQuotient(size);  // the bone itself
      const Vector3d centre = seam.point(middle.x(), middle.y());
      EXPECT_NEAR((centre - limb.frames.joints[j + 1]).norm(), limb.shape.links[j].length, 1e-12);
      EXPECT_NEAR((centre - limb.frames.joints[j - 1]).norm(), limb.shape.links[j - 1].length, 1e-12);
    }
  }
}

TEST(MuscleLayer, SixtyFourPointsEqualTheAffineRoute) {
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    const RandomLimb limb = randomLimb(random);
    const LimbPose pose = poseLimb(limb.shape, limb.frames, limb.muscles);
    for (int v = 0; v < pose.volumeCount(); ++v) {
      const Vector3d uvw(uniform01(random), uniform01(random), uniform01(random));
      const FfdPlane* planes = &pose.planes[3 * v];
      const FfdLattice lattice = latticeOf({planes[0], planes[1], planes[2], planes[3]});
      const FfdSample full = lattice.evaluate(uvw), affine = evaluateAffine(planes, uvw);
      EXPECT_LE((full.position - affine.position).norm(), 1e-12);
      EXPECT_LE((full.derivatives - affine.derivatives).norm(), 1e-12);
      EXPECT_LE((lattice.position(uvw) - full.position).norm(), 1e-14);
      EXPECT_LE((lattice.position(pose.turned(v, uvw)) - pose.position(v, uvw)).norm(), 1e-12);
    }
  }
}

TEST(MuscleLayer, DerivativesAreThoseOfThePositionTwistAndDisplacementsIncluded) {
  std::mt19937_64 random(11);
  for (int i = 0; i < 50; ++i) {
    RandomLimb limb = randomLimb(random);
    if (i % 2 == 1)
      for (int c = 0; c < 16; ++c)
        limb.muscles[0].plane4.displacement.push_back(0.02 * testing::randomUnit(random));
    const LimbPose pose = poseLimb(limb.shape, limb.frames, limb.muscles);
    for (int v = 0; v < pose.volumeCount(); ++v) {
      const Vector3d uvw(uniform01(random), uniform01(random), uniform01(random));
      const FfdSample at = pose.evaluate(v, uvw);
      EXPECT_LE((at.position - pose.position(v, uvw)).norm(), 1e-14);
      constexpr double h = 1e-6;
      for (int k = 0; k < 3; ++k) {
        const Vector3d step = h * Vector3d::Unit(k);
        const Vector3d slope = (pose.position(v, uvw + step) - pose.position(v, uvw - step)) / (2.0 * h);
        EXPECT_LE((slope - at.derivatives.col(k)).norm(), 1e-8) << "chain " << i << " d/d"
                                                                << "uvw"[k];
      }
    }
  }
}

TEST(MuscleLayer, TwistAlongAStraightLimbKeepsEverySectionAndTurnsItEvenly) {
  const LimbShape shape = defaultLimbShape({0.3, 0.25});
  for (const double twist : {0.5, 1.4, 3.0}) {
    const LimbFrames frames{.joints = {{0, 0, 0}, {0, 0, 0.3}, {0, 0, 0.55}},
                            .rotations = {Matrix3d::Identity(), Matrix3d::Identity()},
                            .farTwist = twist};
    const LimbPose pose = poseLimb(shape, frames);
    double before = 0.0;
    for (int v = 0; v < pose.volumeCount(); ++v)
      for (double w = 0.0; w < 1.0; w += 0.05) {
        const FfdSample at = pose.evaluate(v, {0.9, 0.5, w});  // 0.08 m from the bone
        EXPECT_NEAR(at.position.head<2>().norm(), 0.08, 1e-12) << twist;
        const Vector3d area = at.derivatives.col(0).cross(at.derivatives.col(1));
        EXPECT_NEAR(area.z(), 0.04, 1e-12);  // a blend of turned planes: down to cos^2(twist / 2) of it
        const double turned = std::atan2(at.position.y(), at.position.x());
        EXPECT_GE(turned, before - 1e-12);
        before = turned;
        if (v < 2) EXPECT_NEAR(turned, 0.0, 1e-12) << "the upper link takes none of the hand's";
      }
  }
}

TEST(MuscleLayer, RigidMotionCommutes) {
  std::mt19937_64 random(6);
  for (int i = 0; i < 100; ++i) {
    const RandomLimb limb = randomLimb(random);
    Eigen::Isometry3d motion(expRotation(2.0 * testing::randomUnit(random)));
    motion.translation() = testing::randomUnit(random);
    LimbFrames moved = limb.frames;
    for (Vector3d& joint : moved.joints) joint = motion * joint;
    for (Matrix3d& R : moved.rotations) R = motion.linear() * R;
    const LimbPose here = poseLimb(limb.shape, limb.frames, limb.muscles),
                   there = poseLimb(limb.shape, moved, limb.muscles);
    for (int v = 0; v < here.volumeCount(); ++v) {
      const Vector3d uvw(uniform01(random), uniform01(random), uniform01(random));
      EXPECT_LE((motion * here.evaluate(v, uvw).position - there.evaluate(v, uvw).position).norm(), 1e-12);
    }
  }
}

TEST(MuscleLayer, MusclesLeaveTheOuterPlanesAndTheirTangentsFixed) {
  std::mt19937_64 random(7);
  const RandomLimb limb = randomLimb(random);
  const LimbPose with = poseLimb(limb.shape, limb.frames, limb.muscles),
                 without = poseLimb(limb.shape, limb.frames);
  for (int v = 0; v < with.volumeCount(); ++v) {
    const Vector3d uvw(0.3, 0.8, v % 2 == 0 ? 0.0 : 1.0);  // plane 0 or plane 6 of the link
    EXPECT_LE((with.evaluate(v, uvw).position - without.evaluate(v, uvw).position).norm(), 1e-15);
    EXPECT_LE((with.evaluate(v, uvw).derivatives - without.evaluate(v, uvw).derivatives).norm(), 1e-13);
  }
}

TEST(MuscleLayer, EndsJoinTheRigidBodyWithEqualPositionAndTangent) {
  std::mt19937_64 random(8);
  for (int i = 0; i < 100; ++i) {
    const RandomLimb limb = randomLimb(random);
    const LimbPose pose = poseLimb(limb.shape, limb.frames, limb.muscles);
    const Vector2d uv(0.2, 0.7),
        p = limb.shape.sectionLower + uv.cwiseProduct(limb.shape.sectionUpper - limb.shape.sectionLower);
    const FfdSample near = pose.evaluate(0, {uv.x(), uv.y(), 0.0});
    EXPECT_LE((near.position - pose.worldFromNearEnd * Vector3d(p.x(), p.y(), 0.0)).norm(), 1e-13);
    EXPECT_LE((near.derivatives.col(2) / (3.0 * limb.shape.links.front().nearGap) -
               pose.worldFromNearEnd.linear().col(2))
                  .norm(),
              1e-12);
    const FfdSample far = pose.evaluate(pose.volumeCount() - 1, {uv.x(), uv.y(), 1.0});
    EXPECT_LE((far.position - pose.worldFromFarEnd * Vector3d(p.x(), p.y(), 0.0)).norm(), 1e-13);
    EXPECT_LE((far.derivatives.col(2) / (3.0 * limb.shape.links.back().farGap) -
               pose.worldFromFarEnd.linear().col(2))
                  .norm(),
              1e-12);
  }
}

TEST(MuscleLayer, StraightLimbIsTheIdentity) {
  const LimbShape shape = defaultLimbShape({0.3, 0.25});
  LimbFrames frames{.joints = {{0, 0, 0}, {0, 0, 0.3}, {0, 0, 0.55}},
                    .rotations = {Matrix3d::Identity(), Matrix3d::Identity()}};
  const LimbPose pose = poseLimb(shape, frames);
  for (int v = 0; v < pose.volumeCount(); ++v)
    for (double w = 0.0; w <= 1.0; w += 0.25) {
      const FfdSample sample = pose.evaluate(v, {0.25, 0.75, w});
      EXPECT_NEAR(sample.position.x(), -0.05, 1e-15);
      EXPECT_NEAR(sample.position.y(), 0.05, 1e-15);
      EXPECT_GT(sample.derivatives(2, 2), 0.0);  // z grows along the bone: no fold
    }
}

std::string complaintAbout(const LimbShape& shape) {
  try {
    validate(shape);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "accepted";
}

TEST(MuscleLayer, ImpossibleProportionsAreNamed) {
  EXPECT_THROW(defaultLimbShape({}), std::invalid_argument);
  EXPECT_THROW(defaultLimbShape({0.3, 0.0}), std::invalid_argument);
  EXPECT_THROW(defaultLimbShape({0.3, std::nan("")}), std::invalid_argument);
  const auto changed = [](const auto& change) {
    LimbShape shape = defaultLimbShape({0.3, 0.3});
    change(shape);
    return complaintAbout(shape);
  };
  const double nan = std::nan("");
  EXPECT_EQ(changed([](LimbShape&) {}), "accepted");
  EXPECT_NE(changed([](LimbShape& s) {
              s.links[0].farGap *= 0.5;
            }).find("link 1 of the limb violates nearGap equal to farGap"),
            std::string::npos);
  EXPECT_NE(changed([](LimbShape& s) {
              s.links[1].inner = 0.2;
            }).find("link 1 of the limb violates 0 < nearGap < middle - inner"),
            std::string::npos);
  EXPECT_NE(
      changed([](LimbShape& s) { s.links[0].inner = 0.0; }).find("link 0 of the limb violates inner > 0"),
      std::string::npos);
  EXPECT_NE(
      changed([](LimbShape& s) { s.links[0].length = 0.0; }).find("link 0 of the limb violates length > 0"),
      std::string::npos);
  EXPECT_NE(changed([=](LimbShape& s) { s.links[0].middle = nan; }).find("link 0"), std::string::npos);
  EXPECT_NE(changed([](LimbShape& s) { setJointGap(s, 0.45); }).find("middle + inner < length - farGap"),
            std::string::npos);
  EXPECT_NE(changed([](LimbShape& s) { s.sectionUpper = s.sectionLower; }).find("rectangle is empty"),
            std::string::npos);
  EXPECT_NE(changed([=](LimbShape& s) { s.sectionUpper.x() = nan; }).find("rectangle is empty"),
            std::string::npos);
  EXPECT_NE(changed([](LimbShape& s) { s.wedge = 0.5; }).find("[0, 1/2)"), std::string::npos);
}

TEST(MuscleLayer, AWrongNumberOfDisplacedPointsIsNamed) {
  const LimbShape shape = defaultLimbShape({0.3});
  const LimbFrames frames{.joints = {{0, 0, 0}, {0, 0, 0.3}}, .rotations = {Matrix3d::Identity()}};
  MuscleState muscle;
  muscle.plane4.displacement.resize(15, Vector3d::Zero());
  try {
    poseLimb(shape, frames, {muscle});
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("15 displaced control points, expected 16"), std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace gelenk
