#include "apps/render/muscle_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "apps/commands/muscle_report.h"
#include "apps/render/lettering.h"
#include "apps/render/limb_part.h"
#include "apps/render/renderer.h"
#include "apps/render/signs.h"
#include "skinning/gpu/render_target.h"

namespace gelenk {
namespace {

using Eigen::Vector3d;

constexpr double degree = M_PI / 180.0;
constexpr double bends[] = {0.0, 60.0, 120.0};
constexpr const char* ways[] = {"LBS", "FFD", "FFD + muscle"};

/// The triangles whose corners all belong to these joints.
MuscleSkin cutOut(const MuscleSkin& body, const std::vector<int>& joints) {
  MuscleSkin part{.skin = {.mesh = {}, .influences = {}, .jointFromRestWorld = body.skin.jointFromRestWorld},
                  .limbs = body.limbs,
                  .vertices = {},
                  .outside = {},
                  .unbound = 0};
  std::vector<int> kept(body.vertices.size(), -1);
  for (std::size_t v = 0; v < kept.size(); ++v) {
    const Influences& in = body.skin.influences[v];
    if (!belongsTo(in, joints)) continue;
    kept[v] = static_cast<int>(part.vertices.size());
    part.skin.mesh.positions.push_back(body.skin.mesh.positions[v]);
    part.skin.mesh.normals.push_back(body.skin.mesh.normals[v]);
    part.skin.influences.push_back(in);
    part.vertices.push_back(body.vertices[v]);
    part.outside.push_back(body.outside[v]);
  }
  for (const auto& [a, b, c] : body.skin.mesh.triangles)
    if (kept[a] >= 0 && kept[b] >= 0 && kept[c] >= 0)
      part.skin.mesh.triangles.push_back({kept[a], kept[b], kept[c]});
  if (part.skin.mesh.triangles.empty())
    throw std::invalid_argument("no part of the skin follows limb '" + body.limbs[0].name + "'");
  return part;
}

/// Along the bend axis, from outside the body; the first bone hangs down.
Camera alongBendAxis(const Limb& limb, const Frames& rest, const Viewport& cell) {
  const LimbFrames frames = limbFrames(limb, rest);
  const Vector3d& joint = frames.joints[1];
  Vector3d towardsViewer = frames.rotations[0].col(1);
  if (towardsViewer.dot(joint - rest[0].translation()) < 0.0) towardsViewer = -towardsViewer;
  Camera camera{.up = -frames.rotations[0].col(2), .orthographic = true};
  const Eigen::Matrix3d front = camera.axes();
  camera.azimuth = std::atan2(towardsViewer.dot(front.col(0)), towardsViewer.dot(front.col(2)));
  // Most of the first bone above the joint, as much of the second as fits, room on the side to which it
  // bends.
  const double reach = limb.shape.links[0].length;
  const double height = 1.56 * reach, width = height * cell.aspect();
  const double insideOnScreen = frames.rotations[0].col(0).dot(camera.axes().col(0)) > 0.0 ? 1.0 : -1.0;
  camera.target =
      joint + 0.06 * reach * camera.up + insideOnScreen * (0.5 * width - 0.40 * reach) * camera.axes().col(0);
  camera.distance = 0.5 * height / std::tan(0.5 * camera.verticalFieldOfView);
  return camera;
}

/// The bones of the limb alone.
void addLimbBones(Overlay& overlay, const LimbFrames& frames, double length) {
  for (std::size_t i = 0; i + 1 < frames.joints.size(); ++i)
    overlay.bone(frames.joints[i], frames.joints[i + 1], 0.045 * length, boneColour);
  for (const Vector3d& joint : frames.joints) overlay.point(joint, boneColour, 9.0f);
}

class SheetPainter {
 public:
  SheetPainter(const Model& model, const Limb& limb, const MuscleSheet& sheet)
      : model_(model),
        sheet_(sheet),
        cell_{scaled(sheet.cellWidth), scaled(sheet.cellHeight)},
        rest_(restFrames(model.skeleton)),
        rig_(bindMuscles(*model.skin, {limb}, rest_), rest_),
        part_(cutOut(rig_.body(), descendants(model.skeleton, limb.joints.front()))),
        mesh_(part_),
        camera_(alongBendAxis(limb, rest_, cell_)),
        target_(cell_.width, cell_.height) {
    renderer_.setSupersampling(sheet.smoothing);
  }

  Image paint() {
    const int left = scaled(84), top = scaled(72), bottom = scaled(44), gap = scaled(6);
    Image page{.width = left + 3 * (cell_.width + gap),
               .height = top + 3 * (cell_.height + gap) + bottom,
               .pixels = {}};
    page.pixels.assign(4 * static_cast<std::size_t>(page.width) * page.height,
                       sheet_.theme == Theme::Dark ? 30 : 255);
    const Lettering large(scaled(28)), small(scaled(18));
    const Colour ink = sheet_.theme == Theme::Dark ? Colour{0.9f, 0.9f, 0.9f} : Colour{0.15f, 0.17f, 0.2f};
    for (int column = 0; column < 3; ++column) {
      const int middle = left + column * (cell_.width + gap) + cell_.width / 2;
      large.write(page, middle - large.width(ways[column]) / 2, top - scaled(26), ways[column], ink);
    }
    for (int row = 0; row < 3; ++row) {
      const int y = top + row * (cell_.height + gap);
      for (int column = 0; column < 3; ++column) {
        const double bend = paintCell(bends[row], column, page, left + column * (cell_.width + gap), y);
        if (column > 0) continue;
        const std::string words = fmt::format("{:.0f}°", std::abs(bend / degree));
        large.write(page, left - scaled(16) - large.width(words), y + cell_.height / 2, words, ink);
      }
    }
    const int y = page.height - scaled(16);
    int x = left;
    x += legend(page, small, x, y, connectingPlaneColour, "connecting planes 0, 1, 5, 6");
    x += legend(page, small, x, y, innerPlaneColour, "inner planes 2, 3, 4");
    legend(page, small, x, y, boneColour, "bones");
    const std::string title = model_.name + ", " + rig_.body().limbs[0].name;
    small.write(page, page.width - gap - small.width(title), y, title, ink);
    return page;
  }

 private:
  int scaled(int pixels) const { return static_cast<int>(std::lround(sheet_.scale * pixels)); }

  int legend(Image& page, const Lettering& type, int x, int y, const Colour& colour,
             const std::string& words) const {
    type.write(page, x, y, words, colour);
    return scaled(36) + type.width(words);
  }

  /// Returns the bend that the pose really has, radians.
  double paintCell(double degrees, int way, Image& page, int x, int y) {
    const Limb& limb = rig_.body().limbs[0];
    const Frames frames = bentTo(model_.skeleton, limb, degrees * degree);
    const LimbFrames bones = limbFrames(limb, frames);
    rig_.controls()[0] = way == 2 ? defaultMuscleControl(limb) : noMuscleControl(limb);
    const std::vector<LimbPose> limbs = rig_.pose(frames);
    SkinPose pose;
    if (way == 0)
      poseSkin(part_.skin, frames, pose);
    else
      poseSkin(part_, frames, limbs, pose);

    RenderScene scene{.theme = sheet_.theme, .xray = true, .lightFromViewer = true};
    scene.ground.visible = false;
    const double reach = limb.shape.links[0].length + limb.shape.links[1].length;
    scene.bounds = Eigen::AlignedBox3d(Vector3d(bones.joints[1].array() - reach),
                                       Vector3d(bones.joints[1].array() + reach));
    scene.bodies.push_back(
        {.mesh = &mesh_, .pose = &pose, .tint = {0.95f, 0.80f, 0.71f}, .seeThrough = 0.3f});
    if (way > 0) addLattice(scene.overlay, limbs[0], {.opacity = 1.0f, .between = 1.0f});
    addLimbBones(scene.overlayOnTop, bones, limb.shape.links[0].length);
    Camera camera = camera_;  // the more it bends, the less hangs below the joint
    camera.target += 0.08 * limb.shape.links[0].length * (degrees / 120.0) * camera.up;
    renderer_.draw(scene, camera, cell_, target_.framebuffer(), static_cast<float>(1.4 * sheet_.scale));
    const std::vector<std::uint8_t> pixels = target_.readPixels();
    for (int row = 0; row < cell_.height; ++row)
      std::copy_n(&pixels[4 * static_cast<std::size_t>(row) * cell_.width], 4 * cell_.width,
                  &page.pixels[4 * (static_cast<std::size_t>(y + row) * page.width + x)]);
    return jointBend(bones, 1).bend;
  }

  const Model& model_;
  MuscleSheet sheet_;
  Viewport cell_;
  Frames rest_;
  MuscleRig rig_;
  MuscleSkin part_;
  SkinnedMeshGl mesh_;
  Camera camera_;
  Renderer renderer_;
  RenderTarget target_;
};

}  // namespace

Image drawMuscleSheet(const Model& model, const Limb& limb, const MuscleSheet& sheet) {
  if (!model.skin) throw std::invalid_argument("model '" + model.name + "' has no skin to deform");
  if (limb.shape.links.size() < 2)
    throw std::invalid_argument("limb '" + limb.name + "' has one link, a sheet needs a joint to bend");
  return SheetPainter(model, limb, sheet).paint();
}

}  // namespace gelenk
