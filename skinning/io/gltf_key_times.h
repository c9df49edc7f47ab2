#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace gelenk {

/// Seconds of the frames as glTF keeps them: single precision, ascending. Throws std::invalid_argument for a
/// rate at which they would be infinite or equal.
inline std::vector<float> gltfKeyTimes(int frames, double framesPerSecond) {
  std::vector<float> times;
  for (int f = 0; f < frames; ++f) {
    times.push_back(static_cast<float>(f / framesPerSecond));
    if (!std::isfinite(times[f]) || (f > 0 && !(times[f] > times[f - 1])))
      throw std::invalid_argument("glTF counts seconds in single precision, which does not hold " +
                                  std::to_string(frames) + " frames at this frame rate");
  }
  return times;
}

}  // namespace gelenk
