#include "apps/render/rulers.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Stroke = std::vector<Vector2d>;

/// Part of an ellipse; degrees, counter-clockwise from x.
Stroke arc(double x, double y, double rx, double ry, double from, double to) {
  Stroke points;
  constexpr int steps = 20;
  for (int i = 0; i <= steps; ++i) {
    const double t = (from + (to - from) * i / steps) * M_PI / 180.0;
    points.emplace_back(x + rx * std::cos(t), y + ry * std::sin(t));
  }
  return points;
}

/// A sign of a number as a pen draws it: the height of a digit is 1, y up; width is what it takes in the
/// line.
struct Sign {
  double width;
  std::vector<Stroke> strokes;
};
Sign signOf(char c) {
  const Stroke stem{{0.1, 0.8}, {0.33, 1.0}, {0.33, 0.0}}, minus{{0.0, 0.45}, {0.42, 0.45}};
  switch (c) {
    case '0': return {0.56, {arc(0.28, 0.5, 0.28, 0.5, 0, 360)}};
    case '1': return {0.56, {stem}};
    case '2':
      return {0.56, {arc(0.28, 0.72, 0.26, 0.28, 165, -38), {{0.48, 0.55}, {0.02, 0.0}, {0.56, 0.0}}}};
    case '3': return {0.56, {arc(0.27, 0.75, 0.24, 0.25, 150, -90), arc(0.27, 0.25, 0.28, 0.25, 90, -150)}};
    case '4': return {0.56, {{{0.43, 0.0}, {0.43, 1.0}, {0.0, 0.29}, {0.58, 0.29}}}};
    case '5': return {0.56, {{{0.5, 1.0}, {0.1, 1.0}, {0.06, 0.52}}, arc(0.26, 0.32, 0.28, 0.32, 135, -145)}};
    case '6': return {0.56, {arc(0.28, 0.31, 0.28, 0.31, 0, 360), arc(0.5, 0.31, 0.5, 0.69, 98, 180)}};
    case '7': return {0.56, {{{0.0, 1.0}, {0.56, 1.0}, {0.19, 0.0}}}};
    case '8': return {0.56, {arc(0.28, 0.75, 0.24, 0.25, 0, 360), arc(0.28, 0.25, 0.28, 0.25, 0, 360)}};
    case '9': return {0.56, {arc(0.28, 0.69, 0.28, 0.31, 0, 360), arc(0.06, 0.69, 0.5, 0.69, -82, 0)}};
    case '.': return {0.0, {{{0.0, 0.02}, {0.0, 0.02}}}};
    case '-': return {0.42, {minus}};
    case '+': return {0.42, {minus, {{0.21, 0.24}, {0.21, 0.66}}}};
    case 'e': return {0.5, {{{0.02, 0.36}, {0.48, 0.36}}, arc(0.25, 0.34, 0.24, 0.34, 0, 310)}};
    default: return {0.3, {}};
  }
}

constexpr double digitHeight = 9.0, between = 0.2;  // pixels at scale 1; of the height

double widthOf(const std::string& number) {
  double width = -between;
  for (const char c : number) width += signOf(c).width + between;
  return width;
}

}  // namespace

double niceStep(double step) {
  const double power = std::pow(10.0, std::floor(std::log10(step)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= step * 0.999) return factor * power;
  return 10.0 * power;
}

void addRulers(Overlay& overlay, const Camera& camera, const Viewport& viewport, float pixelScale,
               double height, const Colour& colour) {
  if ((camera.axes() - Eigen::Matrix3d::Identity()).norm() > 1e-3) return;
  const auto pixelOf = [&](double x, double y) { return project(camera, viewport, {x, y, height}).pixel; };
  const Vector2d origin = pixelOf(0, 0);
  const double perUnit = pixelOf(1, 0).x() - origin.x(), scale = pixelScale;
  if (!(perUnit > 0.0)) return;
  const auto world = [&](double px, double py) {
    return Eigen::Vector3d((px - origin.x()) / perUnit, (origin.y() - py) / perUnit, height);
  };
  const auto snapped = [](double pixel) { return std::floor(pixel) + 0.5; };  // a pixel's middle: crisp
  const auto line = [&](double ax, double ay, double bx, double by, const Colour& ink) {
    overlay.line(world(ax, ay), world(bx, by), ink, 1.0f);
  };
  /// left, low: its lower left corner, pixels
  const auto write = [&](const std::string& number, double left, double low) {
    const double size = digitHeight * scale;
    double x = left;
    for (const char c : number) {
      const Sign sign = signOf(c);
      for (const Stroke& stroke : sign.strokes) {
        std::vector<Eigen::Vector3d> points;
        for (const Vector2d& p : stroke) points.push_back(world(x + size * p.x(), low - size * p.y()));
        overlay.polyline(points, colour, 1.15f);
      }
      x += size * (sign.width + between);
    }
  };
  const double w = viewport.width, h = viewport.height, tick = 5.0 * scale, size = digitHeight * scale;
  const Colour faint = withAlpha(colour, 0.4f * colour.a);
  line(0, snapped(origin.y()), w, snapped(origin.y()), faint);
  line(snapped(origin.x()), 0, snapped(origin.x()), h, faint);
  const double step = niceStep(80.0 * scale / perUnit);
  const auto number = [&](double i) { return fmt::format("{:g}", i == 0.0 ? 0.0 : i * step); };
  for (double i = std::ceil(-origin.x() / perUnit / step); i * step * perUnit <= w - origin.x(); ++i) {
    const double x = snapped(origin.x() + i * step * perUnit), wide = size * widthOf(number(i));
    line(x, h, x, h - tick, colour);
    if (x - 0.5 * wide > rulerWidth * scale && x + 0.5 * wide < w)  // the corner belongs to the other ruler
      write(number(i), x - 0.5 * wide, h - tick - 4.0 * scale);
  }
  for (double i = std::ceil((origin.y() - h) / perUnit / step); i * step * perUnit <= origin.y(); ++i) {
    const double y = snapped(origin.y() - i * step * perUnit);
    line(0, y, tick, y, colour);
    if (y < h - rulerHeight * scale && y > size) write(number(i), tick + 4.0 * scale, y + 0.5 * size);
  }
}

}  // namespace gelenk
