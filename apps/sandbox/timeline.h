#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/sandbox/sandbox.h"

namespace gelenk {

/// What a timeline shows. Frames count from 0.
struct TimelineContent {
  struct Row {
    std::string label;
    std::vector<std::pair<int, int>> spans;  ///< first and last frame
  };
  int frameCount = 1;
  double framesPerSecond = 30.0;
  double seconds = 0.0;     ///< of the playhead
  std::vector<Row> rows;    ///< such as feet in contact
  std::vector<float> bars;  ///< one a frame, 0 to 1: joints beyond their limits; drawn in a row of its own
  std::vector<int> keys;    ///< frames with keys
  std::vector<int> selectedKeys;  ///< those of the selected joint
};

/// What the mouse did in it.
struct TimelineAction {
  std::optional<double> scrubTo = {};               ///< seconds
  std::optional<std::pair<int, int>> moveKey = {};  ///< from, to: let go in this frame
};

/// Ruler in seconds, rows, keys as diamonds, playhead. A drag on a diamond moves the key, any other scrubs.
class Timeline {
 public:
  TimelineAction draw(Sandbox::State& state, const TimelineContent& content);
  /// Where the keys were drawn last, pixels of the window, in the order of content.keys.
  const std::vector<std::pair<float, float>>& keyPixels() const { return keyPixels_; }

 private:
  std::vector<std::pair<float, float>> keyPixels_;
  std::optional<std::pair<int, int>> movingKey_;  ///< where it was taken, where it is
};

}  // namespace gelenk
