#pragma once

#include <cstdint>

namespace gelenk {

/// Plain data of the flagship's inner loops. The loops are compiled once an instruction set
/// (serial_kernel_*.cpp) and chosen at run time, so this header must stay free of inline functions and
/// templates: two copies compiled with different instructions would be merged by the linker.

inline constexpr int maxChainDofs = 8;
inline constexpr int kernelLanes = 16;  ///< starts or problems side by side

/// Modified Denavit-Hartenberg constants of a chain, see SerialChain. Entry i belongs to dof i.
struct ChainConstants {
  double a[maxChainDofs], d[maxChainDofs], cosAlpha[maxChainDofs], sinAlpha[maxChainDofs],
      theta[maxChainDofs];
  double revolute[maxChainDofs];                            ///< 1 or 0 (prismatic)
  double lower[maxChainDofs], upper[maxChainDofs];          ///< walls; -+1e300 where there is none
  double seedLower[maxChainDofs], seedUpper[maxChainDofs];  ///< where random starts are drawn
};

/// A goal in the chain's base frame and lengths: columns of the wanted rotation and the wanted place of the
/// point.
struct KernelTarget {
  double x[3], y[3], z[3], p[3];
};

/// What is asked of the last frame, the same for all problems of a call.
struct KernelTask {
  double point[3] = {0, 0, 0};  ///< the controlled point in the last frame
  int hasPoint = 0;             ///< 0: the point is the frame's origin
  int position = 1, orientation = 1;
  double positionTolerance2 = 1e-12, orientationTolerance2 = 1e-12;  ///< squares
  int attemptIterations = 15;  ///< a start that has not converged by then is given up
};

struct KernelAnswer {
  int solved = 0;
  int iterations = 0;           ///< of all lanes and attempts together
  int evaluations = 0;          ///< of the forward kinematics, likewise
  int attempts = 0;             ///< starts used, the first included
  double error2 = 0.0;          ///< squared error of q (chain lengths and radians)
  double start[maxChainDofs];   ///< where attempt or race solved: the start that led there
  double e[3] = {}, w[3] = {};  ///< likewise: the error of q, position (chain lengths) and 2 tan(theta/2)
                                ///< axis, in the base frame
  double q[maxChainDofs];
};

/// Starts that reach into one cell of the seed table, turned to azimuth 0, and the x and y axes of their last
/// frames; a start a lane.
struct alignas(64) SeedCell {
  float q[maxChainDofs][kernelLanes];
  float x[3][kernelLanes], y[3][kernelLanes];
};

/// Starts side by side: dof by dof, a start a lane; bit l of valid tells whether lane l holds one.
struct alignas(64) LaneStarts {
  float q[maxChainDofs][kernelLanes];
  int valid = 0;
};

/// The inner loops for one number of dofs.
struct SerialKernel {
  /// One start, one lane. answer.q: the solution, or the best point met.
  void (*attempt)(const ChainConstants&, const KernelTask&, const KernelTarget&, const double* start,
                  KernelAnswer&);

  /// One problem, sixteen starts side by side; lanes without a start, and lanes that fail, take random ones.
  /// Ends with the first lane that converges, or when maxAttempts starts are spent.
  void (*race)(const ChainConstants&, const KernelTask&, const KernelTarget&, const LaneStarts&,
               int maxAttempts, std::uint64_t randomSeed, KernelAnswer&);

  /// Many problems, one a lane; a lane that is done takes the next problem. seeds: seedsEach x n a problem;
  /// random starts after. Random starts depend on the problem's index, not on its neighbours.
  void (*batch)(const ChainConstants&, const KernelTask&, const KernelTarget*, int count, const double* seeds,
                int seedsEach, int maxAttempts, std::uint64_t randomSeed, KernelAnswer*);

  /// Frame and geometric Jacobian of a point in the last frame. base: columns x, y, z, p (12). frame:
  /// likewise (12), of the last frame with p the point's place. J: n columns of 6 (velocity of the point,
  /// angular velocity).
  void (*frameAndJacobian)(const ChainConstants&, const double* base, const double* point, const double* q,
                           double* frame, double* J);

  /// The cell's starts turned to the target: q_1 by its azimuth, q_n so that the remaining rotation is
  /// smallest. Valid where both are within the limits.
  void (*turnSeeds)(const ChainConstants&, const KernelTarget&, const SeedCell&, int count, LaneStarts&);

  /// Squared error (chain lengths and radians) of a configuration.
  double (*error)(const ChainConstants&, const KernelTask&, const KernelTarget&, const double* q);
};

enum class InstructionSet { Baseline, Avx2, Avx512 };

/// nullptr where this build has no such kernel. n: 1..maxChainDofs.
const SerialKernel* serialKernelBaseline(int n, bool prismatic);
const SerialKernel* serialKernelAvx2(int n, bool prismatic);
const SerialKernel* serialKernelAvx512(int n, bool prismatic);

/// The best set that this processor and this build have.
InstructionSet bestInstructionSet();
bool isAvailable(InstructionSet set);
const char* toString(InstructionSet set);
/// Throws std::invalid_argument where the set is not available here.
const SerialKernel& serialKernel(InstructionSet set, int n, bool prismatic);

}  // namespace gelenk
