#include "apps/render/label_places.h"

#include <algorithm>
#include <cmath>

namespace gelenk {

bool LabelPlaces::isFree(const LabelBox& box) const {
  return std::ranges::none_of(taken_, [&](const LabelBox& other) { return box.overlaps(other); });
}

bool LabelPlaces::place(LabelBox& wanted) {
  LabelBox reach = view_;  // with a margin of its own size
  reach.x -= wanted.width, reach.y -= wanted.height;
  reach.width += 2 * wanted.width, reach.height += 2 * wanted.height;
  if (!reach.overlaps(wanted) || wanted.width > view_.width || wanted.height > view_.height) return false;
  const auto inside = [&](LabelBox box) {
    box.x = std::clamp(box.x, view_.x, view_.x + view_.width - box.width);
    box.y = std::clamp(box.y, view_.y, view_.y + view_.height - box.height);
    return box;
  };
  LabelBox best;
  float nearest = -1.0f;
  const auto consider = [&](LabelBox box) {
    box = inside(box);
    const float away = std::hypot(box.x - wanted.x, box.y - wanted.y);
    if ((nearest < 0.0f || away < nearest) && isFree(box)) best = box, nearest = away;
  };
  consider(wanted);
  // Beside what is taken: touching it above, below, left and right is as near as a free place can be.
  constexpr float gap = 2.0f;
  for (const LabelBox& other : taken_) {
    const float above = other.y - wanted.height - gap, below = other.y + other.height + gap;
    const float left = other.x - wanted.width - gap, right = other.x + other.width + gap;
    consider({wanted.x, above, wanted.width, wanted.height});
    consider({wanted.x, below, wanted.width, wanted.height});
    consider({left, wanted.y, wanted.width, wanted.height});
    consider({right, wanted.y, wanted.width, wanted.height});
    consider({left, above, wanted.width, wanted.height});
    consider({right, below, wanted.width, wanted.height});
  }
  if (nearest < 0.0f) return false;
  wanted = best;
  take(best);
  return true;
}

void LabelPlaces::takeAround(float x, float y, float half) {
  take({std::floor(x - half), std::floor(y - half), std::ceil(2 * half), std::ceil(2 * half)});
}

}  // namespace gelenk
