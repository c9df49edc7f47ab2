#pragma once

#include <vector>

namespace gelenk {

struct LabelBox {
  float x = 0, y = 0, width = 0, height = 0;
  bool overlaps(const LabelBox& other) const {
    return x < other.x + other.width && other.x < x + width && y < other.y + other.height &&
           other.y < y + height;
  }
};

/// Where labels are written so that none hides another and none leaves the view: each as near as possible to
/// where it wants to be, earlier ones first. One that finds no room is left out (place() says so).
class LabelPlaces {
 public:
  explicit LabelPlaces(const LabelBox& view) : view_(view) {}
  /// wanted is moved to where there is room; false: there is none. A label whose place lies outside the view
  /// by more than its own size has left with what it names.
  bool place(LabelBox& wanted);
  /// Room that is taken by something else.
  void take(const LabelBox& box) { taken_.push_back(box); }
  /// The same: a square around a mark that must stay in sight, in whole pixels. half: of its width.
  void takeAround(float x, float y, float half);

 private:
  bool isFree(const LabelBox& box) const;
  LabelBox view_;
  std::vector<LabelBox> taken_;
};

}  // namespace gelenk
