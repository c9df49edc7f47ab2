#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "solvers/serial/serial_kernel.h"

namespace gelenk {

struct SeedTableOptions {
  int cellsPerSide = 8;   ///< of each of the four key dimensions
  int samples = 400'000;  ///< random configurations drawn to fill it
  std::uint64_t seed = 1;
};

/// Starts for pose goals of a chain whose first and last joint are revolute, looked up by where the goal is.
///
/// Turning the first joint spins the whole pose about the base's axis, turning the last one rolls the frame
/// about its own: both are factored out in closed form, so that a six-dimensional pose needs a key of four:
/// radius and height of the last frame's origin in the base frame, and the direction of the last axis seen
/// from the azimuth of that origin (cosine to the base's axis and azimuth). Every cell keeps up to sixteen
/// configurations that reach into it; looking them up means choosing q_1 from the azimuth and q_n so that the
/// remaining rotation is smallest. A cell's starts are their own training set: each is tried as a start for
/// the poses of the others; the one that leads to most of them, soonest, comes first, then the one that adds
/// most, and so on.
class SeedTable {
 public:
  /// C: the constants that the kernel is given. None where the first or the last joint is prismatic or n < 3.
  static std::optional<SeedTable> build(const ChainConstants& C, int n, const SerialKernel& kernel,
                                        const SeedTableOptions& options);

  /// The starts for a target; false where its cell is empty.
  bool lookUp(const ChainConstants& C, const SerialKernel& kernel, const KernelTarget& target,
              LaneStarts& starts) const;

  std::size_t bytes() const { return cells_.size() * sizeof(SeedCell) + counts_.size(); }
  double seconds() const { return seconds_; }  ///< that building took
  double filledCells() const;                  ///< share of the cells that have an entry, 0..1

 private:
  int cellOf(double radius, double height, double cosine, double turn) const;
  int cellOf(const KernelTarget& target) const;
  void order(const ChainConstants& C, const SerialKernel& kernel, int cell);

  int n_ = 0, side_ = 0;
  double radius_ = 0.0, lowest_ = 0.0, highest_ = 0.0;  ///< the reached region
  std::vector<SeedCell> cells_;
  std::vector<std::uint8_t> counts_;
  double seconds_ = 0.0;
};

}  // namespace gelenk
