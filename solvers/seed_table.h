#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "solvers/serial_kernel.h"

namespace gelenk {

struct SeedTableOptions {
  int cellsPerSide = 8;   ///< of each of the four key dimensions
  int entriesPerCell = 8;
  int samples = 400'000;  ///< random configurations drawn to fill it
  std::uint64_t seed = 1;
};

/// Starts for pose goals of a chain whose first and last joint are revolute, looked up by where the goal is.
///
/// Turning the first joint spins the whole pose about the base's axis, turning the last one rolls the frame about its own: both
/// are factored out in closed form, so that a six-dimensional pose needs a key of four: radius and height of the last frame's
/// origin in the base frame, and the direction of the last axis seen from the azimuth of that origin (cosine to the base's axis
/// and azimuth). Every cell keeps a few configurations that reach into it; looking one up means choosing q_1 from the azimuth
/// and q_n so that the remaining rotation is smallest.
class SeedTable {
 public:
  /// C: the constants that the kernel is given. None where the first or the last joint is prismatic or n < 3.
  static std::optional<SeedTable> build(const ChainConstants& C, int n, const SerialKernel& kernel, const SeedTableOptions& options);

  /// Writes at most `most` starts (rows of n), the nearest first, and returns how many. Only starts within the limits are given.
  int lookUp(const ChainConstants& C, const KernelTarget& target, int most, double* starts) const;

  std::size_t bytes() const { return entries_.size() * sizeof(Entry) + counts_.size(); }
  double seconds() const { return seconds_; }  ///< that building took
  double filledCells() const;                  ///< share of the cells that have an entry, 0..1

 private:
  /// A configuration turned to azimuth 0, and its last frame.
  struct Entry {
    float q[maxChainDofs];
    float x[3], y[3], radius, height;
  };
  int cellOf(double radius, double height, double cosine, double azimuth) const;

  int n_ = 0, side_ = 0, perCell_ = 0;
  double radius_ = 0.0, lowest_ = 0.0, highest_ = 0.0;  ///< the reached region
  std::vector<Entry> entries_;
  std::vector<std::uint8_t> counts_;
  double seconds_ = 0.0;
};

}  // namespace gelenk
