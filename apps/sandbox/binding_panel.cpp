#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "apps/commands/muscle_report.h"
#include "apps/document/binding_scene.h"
#include "apps/sandbox/builtin_panels.h"
#include "apps/sandbox/sandbox_state.h"
#include "kinematics/io/text_file.h"
#include "kinematics/symmetry.h"
#include "skinning/io/pinocchio_weights.h"
#include "skinning/rigging/bone_heat.h"
#include "skinning/rigging/weight_paint.h"

namespace gelenk {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Which points of the view nothing hides: a depth map of the triangles with cells of three pixels.
class DepthMap {
 public:
  /// points: projected vertices, pixels of the view.
  DepthMap(const std::vector<Projected>& points, const std::vector<std::array<int, 3>>& triangles,
           const Viewport& view)
      : width_(view.width / cellSize + 1),
        height_(view.height / cellSize + 1),
        nearest_(static_cast<std::size_t>(width_) * height_, 1e300) {
    for (const auto& [a, b, c] : triangles)
      if (points[a].depth > 0.0 && points[b].depth > 0.0 && points[c].depth > 0.0)
        fill(points[a], points[b], points[c]);
  }

  bool shows(const Projected& p, double tolerance) const {
    const int x = static_cast<int>(std::floor(p.pixel.x() / cellSize)),
              y = static_cast<int>(std::floor(p.pixel.y() / cellSize));
    if (p.depth <= 0.0 || x < 0 || y < 0 || x >= width_ || y >= height_) return false;
    return p.depth <= nearest_[static_cast<std::size_t>(y) * width_ + x] + tolerance;
  }

 private:
  static constexpr int cellSize = 3;

  void fill(const Projected& a, const Projected& b, const Projected& c) {
    const auto cross = [](const Vector2d& u, const Vector2d& v) { return u.x() * v.y() - u.y() * v.x(); };
    const double area = cross(b.pixel - a.pixel, c.pixel - a.pixel);
    if (std::abs(area) < 1e-9) return;
    const Vector2d low = a.pixel.cwiseMin(b.pixel).cwiseMin(c.pixel) / cellSize,
                   high = a.pixel.cwiseMax(b.pixel).cwiseMax(c.pixel) / cellSize;
    if (!(low.x() < width_ && low.y() < height_ && high.x() >= 0.0 && high.y() >= 0.0)) return;
    const int x0 = std::max(0, static_cast<int>(low.x())), x1 = std::min(width_ - 1.0, high.x());
    const int y0 = std::max(0, static_cast<int>(low.y())), y1 = std::min(height_ - 1.0, high.y());
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x) {
        const Vector2d p = cellSize * Vector2d(x + 0.5, y + 0.5);
        const double u = cross(p - a.pixel, c.pixel - a.pixel) / area,
                     v = cross(b.pixel - a.pixel, p - a.pixel) / area;
        if (u < 0.0 || v < 0.0 || u + v > 1.0) continue;
        double& nearest = nearest_[static_cast<std::size_t>(y) * width_ + x];
        nearest = std::min(nearest, a.depth + u * (b.depth - a.depth) + v * (c.depth - a.depth));
      }
  }

  int width_, height_;
  std::vector<double> nearest_;
};

/// Binding by hand: brush or lasso vertices to a joint or a layer, smooth, mirror, undo (lecture 10.3).
class BindingPanel final : public Panel {
 public:
  std::string name() const override { return "Binding"; }
  bool hasInspector() const override { return true; }

  void modelChanged(Sandbox& sandbox) override {
    editor_.reset();
    layers_.clear();
    tool_ = Tool::Off;
    lasso_.clear();
    layer_ = -1;
    const Model& model = sandbox.session().model();
    if (!model.skin) return;
    editor_.emplace(model.skin->influences);
    skeleton_ = model.skeleton;
    neighbours_ = vertexNeighbours(model.skin->mesh);
    const Frames rest = bindFrames(model);
    bones_ = bonesOf(model.skeleton, rest, model.skin->mesh);
    for (const Limb& limb : standardLimbs(model.skeleton, rest))
      layers_.emplace_back(limb.name, layerOf({limb.joints.begin(), limb.joints.end() - 1}));
    radius_ = 0.03 * sandbox.state().size;
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    if (!editor_) {
      ImGui::TextWrapped("This model has no body to bind.");
      return;
    }
    heading(s, "TOOL");
    toolChoice("Off", Tool::Off, "The mouse drags the model; nothing is painted.");
    ImGui::SameLine();
    toolChoice("Brush", Tool::Brush, "Drag over the body: weights move as the mouse goes. Key B.");
    ImGui::SameLine();
    toolChoice("Lasso", Tool::Lasso, "Draw around vertices; they change when the button is let go. Key V.");
    modeChoice("Bind", Mode::Bind,
               "w' = (1 - a) w + a t: towards the joint, or towards the layer in the proportions that a "
               "vertex has there.");
    ImGui::SameLine();
    modeChoice("Take away", Mode::Erase,
               "The target's weights shrink by 1 - a, the others take their share.");
    ImGui::SameLine();
    modeChoice("Smooth", Mode::Smooth,
               "w' = (1 - a) w + a times the mean of the neighbours along the mesh's edges.");
    float millimetres = static_cast<float>(1000.0 * radius_), strength = static_cast<float>(strength_);
    ImGui::SetNextItemWidth(0.6f * ImGui::GetContentRegionAvail().x);
    if (ImGui::SliderFloat("Radius", &millimetres, static_cast<float>(5.0 * s.size),
                           static_cast<float>(120.0 * s.size), "%.0f mm"))
      radius_ = 0.001 * millimetres;
    tooltip("Of the brush, on the posed surface, millimetres. [ and ] change it.");
    ImGui::SetNextItemWidth(0.6f * ImGui::GetContentRegionAvail().x);
    if (ImGui::SliderFloat("Strength", &strength, 0.02f, 1.0f, "%.2f")) strength_ = strength;
    tooltip(
        "a at the brush's centre; it fades as (1 - (d/r)²)² towards the rim. For the lasso: a of every "
        "vertex inside.");
    if (tool_ == Tool::Lasso) {
      ImGui::Checkbox("Through the body", &through_);
      tooltip("Takes hidden vertices too. Otherwise only those that face you and that nothing covers.");
    }

    heading(s, "TARGET");
    targetChoice(sandbox);
    scaleBar(s);
    facts(sandbox);

    heading(s, "WHOLE BODY");
    wholeBody(sandbox);

    heading(s, "HISTORY");
    history(sandbox);
  }

  bool takesMouse(const Sandbox& sandbox) const override {
    return editor_ && tool_ != Tool::Off && inFront(sandbox);
  }

  bool pressed(Sandbox& sandbox, const Vector2d& pixel) override {
    editor_->finishStep();
    lasso_.clear();
    lastStamp_.reset();
    if (tool_ == Tool::Lasso) {
      lasso_.push_back(pixel);
      return true;
    }
    stroke(sandbox, pixel);
    return lastStamp_.has_value();
  }

  void moved(Sandbox& sandbox, const Vector2d& pixel) override {
    if (tool_ == Tool::Lasso) {
      if (lasso_.empty() || (lasso_.back() - pixel).norm() >= 2.0) lasso_.push_back(pixel);
    } else {
      stroke(sandbox, pixel);
    }
  }

  void released(Sandbox& sandbox) override {
    if (tool_ == Tool::Lasso && lasso_.size() > 2) applyLasso(sandbox);
    lasso_.clear();
    lastStamp_.reset();
    editor_->finishStep();
    sandbox.setWeights(editor_->weights());
  }

  bool keyPressed(Sandbox& sandbox, int key, int modifiers) override {
    if (!editor_ || !inFront(sandbox)) return false;
    if (!(modifiers & GLFW_MOD_CONTROL) && (key == GLFW_KEY_B || key == GLFW_KEY_V)) {
      const Tool tool = key == GLFW_KEY_B ? Tool::Brush : Tool::Lasso;
      tool_ = tool_ == tool ? Tool::Off : tool;
      return true;
    }
    if (!takesMouse(sandbox)) return false;
    if (modifiers & GLFW_MOD_CONTROL) {
      if (key != GLFW_KEY_Z && key != GLFW_KEY_Y) return false;
      const bool redo = key == GLFW_KEY_Y || (modifiers & GLFW_MOD_SHIFT);
      takeBack(sandbox, redo);
      return true;
    }
    switch (key) {
      case GLFW_KEY_LEFT_BRACKET:
        radius_ = std::max(0.005 * sandbox.state().size, radius_ / 1.15);
        return true;
      case GLFW_KEY_RIGHT_BRACKET:
        radius_ = std::min(0.12 * sandbox.state().size, radius_ * 1.15);
        return true;
      case GLFW_KEY_ESCAPE: tool_ = Tool::Off; return true;
      default: return false;
    }
  }

  void overlay(Sandbox& sandbox) override {
    if (!editor_ || sandbox.frameNumber() != shownAt_) return;
    const PaintTarget target = targetOf(sandbox);
    if (!target.joints.empty()) sandbox.showVertexScalars(weightsOn(editor_->weights(), target));
    if (!takesMouse(sandbox)) return;
    if (tool_ == Tool::Brush) drawBrush(sandbox);
    if (lasso_.size() > 1) drawLasso(sandbox);
  }

  std::string save() const override {
    return editor_
               ? bindingText(editor_->difference(), static_cast<int>(editor_->weights().size()), skeleton_)
               : "";
  }
  void load(Sandbox& sandbox, const std::string& json) override {
    if (!editor_) return;
    const WeightChange change =
        parseBinding(json, static_cast<int>(editor_->weights().size()), sandbox.session().skeleton());
    editor_->finishStep();
    std::vector<Influences> weights = editor_->start();
    for (const auto& [vertex, influences] : change) weights[vertex] = influences;
    replaceAll(sandbox, weights);
  }
  void verify(const Model& model, const std::string& json) const override {
    if (model.skin) parseBinding(json, static_cast<int>(model.skin->influences.size()), model.skeleton);
  }
  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (!editor_) throw std::invalid_argument("the model has no skin");
    if (words.size() != 2 || words[0] != "export")
      throw std::invalid_argument("the Binding panel's command is: export FILE");
    exportTo(sandbox, words[1]);
  }
  void reset(Sandbox& sandbox) override {
    if (editor_) replaceAll(sandbox, editor_->start());
  }

 private:
  enum class Tool { Off, Brush, Lasso };
  enum class Mode { Bind, Erase, Smooth };

  bool inFront(const Sandbox& sandbox) const { return sandbox.frameNumber() - shownAt_ <= 1; }

  void toolChoice(const char* label, Tool tool, const char* explanation) {
    if (ImGui::RadioButton(label, tool_ == tool)) tool_ = tool;
    tooltip(explanation);
  }
  void modeChoice(const char* label, Mode mode, const char* explanation) {
    if (ImGui::RadioButton(label, mode_ == mode)) mode_ = mode;
    tooltip(explanation);
  }

  PaintTarget layerOf(std::vector<int> joints) const {
    PaintTarget layer{.joints = std::move(joints)};
    for (const Bone& bone : bones_)
      if (layer.contains(bone.joint)) layer.bones.push_back(bone);
    return layer;
  }

  /// The layer chosen, else the selected joint; empty: nothing to bind to.
  PaintTarget targetOf(const Sandbox& sandbox) const {
    if (layer_ >= 0) return layers_[layer_].second;
    if (const auto joint = sandbox.selectedJoint()) return layerOf({*joint});
    return {};
  }

  void targetChoice(Sandbox& sandbox) {
    const Skeleton& skeleton = sandbox.session().skeleton();
    const auto joint = sandbox.selectedJoint();
    const std::string shown = layer_ >= 0 ? "Layer: " + layers_[layer_].first
                              : joint     ? skeleton.joint(*joint).name
                                          : "Choose a joint or a layer";
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::BeginCombo("##target", shown.c_str())) {
      tooltip(
          "What vertices are bound to: one joint, or a layer (the joints of a limb that carries muscles). "
          "With the tool off, a click on the body selects its joint.");
      return;
    }
    for (int l = 0; l < static_cast<int>(layers_.size()); ++l)
      if (ImGui::Selectable(("Layer: " + layers_[l].first).c_str(), l == layer_)) layer_ = l;
    for (int j = 0; j < skeleton.jointCount(); ++j)
      if (ImGui::Selectable(skeleton.joint(j).name.c_str(), layer_ < 0 && joint == j)) {
        layer_ = -1;
        sandbox.select(j);
      }
    ImGui::EndCombo();
  }

  static void scaleBar(const Sandbox::State& s) {
    colourBar(s);
    tooltip("Weight of the target, 0 (violet) to 1 (yellow).");
  }

  void facts(Sandbox& sandbox) const {
    const PaintTarget target = targetOf(sandbox);
    if (target.joints.empty()) return;
    const std::vector<float> weights = weightsOn(editor_->weights(), target);
    const auto carried = std::count_if(weights.begin(), weights.end(), [](float w) { return w > 0.0f; });
    ImGui::Text("%ld of %zu vertices", static_cast<long>(carried), weights.size());
    tooltip("Vertices with a weight on the target.");
  }

  void wholeBody(Sandbox& sandbox) {
    const Model& model = sandbox.session().model();
    if (ImGui::Button("Smooth all"))
      change(sandbox, smoothed(editor_->weights(), everyVertex(strength_), neighbours_));
    tooltip("Smooths every vertex once, with the strength above.");
    ImGui::SameLine();
    if (ImGui::Button("Heat weights")) {
      try {
        replaceAll(sandbox,
                   fourLargest(boneHeatWeights(model.skin->mesh, bones_), model.skeleton.jointCount()));
      } catch (const std::exception& error) {
        sandbox.say(error.what(), true);
      }
    }
    tooltip("Weights by heat diffusion on the surface (Baran and Popovic 2007), as a start. Can be undone.");
    if (ImGui::Button("Mirror +x to -x")) mirror(sandbox, MirrorFrom::PositiveX);
    tooltip(
        "Copies the weights of the side x > 0 to the other; vertices by position in the rest pose, joints by "
        "name (_l, _r, left, right).");
    ImGui::SameLine();
    if (ImGui::Button("-x to +x")) mirror(sandbox, MirrorFrom::NegativeX);
    tooltip("The other way.");
  }

  void history(Sandbox& sandbox) {
    const auto button = [&](const char* label, bool possible, bool redo, const char* explanation) {
      ImGui::BeginDisabled(!possible);
      if (ImGui::Button(label)) takeBack(sandbox, redo);
      ImGui::EndDisabled();
      tooltip(explanation);
    };
    button("Undo", editor_->canUndo(), false,
           "Takes the last stroke back, exactly. Ctrl+Z while a tool is on.");
    ImGui::SameLine();
    button("Redo", editor_->canRedo(), true, "Ctrl+Shift+Z or Ctrl+Y while a tool is on.");
    ImGui::SameLine();
    if (ImGui::Button("Original")) replaceAll(sandbox, editor_->start());
    tooltip("The model's own weights. Can be undone.");
    ImGui::TextColored(sandbox.state().colours().textDim, "Saved with the scene, to the last bit.");
    ImGui::SetNextItemWidth(0.6f * ImGui::GetContentRegionAvail().x);
    ImGui::InputText("##attachment", attachmentPath_, sizeof attachmentPath_);
    tooltip("File of the button beside it.");
    ImGui::SameLine();
    if (ImGui::Button("Export")) exportTo(sandbox, attachmentPath_);
    tooltip(
        "Writes the weights as a Pinocchio attachment file, one line a vertex and one column a bone, as "
        "--weights takes it.");
  }

  void exportTo(Sandbox& sandbox, const std::string& path) {
    try {
      writeFile(path, formatPinocchioWeights(boneWeights(editor_->weights(), skeleton_)));
      const auto onTip = std::ranges::count_if(editor_->weights(), [&](const Influences& in) {
        for (int k = 0; k < 4; ++k)
          if (in.weights[k] > 0.0 && skeleton_.children(in.joints[k]).empty()) return true;
        return false;
      });
      sandbox.say(
          onTip == 0
              ? "Wrote " + path
              : fmt::format(
                    "Wrote {}; {} vertices follow joints without a child, which come back on the parent",
                    path, onTip));
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  VertexSelection everyVertex(double share) const {
    VertexSelection all;
    for (int v = 0; v < static_cast<int>(editor_->weights().size()); ++v) all.push_back({v, share});
    return all;
  }

  /// One step: in the editor, the session and on the GPU.
  void change(Sandbox& sandbox, const WeightChange& change) {
    if (change.empty()) return;
    editor_->finishStep();
    editor_->apply(change);
    editor_->finishStep();
    sandbox.setWeights(editor_->weights());
  }
  void replaceAll(Sandbox& sandbox, const std::vector<Influences>& weights) {
    WeightChange all;
    for (int v = 0; v < static_cast<int>(weights.size()); ++v)
      if (!(weights[v] == editor_->weights()[v])) all.emplace_back(v, weights[v]);
    change(sandbox, all);
  }
  void takeBack(Sandbox& sandbox, bool redo) {
    if (redo ? editor_->redo() : editor_->undo())
      sandbox.setWeights(editor_->weights());
    else
      sandbox.say(redo ? "Nothing to redo" : "Nothing to undo");
  }

  void mirror(Sandbox& sandbox, MirrorFrom from) {
    const Model& model = sandbox.session().model();
    try {
      const std::vector<int> joints = mirrorPartners(model.skeleton);
      const std::vector<int> vertices =
          mirrorVertices(model.skin->mesh.positions, 1e-3 * sandbox.state().size);
      const auto alone = std::count(vertices.begin(), vertices.end(), -1);
      change(sandbox, mirrored(editor_->weights(), model.skin->mesh.positions, vertices, joints, from));
      sandbox.say(alone > 0 ? fmt::format("Mirrored; {} vertices have no mirror image and stay", alone)
                            : "Mirrored");
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  WeightChange operation(Sandbox& sandbox, const VertexSelection& selection,
                         const PaintTarget& target) const {
    switch (mode_) {
      case Mode::Bind:
        return painted(editor_->weights(), selection, target, sandbox.session().model().skin->mesh.positions);
      case Mode::Erase: return erased(editor_->weights(), selection, target);
      case Mode::Smooth: return smoothed(editor_->weights(), selection, neighbours_);
    }
    return {};
  }

  bool hasTarget(Sandbox& sandbox, const PaintTarget& target) const {
    if (mode_ == Mode::Smooth || !target.joints.empty()) return true;
    sandbox.say("Choose a joint or a layer to bind to");
    return false;
  }

  std::optional<SurfaceHit> hitAt(Sandbox& sandbox, const Vector2d& pixel) const {
    const Sandbox::State& s = sandbox.state();
    const Skin& skin = *sandbox.session().model().skin;
    return pickSurface(skin.mesh.triangles, sandbox.surface().positions,
                       rayThroughPixel(s.camera, s.viewport(), s.toView(pixel)));
  }

  /// One stamp of the brush, and no other until the mouse has moved on by a quarter of the radius: a stroke
  /// does not depend on the frame rate.
  void stroke(Sandbox& sandbox, const Vector2d& pixel) {
    const auto hit = hitAt(sandbox, pixel);
    if (!hit || (lastStamp_ && (hit->position - *lastStamp_).norm() < 0.25 * radius_)) return;
    lastStamp_ = hit->position;
    const PaintTarget target = targetOf(sandbox);
    if (!hasTarget(sandbox, target)) return;
    const Skin& skin = *sandbox.session().model().skin;
    const Brush brush{.radius = radius_, .strength = strength_};
    const WeightChange stamp =
        operation(sandbox,
                  underBrush(brush, hit->position, skin.mesh.triangles[hit->point.triangle],
                             sandbox.surface().positions, neighbours_),
                  target);
    if (stamp.empty()) return;
    editor_->apply(stamp);
    sandbox.setWeights(editor_->weights(), false);
  }

  void applyLasso(Sandbox& sandbox) {
    const PaintTarget target = targetOf(sandbox);
    if (!hasTarget(sandbox, target)) return;
    const Sandbox::State& s = sandbox.state();
    const SkinnedVertices& surface = sandbox.surface();
    const Vector3d eye = s.camera.eye();
    std::vector<Projected> points;
    for (const Vector3d& p : surface.positions) points.push_back(project(s.camera, s.viewport(), p));
    const DepthMap depths(points, sandbox.session().model().skin->mesh.triangles, s.viewport());
    std::vector<Vector2d> outline;
    for (const Vector2d& pixel : lasso_) outline.push_back(s.toView(pixel));
    VertexSelection selection;
    for (int v = 0; v < static_cast<int>(points.size()); ++v) {
      if (points[v].depth <= 0.0 || !insideLasso(outline, points[v].pixel)) continue;
      const bool facing = surface.normals[v].dot(eye - surface.positions[v]) > 0.0;
      if (through_ || (facing && depths.shows(points[v], 0.02 * s.size))) selection.push_back({v, strength_});
    }
    editor_->apply(operation(sandbox, selection, target));
    sandbox.say(fmt::format("{} vertices in the lasso", selection.size()));
  }

  void drawBrush(Sandbox& sandbox) {
    const Sandbox::State& s = sandbox.state();
    if (!s.layout.view.contains(s.mouse.x(), s.mouse.y())) return;
    const auto hit = hitAt(sandbox, s.mouse);
    if (!hit) return;
    Vector3d normal = Vector3d::Zero();
    const auto& triangle = sandbox.session().model().skin->mesh.triangles[hit->point.triangle];
    for (int k = 0; k < 3; ++k) normal += hit->point.barycentric[k] * sandbox.surface().normals[triangle[k]];
    if (normal.norm() < 1e-9) return;
    const Vector3d u = normal.unitOrthogonal(), v = normal.normalized().cross(u);
    for (const double radius : {radius_, 0.5 * radius_}) {
      std::vector<Vector2d> circle;
      for (int i = 0; i < 64; ++i) {
        const double angle = 2.0 * M_PI * i / 64.0;
        circle.push_back(
            s.toWindow(hit->position + radius * (std::cos(angle) * u + std::sin(angle) * v)).pixel);
      }
      drawOutline(s, circle, radius == radius_ ? 1.0f : 0.45f);
    }
  }

  void drawLasso(Sandbox& sandbox) const { drawOutline(sandbox.state(), lasso_, 1.0f); }

  /// A closed line over the view, white beneath so that it shows on every colour.
  static void drawOutline(const Sandbox::State& s, const std::vector<Vector2d>& pixels, float strength) {
    ImDrawList* draw = ImGui::GetForegroundDrawList();
    const Layout::Rect& view = s.layout.view;
    draw->PushClipRect({view.x, view.y}, {view.x + view.width, view.y + view.height});
    std::vector<ImVec2> points;
    for (const Vector2d& p : pixels) points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y())});
    const int count = static_cast<int>(points.size());
    draw->AddPolyline(points.data(), count, colour32({1, 1, 1, 0.9f}, strength), ImDrawFlags_Closed,
                      3.6f * s.scale);
    draw->AddPolyline(points.data(), count, colour32(s.colours().accent, strength), ImDrawFlags_Closed,
                      1.6f * s.scale);
    draw->PopClipRect();
  }

  std::optional<WeightEditor> editor_;
  VertexNeighbours neighbours_;
  std::vector<Bone> bones_;
  std::vector<std::pair<std::string, PaintTarget>> layers_;
  Skeleton skeleton_;

  Tool tool_ = Tool::Off;
  Mode mode_ = Mode::Bind;
  double radius_ = 0.05, strength_ = 0.3;
  bool through_ = false;
  int layer_ = -1;
  int shownAt_ = -1000;  ///< frame in which the tab was last in front

  std::optional<Vector3d> lastStamp_;
  std::vector<Vector2d> lasso_;
  char attachmentPath_[512] = "weights.attachment";
};

}  // namespace

std::unique_ptr<Panel> makeBindingPanel() { return std::make_unique<BindingPanel>(); }

}  // namespace gelenk
