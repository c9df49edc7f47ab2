#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/document/chosen_skin.h"
#include "apps/document/session.h"
#include "apps/render/lecture_drawing.h"
#include "apps/render/motion_marks.h"
#include "apps/render/posed_bounds.h"
#include "apps/render/renderer.h"
#include "apps/render/teaching_pictures.h"
#include "skinning/blend/skin_measures.h"
#include "skinning/muscles/layered_blend.h"
#include "skinning/muscles/muscle_control.h"

namespace gelenk {

/// A further body in the picture: a comparison, a keyframe, a mocap source.
struct Ghost {
  Frames worldFromJoint;                      ///< of the document's model
  Eigen::Vector3f tint = {0.3f, 0.5f, 0.9f};  ///< sRGB, 0..1
  float opacity = 0.4f;
};

/// What a picture shows beyond the document, that one time.
struct PictureExtras {
  std::optional<std::vector<Eigen::Vector3f>> vertexColours = {};  ///< linear light 0..1, instead of clay
  Overlay overlay = {};                                            ///< hidden by bodies in front of it
  Overlay overlayOnTop = {};                                       ///< seen through everything
  std::vector<SceneLabel> labels = {};
  LectureDrawing* lecture = nullptr;   ///< the document's, as it is worked on; null: as the document has it
  std::vector<double> limitGlow = {};  ///< a joint, 0 to 1: limits that light up
  bool whole = true;                   ///< a still picture: what is computed bit by bit is finished at once
  int latticePlane = -1, latticePoint = -1;  ///< of the limb whose lattice is shown, drawn stronger
  std::optional<Viewport> viewport =
      {};                   ///< of the picture, for what lies along its edges; none: nothing does
  float pixelScale = 1.0f;  ///< its pixels for one at scale 1
  std::optional<GoalId> hovered = {}, selected = {};  ///< drawn larger; with all that belongs to them
};

/// A skin drawn beside the body by another method, and what is measured of it.
struct SkinFacts {
  SkinChoice choice = {};
  double volume = 0.0;    ///< change of the volume of what is drawn since rest, of it: body or limb
  double section = 1.0;   ///< smallest section across a limb's bone, of rest's
  double farthest = 0.0;  ///< largest distance of a vertex from the body's own, metres
  Eigen::Vector3d above = Eigen::Vector3d::Zero();  ///< where its name stands
};

/// The one way from a document to a picture, for window, offscreen, replay and `gelenk render`. Holds what is
/// costly to make (meshes on the GPU, bound muscle layers, the surface for picking), each made anew where
/// what it stands on has changed. Needs a current context.
class SceneView {
 public:
  enum class Ground {
    UnderRest,    ///< the rest pose stands on it
    UnderMotion,  ///< the first frame of the model's motion does, where that is elsewhere (a BVH's hips often
                  ///< rest in the origin)
  };
  explicit SceneView(const Session& session, Ground ground = Ground::UnderMotion);

  /// Brings everything up to date with the document and the pose that is shown; cheap where nothing changed.
  /// ownPose: the frames are those of the session's q. stroke: weights are being painted, and muscle layers
  /// stay as they were bound until that is over.
  void follow(const Session& session, const Frames& worldFromJoint, bool ownPose, bool stroke = false);

  double size() const { return size_; }                  ///< diagonal of the rest pose, metres
  double groundHeight() const { return groundHeight_; }  ///< along up
  bool standsOnMotion() const { return standsOnMotion_; }
  Eigen::AlignedBox3d bounds() const { return bounds_; }  ///< of the pose shown
  const Frames& frames() const { return frames_; }
  bool hasBody() const { return mesh_ != nullptr; }
  /// The surface as it is shown (world, metres), for picking; empty without a skin.
  const SkinnedVertices& surface(const Session& session);
  /// Its triangles; those that are not shown (MuscleSettings::alone) have three times the same corner.
  const std::vector<std::array<int, 3>>& triangles(const Session& session) const;
  /// Whether a goal's mark is drawn and can be taken: of a limb alone the free handles are its own.
  bool shows(const Session& session, const SceneGoal& goal) const;
  /// The bound muscle layers; nullptr: off.
  const MuscleRig* muscles() const { return rig_.get(); }
  const std::vector<LimbPose>& limbPoses(const Session& session);
  /// Why the muscle layers that the document asks for are not there; empty: nothing is amiss.
  const std::string& muscleFault() const { return muscleFault_; }

  /// The camera of a document that begins: everything in view (all that the arm can reach where it is planar
  /// or that is shown), from the direction that the document's camera looks.
  Camera wholeView(const Session& session, const Viewport& viewport, const Eigen::AlignedBox3d& box);

  /// Of the document's motion with its edits; nothing is known without one.
  const MotionFacts& motionFacts(const Session& session);

  /// What stands beside the body to explain it.
  const TeachingPictures& teaching() const { return teaching_; }
  TeachingPictures& teaching() { return teaching_; }

  /// The picture. It points into this object and is valid until the next call.
  RenderScene compose(const Session& session, PictureExtras extras = {});

  /// Other bodies in the picture, as they were composed last.
  const std::vector<Ghost>& ghosts() const { return ghosts_; }
  /// The body's own skin first, then those beside it (LabSettings::skins), as they were composed last.
  const std::vector<SkinFacts>& skinFacts() const { return skinFacts_; }
  /// The body's own as it is drawn: the document's, with the muscle layers where they are on.
  SkinChoice drawnSkin(const Session& session) const;
  /// The skin as the document's method has it; nullptr without one.
  const PreparedSkin* prepared() const { return prepared_.get(); }

 private:
  struct SkinBeside {
    SkinChoice choice;
    int version = -1;  ///< of the weights
    std::shared_ptr<const MuscleSettings> settings;
    std::optional<ChosenSkin> skin;  ///< none: its layers cannot be
    std::unique_ptr<SkinnedMeshGl> mesh;
    SkinPose pose;
  };
  void prepareBeside(const Session& session, const SkinChoice& wanted, SkinBeside& beside);
  void addSkinsBeside(const Session& session, RenderScene& scene);
  double stepBeside(const Camera& camera, const Session& session) const;
  bool isSplit() const { return rig_ && settings_->split; }
  Eigen::Vector3d placeAbove(const Session& session, const Frames& frames) const;
  SkinFacts factsOf(const SkinChoice& choice, const SkinnedVertices& at, const SkinnedVertices& own) const;
  void prepare(const Session& session, bool stroke);
  const Eigen::VectorXd* knownPose(const Session& session) const { return ownPose_ ? &session.q() : nullptr; }
  void bind(const Session& session);
  void showLimbAlone(const Session& session);
  void addBodies(const Session& session, PictureExtras& extras, RenderScene& scene);
  LectureDrawing* lectureOf(const Session& session);
  void addMarks(const Session& session, const PictureExtras& extras, RenderScene& scene);
  Eigen::AlignedBox3d boundsAt(const Frames& frames) const;
  Eigen::AlignedBox3d limbBounds() const;

  std::unique_ptr<PreparedSkin> prepared_;
  SkinChoice choice_, rigChoice_;  ///< that prepared_ and rig_ stand on
  std::unique_ptr<LayeredSkin> layered_;
  std::unique_ptr<SkinnedMeshGl> mesh_, layeredMesh_;
  std::unique_ptr<PosedBounds> posedBounds_;
  std::unique_ptr<MeshLookGl> look_;               ///< null: clay
  const SkinnedMeshGl* colouredByLook_ = nullptr;  ///< whose vertex colours are the look's
  int meshVersion_ = 0, rigVersion_ = 0;           ///< Session::weightsVersion() that they stand on
  std::shared_ptr<const MuscleSettings> settings_;
  std::unique_ptr<MuscleRig> rig_;
  std::string muscleFault_;
  std::string aloneLimb_;                           ///< that is drawn; empty: the whole body
  std::vector<int> aloneJoints_;                    ///< that carry it
  std::vector<std::array<int, 3>> aloneTriangles_;  ///< of every mesh while it is alone
  bool aloneIsCurrent_ = true;                      ///< no mesh was made since

  Frames frames_;
  bool ownPose_ = false;
  SkinnedVertices surface_;
  bool surfaceIsCurrent_ = false, limbsAreCurrent_ = false;
  std::vector<LimbPose> limbs_;
  Eigen::AlignedBox3d bounds_;
  double size_ = 1.0, groundHeight_ = 0.0;
  bool standsOnMotion_ = false;

  TeachingPictures teaching_;
  std::optional<ClipEditor> motion_;
  MotionFacts motionFacts_;
  SkinPose pose_;
  std::unique_ptr<LectureDrawing> lecture_;
  LectureState lectureState_;  ///< that it stands on
  std::vector<Ghost> ghosts_;
  std::vector<SkinPose> ghostPoses_;
  std::vector<SkinBeside> skinsBeside_;
  std::vector<SkinFacts> skinFacts_;
  std::vector<SkinSection> sections_;  ///< across the bones of the limbs that are drawn
  std::optional<PartVolume> volume_;   ///< of the body or limb that is drawn; with the sections
};

}  // namespace gelenk
