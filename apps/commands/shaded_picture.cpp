#include "apps/commands/shaded_picture.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;

ShadedPicture::ShadedPicture(int width, int height, const std::array<std::uint8_t, 3>& background)
    : image_{.width = width, .height = height, .pixels = {}},
      depth_(static_cast<std::size_t>(width) * height, 1e30f) {
  image_.pixels.reserve(4 * depth_.size());
  for (std::size_t i = 0; i < depth_.size(); ++i)
    image_.pixels.insert(image_.pixels.end(), {background[0], background[1], background[2], 255});
}

void ShadedPicture::draw(const Frame& frame, const Eye& eye, const std::vector<Vector3d>& positions,
                         const std::vector<Vector3d>& normals,
                         const std::vector<std::array<int, 3>>& triangles,
                         const std::vector<Eigen::Vector3f>& colour) {
  const Vector3d ahead = eye.direction.normalized(), right = ahead.cross(eye.up).normalized(),
                 up = right.cross(ahead);
  const Vector3d light = (-ahead + 0.6 * up - 0.5 * right).normalized();
  const double scale = frame.height / eye.height;
  std::vector<Vector3d> seen(positions.size());  // pixels and depth
  std::vector<float> shade(positions.size());
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Vector3d d = positions[v] - eye.centre;
    seen[v] = {frame.left + 0.5 * frame.width + scale * right.dot(d),
               frame.top + 0.5 * frame.height - scale * up.dot(d), ahead.dot(d)};
    shade[v] = static_cast<float>(0.28 + 0.72 * std::max(0.0, normals[v].dot(light)));
  }
  for (const auto& t : triangles) {
    const Vector3d &a = seen[t[0]], &b = seen[t[1]], &c = seen[t[2]];
    const double area = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    if (area == 0.0) continue;
    const bool inside = area > 0.0;  // pixels run downwards: fronts are negative
    const int x0 = std::max(frame.left, static_cast<int>(std::floor(std::min({a.x(), b.x(), c.x()}))));
    const int x1 =
        std::min(frame.left + frame.width - 1, static_cast<int>(std::ceil(std::max({a.x(), b.x(), c.x()}))));
    const int y0 = std::max(frame.top, static_cast<int>(std::floor(std::min({a.y(), b.y(), c.y()}))));
    const int y1 =
        std::min(frame.top + frame.height - 1, static_cast<int>(std::ceil(std::max({a.y(), b.y(), c.y()}))));
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const double px = x + 0.5, py = y + 0.5;
        const double wa = ((b.x() - px) * (c.y() - py) - (b.y() - py) * (c.x() - px)) / area;
        const double wb = ((c.x() - px) * (a.y() - py) - (c.y() - py) * (a.x() - px)) / area;
        const double wc = 1.0 - wa - wb;
        if (wa < 0.0 || wb < 0.0 || wc < 0.0) continue;
        const auto z = static_cast<float>(wa * a.z() + wb * b.z() + wc * c.z());
        const std::size_t at = static_cast<std::size_t>(y) * image_.width + x;
        if (z >= depth_[at]) continue;
        depth_[at] = z;
        Eigen::Vector3f base = colour.size() == 1 ? colour[0]
                                                  : Eigen::Vector3f(static_cast<float>(wa) * colour[t[0]] +
                                                                    static_cast<float>(wb) * colour[t[1]] +
                                                                    static_cast<float>(wc) * colour[t[2]]);
        if (inside) base = {0.85f, 0.25f, 0.2f};  // the skin's back: it went through itself
        const auto lit = static_cast<float>(wa * shade[t[0]] + wb * shade[t[1]] + wc * shade[t[2]]);
        for (int k = 0; k < 3; ++k)
          image_.pixels[4 * at + k] =
              static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(base[k] * lit, 0.0f, 1.0f)));
      }
  }
}

}  // namespace gelenk
