#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

namespace gelenk {

/// How thick a limb is along an axis, as a tape around it tells: the length of a convex curve is pi times its
/// mean width (Cauchy), so inner layers and the gaps between fingers do not count. Fed with the edges of a
/// surface, closed or not.
class GirthProfile {
 public:
  /// cuts: at even distances, both ends included; at least 2.
  GirthProfile(const Eigen::Vector3d& from, const Eigen::Vector3d& to, int cuts);

  void add(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

  double girth(int cut) const;  ///< 0 where no edge crosses
  /// Where it is narrowest between two parts that are at least 15 % thicker: the distance from the start to
  /// the middle of what is about as narrow.
  std::optional<double> waist() const;

 private:
  static constexpr int directions = 8;
  struct Width {
    double least = std::numeric_limits<double>::infinity(), most = -least;
  };

  Eigen::Vector3d from_, along_;
  double step_;
  std::array<Eigen::Vector3d, directions> across_;
  std::vector<std::array<Width, directions>> widths_;
};

}  // namespace gelenk
