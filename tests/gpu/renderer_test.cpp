#include "apps/render/renderer.h"

#include "apps/commands/image.h"
#include "apps/render/posed_bounds.h"
#include "apps/render/signs.h"
#include "skinning/bodies/mannequin_body.h"
#include "skinning/bodies/polygonise.h"
#include "skinning/gpu/render_target.h"
#include "tests/gpu/gl_fixture.h"
#include "tests/gpu/test_bodies.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;
using testing::Arm;
using testing::GlTest;

const Viewport viewport{320, 200};

/// A box of 0.4 x 1 x 0.4 m on the ground, seen from the front and a little above.
class RendererTest : public GlTest {
 protected:
  void SetUp() override {
    GlTest::SetUp();
    body_ = testing::box({0.4, 1.0, 0.4});
    mesh_.emplace(body_.skin);
    pose_ = poseSkin(body_.skin, restFrames(body_.skeleton));
    scene_.bodies = {{.mesh = &*mesh_, .pose = &pose_}};
    scene_.bounds = PosedBounds(body_.skin)(pose_);
    camera_ = {.target = {0.2, 0.4, 0}, .distance = 5.0, .azimuth = 0.0, .elevation = 0.5};
    renderer_.emplace();
    target_.emplace(viewport.width, viewport.height);
  }
  void TearDown() override {
    target_.reset();
    renderer_.reset();
    mesh_.reset();
    GlTest::TearDown();
  }

  /// The figure in the box's place, rigid, alone: no shadow and no ground.
  void showFigure() {
    Mesh mesh = polygonise(mannequinShape(), mannequinGrid());
    const Frames rest = restFrames(body_.skeleton);
    std::vector<Influences> influences(mesh.positions.size());
    body_.skin = bindSkin(std::move(mesh), rest, std::move(influences));
    mesh_.emplace(body_.skin);
    pose_ = poseSkin(body_.skin, rest);
    scene_.bounds = PosedBounds(body_.skin)(pose_);
    scene_.size = 1.8;
    scene_.shadows = false;
    scene_.ground.visible = false;
  }

  Image draw() {
    renderer_->draw(scene_, camera_, viewport, target_->framebuffer());
    return {viewport.width, viewport.height, target_->readPixels()};
  }
  Eigen::Vector3i at(const Image& image, const Eigen::Vector2d& pixel) const {
    const std::uint8_t* p = image.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
    return {p[0], p[1], p[2]};
  }
  Eigen::Vector3i at(const Image& image, const Vector3d& world) const {
    return at(image, project(camera_, viewport, world).pixel);
  }

  Arm body_;
  std::optional<SkinnedMeshGl> mesh_;
  SkinPose pose_;
  RenderScene scene_;
  Camera camera_;
  std::optional<Renderer> renderer_;
  std::optional<RenderTarget> target_;
};

int differingPixels(const Image& a, const Image& b, int threshold = 8) {
  int count = 0;
  for (std::size_t i = 0; i < a.pixels.size(); i += 4)
    count += std::abs(a.pixels[i] - b.pixels[i]) + std::abs(a.pixels[i + 1] - b.pixels[i + 1]) +
                 std::abs(a.pixels[i + 2] - b.pixels[i + 2]) >
             threshold;
  return count;
}

// The key light comes from the left, above and before: a ground point behind and to the right lies in the
// shadow.
const Vector3d inShadow(0.45, 0.0, -0.35), inLight(-0.9, 0.0, 0.4);

TEST_F(RendererTest, ABodyDarkensTheGroundBehindItAndOnlyThere) {
  const Image with = draw();
  scene_.shadows = false;
  const Image without = draw();
  EXPECT_LT(at(with, inShadow).sum(), 0.85 * at(without, inShadow).sum());
  EXPECT_NEAR(at(with, inLight).sum(), at(without, inLight).sum(), 3);  // one step of rounding a channel
}

TEST_F(RendererTest, AGhostCastsNoShadowAndLetsTheGroundThrough) {
  const Image solid = draw();
  scene_.bodies[0].tint.a = 0.3f;
  const Image ghost = draw();
  EXPECT_GT(at(ghost, inShadow).sum(), at(solid, inShadow).sum());
  scene_.bodies.clear();
  const Image empty = draw();
  const Vector3d onBody(0.0, 0.5, 0.2);
  const auto distance = [&](const Image& a, const Image& b) {
    return (at(a, onBody) - at(b, onBody)).cast<double>().norm();
  };
  EXPECT_LT(distance(ghost, empty), distance(solid, empty));
  EXPECT_GT(distance(ghost, empty), 0.0);
}

TEST_F(RendererTest, BackgroundCornersFollowTheGradientOfTheTheme) {
  scene_.ground.visible = false;
  scene_.bodies.clear();
  for (const Theme theme : {Theme::Light, Theme::Dark}) {
    scene_.theme = theme;
    const Image image = draw();
    const Eigen::Vector2d upper(0, 0), upperRight(319, 0), lower(0, 199);
    EXPECT_EQ(at(image, upper), at(image, upperRight));
    EXPECT_GT(at(image, lower).sum(), at(image, upper).sum() + 20);
    EXPECT_EQ(at(image, upper).sum() > 384, theme == Theme::Light);
  }
}

/// Two boxes that stand a hand's breadth apart: the sides that face each other get less light in a still
/// picture, what is open keeps it, with samples of the hardware's own too.
TEST_F(RendererTest, FoldsAreDarkerInStillPictures) {
  SkinPose other = pose_;
  other.rows[3] += 0.48f;  // x of the first joint's translation
  scene_.bodies.push_back({.mesh = &*mesh_, .pose = &other});
  scene_.shadows = false;
  const Vector3d between(0.2, 0.5, 0.1), open(-0.1, 0.5, 0.2);
  scene_.size = 4.0;
  camera_.distance = 2.0;
  camera_.azimuth = 0.5;  // sees into the gap
  camera_.target = {0.22, 0.5, 0.2};
  for (const int samples : {0, 4}) {
    renderer_->setSamples(samples);
    renderer_->setSupersampling(1);
    const Image plain = draw();
    renderer_->setSupersampling(2);
    const Image still = draw();
    EXPECT_LT(at(still, between).sum(), 0.95 * at(plain, between).sum()) << samples;
    EXPECT_NEAR(at(still, open).sum(), at(plain, open).sum(), 8) << samples;
  }
}

/// Neither the pattern of the search for folds nor the mesh's triangles show on a smooth body: how much the
/// light bends within 4 pixels along a row of the figure's trunk, beside the picture without darker folds.
TEST_F(RendererTest, FoldsLeaveNoStripesOnASmoothBody) {
  showFigure();
  camera_ = {.target = {-0.03, 1.2, 0.0}, .distance = 0.6, .azimuth = 0.35, .elevation = 0.09};
  const auto unevenness = [&](const Image& image) {
    double sum = 0.0;
    int count = 0;
    for (int y = 20; y < viewport.height - 20; ++y)
      for (int x = 100; x < 200; ++x, ++count) {
        const auto light = [&](int column) { return image.at(column, y)[0] + image.at(column, y)[1]; };
        sum += std::abs(light(x + 4) - 2 * light(x) + light(x - 4));
      }
    return sum / count;
  };
  renderer_->setSamples(0);
  renderer_->setSupersampling(1);
  const double plain = unevenness(draw());
  renderer_->setSupersampling(2);
  const double still = unevenness(draw());
  EXPECT_GT(plain, 0.1);
  EXPECT_LT(still, 1.3 * plain);
}

/// A body that lets its bones be seen lies between itself and what is behind it. Along its outline dark
/// specks stood, where the side that faces away came through.
TEST_F(RendererTest, ATranslucentBodyHasNoSpecksAlongItsOutline) {
  showFigure();
  const std::vector<BodyInstance> figure = scene_.bodies;
  renderer_->setSamples(0);
  int specks = 0, ghostSpecks = 0, covered = 0;
  for (const double azimuth : {0.0, 0.8, 1.6, 2.4}) {
    camera_ = {.target = {0.0, 0.9, 0.0}, .distance = 3.0, .azimuth = azimuth, .elevation = 0.3};
    scene_.bodies.clear();
    const Image behind = draw();
    scene_.bodies = figure;
    scene_.xray = false;
    const Image solid = draw();
    scene_.xray = true;
    const Image through = draw();
    scene_.xray = false;
    scene_.bodies[0].tint.a = 0.7f;
    const Image ghost = draw();
    for (std::size_t p = 0; p < solid.pixels.size(); p += 4) {
      covered += std::abs(solid.pixels[p] - behind.pixels[p]) > 8;
      const int least = std::min(solid.pixels[p], behind.pixels[p]);
      specks += through.pixels[p] + 30 < least;
      ghostSpecks += ghost.pixels[p] + 30 < least;
    }
  }
  EXPECT_GT(covered, 4000);
  EXPECT_EQ(specks, 0);
  EXPECT_LE(ghostSpecks, 2);  // it stands a little behind where it is: places in front of each other change
}

TEST_F(RendererTest, ColoursArriveAsTheyWerePicked) {
  // Through linear light, the sRGB target and the copy: 8-bit rounding alone is left.
  scene_.overlayOnTop.triangle({-9, -9, 0}, {9, -9, 0}, {0, 18, 0}, {0.2f, 0.5f, 0.8f});
  for (const int n : {1, 2}) {
    renderer_->setSupersampling(n);
    const Eigen::Vector3i colour = at(draw(), Vector3d(0.2, 0.4, 0));
    EXPECT_NEAR(colour[0], 51, 1);
    EXPECT_NEAR(colour[1], 128, 1);
    EXPECT_NEAR(colour[2], 204, 1);
  }
}

TEST_F(RendererTest, AnOverlayIsHiddenByTheBodyUnlessItLiesOnTopOrTheBodyIsTransparent) {
  const Vector3d within(0.0, 0.5, 0.0);
  const Image plain = draw();
  scene_.overlay.point(within, {1, 0, 0}, 12);
  EXPECT_EQ(differingPixels(plain, draw()), 0);
  scene_.xray = true;
  const Image through = draw();
  EXPECT_GT(at(through, within)[0], at(through, Vector3d(0.12, 0.5, 0.0))[0] + 10);
  scene_.xray = false;
  std::swap(scene_.overlay, scene_.overlayOnTop);
  const Eigen::Vector3i colour = at(draw(), within);
  EXPECT_GT(colour[0], 250);
  EXPECT_LT(colour[1], 5);
}

TEST_F(RendererTest, LinesAndMarksHaveTheirWidthInPixels) {
  scene_.ground.visible = false;
  scene_.bodies.clear();
  const Image plain = draw();
  scene_.overlay.line({-5, 0.4, 0}, {5, 0.4, 0}, {1, 0, 0}, 4);
  const Image lined = draw();
  int rows = 0;
  for (int y = 0; y < viewport.height; ++y)
    rows += at(lined, Eigen::Vector2d(160, y)) != at(plain, Eigen::Vector2d(160, y));
  EXPECT_GE(rows, 4);
  EXPECT_LE(rows, 6);  // its edges are smoothed
  scene_.overlay.clear();
  scene_.overlay.point({0.2, 0.4, 0}, {0, 0, 1}, 20);
  const int covered = differingPixels(plain, draw(), 0);
  EXPECT_NEAR(covered, 314, 40);  // pi 10^2, and the smoothed rim
}

/// Ends of its pieces that lie over each other would show as dots of twice the colour.
TEST_F(RendererTest, ATranslucentCurveHasOneColourAlongItsWay) {
  scene_.ground.visible = false;
  scene_.bodies.clear();
  const Vector3d centre(0.2, 0.4, 0);
  scene_.overlay.arc(centre, Vector3d::UnitX(), Vector3d::UnitY(), 0.7, {1, 0, 0, 0.5}, 6);
  const Image image = draw();
  int least = 255, most = 0;
  for (int k = 0; k < 720; ++k) {
    const double angle = 2.0 * M_PI * k / 720;
    const int green = at(image, Vector3d(centre + 0.7 * Vector3d(std::cos(angle), std::sin(angle), 0)))[1];
    least = std::min(least, green);
    most = std::max(most, green);
  }
  EXPECT_LT(most - least, 30) << least << " to "
                              << most;  // the background's gradient, and seams within a pixel
}

/// While something moves: fewer triangles where they are small, and what faces away is left out.
TEST_F(RendererTest, QuickPicturesOfAClosedBodyHardlyDiffer) {
  BodyPart part{.form = BodyPart::Form::RoundCone};
  part.a = {0.2, 0.3, 0};
  part.b = {0.2, 0.9, 0.2};
  part.radiusA = 0.25;
  part.radiusB = 0.12;
  Arm ball{.skeleton = body_.skeleton, .skin = {}};
  Mesh mesh = polygonise(BodyShape({part}), {.cell = 0.02});
  const std::size_t count = mesh.positions.size();
  ball.skin = bindSkin(std::move(mesh), restFrames(ball.skeleton),
                       std::vector<Influences>(count, Influences{{0, 0, 0, 0}, {1, 0, 0, 0}}));
  const SkinnedMeshGl fine(ball.skin);
  EXPECT_TRUE(fine.isClosed());
  EXPECT_GT(fine.coarseEdge(), 0.02f);
  EXPECT_LT(fine.coarseEdge(), 0.08f);
  EXPECT_GT(fine.coarseEdge(1), 1.5f * fine.coarseEdge());  // and so on: a sixteenth of the triangles
  EXPECT_FALSE(fine.drawCoarse(0.99f * fine.coarseEdge()));
  scene_.bodies = {{.mesh = &fine, .pose = &pose_}};
  const Image whole = draw();
  renderer_->setQuick(true);
  const Image quick = draw();
  EXPECT_GT(differingPixels(whole, quick, 0), 0);  // it is another way to draw
  EXPECT_LT(differingPixels(whole, quick, 24), 0.004 * viewport.width * viewport.height);
  renderer_->setQuick(false);
  EXPECT_EQ(differingPixels(whole, draw(), 0), 0);
}

/// It is drawn in the rows in which it is seen alone: above them there must be none to be cut off.
TEST_F(RendererTest, TheGroundFadesOutWithoutASeam) {
  scene_.bodies.clear();
  scene_.ground.grid = false;
  scene_.theme = Theme::Dark;
  for (const double elevation : {0.1, 0.25, 0.5, 1.0, 1.5})
    for (const double distance : {2.0, 5.0, 20.0}) {
      camera_.elevation = elevation;
      camera_.distance = distance;
      const Image image = draw();
      int steepest = 0, all = 0;
      for (const int x : {5, 160, 315})
        for (int y = 1; y < viewport.height; ++y) {
          const int step = std::abs(image.at(x, y)[0] - image.at(x, y - 1)[0]);
          steepest = std::max(steepest, step);
          all += step;
        }
      EXPECT_LE(steepest, 3) << "elevation " << elevation << ", distance " << distance;
      EXPECT_GT(all, 5) << "elevation " << elevation << ", distance " << distance;
    }
}

TEST_F(RendererTest, LinesThroughTheEyeAndBehindItDoNoHarm) {
  const Vector3d eye = camera_.eye(), forward = camera_.target - eye;
  scene_.overlay.line(eye - forward, eye + forward, {1, 0, 0}, 3);
  scene_.overlay.line(eye - forward, eye - 2.0 * forward, {1, 0, 0}, 3);
  scene_.overlay.line(camera_.target, camera_.target, {1, 0, 0}, 3);
  draw();
}

TEST_F(RendererTest, EveryViewModeDrawsAnotherPicture) {
  const Image clay = draw();
  scene_.bodies[0].wireframe = true;
  EXPECT_GT(differingPixels(clay, draw()), 30);
  scene_.bodies[0].wireframe = false;
  mesh_->setColours(viridisColours(std::vector<float>(mesh_->vertexCount(), 1.0f)));
  scene_.bodies[0].surface = SurfaceColour::Vertex;
  const Eigen::Vector3i yellow = at(draw(), Vector3d(0.0, 0.5, 0.2));
  EXPECT_GT(yellow[0], 2 * yellow[2]);
  EXPECT_GT(yellow[1], 2 * yellow[2]);
}

TEST_F(RendererTest, PlanarScenesInHundredsOfUnitsGetTheirShadowToo) {
  const Arm arm = testing::arm(3, 150.0, 20.0);
  const SkinnedMeshGl mesh(arm.skin);
  const SkinPose pose = poseSkin(arm.skin, restFrames(arm.skeleton));
  scene_.bodies = {{.mesh = &mesh, .pose = &pose}};
  scene_.bounds = PosedBounds(arm.skin)(pose);
  scene_.ground.height = -22.0;
  camera_ = frameBox(lookFrom({.up = Vector3d::UnitZ(), .orthographic = true}, StandardView::Top), viewport,
                     scene_.bounds);
  const Image with = draw();
  scene_.shadows = false;
  const int shadowed = differingPixels(with, draw(), 20);
  EXPECT_GT(shadowed, 500);
  EXPECT_LT(shadowed, viewport.width * viewport.height / 3);
}

TEST_F(RendererTest, DrawsBodiesOfBothPoseStoragesWithMultisamplingAndAtAnySize) {
  const Arm many = testing::arm(400, 0.004, 0.05, 1, 8);
  const SkinnedMeshGl mesh(many.skin);
  const SkinPose pose = poseSkin(many.skin, restFrames(many.skeleton));
  scene_.bodies.push_back({.mesh = &mesh, .pose = &pose});
  scene_.bodies.push_back({.mesh = &mesh, .pose = &pose, .tint = {0.2f, 0.4f, 0.9f, 0.4f}});
  renderer_->setSamples(4);
  draw();
  renderer_->setSupersampling(2);
  draw();
  RenderTarget tiny(1, 1);
  renderer_->draw(scene_, camera_, {1, 1}, tiny.framebuffer());
}

TEST_F(RendererTest, AnEmptySceneIsAPictureToo) {
  scene_ = {};
  draw();
}

TEST_F(RendererTest, LeavesTheStateThatAnInterfaceDrawnAfterwardsExpects) {
  draw();
  GLint framebuffer = 0, program = 0, array = 0, texture = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
  glGetIntegerv(GL_CURRENT_PROGRAM, &program);
  glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &array);
  glGetIntegerv(GL_TEXTURE_BINDING_2D, &texture);
  EXPECT_EQ(static_cast<GLuint>(framebuffer), target_->framebuffer());
  EXPECT_EQ(program, 0);
  EXPECT_EQ(array, 0);
  EXPECT_EQ(texture, 0);
  for (const GLenum state : {GL_DEPTH_TEST, GL_BLEND, GL_CULL_FACE, GL_SCISSOR_TEST, GL_FRAMEBUFFER_SRGB})
    EXPECT_FALSE(glIsEnabled(state)) << std::hex << state;
}

TEST(PosedBounds, HoldsEveryVertexOfABentArmNearly) {
  const Arm arm = testing::arm(4, 0.3, 0.05);
  std::mt19937_64 random(6);
  for (int trial = 0; trial < 20; ++trial) {
    const Frames frames = forwardKinematics(arm.skeleton, testing::bent(arm.skeleton, random, 1.0));
    const Eigen::AlignedBox3d estimate = PosedBounds(arm.skin)(poseSkin(arm.skin, frames));
    Eigen::AlignedBox3d exact;
    for (const Vector3d& p : linearBlendSkin(arm.skin, frames).positions) exact.extend(p);
    // Vertices that two joints share lie between what the two boxes say: off by the radius at most.
    EXPECT_LE((estimate.min() - exact.min()).cwiseAbs().maxCoeff(), 0.1) << "seed 6, trial " << trial;
    EXPECT_LE((estimate.max() - exact.max()).cwiseAbs().maxCoeff(), 0.1) << "seed 6, trial " << trial;
  }
}

TEST(Viridis, RisesInLuminanceFromEndToEnd) {
  double before = -1.0;
  for (int i = 0; i <= 100; ++i) {
    const double luminance =
        Eigen::Vector3f(0.2126f, 0.7152f, 0.0722f).dot(linearLight(viridis(0.01f * static_cast<float>(i))));
    EXPECT_GT(luminance, before) << i;
    before = luminance;
  }
  EXPECT_EQ(viridis(-1.0f).r, viridis(0.0f).r);
  EXPECT_EQ(viridis(NAN).r, viridis(0.0f).r);
  EXPECT_EQ(viridis(2.0f).r, viridis(1.0f).r);
}

}  // namespace
}  // namespace gelenk
