#pragma once

#include <Eigen/Geometry>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/document/camera.h"
#include "apps/document/clip_editor.h"
#include "apps/document/model.h"
#include "apps/document/model_reference.h"
#include "apps/document/muscle_settings.h"
#include "apps/document/shared_rows.h"
#include "apps/document/theme.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/skin.h"
#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// How a goal takes part in the solve.
enum class GoalState {
  Free,     ///< a handle that nothing holds: it goes with the body
  Held,     ///< kept at its target
  Dragged,  ///< follows the mouse (never in a file)
  Pinned,   ///< kept at its target with a large weight
};
const char* toString(GoalState state);

/// A point of the skin: a place on a triangle, carried by the blend of the triangle's bones.
struct SurfacePoint {
  int triangle = -1;
  Eigen::Vector3d barycentric = Eigen::Vector3d::Constant(1.0 / 3.0);
};

/// The name of a goal for programs: never used twice in a document, so that it means the same goal, or none
/// any more, whatever was added and removed meanwhile. In a file a positive number.
enum class GoalId : int {};

/// A goal of the document and how it is held. Goals of handles are always there; others come with a drag and
/// go with it.
struct SceneGoal {
  Goal goal;  ///< its own weight is set by the session from state and weight
  GoalState state = GoalState::Free;
  double weight = 1.0;  ///< of the user: on the squared error, beside what the state brings
  bool handle = false;
  SurfacePoint surface =
      {};  ///< triangle >= 0: a point of the skin, whose pointInJoint the session keeps up to date
  GoalId id = {};
};

/// What undo brings back: everything that a person changes of the model's pose, goals, binding, muscles and
/// motion. Copies share what is large.
struct Edits {
  Eigen::VectorXd q = {};  ///< nq, radians and metres
  std::vector<SceneGoal> goals = {};
  SharedRows<Influences> weights = {};                 ///< of the skin, one row a vertex
  std::shared_ptr<const MuscleSettings> muscles = {};  ///< null where the model has no limb for them
  std::shared_ptr<const ClipEdits> clip = {};          ///< null: the motion is as its file holds it
  double seconds = 0.0;  ///< of the playhead: an edit is taken back where it was made
};

/// The method that follows the goals, and what was set of any method's parameters (radians, metres), by the
/// method's name.
struct SolverChoice {
  std::string name = "drag";
  std::map<std::string, std::map<std::string, double, std::less<>>> parameters = {};
  bool balance = false;  ///< the centre of mass stays over the soles, where the model has both
};

/// What is drawn.
struct ViewOptions {
  bool skin = true;
  bool wireframe = false;
  bool skeleton = false;  ///< slim bones seen through the skin
  bool weights = false;   ///< of the selected joint, as colours
  bool jointFrames = false;
  bool limits = true;  ///< cones and arcs of joints at their limit
  bool handles = true;
  bool ground = true;
  bool shadow = true;
  // Pictures that explain an arm (apps/render/teaching_pictures.h)
  bool velocityEllipsoid = false, forceEllipsoid = false;
  bool reachable = false;    ///< where the effector comes to
  bool solutions = false;    ///< every other pose of the same effector pose
  bool nullSpace = false;    ///< the self-motion of a redundant arm
  bool convergence = false;  ///< where the present solver converges from here
  bool operator==(const ViewOptions&) const = default;
};
/// The options by the names that files and replays use.
struct ViewOptionName {
  bool ViewOptions::*option;
  std::string_view name;   ///< in scenes, replays and commands
  std::string_view title;  ///< in words, as the window calls it
};
std::span<const ViewOptionName> viewOptionNames();
/// Throws std::invalid_argument that lists the names.
bool ViewOptions::*viewOption(const std::string& name);

struct View {
  Camera camera = {};
  ViewOptions show = {};
  std::string selectedJoint = {};     ///< empty: none
  std::set<std::string> hidden = {};  ///< parts of the body that are not drawn (MeshLook::Part)
};

/// How the model's motion plays.
struct Playback {
  double speed = 1.0;  ///< negative: backwards
  bool loop = true, follow = true, showing = true, goalsOnTop = false;
  bool trails = true, contacts = true, limits = true;  ///< marks
};

/// Solvers side by side on the same goals.
struct LabSettings {
  static constexpr std::size_t mostSolvers = 4;
  bool compare = false, sideBySide = false;
  std::vector<SkinChoice> skins =
      {};  ///< drawn beside the body, coloured by their distance from it; up to three
  static constexpr std::size_t mostSkins = 3;
  std::vector<std::string> solvers{"pseudo-inverse", "dls", "sdls", "exact-hessian"};
  /// Where each of the solvers stands, nq; of length 0 where it cannot do the goals. Empty: all begin where
  /// the document stands.
  std::vector<Eigen::VectorXd> poses = {};
};

/// An open example of the lecture; topic empty: none.
struct LectureState {
  std::string topic = {};
  std::string state = {};  ///< the scene's own words
  bool operator==(const LectureState&) const = default;
};

/// All that a scene is: everything but the model's own data. What a file holds, what a picture shows, what
/// undo goes through (edits) and what a model that is opened begins with.
struct Document {
  ModelReference model = {};
  Edits edits = {};
  SolverChoice solver = {};
  SkinChoice skin = {};  ///< how the skin follows its bones
  View view = {};
  Theme theme = Theme::Light;  ///< a preference of the user, which goes from one model to the next
  Playback playback = {};
  LabSettings lab = {};
  LectureState lecture = {};
};

/// How a model begins: rest pose, its own weights and motion, the view that suits it but for the camera's
/// distance. No goals yet: Session makes the handles.
Document newDocument(const Model& model, ModelReference reference);

/// How the skin is drawn from now on; layers that the choice has are switched on, as volumes alone or with
/// the muscles that the document has. Throws std::invalid_argument where the model has no limb for them.
void chooseSkin(Document& document, const Model& model, SkinChoice choice);
/// The document's choice, with the layers that are switched on.
SkinChoice chosenSkin(const Document& document);

}  // namespace gelenk
