#include "apps/render/label_places.h"

#include <gtest/gtest.h>

#include <random>

#include "apps/render/label_writer.h"
#include "apps/sandbox/gizmo.h"
#include "apps/sandbox/sandbox_state.h"
#include "tests/sandbox/stage.h"

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

/// The words of one point stood on the cross of another, which is named from the side.
TEST(Labels, LeaveWhatIsNamedFromTheSideInSight) {
  testing::Stage stage({.model = "planar", .width = 640, .height = 480});
  stage.play("", 1);
  Sandbox::State& s = stage.sandbox.state();
  const Camera& camera = s.camera();
  const Eigen::Vector3d cross = camera.target;
  ImGui::NewFrame();
  ImGui::Begin("labels alone");
  LabelPlaces places = roomForLabels({0, 0}, s.viewport(), true, 1.0f);
  writeLabels({ImGui::GetWindowDrawList(), palette(Theme::Light), s.gui.fonts().small, 13.0f, 1.0f, &places},
              {{cross + 0.2 * s.size() * camera.axes().col(1), "X", {1, 0, 0, 1}, cross}}, camera,
              s.viewport(), {0, 0});
  const Projected p = project(camera, s.viewport(), cross);
  LabelBox words{static_cast<float>(p.pixel.x()) - 30, static_cast<float>(p.pixel.y()) - 6, 60, 12};
  const LabelBox wanted = words;
  ASSERT_TRUE(places.place(words));
  EXPECT_FALSE(
      words.overlaps({static_cast<float>(p.pixel.x()) - 4, static_cast<float>(p.pixel.y()) - 4, 8, 8}));
  EXPECT_NEAR(std::abs(words.y - wanted.y), 14, 3);  // no farther than it must
  ImGui::End();
  ImGui::EndFrame();
}

/// knee_r stood as a knee with an index.
TEST(Labels, NamesAreWrittenLetterByLetter) {
  testing::Stage stage({.model = "planar", .width = 640, .height = 480});
  stage.play("", 1);
  Sandbox::State& s = stage.sandbox.state();
  ImGui::NewFrame();
  ImGui::Begin("labels alone");
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRectFullScreen();
  const auto vertices = [&](bool isName) {
    const int before = draw.VtxBuffer.Size;
    LabelPlaces places = roomForLabels({0, 0}, s.viewport(), true, 1.0f);
    writeLabels({&draw, palette(Theme::Light), s.gui.fonts().small, 13.0f, 1.0f, &places},
                {{.at = s.camera().target, .text = "knee_r", .colour = {1, 0, 0, 1}, .isName = isName}},
                s.camera(), s.viewport(), {0, 0});
    return draw.VtxBuffer.Size - before;
  };
  EXPECT_EQ(vertices(true), vertices(false) + 4);  // the underscore's
  draw.PopClipRect();
  ImGui::End();
  ImGui::EndFrame();
}

/// The names of skins side by side began over the bodies' middles.
TEST(Labels, ANameAboveABodyIsCentredAboveIt) {
  testing::Stage stage({.model = "planar", .width = 640, .height = 480});
  stage.play("", 1);
  Sandbox::State& s = stage.sandbox.state();
  ImGui::NewFrame();
  ImGui::Begin("labels alone");
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRectFullScreen();
  const int before = draw.VtxBuffer.Size;
  LabelPlaces places = roomForLabels({0, 0}, s.viewport(), true, 1.0f);
  const Eigen::Vector3d place = s.camera().target;
  writeLabels({&draw, palette(Theme::Light), s.gui.fonts().small, 13.0f, 1.0f, &places},
              {{.at = place, .text = "cor+twist", .colour = {1, 0, 0, 1}, .isName = true, .isAbove = true}},
              s.camera(), s.viewport(), {0, 0});
  ImVec2 low(1e9f, 1e9f), high(-1e9f, -1e9f);
  for (int v = before; v < draw.VtxBuffer.Size; ++v) {
    low = {std::min(low.x, draw.VtxBuffer[v].pos.x), std::min(low.y, draw.VtxBuffer[v].pos.y)};
    high = {std::max(high.x, draw.VtxBuffer[v].pos.x), std::max(high.y, draw.VtxBuffer[v].pos.y)};
  }
  const Projected p = project(s.camera(), s.viewport(), place);
  EXPECT_NEAR(0.5 * (low.x + high.x), p.pixel.x(), 1.0);
  EXPECT_NEAR(high.y, p.pixel.y(), 4.0);
  draw.PopClipRect();
  ImGui::End();
  ImGui::EndFrame();
}

/// The name of the selected goal lay on an arrow of its gizmo, how far it is out of reach on a ring.
TEST(Labels, NoneLiesOnTheGizmosArrowsAndRings) {
  testing::Stage stage({.model = "panda", .width = 800, .height = 600});
  stage.play("", 2);
  Sandbox::State& s = stage.sandbox.state();
  s.selectedGoal = s.session->goals().front().id;
  stage.play("", 2);
  const auto gizmo = gizmoOf(s);
  ASSERT_TRUE(gizmo);
  LabelPlaces places({0, 0, 800, 600});
  keepGizmoFree(s, places);
  const auto isFreeOfWords = [&](const Eigen::Vector2d& at) {
    const LabelBox spot{static_cast<float>(at.x()) - 1, static_cast<float>(at.y()) - 1, 2, 2};
    LabelBox words{spot.x - 20, spot.y - 6, 40, 12};
    LabelPlaces others = places;
    return others.place(words) && !words.overlaps(spot);
  };
  for (int axis = 0; axis < 3; ++axis)
    for (double along : {0.3, 0.6, 0.95})
      EXPECT_TRUE(
          isFreeOfWords(s.toWindow(gizmo->at + along * gizmo->size * Eigen::Vector3d::Unit(axis)).pixel))
          << axis << " " << along;
  // A ring is taken within some pixels of it: in the middle of that band it is itself.
  const auto isOnRing = [&](double x, double y) {
    for (const auto& [dx, dy] : {std::pair{4.0, 0.0}, {-4.0, 0.0}, {0.0, 4.0}, {0.0, -4.0}})
      if (const auto part = gizmoPartAt(s, *gizmo, {x + dx, y + dy});
          !part || part->kind != GizmoPart::Kind::Ring)
        return false;
    return true;
  };
  int onRings = 0;
  const Eigen::Vector2d middle = s.toWindow(gizmo->at).pixel;
  for (double dx = -70; dx <= 70; ++dx)
    for (double dy = -70; dy <= 70; ++dy)
      if (isOnRing(middle.x() + dx, middle.y() + dy)) {
        ++onRings;
        EXPECT_TRUE(isFreeOfWords(middle + Eigen::Vector2d(dx, dy))) << dx << " " << dy;
      }
  EXPECT_GT(onRings, 200);
}

/// At the edge of the view a label was moved in, over the dot that it names.
TEST(Labels, NeverCoverTheDotThatTheyName) {
  testing::Stage stage({.model = "planar", .width = 640, .height = 480});
  stage.play("", 1);
  Sandbox::State& s = stage.sandbox.state();
  const Viewport viewport = s.viewport();
  const Camera& camera = s.camera();
  int inView = 0;
  for (int i = 0; i < 400; ++i) {
    const double side = 0.6 * s.size();
    const Eigen::Vector3d place = camera.target + side * ((i % 20) / 10.0 - 1.0) * camera.axes().col(0) +
                                  side * ((i / 20) / 10.0 - 1.0) * camera.axes().col(1);
    const Projected p = project(camera, viewport, place);
    if (p.pixel.x() < 40 || p.pixel.y() < 5 || p.pixel.x() > viewport.width - 5 ||
        p.pixel.y() > viewport.height - 30)
      continue;
    ++inView;
    ImGui::NewFrame();
    ImGui::Begin("labels alone");
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const int before = draw.VtxBuffer.Size;
    LabelPlaces places = roomForLabels({0, 0}, viewport, true, 1.0f);
    draw.PushClipRectFullScreen();
    writeLabels({&draw, palette(Theme::Light), s.gui.fonts().small, 13.0f, 1.0f, &places},
                {{place, "end-effector", {1, 0, 0, 1}}}, camera, viewport, {0, 0});
    draw.PopClipRect();
    ASSERT_GT(draw.VtxBuffer.Size, before);
    ImVec2 low = draw.VtxBuffer[before].pos, high = low;
    for (int v = before; v < draw.VtxBuffer.Size; ++v) {
      const ImVec2 at = draw.VtxBuffer[v].pos;
      low = {std::min(low.x, at.x), std::min(low.y, at.y)};
      high = {std::max(high.x, at.x), std::max(high.y, at.y)};
    }
    const LabelBox label{low.x, low.y, high.x - low.x, high.y - low.y};
    const auto x = static_cast<float>(p.pixel.x()), y = static_cast<float>(p.pixel.y());
    EXPECT_FALSE(label.overlaps({x - 4, y - 4, 8, 8})) << p.pixel.transpose();
    ImGui::End();
    ImGui::EndFrame();
  }
  EXPECT_GT(inView, 30);
}

}  // namespace
}  // namespace gelenk
