#include "apps/render/model_view.h"

#include "apps/render/signs.h"

namespace gelenk {

ModelView::ModelView(const Model& model) : model_(&model) {
  const Frames rest = restFrames(model.skeleton);
  if (model.skin) {
    mesh_.emplace(*model.skin);
    posedBounds_.emplace(*model.skin);
  }
  restBounds_ = bounds(rest);
  size_ = std::max(restBounds_.diagonal().norm(), 1e-9);
  // The ground lies under the rest pose. A planar scene is seen from above: a little distance gives its
  // shadow room.
  const Eigen::Vector3d up = model.up;
  groundHeight_ =
      std::min(restBounds_.min().dot(up), restBounds_.max().dot(up)) - (model.planar ? 0.012 * size_ : 0.0);
}

Eigen::AlignedBox3d ModelView::bounds(const Frames& worldFromJoint) const {
  if (posedBounds_) return (*posedBounds_)(poseSkin(*model_->skin, worldFromJoint));
  Eigen::AlignedBox3d box;
  for (const Eigen::Isometry3d& frame : worldFromJoint) box.extend(frame.translation());
  return box;
}

void ModelView::setMuscles(std::shared_ptr<const MuscleRig> muscles, bool lattice) {
  if (muscles)
    mesh_.emplace(muscles->body());
  else if (model_->skin)
    mesh_.emplace(*model_->skin);
  muscles_ = std::move(muscles);
  lattice_ = lattice;
  shownWeights_ = -1;
}

void ModelView::showWeights(int joint) {
  if (joint == shownWeights_) return;
  mesh_->setColours(viridisColours(jointWeights(*model_->skin, joint)));
  shownWeights_ = joint;
}

RenderScene ModelView::compose(const Eigen::VectorXd& q, const ViewOptions& options, Theme theme,
                               std::optional<int> selected) {
  return compose(forwardKinematics(model_->skeleton, q), options, theme, selected);
}

RenderScene ModelView::compose(const Frames& frames, const ViewOptions& options, Theme theme,
                               std::optional<int> selected) {
  RenderScene scene;
  scene.theme = theme;
  scene.size = size_;
  scene.bounds = bounds(frames);
  scene.ground = {.visible = options.ground, .grid = options.ground, .height = groundHeight_};
  scene.shadows = options.shadow;
  if (mesh_ && options.skin) {
    if (muscles_) {
      const std::vector<LimbPose> limbs = muscles_->pose(frames);
      poseSkin(muscles_->body(), frames, limbs, pose_);
      mesh_->setSculpture(*muscles_);
      if (lattice_)
        for (const LimbPose& limb : limbs) addLattice(scene.overlayOnTop, limb);
    } else {
      poseSkin(*model_->skin, frames, pose_);
    }
    if (!muscles_) pose_.layers.clear();
    const bool weights = options.weights && selected;
    if (weights) showWeights(*selected);
    scene.bodies.push_back({.mesh = &*mesh_,
                            .pose = &pose_,
                            .surface = weights ? SurfaceColour::Vertex : SurfaceColour::Clay,
                            .wireframe = options.wireframe});
  }
  if (options.skeleton || !mesh_) {
    scene.xray = options.skeleton;
    addBones(scene.overlayOnTop, model_->skeleton, frames, size_, boneColour, selected.value_or(-1));
  }
  if (options.jointFrames) addJointFrames(scene.overlayOnTop, frames, size_);
  return scene;
}

Camera ModelView::usualCamera(const Viewport& viewport) const {
  Camera camera{.up = model_->up, .orthographic = model_->planar};
  camera = lookFrom(camera, model_->planar ? StandardView::Top : StandardView::ThreeQuarter);
  return frameBox(camera, viewport, restBounds_);
}

}  // namespace gelenk
