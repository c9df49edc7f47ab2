#include "apps/render/scene_view.h"

#include <algorithm>
#include <stdexcept>

#include "apps/render/scene_marks.h"
#include "apps/render/signs.h"

namespace gelenk {
namespace {

Eigen::AlignedBox3d boxOf(const Frames& frames) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Isometry3d& frame : frames) box.extend(frame.translation());
  return box;
}

bool sameFrames(const Frames& a, const Frames& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) { return x.matrix() == y.matrix(); });
}

}  // namespace

SceneView::SceneView(const Session& session, Ground ground) {
  const Model& model = session.model();
  const Frames rest = restFrames(model.skeleton);
  Eigen::AlignedBox3d box;
  if (session.skin()) {
    if (model.look) {
      validate(*model.look, static_cast<int>(session.skin()->mesh.positions.size()),
               static_cast<int>(session.skin()->mesh.triangles.size()));
      look_ = std::make_unique<MeshLookGl>(*model.look);
    }
    mesh_ = std::make_unique<SkinnedMeshGl>(*session.skin());
    takeLook(session, *mesh_);
    posedBounds_ = std::make_unique<PosedBounds>(*session.skin());
    meshVersion_ = session.weightsVersion();
    for (const Eigen::Vector3d& p : linearBlendSkin(*model.skin, rest).positions) box.extend(p);
  }
  if (box.isEmpty()) box = boxOf(rest);
  size_ = std::max(box.diagonal().norm(), 1e-9);
  const auto lowest = [&](const Eigen::AlignedBox3d& b) {
    return std::min(model.up.dot(b.min()), model.up.dot(b.max()));
  };
  groundHeight_ = lowest(box) - (model.planar ? 0.012 * size_ : 0.0);  // room for a shadow
  bounds_ = box;
  if (ground != Ground::UnderMotion || !model.clip || model.planar) return;
  const Eigen::AlignedBox3d first =
      boundsAt(session, forwardKinematics(model.skeleton, model.clip->q.col(0)));
  standsOnMotion_ = std::abs(lowest(first) - groundHeight_) >= 0.1 * size_;
  if (!standsOnMotion_) return;
  groundHeight_ = lowest(first);
  bounds_ = first;
}

Eigen::AlignedBox3d SceneView::boundsAt(const Session& session, const Frames& frames) const {
  return posedBounds_ ? (*posedBounds_)(poseSkin(*session.skin(), frames)) : boxOf(frames);
}

void SceneView::follow(const Session& session, const Frames& frames, bool ownPose, bool stroke) {
  const int version = session.weightsVersion();
  if (mesh_ && meshVersion_ != version) {
    mesh_ = std::make_unique<SkinnedMeshGl>(*session.skin());
    takeLook(session, *mesh_);
    posedBounds_ = std::make_unique<PosedBounds>(*session.skin());
    meshVersion_ = version;
    surfaceIsCurrent_ = false;
  }
  if (settings_ != session.edits().muscles || (rig_ && rigVersion_ != version && !stroke)) bind(session);
  ownPose_ = ownPose;
  if (!sameFrames(frames_, frames)) {
    frames_ = frames;
    surfaceIsCurrent_ = limbsAreCurrent_ = false;
  }
  bounds_ = boundsAt(session, frames_);
}

void SceneView::takeLook(const Session& session, SkinnedMeshGl& mesh) {
  colouredByLook_ = nullptr;
  if (look_ && !session.model().look->coordinates.empty())
    mesh.setCoordinates(session.model().look->coordinates);
}

/// Anew after switching on, and where weights or proportions changed, because the rest lattice did.
void SceneView::bind(const Session& session) {
  const auto before = std::exchange(settings_, session.edits().muscles);
  surfaceIsCurrent_ = limbsAreCurrent_ = false;
  muscleFault_.clear();
  if (!settings_ || !settings_->enabled || !session.skin()) {
    rig_.reset();
    layeredMesh_.reset();
    return;
  }
  if (rig_ && rigVersion_ == session.weightsVersion() && sameProportions(*before, *settings_))
    return applyControls(*rig_, *settings_);
  try {
    rig_ = std::make_unique<MuscleRig>(makeMuscleRig(session.model(), *session.skin(), *settings_));
    layeredMesh_ = std::make_unique<SkinnedMeshGl>(rig_->body());
    takeLook(session, *layeredMesh_);
    rigVersion_ = session.weightsVersion();
  } catch (const std::invalid_argument& error) {
    muscleFault_ = error.what();
    rig_.reset();
    layeredMesh_.reset();
  }
}

const std::vector<LimbPose>& SceneView::limbPoses() {
  if (!limbsAreCurrent_) limbs_ = rig_ ? rig_->pose(frames_) : std::vector<LimbPose>{};
  limbsAreCurrent_ = true;
  return limbs_;
}

const SkinnedVertices& SceneView::surface(const Session& session) {
  if (surfaceIsCurrent_) return surface_;
  if (!session.skin())
    surface_ = {};
  else if (rig_)
    skinWithMuscles(rig_->body(), frames_, limbPoses(), surface_);
  else
    linearBlendSkin(*session.skin(), frames_, surface_);
  surfaceIsCurrent_ = true;
  return surface_;
}

Camera SceneView::wholeView(const Session& session, const Viewport& viewport,
                            const Eigen::AlignedBox3d& shown) const {
  Eigen::AlignedBox3d box = shown;
  if (session.model().planar && !frames_.empty()) {
    double reach = 0.0;
    for (int i = 0; i < session.skeleton().jointCount(); ++i)
      reach = std::max(reach, chainLength(session.skeleton(), i));
    const Eigen::Vector3d base = frames_[0].translation(), far(reach, reach, 0.0);
    box.extend(base + far);
    box.extend(base - far);
  }
  return frameBox(newDocument(session.model(), {}).view.camera, viewport, box);
}

void SceneView::addBodies(const Session& session, PictureExtras& extras, RenderScene& scene) {
  if (!mesh_) return;
  const ViewOptions& show = session.document().view.show;
  if (show.skin || show.wireframe) {
    SkinnedMeshGl* mesh = mesh_.get();
    if (rig_) {
      poseSkin(rig_->body(), frames_, limbPoses(), pose_);
      layeredMesh_->setSculpture(*rig_);
      mesh = layeredMesh_.get();
    } else {
      poseSkin(*session.skin(), frames_, pose_);
      pose_.layers.clear();
    }
    BodyInstance body{.mesh = mesh, .pose = &pose_, .wireframe = show.wireframe};
    auto& colours = extras.vertexColours;
    if (!colours && show.weights && session.selectedJoint())
      colours = viridisColours(jointWeights(*session.skin(), *session.selectedJoint()));
    if (colours && static_cast<int>(colours->size()) == mesh->vertexCount()) {
      mesh->setColours(*colours);
      body.surface = SurfaceColour::Vertex;
      colouredByLook_ = nullptr;
    } else if (look_) {
      if (colouredByLook_ != mesh) {
        const auto& own = look_->look().colours;
        mesh->setColours(
            own.empty() ? std::vector<Eigen::Vector3f>(mesh->vertexCount(), Eigen::Vector3f::Ones()) : own);
        colouredByLook_ = mesh;
      }
      body.look = look_.get();
      body.hidden = &session.document().view.hidden;
    }
    scene.bodies.push_back(body);
  }
  if (rig_ && settings_->split)
    extras.ghosts.push_back({.worldFromJoint = framesBeside(session, frames_, size_),
                             .tint = {0.80f, 0.76f, 0.71f},
                             .opacity = 1.0f});
  ghostPoses_.resize(extras.ghosts.size());
  for (std::size_t i = 0; i < extras.ghosts.size(); ++i) {
    const Ghost& ghost = extras.ghosts[i];
    poseSkin(*session.skin(), ghost.worldFromJoint, ghostPoses_[i]);
    scene.bodies.push_back({.mesh = mesh_.get(),
                            .pose = &ghostPoses_[i],
                            .tint = {ghost.tint.x(), ghost.tint.y(), ghost.tint.z(), ghost.opacity}});
  }
}

void SceneView::addMarks(const Session& session, const PictureExtras& extras, RenderScene& scene) {
  const ViewOptions& show = session.document().view.show;
  const MarkColours& colours = markColours(session.document().theme);
  const std::optional<int> selected = session.selectedJoint();
  if (show.skeleton || !mesh_)
    addBones(scene.overlayOnTop, session.skeleton(), frames_, size_, boneColour, selected.value_or(-1));
  if (session.model().planar) addWorkspace(scene.overlay, session, frames_, colours);
  if (show.jointFrames) {
    addJointFrames(scene.overlayOnTop, frames_, size_);
    if (ownPose_ && session.skeleton().jointCount() <= 12)
      addJointAxes(scene.overlayOnTop, session.skeleton(), session.q(), frames_, size_, colours.dim);
  }
  if (ownPose_ && show.limits) {
    const std::vector<bool> at = session.jointsAtLimit();
    for (int i = 0; i < static_cast<int>(at.size()); ++i) {
      double glow = i < static_cast<int>(extras.limitGlow.size()) ? extras.limitGlow[i] : 0.0;
      if (at[i] && selected == i && !session.dragged()) glow = 1.0;
      if (glow > 0.0)
        addLimit(scene.overlayOnTop, session, frames_, i, size_,
                 withAlpha(colours.bad, static_cast<float>(glow)));
    }
  }
  if (show.handles && ownPose_)
    addGoals(scene.overlayOnTop, session, size_, colours, extras.hovered, extras.selected);
  if (rig_ && settings_->lattice)
    for (std::size_t l = 0; l < rig_->body().limbs.size(); ++l)
      if (settings_->shownLimb.empty() || settings_->shownLimb == rig_->body().limbs[l].name)
        addLattice(scene.overlayOnTop, limbPoses()[l],
                   {.connecting = colours.pinned,
                    .inner = colours.held,
                    .selectedPlane = extras.latticePlane,
                    .selectedPoint = extras.latticePoint});
}

RenderScene SceneView::compose(const Session& session, PictureExtras extras) {
  const ViewOptions& show = session.document().view.show;
  RenderScene scene;
  scene.theme = session.document().theme;
  scene.shadows = show.shadow;
  scene.ground = {.visible = show.ground, .grid = show.ground, .height = groundHeight_};
  scene.xray = show.skeleton;
  scene.bounds = bounds_;
  scene.size = size_;
  if (ownPose_)
    teaching_.add(session, frames_,
                  {.size = size_,
                   .colours = &markColours(scene.theme),
                   .selected = extras.selected,
                   .whole = extras.whole},
                  extras.overlay, extras.overlayOnTop, extras.ghosts);
  addBodies(session, extras, scene);
  scene.overlay = std::move(extras.overlay);
  scene.overlayOnTop = std::move(extras.overlayOnTop);
  addMarks(session, extras, scene);
  return scene;
}

}  // namespace gelenk
