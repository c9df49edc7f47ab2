#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "apps/commands/image.h"

namespace gelenk {

/// A place to draw surfaces on without a graphics card: parallel projection, a depth buffer, one light over
/// the viewer's left shoulder. For tables of many small pictures.
class ShadedPicture {
 public:
  ShadedPicture(int width, int height, const std::array<std::uint8_t, 3>& background);

  /// The picture's frame in pixels: left, top, width, height; what is drawn stays inside.
  struct Frame {
    int left, top, width, height;
  };
  /// What is seen: looking along `direction`, `up` upwards, `centre` in the middle, `height` metres high.
  struct Eye {
    Eigen::Vector3d direction, up, centre;
    double height;
  };
  /// normals: one a vertex. colour: sRGB, 0 to 1; one a vertex, or one for all.
  void draw(const Frame& frame, const Eye& eye, const std::vector<Eigen::Vector3d>& positions,
            const std::vector<Eigen::Vector3d>& normals, const std::vector<std::array<int, 3>>& triangles,
            const std::vector<Eigen::Vector3f>& colour);
  const Image& image() const { return image_; }

 private:
  Image image_;
  std::vector<float> depth_;
};

}  // namespace gelenk
