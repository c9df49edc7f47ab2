// Loading and playing motion capture. The clips are made here from a CMU-like skeleton: 30 bones, 62 values a
// frame.
#include <benchmark/benchmark.h>

#include <random>

#include "kinematics/configuration.h"
#include "kinematics/forward_kinematics.h"
#include "kinematics/io/asf_amc.h"
#include "kinematics/io/bvh.h"

namespace gelenk {
namespace {

constexpr int frames = 5000;

/// A root, nine bones of three dofs, ten of two, nine of one, two of none: 6 + 27 + 20 + 9 = 62 values.
AsfSkeleton cmuLikeSkeleton() {
  std::string bones = ":bonedata\n", tree = ":hierarchy\nbegin\n";
  for (int b = 0; b < 30; ++b) {
    const char* dofs = b < 9 ? " dof rx ry rz\n" : b < 19 ? " dof rx rz\n" : b < 28 ? " dof rx\n" : "";
    const std::string name = "bone" + std::to_string(b);
    bones +=
        "begin\n name " + name + "\n direction 0 1 0\n length 4.5\n axis 10 20 30 XYZ\n" + dofs + "end\n";
    tree += (b % 6 == 0 ? "root" : "bone" + std::to_string(b - 1)) + " " + name + "\n";
  }
  return parseAsf(
      ":units\nlength 0.45\nangle deg\n:root\norder TX TY TZ RX RY RZ\naxis XYZ\n" + bones + tree + "end\n",
      "made.asf");
}

MotionClip walk(const Skeleton& skeleton) {
  std::mt19937_64 random(1);
  MotionClip clip{.framesPerSecond = 120.0, .q = Eigen::MatrixXd(skeleton.nq(), frames)};
  for (int i = 0; i < skeleton.nq(); ++i) {
    const double phase = 6.0 * uniform01(random), speed = 0.02 + 0.05 * uniform01(random);
    for (int f = 0; f < frames; ++f) clip.q(i, f) = std::sin(phase + speed * f);
  }
  return clip;
}

void LoadAmc5000Frames(benchmark::State& state) {
  const AsfSkeleton asf = cmuLikeSkeleton();
  const std::string text =
      formatAmc(asf.skeleton, walk(asf.skeleton));  // 17 digits a number: longer than CMU's six
  for (auto _ : state) benchmark::DoNotOptimize(parseAmc(text, "made.amc", asf));
  state.counters["MB"] = static_cast<double>(text.size()) / 1e6;
}
BENCHMARK(LoadAmc5000Frames)->Unit(benchmark::kMillisecond);

void LoadBvh5000Frames(benchmark::State& state) {
  const AsfSkeleton asf = cmuLikeSkeleton();
  const std::string text = formatBvh(asf.skeleton, walk(asf.skeleton));
  for (auto _ : state) benchmark::DoNotOptimize(parseBvh(text, "made.bvh"));
  state.counters["MB"] = static_cast<double>(text.size()) / 1e6;
}
BENCHMARK(LoadBvh5000Frames)->Unit(benchmark::kMillisecond);

/// A frame between two samples: interpolation on quaternions, angles back, forward kinematics.
void PlayOneFrame(benchmark::State& state) {
  const AsfSkeleton asf = cmuLikeSkeleton();
  const MotionClip clip = walk(asf.skeleton);
  Eigen::VectorXd q;
  Frames pose;
  double seconds = 0.0;
  for (auto _ : state) {
    sample(asf.skeleton, clip, seconds += 0.0171, BeyondEnd::Loop, q);
    forwardKinematics(asf.skeleton, q, pose);
    benchmark::DoNotOptimize(pose.data());
  }
}
BENCHMARK(PlayOneFrame)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace gelenk
