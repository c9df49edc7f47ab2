#include "apps/render/scene_view.h"

#include <algorithm>
#include <stdexcept>

#include "apps/render/colour.h"
#include "apps/render/lab_marks.h"
#include "apps/render/limb_part.h"
#include "apps/render/rulers.h"
#include "apps/render/scene_marks.h"
#include "apps/render/signs.h"
#include "skinning/blend/limb_chains.h"
#include "skinning/io/prepared_cache.h"
#include "skinning/io/skin_cache.h"

namespace gelenk {
namespace {

Eigen::AlignedBox3d boxOf(const Frames& frames) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Isometry3d& frame : frames) box.extend(frame.translation());
  return box;
}

/// One value a vertex for the shader: its colour, or, where there are texture coordinates, the colour in the
/// bits of one number and the coordinates (surface.vert). Vertex attributes are 16 at most, and skinning
/// needs the rest.
std::vector<Eigen::Vector3f> lookColours(const MeshLook& look, int count) {
  std::vector<Eigen::Vector3f> values(count, Eigen::Vector3f::Ones());
  for (int v = 0; v < count; ++v) {
    if (!look.colours.empty()) values[v] = look.colours[v];
    if (look.coordinates.empty()) continue;
    const Eigen::Vector3f bytes = (255.0f * values[v]).array().round();
    values[v] = {bytes.x() + 256.0f * bytes.y() + 65536.0f * bytes.z(), look.coordinates[v].x(),
                 look.coordinates[v].y()};
  }
  return values;
}

void nameBody(const Eigen::Vector3d& at, const std::string& name, const Colour& colour, RenderScene& scene) {
  scene.labels.push_back({.at = at, .text = name, .colour = colour, .isName = true, .isAbove = true});
}

/// Of the i-th skin beside the body, one to the right, then to the left; there the first is the muscle view's
/// where it is split.
int placeBeside(std::size_t i, bool isSplit) {
  static constexpr int places[] = {-1, 1, 2, -2};
  return places[isSplit && i > 0 ? i + 1 : i];
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
    prepare(session, false);
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
  bounds_ = boundsAt(forwardKinematics(model.skeleton, model.clip->q.col(0)));
  standsOnMotion_ = std::abs(lowest(bounds_) - groundHeight_) >= 0.1 * size_;
  if (standsOnMotion_) groundHeight_ = lowest(bounds_);
}

Eigen::AlignedBox3d SceneView::boundsAt(const Frames& frames) const {
  return posedBounds_ ? (*posedBounds_)(poseSkin(prepared_->skin, frames)) : boxOf(frames);
}

void SceneView::follow(const Session& session, const Frames& frames, bool ownPose, bool stroke) {
  const int version = session.weightsVersion();
  prepare(session, stroke);
  const bool rigIsOld = rig_ && (rigVersion_ != version || rigChoice_ != choice_);
  if (settings_ != session.edits().muscles || (rigIsOld && !stroke)) bind(session);
  showLimbAlone(session);
  ownPose_ = ownPose;
  if (!sameFrames(frames_, frames)) {
    frames_ = frames;
    surfaceIsCurrent_ = limbsAreCurrent_ = false;
  }
  bounds_ = aloneLimb_.empty() ? boundsAt(frames_) : limbBounds();
}

/// Of the limb's joints and what is around them.
Eigen::AlignedBox3d SceneView::limbBounds() const {
  Eigen::AlignedBox3d box;
  for (const int joint : aloneJoints_) box.extend(frames_[joint].translation());
  const Eigen::Vector3d around = Eigen::Vector3d::Constant(0.12 * box.diagonal().norm());
  return {box.min() - around, box.max() + around};
}

const std::vector<std::array<int, 3>>& SceneView::triangles(const Session& session) const {
  return aloneLimb_.empty() ? session.skin()->mesh.triangles : aloneTriangles_;
}

bool SceneView::shows(const Session& session, const SceneGoal& goal) const {
  return isGoalShown(session, goal) &&
         (aloneLimb_.empty() || goal.state != GoalState::Free ||
          std::ranges::find(aloneJoints_, goal.goal.joint) != aloneJoints_.end());
}

/// Of one limb alone every mesh draws the triangles that belong to its joints and what hangs on them.
void SceneView::showLimbAlone(const Session& session) {
  const std::string wanted = rig_ && settings_->alone ? settings_->shownLimb : std::string();
  if (!session.skin() || (wanted == aloneLimb_ && (aloneIsCurrent_ || wanted.empty()))) return;
  aloneIsCurrent_ = true;
  volume_.reset();
  aloneLimb_.clear();
  aloneTriangles_ = session.skin()->mesh.triangles;
  for (const Limb& limb : rig_ ? rig_->body().limbs : std::vector<Limb>{}) {
    if (limb.name != wanted) continue;
    aloneLimb_ = wanted;
    aloneJoints_ = descendants(session.skeleton(), limb.joints.front());
    const auto isOutside = [&](int vertex) {
      return !belongsTo(session.skin()->influences[vertex], aloneJoints_);
    };
    for (auto& triangle : aloneTriangles_)
      if (std::ranges::any_of(triangle, isOutside)) triangle.fill(triangle[0]);
  }
  for (SkinnedMeshGl* mesh : {mesh_.get(), layeredMesh_.get()})
    if (mesh) mesh->setTriangles(aloneTriangles_);
  for (SkinBeside& beside : skinsBeside_)
    if (beside.mesh) beside.mesh->setTriangles(aloneTriangles_);
}

/// Anew where method or weights changed. While weights are being painted the skin is a plain linear blend,
/// which needs the least of it.
void SceneView::prepare(const Session& session, bool stroke) {
  if (!session.skin()) return;
  const SkinChoice wanted = stroke ? SkinChoice{} : session.document().skin;
  if (prepared_ && choice_ == wanted && meshVersion_ == session.weightsVersion()) return;
  const bool isTheModels = session.weightsVersion() == 0;  // edited weights change all the time
  prepared_ = std::make_unique<PreparedSkin>(
      cachedPreparedSkin(isTheModels ? cacheFolder() : "", session.model().name, *session.skin(), wanted,
                         session.skeleton(), bindFrames(session.model())));
  mesh_ = std::make_unique<SkinnedMeshGl>(*prepared_);
  aloneIsCurrent_ = false;
  colouredByLook_ = nullptr;
  posedBounds_ = std::make_unique<PosedBounds>(prepared_->skin);
  choice_ = wanted;
  meshVersion_ = session.weightsVersion();
  surfaceIsCurrent_ = false;
}

/// Anew after switching on, and where weights or proportions changed, because the rest lattice did.
void SceneView::bind(const Session& session) {
  const auto before = std::exchange(settings_, session.edits().muscles);
  surfaceIsCurrent_ = limbsAreCurrent_ = false;
  muscleFault_.clear();
  if (!settings_ || !settings_->enabled || !session.skin()) {
    rig_.reset();
    layered_.reset();
    layeredMesh_.reset();
    return;
  }
  if (rig_ && rigVersion_ == session.weightsVersion() && rigChoice_ == choice_ &&
      sameProportions(*before, *settings_))
    return applyControls(*rig_, *settings_);
  try {
    rig_ = std::make_unique<MuscleRig>(makeMuscleRig(session.model(), prepared_->skin, *settings_));
    layered_ = std::make_unique<LayeredSkin>(
        prepareLayers(rig_->body(), *prepared_->method, bindFrames(session.model()), prepared_->spread));
    layeredMesh_ = std::make_unique<SkinnedMeshGl>(*layered_, rig_->body());
    aloneIsCurrent_ = false;
    colouredByLook_ = nullptr;
    rigChoice_ = choice_;
    rigVersion_ = session.weightsVersion();
  } catch (const std::invalid_argument& error) {
    muscleFault_ = error.what();
    rig_.reset();
    layered_.reset();
    layeredMesh_.reset();
  }
}

const std::vector<LimbPose>& SceneView::limbPoses(const Session& session) {
  if (!limbsAreCurrent_) limbs_ = rig_ ? rig_->pose(frames_, knownPose(session)) : std::vector<LimbPose>{};
  limbsAreCurrent_ = true;
  return limbs_;
}

const SkinnedVertices& SceneView::surface(const Session& session) {
  if (surfaceIsCurrent_) return surface_;
  if (!session.skin())
    surface_ = {};
  else if (rig_)
    skinWithMuscles(*layered_, frames_, limbPoses(session), surface_, knownPose(session));
  else
    blendSkin(*prepared_, poseBones(*prepared_, frames_, knownPose(session)), surface_);
  surfaceIsCurrent_ = true;
  return surface_;
}

Camera SceneView::wholeView(const Session& session, const Viewport& viewport,
                            const Eigen::AlignedBox3d& shown) {
  Eigen::AlignedBox3d box = shown;
  if (session.document().view.show.reachable) box.extend(teaching_.reachableBox(session, std::nullopt));
  if (session.model().planar && !frames_.empty()) {
    double reach = 0.0;
    for (int i = 0; i < session.skeleton().jointCount(); ++i)
      reach = std::max(reach, chainLength(session.skeleton(), i));
    const Eigen::Vector3d base = frames_[0].translation(), far(reach, reach, 0.0);
    box.extend(base + far);
    box.extend(base - far);
  }
  const Camera camera = newDocument(session.model(), {}).view.camera;
  if (!aloneLimb_.empty()) {  // and those beside it
    const Eigen::Vector3d step = stepBeside(camera, session) * levelRight(camera, session.model().up);
    for (std::size_t i = 0; i < session.document().lab.skins.size(); ++i)
      box.extend(shown.translated(-placeBeside(i, isSplit()) * step));
    if (isSplit()) box.extend(shown.translated(-step));
  }
  return frameBox(camera, viewport, box);
}

void SceneView::addBodies(const Session& session, PictureExtras& extras, RenderScene& scene) {
  if (!mesh_) return;
  const ViewOptions& show = session.document().view.show;
  if (show.skin || show.wireframe) {
    SkinnedMeshGl* mesh = mesh_.get();
    if (rig_) {
      const std::vector<LimbPose>& limbs = limbPoses(session);
      const Frames frames = withEnds(frames_, limbs);
      poseSkin(*layered_, poseBones(layered_->outside, frames, knownPose(session)), limbs, pose_);
      layeredMesh_->setSculpture(*rig_);
      mesh = layeredMesh_.get();
    } else {
      poseSkin(*prepared_, poseBones(*prepared_, frames_, knownPose(session)), pose_);
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
        mesh->setColours(lookColours(look_->look(), mesh->vertexCount()));
        colouredByLook_ = mesh;
      }
      body.look = look_.get();
      body.hidden = &session.document().view.hidden;
    }
    scene.bodies.push_back(body);
  }
  addSkinsBeside(session, scene);
  if (isSplit()) {
    ghosts_.push_back({.worldFromJoint = framesBeside(session, frames_,
                                                      stepBeside(session.document().view.camera, session)),
                       .tint = {0.80f, 0.76f, 0.71f},
                       .opacity = 1.0f});
    const SkinChoice& plain = session.document().skin;
    const Colour& dim = markColours(scene.theme).dim;
    nameBody(placeAbove(session, ghosts_.back().worldFromJoint), toString(plain), dim, scene);
    if (skinFacts_.empty()) nameBody(placeAbove(session, frames_), toString(drawnSkin(session)), dim, scene);
  }
  ghostPoses_.resize(ghosts_.size());
  for (std::size_t i = 0; i < ghosts_.size(); ++i) {
    const Ghost& ghost = ghosts_[i];
    poseSkin(*prepared_, poseBones(*prepared_, ghost.worldFromJoint), ghostPoses_[i]);
    scene.bodies.push_back({.mesh = mesh_.get(),
                            .pose = &ghostPoses_[i],
                            .tint = {ghost.tint.x(), ghost.tint.y(), ghost.tint.z(), ghost.opacity}});
  }
}

SkinChoice SceneView::drawnSkin(const Session& session) const {
  SkinChoice drawn = session.document().skin;
  if (rig_) drawn.layers = SkinLayers::Muscles;
  return drawn;
}

/// From one body to the next, metres: a limb alone takes as much room as it is wide.
double SceneView::stepBeside(const Camera& camera, const Session& session) const {
  if (aloneLimb_.empty()) return 0.55 * size_;
  return 1.15 * levelRight(camera, session.model().up).cwiseAbs().dot(bounds_.sizes());
}

/// Where the name of the body stands, or of one of the same pose whose frames lie beside it.
Eigen::Vector3d SceneView::placeAbove(const Session& session, const Frames& frames) const {
  const Eigen::Vector3d& up = session.model().up;
  const double height = 0.5 * up.cwiseAbs().dot(bounds_.sizes()) +
                        0.06 * (aloneLimb_.empty() ? size_ : bounds_.diagonal().norm());
  return bounds_.center() + height * up + frames[0].translation() - frames_[0].translation();
}

SkinFacts SceneView::factsOf(const SkinChoice& choice, const SkinnedVertices& at,
                             const SkinnedVertices& own) const {
  const Mesh& rest = prepared_->skin.mesh;
  SkinFacts facts{.choice = choice, .section = smallestSection(sections_, at.positions)};
  if (const double volume = volume_->volume(rest.positions); volume > 0.0)
    facts.volume = volume_->volume(at.positions) / volume - 1.0;
  for (const auto& triangle : aloneLimb_.empty() ? rest.triangles : aloneTriangles_)
    for (const int v : triangle)
      facts.farthest = std::max(facts.farthest, (at.positions[v] - own.positions[v]).norm());
  return facts;
}

/// Anew where choice or weights changed; muscles that were set otherwise are taken over.
void SceneView::prepareBeside(const Session& session, const SkinChoice& wanted, SkinBeside& beside) {
  const auto& settings = session.edits().muscles;
  const bool isCurrent = beside.choice == wanted && beside.version == session.weightsVersion();
  if (isCurrent && (beside.settings == settings || wanted.layers == SkinLayers::None)) return;
  const bool onlyControls =
      isCurrent && beside.skin && settings && beside.settings && sameProportions(*beside.settings, *settings);
  beside.settings = settings;
  if (onlyControls) {
    if (wanted.layers == SkinLayers::Muscles) beside.skin->setControls(*settings);
    return;
  }
  beside.choice = wanted;
  beside.version = session.weightsVersion();
  beside.mesh.reset();
  beside.skin.reset();
  try {
    beside.skin.emplace(session.model(), *session.skin(), wanted, settings.get());
    beside.mesh = beside.skin->layered()
                      ? std::make_unique<SkinnedMeshGl>(*beside.skin->layered(), beside.skin->rig()->body())
                      : std::make_unique<SkinnedMeshGl>(beside.skin->prepared());
    if (!aloneLimb_.empty()) beside.mesh->setTriangles(aloneTriangles_);
  } catch (const std::invalid_argument& error) {
    muscleFault_ = error.what();
    beside.skin.reset();
  }
}

/// Other methods in the same pose, to the right, to the left and further to the left, coloured by the
/// distance from the body's own skin: black none, yellow 20 mm.
void SceneView::addSkinsBeside(const Session& session, RenderScene& scene) {
  skinFacts_.clear();
  const std::vector<SkinChoice>& wanted = session.document().lab.skins;
  if (wanted.empty()) return;
  if (!volume_) {
    volume_.emplace(triangles(session));
    sections_.clear();
    const Frames bound = bindFrames(session.model());
    for (const LimbChain& limb : limbChains(session.skeleton())) {
      if (!aloneLimb_.empty() && !std::ranges::binary_search(aloneJoints_, limb.joints.back())) continue;
      for (std::size_t k = 0; k + 1 < limb.joints.size(); ++k)
        for (SkinSection& section : sectionsAlong(prepared_->skin.mesh, bound[limb.joints[k]].translation(),
                                                  bound[limb.joints[k + 1]].translation(), 9))
          sections_.push_back(std::move(section));
    }
  }
  const SkinnedVertices& own = surface(session);
  skinFacts_.push_back(factsOf(drawnSkin(session), own, own));
  skinFacts_.back().above = placeAbove(session, frames_);
  skinsBeside_.resize(wanted.size());
  const double step = stepBeside(session.document().view.camera, session);
  SkinnedVertices at;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    SkinBeside& beside = skinsBeside_[i];
    prepareBeside(session, wanted[i], beside);
    if (!beside.skin) continue;
    beside.skin->pose(frames_, knownPose(session), at);
    const Frames shifted = framesBeside(session, frames_, step, placeBeside(i, isSplit()));
    const Eigen::VectorXd* q = knownPose(session);
    if (const LayeredSkin* layered = beside.skin->layered()) {
      const std::vector<LimbPose> limbs = beside.skin->rig()->pose(shifted, q);
      poseSkin(*layered, poseBones(layered->outside, withEnds(shifted, limbs), q), limbs, beside.pose);
      beside.mesh->setSculpture(*beside.skin->rig());
    } else {
      poseSkin(beside.skin->prepared(), poseBones(beside.skin->prepared(), shifted, q), beside.pose);
    }
    std::vector<float> distance(at.positions.size());
    for (std::size_t v = 0; v < distance.size(); ++v)
      distance[v] = static_cast<float>(std::min(1.0, (at.positions[v] - own.positions[v]).norm() / 0.02));
    beside.mesh->setColours(viridisColours(distance));
    scene.bodies.push_back(
        {.mesh = beside.mesh.get(), .pose = &beside.pose, .surface = SurfaceColour::Vertex});
    skinFacts_.push_back(factsOf(wanted[i], at, own));
    skinFacts_.back().above = placeAbove(session, shifted);
  }
  for (const SkinFacts& facts : skinFacts_)
    nameBody(facts.above, toString(facts.choice), markColours(scene.theme).dim, scene);
}

void SceneView::addMarks(const Session& session, const PictureExtras& extras, RenderScene& scene) {
  const ViewOptions& show = session.document().view.show;
  const MarkColours& colours = markColours(session.document().theme);
  const std::optional<int> selected = session.selectedJoint();
  if (show.skeleton || !mesh_)
    addBones(scene.overlayOnTop, session.skeleton(), frames_, size_, boneColour, selected.value_or(-1));
  if (session.model().planar) {
    addWorkspace(scene.overlay, session, frames_, colours);
    if (extras.viewport)
      addRulers(scene.overlay, session.document().view.camera, *extras.viewport, extras.pixelScale, 0.0,
                colours.dim);
  }
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
    addGoals(scene.overlayOnTop, session, size_, colours, extras.hovered, extras.selected,
             [&](const SceneGoal& goal) { return shows(session, goal); });
  if (rig_ && settings_->lattice)
    for (std::size_t l = 0; l < rig_->body().limbs.size(); ++l)
      if (settings_->shownLimb.empty() || settings_->shownLimb == rig_->body().limbs[l].name)
        addLattice(scene.overlayOnTop, limbPoses(session)[l],
                   {.connecting = colours.pinned,
                    .inner = colours.held,
                    .selectedPlane = extras.latticePlane,
                    .selectedPoint = extras.latticePoint});
}

const MotionFacts& SceneView::motionFacts(const Session& session) {
  const Model& model = session.model();
  const auto& edits = session.edits().clip;
  if (!model.clip || (motion_ && motion_->edits() == edits)) return motionFacts_;
  if (!motion_) motion_.emplace(model.skeleton, *model.clip);
  if (motion_->edits() != edits) motion_->setEdits(edits);
  motionFacts_ = gelenk::motionFacts(model.skeleton, motion_->clip());
  return motionFacts_;
}

LectureDrawing* SceneView::lectureOf(const Session& session) {
  const LectureState& state = session.document().lecture;
  if (state == lectureState_) return lecture_.get();
  lectureState_ = state;
  lecture_ = state.topic.empty() ? nullptr : makeLectureDrawing(state.topic);
  if (lecture_) lecture_->load(session, state.state);
  return lecture_.get();
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
  scene.labels = std::move(extras.labels);
  ghosts_.clear();
  if (LectureDrawing* lecture = extras.lecture ? extras.lecture : lectureOf(session))
    lecture->draw({session, size_, extras.overlayOnTop, ghosts_, scene.labels});
  addComparedSolvers(session, size_, ghosts_, scene.labels);
  if (ownPose_)
    teaching_.add(session, frames_,
                  {.size = size_,
                   .colours = &markColours(scene.theme),
                   .selected = extras.selected,
                   .whole = extras.whole},
                  extras.overlay, extras.overlayOnTop, ghosts_);
  if (session.model().clip && session.document().playback.showing) {
    const MotionFacts& facts = motionFacts(session);
    addMotionMarks(session, motion_->clip(), facts, frames_, groundHeight_, size_, markColours(scene.theme),
                   extras.overlay, extras.overlayOnTop);
  }
  addBodies(session, extras, scene);
  scene.overlay = std::move(extras.overlay);
  scene.overlayOnTop = std::move(extras.overlayOnTop);
  addMarks(session, extras, scene);
  return scene;
}

}  // namespace gelenk
