// The number of solutions by a method that shares nothing with the complete sets: joint 1 on a fine grid, the
// two elbows that put the wrist at its distance, and sign changes of the one equation that is left.
#include <gtest/gtest.h>

#include <cmath>

#include "solvers/solutions/arm_solutions.h"
#include "tests/solvers/solutions/example_arms.h"

namespace gelenk {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using testing::chainOf;

/// Any shoulder and elbow before a wrist whose axes meet at right angles (so that every orientation is its,
/// in two ways); standard convention, metres.
DhTable randomArmWithAWrist(std::mt19937_64& random) {
  const auto between = [&](double a, double b) { return a + (b - a) * uniform01(random); };
  const auto length = [&] { return (uniform01(random) < 0.5 ? -1.0 : 1.0) * between(0.1, 1.0); };
  std::vector<Vector3d> rows;
  for (int i = 0; i < 3; ++i) {
    const double a = length(), alpha = between(-M_PI, M_PI), d = length();
    rows.emplace_back(a, alpha, d);
  }
  rows.emplace_back(0, M_PI / 2, length());
  rows.emplace_back(0, -M_PI / 2, 0);
  rows.emplace_back(0, 0, between(-0.3, 0.3));
  return testing::standardTable("wrist", rows);
}

Isometry3d fixedPart(const ChainConstants& C, int i) {
  return Eigen::AngleAxisd(std::atan2(C.sinAlpha[i], C.cosAlpha[i]), Vector3d::UnitX()) *
         Eigen::Translation3d(C.a[i], 0, C.d[i]);
}

/// Twice the number of ways in which joints 1 to 3 place the wrist's centre: each leaves two wrists. Two ways
/// within one cell of the grid are not seen.
int countByGrid(const SerialChain& chain, const Isometry3d& pose, int grid) {
  const ChainConstants& C = chain.constants;
  const Isometry3d last = chain.worldFromBase.inverse() * pose * chain.lastFromTip.inverse();
  const Vector3d wrist = last * Vector3d(0, 0, -C.d[5]);
  const Isometry3d F2 = fixedPart(C, 1), F3 = fixedPart(C, 2);
  const Vector3d forearm = fixedPart(C, 3).translation();
  // |F3 Rz(u3) forearm|^2 = a + b cos u3 + c sin u3
  const Vector3d t = F3.linear().transpose() * F3.translation();
  const double a = forearm.squaredNorm() + t.squaredNorm() + 2.0 * t.z() * forearm.z(),
               b = 2.0 * (t.x() * forearm.x() + t.y() * forearm.y()),
               c = 2.0 * (t.y() * forearm.x() - t.x() * forearm.y()), r = std::hypot(b, c);
  struct Elbows {
    bool exist;
    double f[2];
  };
  const auto at = [&](double u1) -> Elbows {
    const Vector3d w = F2.inverse() * (Eigen::AngleAxisd(-u1, Vector3d::UnitZ()) * wrist);
    const double x = (w.squaredNorm() - a) / r;
    if (std::abs(x) > 1.0) return {false, {}};
    Elbows e{true, {}};
    for (int k = 0; k < 2; ++k) {
      const double u3 = std::atan2(c, b) + (k == 0 ? 1.0 : -1.0) * std::acos(x);
      e.f[k] = (F3 * (Eigen::AngleAxisd(u3, Vector3d::UnitZ()) * forearm)).z() - w.z();
    }
    return e;
  };
  const double h = 2.0 * M_PI / grid;
  std::vector<Elbows> e;
  for (int k = 0; k < grid; ++k) e.push_back(at((k + 0.5) * h));
  int ways = 0;
  for (int k = 0; k < grid; ++k) {
    const Elbows &now = e[k], &next = e[(k + 1) % grid];
    if (now.exist && next.exist) {
      for (int j = 0; j < 2; ++j) ways += (now.f[j] < 0.0) != (next.f[j] < 0.0);
    } else if (now.exist != next.exist) {
      // The two elbows merge within the cell: one root there where they have different signs before.
      double in = now.exist ? (k + 0.5) * h : (k + 1.5) * h, out = now.exist ? in + h : in - h;
      Elbows inside = now.exist ? now : next;
      const Elbows start = inside;
      for (int halving = 0; halving < 50; ++halving) {
        const double middle = 0.5 * (in + out);
        const Elbows m = at(middle);
        (m.exist ? in : out) = middle;
        if (m.exist) inside = m;
      }
      const bool end = inside.f[0] + inside.f[1] < 0.0;
      for (int j = 0; j < 2; ++j) ways += (start.f[j] < 0.0) != end;
    }
  }
  return 2 * ways;
}

/// 100 random arms and the PUMA, 100 poses each (seed 71), a quarter of a degree. Where that differs, ways
/// lie within one cell: a grid two hundred times finer agrees.
TEST(IndependentCount, AGridOfJointOneFindsAsManySolutions) {
  std::mt19937_64 random(71);
  int same = 0, finer = 0;
  std::array<int, 9> histogram{};
  for (int which = 0; which <= 100; ++which) {
    const DhTable table = which == 0 ? robotTable("puma560") : randomArmWithAWrist(random);
    const SixJointArm arm(chainOf(table));
    ASSERT_EQ(arm.kind(), LoopClass::SphericalTriple);
    for (int trial = 0; trial < 100; ++trial) {
      const Isometry3d pose = tipFrame(arm.chain(), testing::randomAngles(random));
      ArmSolutions found;
      arm.solve(pose, Vector6d::Zero(), found);
      ASSERT_LE(found.count, 8);
      ++histogram[found.count];
      if (countByGrid(arm.chain(), pose, 1440) == found.count) {
        ++same;
        continue;
      }
      ++finer;
      EXPECT_EQ(countByGrid(arm.chain(), pose, 288000), found.count) << "arm " << which << ", pose " << trial;
    }
  }
  RecordProperty("finer", finer);
  EXPECT_GE(same, 10050);
  for (const int count : {4, 8})
    EXPECT_GT(histogram[count], 100) << count;  // joints 1 to 3: two ways or four
}

}  // namespace
}  // namespace gelenk
