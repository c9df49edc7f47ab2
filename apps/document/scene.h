#pragma once

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "apps/document/camera.h"
#include "apps/document/model.h"
#include "apps/document/theme.h"
#include "solvers/problem/ik_problem.h"

namespace gelenk {

/// What a scene was opened from: a built-in model or a file, and, beside an OBJ, its skeleton and weights.
struct ModelReference {
  std::string nameOrFile = "figure";
  std::string skeletonFile = {};
  std::string weightsFile = {};
  std::string asfFile = {},
              amcFile = {};      ///< ASF skeleton to lay an OBJ's fitted skeleton on, and its motion
  std::string mappingFile = {};  ///< which bones lie on which joints; default: CMU's on Pinocchio's human
  bool operator==(const ModelReference&) const = default;
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
};

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

/// A goal of the scene and how it is held. Goals of handles are always there; others come with a drag and go
/// with it.
struct SceneGoal {
  Goal goal;  ///< Position, Pose or Pole; weight is set by the session from the state
  GoalState state = GoalState::Free;
  bool handle = false;
  SurfacePoint surface =
      {};  ///< triangle >= 0: a point of the skin, whose pointInJoint the session keeps up to date
};

/// All that is needed to see the same picture again: everything but the model's own data.
struct Scene {
  ModelReference model;
  Eigen::VectorXd q;  ///< nq, radians and metres
  std::vector<SceneGoal> goals;
  Camera camera;
  ViewOptions options;
  std::string solver = "drag";
  Theme theme = Theme::Light;
  std::string selectedJoint = {};
  std::map<std::string, std::string> panels;  ///< panel name -> its state as a JSON text
};

/// Writes JSON (docs/formats/scene.md); doubles read back as exactly the same values. Joints are written by
/// name. Temporary file and rename. Throws std::runtime_error with the system's reason.
void saveScene(const std::string& path, const Scene& scene, const Skeleton& skeleton);

/// The model that a scene file names, read without opening it. Throws ParseError.
ModelReference readModelReference(const std::string& path);
ModelReference parseModelReference(std::string_view text, const std::string& file);
/// The model itself, with a body of its own where it has none. Throws ParseError and std::invalid_argument.
Model readModel(const ModelReference& reference);

/// skeleton: of the model named by readModelReference. Throws ParseError naming the entry, what was expected
/// and what was found: q of the wrong length, unknown joints, values that are not finite numbers, quaternions
/// that are not of unit length.
Scene loadScene(const std::string& path, const Skeleton& skeleton);
Scene parseScene(std::string_view text, const std::string& file, const Skeleton& skeleton);

}  // namespace gelenk
