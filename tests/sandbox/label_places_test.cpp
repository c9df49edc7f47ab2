#include "apps/render/label_places.h"

#include <gtest/gtest.h>

#include <random>

namespace gelenk {
namespace {

TEST(Labels, NeitherOverlapNorLeaveTheView) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  const LabelBox view{40, 30, 900, 520};
  int placed = 0;
  for (int trial = 0; trial < 200; ++trial) {
    LabelPlaces places(view);
    std::vector<LabelBox> boxes;
    std::uniform_real_distribution<float> x(-60, 1000), y(0, 600), width(20, 180);
    for (int i = 0; i < 24; ++i) {
      LabelBox box{i % 3 ? x(random) : 400.0f, i % 3 ? y(random) : 300.0f, width(random), 18};
      if (places.place(box)) boxes.push_back(box);
    }
    placed += static_cast<int>(boxes.size());
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_GE(boxes[i].x, view.x);
      EXPECT_GE(boxes[i].y, view.y);
      EXPECT_LE(boxes[i].x + boxes[i].width, view.x + view.width);
      EXPECT_LE(boxes[i].y + boxes[i].height, view.y + view.height);
      for (std::size_t j = 0; j < i; ++j)
        EXPECT_FALSE(boxes[i].overlaps(boxes[j])) << trial << " seed " << seed;
    }
  }
  EXPECT_GT(placed, 200 * 18);  // and nearly all that are in view find room
}

TEST(Labels, OneThatHasRoomStaysAndOneWhosePointIsGoneGoes) {
  LabelPlaces places({0, 0, 100, 100});
  LabelBox box{30, 40, 20, 10};
  ASSERT_TRUE(places.place(box));
  EXPECT_EQ(box.x, 30);
  EXPECT_EQ(box.y, 40);
  LabelBox again{32, 41, 20, 10};
  ASSERT_TRUE(places.place(again));
  EXPECT_FALSE(again.overlaps(box));
  LabelBox gone{130, 40, 20, 10};
  EXPECT_FALSE(places.place(gone));
}

}  // namespace
}  // namespace gelenk
