#include "kinematics/motion/motion_edit.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "kinematics/io/asf_amc.h"
#include "tests/kinematics/random_skeleton.h"
#include "tests/places.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

Skeleton swingAndBall() {
  Joint root{.name = "root"};
  for (int k = 0; k < 3; ++k) root.axes.push_back({AxisDof::Kind::Translation, Vector3d::Unit(k)});
  root.ball = true;
  Joint hinge{.name = "hinge", .parent = 0};
  hinge.parentFromZero.translation() = Vector3d(0, 1, 0);
  hinge.axes = {{AxisDof::Kind::Rotation, Vector3d::UnitX()}};
  return Skeleton({root, hinge});
}

/// Root slides along x as a sine of that frequency, turns about y likewise, the hinge too.
MotionClip sine(const Skeleton& skeleton, double hertz, double rate, int frames) {
  MotionClip clip{.framesPerSecond = rate, .q = Eigen::MatrixXd::Zero(skeleton.nq(), frames)};
  for (int f = 0; f < frames; ++f) {
    const double s = std::sin(2.0 * M_PI * hertz * f / rate);
    VectorXd q = neutral(skeleton);
    q[0] = s;
    setBallRotation(skeleton, q, 0, expRotation(Vector3d(0, 0.1 * s, 0)));
    q[7] = 0.5 * s;
    clip.q.col(f) = q;
  }
  return clip;
}

/// Amplitude relative to the input, and the shift in time (from the phase), in the middle of the clip.
std::pair<double, double> gainAndDelay(const Eigen::VectorXd& out, double hertz, double rate) {
  double c = 0.0, s = 0.0;
  int n = 0;
  const int period = static_cast<int>(std::lround(rate / hertz));
  for (int f = 4 * period; f < out.size() - 4 * period && n < 8 * period; ++f, ++n) {
    c += out[f] * std::cos(2.0 * M_PI * hertz * f / rate);
    s += out[f] * std::sin(2.0 * M_PI * hertz * f / rate);
  }
  return {2.0 * std::hypot(c, s) / n, std::atan2(c, s) / (2.0 * M_PI * hertz)};
}

TEST(LowPass, HalvesThePowerAtItsCutOffWithoutDelay) {
  const Skeleton skeleton = swingAndBall();
  const double rate = 120.0;
  const auto at = [&](double hertz) {
    return gainAndDelay(lowPassed(skeleton, sine(skeleton, hertz, rate, 1200), 6.0).q.row(0), hertz, rate);
  };
  EXPECT_NEAR(at(6.0).first, std::sqrt(0.5), 1e-3);
  EXPECT_GT(at(1.0).first, 0.999);
  EXPECT_LT(at(24.0).first, 0.01);
  for (const double hertz : {1.0, 6.0}) EXPECT_NEAR(at(hertz).second, 0.0, 1e-4);
}

TEST(LowPass, TurnsAreFilteredLikeAnglesWhereTheyAreSmall) {
  const Skeleton skeleton = swingAndBall();
  const MotionClip clip = sine(skeleton, 6.0, 120.0, 1200), smooth = lowPassed(skeleton, clip, 6.0);
  Eigen::VectorXd angle(1200);
  for (int f = 0; f < 1200; ++f)
    angle[f] = logRotation(jointRotation(skeleton, smooth.q.col(f), 0)).y() / 0.1;
  EXPECT_NEAR(gainAndDelay(angle, 6.0, 120.0).first, std::sqrt(0.5), 3e-3);
  for (int f = 0; f < 1200; ++f) EXPECT_NEAR(ballRotation(skeleton, smooth.q.col(f), 0).norm(), 1.0, 1e-12);
}

TEST(LowPass, AConstantPoseAndAStraightLineStay) {
  const Skeleton skeleton = swingAndBall();
  MotionClip clip{.framesPerSecond = 60.0, .q = neutral(skeleton).replicate(1, 100)};
  for (int f = 0; f < 100; ++f) clip.q(0, f) = 0.01 * f;
  const MotionClip smooth = lowPassed(skeleton, clip, 5.0);
  EXPECT_LE((smooth.q - clip.q).middleCols(20, 60).cwiseAbs().maxCoeff(), 1e-3);
  EXPECT_THROW(lowPassed(skeleton, clip, 30.0), std::invalid_argument);
}

class Layered : public ::testing::TestWithParam<Layer::Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Layered, ::testing::Values(Layer::Kind::Override, Layer::Kind::Additive));

TEST_P(Layered, WeightOneOverTheReferenceGivesTheLayerAndWeightZeroTheBase) {
  std::mt19937_64 random(6);
  Joint ball{.name = "a", .ball = true};
  Joint second{.name = "b", .parent = 0, .ball = true};
  const Skeleton skeleton({ball, second});
  const VectorXd reference = randomWithinLimits(skeleton, random);
  MotionClip base{.framesPerSecond = 30, .q = reference.replicate(1, 4)}, layer = base;
  for (int f = 0; f < 4; ++f) layer.q.col(f) = randomWithinLimits(skeleton, random);
  const auto over = [&](Layer::Kind kind, double weight, std::vector<int> joints) {
    return layered(
        skeleton, base,
        {.clip = layer, .kind = kind, .weight = weight, .joints = std::move(joints), .reference = reference});
  };
  const auto kind = GetParam();
  const MotionClip whole = over(kind, 1.0, {}), none = over(kind, 0.0, {}), masked = over(kind, 1.0, {1});
  for (int f = 0; f < 4; ++f)
    for (int i = 0; i < 2; ++i) {
      const auto angle = [&](const MotionClip& a, const MotionClip& b) {
        return logRotation(jointRotation(skeleton, a.q.col(f), i).conjugate() *
                           jointRotation(skeleton, b.q.col(f), i))
            .norm();
      };
      EXPECT_LE(angle(whole, layer), 1e-12);
      EXPECT_LE(angle(none, base), 1e-12);
      EXPECT_LE(angle(masked, i == 1 ? layer : base), 1e-12);
    }
}

TEST(Layer, HalfAWeightOfAHalfTurnedHingeIsAQuarterOfATurnInBothKinds) {
  const Skeleton skeleton = swingAndBall();
  MotionClip base{.framesPerSecond = 30, .q = neutral(skeleton).replicate(1, 3)}, layer = base;
  base.q.row(7).setConstant(0.2);
  base.q.row(0).setConstant(5.0);
  layer.q.row(7).setConstant(1.0);
  const std::vector<int> hinge{1};
  const MotionClip added =
      layered(skeleton, base, {.clip = layer, .kind = Layer::Kind::Additive, .weight = 0.5, .joints = hinge});
  const MotionClip mixed = layered(skeleton, base, {.clip = layer, .weight = 0.5, .joints = hinge});
  EXPECT_NEAR(added.q(7, 2), 0.2 + 0.5 * 1.0, 1e-15);  // 0.5 of the departure from rest on top
  EXPECT_NEAR(mixed.q(7, 2), 0.5 * (0.2 + 1.0), 1e-15);
  EXPECT_EQ(mixed.q(0, 2), 5.0);  // the root takes no part
  EXPECT_EQ(limbBelow(skeleton, 0), (std::vector<int>{0, 1}));
  for (const double weight : {-0.1, 1.1, std::nan("")})
    EXPECT_THROW(layered(skeleton, base, {.clip = layer, .weight = weight}), std::invalid_argument);
  EXPECT_THROW(layered(skeleton, base, {.clip = layer, .joints = {2}}), std::invalid_argument);
}

TEST(CrossFade, BeginsAsTheFirstEndsAsTheSecondAndNeverJumps) {
  const Skeleton skeleton = swingAndBall();
  MotionClip first = sine(skeleton, 0.5, 60.0, 120), second = sine(skeleton, 0.7, 60.0, 120);
  for (int f = 0; f < 120; ++f) {
    first.q.col(f)[0] = 0.01 * f;  // walks along x
    VectorXd q = second.q.col(f);  // walks along z, from elsewhere, heading a quarter turn to the side
    q.head<3>() = Vector3d(5, 0, 7 - 0.01 * f);
    setBallRotation(skeleton, q, 0, expRotation(Vector3d(0, M_PI / 2, 0)) * ballRotation(skeleton, q, 0));
    second.q.col(f) = q;
  }
  const MotionClip both = crossFaded(skeleton, first, second, 0.5);
  ASSERT_EQ(both.frameCount(), 210);
  EXPECT_EQ(both.q.col(0), first.q.col(0));
  double largest = 0.0;
  for (int f = 1; f < both.frameCount(); ++f)
    largest = std::max(largest, (both.q.col(f) - both.q.col(f - 1)).head<3>().norm());
  EXPECT_LE(largest, 0.02);  // each walks 0.01 a frame
  // Aligned, the second goes on where the first one's root faced when the fade began: frame 90, turned by 0.1
  // sin(1.5 pi) about y.
  const Vector3d onward = 0.09 * (expRotation(Vector3d(0, -0.1, 0)) * Vector3d::UnitX());
  EXPECT_LE(((both.q.col(209) - both.q.col(200)).head<3>() - onward).norm(), 1e-9);
}

TEST(Keyed, IsHitExactlyAndForgottenBeyondTheFalloff) {
  const Skeleton skeleton = swingAndBall();
  const MotionClip clip = sine(skeleton, 0.5, 60.0, 120);
  VectorXd turned = clip.q.col(40), moved = clip.q.col(60);
  setBallRotation(skeleton, turned, 0, expRotation({0.3, 0, 0}));
  setBallRotation(skeleton, moved, 0, expRotation({0, 0, 0.4}));
  moved.head<3>() += Vector3d(0.1, 0.2, 0.3);
  moved[7] += 1.0;  // of another joint: not asked for
  const std::vector<JointKey> keys{{40, turned}, {60, moved}};
  const MotionClip result = keyed(skeleton, clip, 0, keys, 0.25);
  for (const JointKey& key : keys) EXPECT_EQ(result.q.col(key.frame).head<7>(), key.q.head<7>());
  EXPECT_EQ(result.q.row(7), clip.q.row(7));
  EXPECT_LE((result.q.col(24) - clip.q.col(24)).norm(), 1e-12);
  EXPECT_LE((result.q.col(76) - clip.q.col(76)).norm(), 1e-12);
  // Half-way between the keys half of each departure, and half a second's fade is half there after an eighth.
  EXPECT_LE(((result.q.col(50) - clip.q.col(50)).head<3>() - Vector3d(0.05, 0.1, 0.15)).norm(), 1e-12);
  EXPECT_NEAR((result.q(0, 67) - clip.q(0, 67)) + (result.q(0, 68) - clip.q(0, 68)), 0.1, 1e-12);
}

TEST(FootPlant, WalkStandsStillAboveTheFloorAndTheRestOfTheBodyStays) {
  const std::string data = testing::dataFolder() + "/mocap/asf/";
  if (!std::filesystem::exists(data + "02_01.amc")) GTEST_SKIP() << "no trial data at " << data;
  const AsfSkeleton asf = readAsf(data + "02.asf");
  const MotionClip clip = readAmc(data + "02_01.amc", asf);
  const auto feet = cmuFeet(asf.skeleton);
  ASSERT_EQ(feet.size(), 2u);
  const auto contacts = footContacts(asf.skeleton, clip, feet);
  EXPECT_GE(contacts.size(), 5u);  // six steps, the first and last cut
  EXPECT_LE(contacts.size(), 8u);
  const FootFacts before = footFacts(asf.skeleton, clip, feet, contacts, 0.0);
  EXPECT_GT(before.meanSlide, 0.3e-3);
  EXPECT_GT(before.deepestPenetration, 2e-3);
  const MotionClip planted = footPlanted(asf.skeleton, clip, feet, contacts);
  const FootFacts after = footFacts(asf.skeleton, planted, feet, contacts, 0.0);
  EXPECT_LE(after.largestSlide, 0.1e-3);
  EXPECT_EQ(after.deepestPenetration, 0.0);
  for (int f = 0; f < clip.frameCount(); ++f) {
    const Frames a = forwardKinematics(asf.skeleton, clip.q.col(f)),
                 b = forwardKinematics(asf.skeleton, planted.q.col(f));
    for (int i = 0; i < asf.skeleton.jointCount(); ++i)
      ASSERT_LE((a[i].translation() - b[i].translation()).norm(), 0.02)
          << asf.skeleton.joint(i).name << ' ' << f;
    for (const char* still : {"head", "lhand", "rhand", "thorax", "root"})
      EXPECT_EQ(
          (a[asf.skeleton.jointIndex(still)].matrix() - b[asf.skeleton.jointIndex(still)].matrix()).norm(),
          0.0);
  }
}

}  // namespace
}  // namespace gelenk
