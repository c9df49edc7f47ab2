#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

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

  void opened(Sandbox& sandbox, bool) override {
    layers_.clear();
    tool_ = Tool::Off;
    lasso_.clear();
    layer_ = -1;
    prepared_ = false;
    if (sandbox.session().model().skin) radius_ = 0.03 * sandbox.state().size();
  }

  void drawInspector(Sandbox& sandbox) override {
    Sandbox::State& s = sandbox.state();
    shownAt_ = sandbox.frameNumber();
    if (!sandbox.session().skin()) {
      wrappedText("This model has no body to bind.");
      return;
    }
    prepare(sandbox.session().model());
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
    if (valueSlider("Radius", millimetres, static_cast<float>(5.0 * s.size()),
                    static_cast<float>(120.0 * s.size()), formatLength(radius_).c_str()))
      radius_ = 0.001 * millimetres;
    tooltip("Of the brush, on the posed surface. [ and ] change it.");
    ImGui::SetNextItemWidth(0.6f * ImGui::GetContentRegionAvail().x);
    if (valueSlider("Strength", strength, 0.02f, 1.0f, "%.2f")) strength_ = strength;
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
    return sandbox.session().skin() && tool_ != Tool::Off && inFront(sandbox);
  }

  std::string mouseHint() const override {
    return tool_ == Tool::Brush ? "Paint on the body · [ ] smaller, larger brush · Esc lets it go"
                                : "Draw around vertices: they change when you let go · Esc lets it go";
  }

  bool pressed(Sandbox& sandbox, const Vector2d& pixel) override {
    lasso_.clear();
    lastStamp_.reset();
    strokeBegun_ = false;
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
  }

  bool keyPressed(Sandbox& sandbox, int key, int modifiers) override {
    if (!sandbox.session().skin() || !inFront(sandbox)) return false;
    if (!(modifiers & GLFW_MOD_CONTROL) && (key == GLFW_KEY_B || key == GLFW_KEY_V)) {
      const Tool tool = key == GLFW_KEY_B ? Tool::Brush : Tool::Lasso;
      tool_ = tool_ == tool ? Tool::Off : tool;
      return true;
    }
    if (!takesMouse(sandbox) || (modifiers & GLFW_MOD_CONTROL)) return false;
    switch (key) {
      case GLFW_KEY_LEFT_BRACKET:
        radius_ = std::max(0.005 * sandbox.state().size(), radius_ / 1.15);
        return true;
      case GLFW_KEY_RIGHT_BRACKET:
        radius_ = std::min(0.12 * sandbox.state().size(), radius_ * 1.15);
        return true;
      case GLFW_KEY_ESCAPE: tool_ = Tool::Off; return true;
      default: return false;
    }
  }

  void overlay(Sandbox& sandbox) override {
    if (!sandbox.session().skin() || sandbox.frameNumber() != shownAt_) return;
    const PaintTarget target = targetOf(sandbox);
    if (!target.joints.empty()) sandbox.showVertexScalars(weightsOn(weights(sandbox), target));
    if (!takesMouse(sandbox)) return;
    if (tool_ == Tool::Brush) drawBrush(sandbox);
    if (lasso_.size() > 1) drawLasso(sandbox);
  }

  void act(Sandbox& sandbox, const std::vector<std::string>& words) override {
    if (!sandbox.session().skin()) throw std::invalid_argument("the model has no skin");
    prepare(sandbox.session().model());
    const std::string command = words.empty() ? "" : words[0];
    if (command == "export" && words.size() == 2)
      exportTo(sandbox, words[1]);
    else if (command == "smooth-all" && words.size() == 1)
      smoothAll(sandbox);
    else if (command == "heat-weights" && words.size() == 1)
      heatWeights(sandbox);
    else if (command == "mirror" && words.size() == 2 && (words[1] == "+x" || words[1] == "-x"))
      mirror(sandbox, words[1] == "+x" ? MirrorFrom::PositiveX : MirrorFrom::NegativeX);
    else
      throw std::invalid_argument(
          "the panel Binding knows export FILE, smooth-all, heat-weights and mirror +x|-x");
  }

 private:
  enum class Tool { Off, Brush, Lasso };
  enum class Mode { Bind, Erase, Smooth };

  /// When the panel is first used: which bones lie inside of the surface takes the time of many frames to
  /// tell.
  void prepare(const Model& model) {
    if (std::exchange(prepared_, true)) return;
    neighbours_ = vertexNeighbours(model.skin->mesh);
    bones_ = bonesOf(model.skeleton, bindFrames(model), model.skin->mesh);
    for (const Limb& limb : limbsOf(model))
      layers_.emplace_back(limb.name, layerOf({limb.joints.begin(), limb.joints.end() - 1}));
  }

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
    colourBar(s, "0", "1");
    tooltip("Weight of the target.");
  }

  void facts(Sandbox& sandbox) const {
    const PaintTarget target = targetOf(sandbox);
    if (target.joints.empty()) return;
    const std::vector<float> shares = weightsOn(weights(sandbox), target);
    const auto carried = std::count_if(shares.begin(), shares.end(), [](float w) { return w > 0.0f; });
    ImGui::Text("%ld of %zu vertices", static_cast<long>(carried), shares.size());
    tooltip("Vertices with a weight on the target.");
  }

  void wholeBody(Sandbox& sandbox) {
    if (ImGui::Button("Smooth all")) smoothAll(sandbox);
    tooltip("Smooths every vertex once, with the strength above.");
    ImGui::SameLine();
    if (ImGui::Button("Heat weights")) heatWeights(sandbox);
    tooltip("Weights by heat diffusion on the surface (Baran and Popovic 2007), as a start. Can be undone.");
    if (ImGui::Button("Mirror +x to -x")) mirror(sandbox, MirrorFrom::PositiveX);
    tooltip(
        "Copies the weights of the side x > 0 to the other; vertices by position in the rest pose, joints by "
        "name (_l, _r, left, right).");
    ImGui::SameLine();
    if (ImGui::Button("-x to +x")) mirror(sandbox, MirrorFrom::NegativeX);
    tooltip("The other way.");
  }

  void smoothAll(Sandbox& sandbox) {
    change(sandbox, smoothed(weights(sandbox), everyVertex(sandbox, strength_), neighbours_));
  }
  void heatWeights(Sandbox& sandbox) {
    const Model& model = sandbox.session().model();
    try {
      replaceAll(sandbox,
                 fourLargest(boneHeatWeights(model.skin->mesh, bones_), model.skeleton.jointCount()));
    } catch (const std::exception& error) {
      sandbox.say(error.what(), true);
    }
  }

  void history(Sandbox& sandbox) {
    const auto button = [&](const char* label, bool possible, bool redo, const char* explanation) {
      ImGui::BeginDisabled(!possible);
      if (ImGui::Button(label)) undoOrRedo(sandbox, redo);
      ImGui::EndDisabled();
      tooltip(explanation);
    };
    button("Undo", sandbox.session().canUndo(), false,
           "Ctrl+Z. Takes the last edit back, exactly: a stroke, a drag, a goal.");
    ImGui::SameLine();
    button("Redo", sandbox.session().canRedo(), true, "Ctrl+Shift+Z or Ctrl+Y.");
    ImGui::SameLine();
    if (ImGui::Button("Original")) replaceAll(sandbox, sandbox.session().model().skin->influences);
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
    const Skeleton& skeleton = sandbox.session().skeleton();
    try {
      writeFile(path, formatPinocchioWeights(boneWeights(weights(sandbox), skeleton)));
      const auto onTip = std::ranges::count_if(weights(sandbox), [&](const Influences& in) {
        for (int k = 0; k < 4; ++k)
          if (in.weights[k] > 0.0 && skeleton.children(in.joints[k]).empty()) return true;
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

  static const std::vector<Influences>& weights(const Sandbox& sandbox) {
    return sandbox.session().skin()->influences;
  }
  static VertexSelection everyVertex(const Sandbox& sandbox, double share) {
    VertexSelection all;
    for (int v = 0; v < static_cast<int>(weights(sandbox).size()); ++v) all.push_back({v, share});
    return all;
  }

  /// One edit.
  static void change(Sandbox& sandbox, const WeightChange& change) {
    if (change.empty()) return;
    sandbox.session().remember();
    sandbox.session().changeWeights(change);
  }
  static void replaceAll(Sandbox& sandbox, const std::vector<Influences>& next) {
    change(sandbox, difference(weights(sandbox), next));
  }

  void mirror(Sandbox& sandbox, MirrorFrom from) {
    const Model& model = sandbox.session().model();
    try {
      const std::vector<int> joints = mirrorPartners(model.skeleton);
      const std::vector<int> vertices =
          mirrorVertices(model.skin->mesh.positions, 1e-3 * sandbox.state().size());
      const auto alone = std::count(vertices.begin(), vertices.end(), -1);
      change(sandbox, mirrored(weights(sandbox), model.skin->mesh.positions, vertices, joints, from));
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
        return painted(weights(sandbox), selection, target, sandbox.session().model().skin->mesh.positions);
      case Mode::Erase: return erased(weights(sandbox), selection, target);
      case Mode::Smooth: return smoothed(weights(sandbox), selection, neighbours_);
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
    return pickSurface(s.view->triangles(sandbox.session()), sandbox.surface().positions,
                       rayThroughPixel(s.camera(), s.viewport(), s.toView(pixel)));
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
    if (!std::exchange(strokeBegun_, true)) sandbox.session().remember();
    sandbox.session().changeWeights(stamp);
  }

  void applyLasso(Sandbox& sandbox) {
    const PaintTarget target = targetOf(sandbox);
    if (!hasTarget(sandbox, target)) return;
    const Sandbox::State& s = sandbox.state();
    const SkinnedVertices& surface = sandbox.surface();
    const Vector3d eye = s.camera().eye();
    std::vector<Projected> points;
    for (const Vector3d& p : surface.positions) points.push_back(project(s.camera(), s.viewport(), p));
    const auto& triangles = s.view->triangles(sandbox.session());
    const DepthMap depths(points, triangles, s.viewport());
    std::vector<bool> seen(points.size(), false);
    for (const auto& t : triangles)
      if (t[0] != t[1]) seen[t[0]] = seen[t[1]] = seen[t[2]] = true;
    std::vector<Vector2d> outline;
    for (const Vector2d& pixel : lasso_) outline.push_back(s.toView(pixel));
    VertexSelection selection;
    for (int v = 0; v < static_cast<int>(points.size()); ++v) {
      if (!seen[v] || points[v].depth <= 0.0 || !insideLasso(outline, points[v].pixel)) continue;
      const bool facing = surface.normals[v].dot(eye - surface.positions[v]) > 0.0;
      if (through_ || (facing && depths.shows(points[v], 0.02 * s.size())))
        selection.push_back({v, strength_});
    }
    change(sandbox, operation(sandbox, selection, target));
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

  bool prepared_ = false;
  VertexNeighbours neighbours_;
  std::vector<Bone> bones_;
  std::vector<std::pair<std::string, PaintTarget>> layers_;

  Tool tool_ = Tool::Off;
  Mode mode_ = Mode::Bind;
  double radius_ = 0.05, strength_ = 0.3;
  bool through_ = false;
  int layer_ = -1;
  int shownAt_ = -1000;  ///< frame in which the tab was last in front

  std::optional<Vector3d> lastStamp_;
  bool strokeBegun_ = false;  ///< the edit that the stroke is has been remembered
  std::vector<Vector2d> lasso_;
  char attachmentPath_[512] = "weights.attachment";
};

}  // namespace

std::unique_ptr<Panel> makeBindingPanel() { return std::make_unique<BindingPanel>(); }

}  // namespace gelenk
