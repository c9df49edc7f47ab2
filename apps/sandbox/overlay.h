#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

namespace gelenk {

/// Marks over the view, given in world coordinates and drawn anti-aliased in the order in which they were added.
/// Widths and radii in pixels at scale 1; colours sRGB with alpha, 0..1.
class Overlay {
 public:
  struct Line { Eigen::Vector3d a, b; Eigen::Vector4f colour; float width; bool dashed; };
  struct Dot { Eigen::Vector3d at; Eigen::Vector4f colour; float radius; bool square; };
  struct Label { Eigen::Vector3d at; Eigen::Vector4f colour; std::string text; };
  struct Patch { std::vector<Eigen::Vector3d> corners; Eigen::Vector4f colour; };

  void line(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector4f& colour, float width = 1.5f,
            bool dashed = false);
  void dot(const Eigen::Vector3d& at, const Eigen::Vector4f& colour, float radius = 4.0f, bool square = false);
  void label(const Eigen::Vector3d& at, const std::string& text, const Eigen::Vector4f& colour);
  void patch(std::vector<Eigen::Vector3d> corners, const Eigen::Vector4f& colour);  ///< a convex polygon, filled
  void clear();

  const std::vector<Line>& lines() const { return lines_; }
  const std::vector<Dot>& dots() const { return dots_; }
  const std::vector<Label>& labels() const { return labels_; }
  const std::vector<Patch>& patches() const { return patches_; }

 private:
  std::vector<Line> lines_;
  std::vector<Dot> dots_;
  std::vector<Label> labels_;
  std::vector<Patch> patches_;
};

}  // namespace gelenk
