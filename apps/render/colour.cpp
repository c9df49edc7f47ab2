#include "apps/render/colour.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

Eigen::Vector3f linearLight(const Colour& colour) {
  const auto linear = [](float c) {
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  return {linear(colour.r), linear(colour.g), linear(colour.b)};
}

Colour viridis(float t) {
  // Ten equidistant colours of the map by Nathaniel Smith and Stefan van der Walt (2015), published as CC0.
  static constexpr unsigned keys[] = {0x440154, 0x482878, 0x3e4a89, 0x31688e, 0x26828e,
                                      0x1f9e89, 0x35b779, 0x6dcd59, 0xb4de2c, 0xfde725};
  constexpr int last = 9;
  const float at = last * (t > 0.0f ? std::min(t, 1.0f) : 0.0f);  // NaN counts as 0
  const int i = std::min(static_cast<int>(at), last - 1);
  const float share = at - static_cast<float>(i);
  const auto channel = [&](int shift) {
    const auto low = static_cast<float>(keys[i] >> shift & 0xff),
               high = static_cast<float>(keys[i + 1] >> shift & 0xff);
    return (low + share * (high - low)) / 255.0f;
  };
  return {channel(16), channel(8), channel(0), 1.0f};
}

std::vector<Eigen::Vector3f> viridisColours(const std::vector<float>& values) {
  std::vector<Eigen::Vector3f> colours;
  colours.reserve(values.size());
  for (const float value : values) colours.push_back(linearLight(viridis(value)));
  return colours;
}

}  // namespace gelenk
