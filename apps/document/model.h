#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/io/urdf.h"
#include "kinematics/motion/motion_clip.h"
#include "kinematics/notation/mannequin_masses.h"
#include "kinematics/skeleton.h"
#include "skinning/blend/skin_choice.h"
#include "skinning/mesh_look.h"
#include "skinning/skin.h"

namespace gelenk {

/// What a user names on the command line or drops on the window: a skeleton, mostly with a body around it.
struct Model {
  std::string name;
  Skeleton skeleton;
  std::optional<Skin> skin = {};
  std::shared_ptr<const MeshLook> look = {};  ///< colours of the skin; null: clay
  SkinChoice skinning = {};  ///< how its skin is drawn where nobody says otherwise (docs/skinning/README.md)
  bool planar = false;       ///< moves in the x-y plane: seen from above by default
  Eigen::Vector3d up =
      Eigen::Vector3d::UnitY();  ///< against gravity; figures stand along y, robots and planar scenes along z
  std::optional<MotionClip> clip = {};        ///< a motion that came with it, for players; never clamped
  std::string clipName = {};                  ///< the file's own name of that motion, where it has one
  std::vector<std::string> clipNames = {};    ///< of all motions in the file, among which --clip chooses
  std::shared_ptr<const Masses> masses = {};  ///< null: unknown
  std::vector<FootPoint> soles = {};          ///< what it stands on, where it can keep its balance
  std::vector<std::string> handles = {};      ///< joints that get a drag handle; empty: the end-effectors
  std::vector<std::string> pins = {};  ///< handles that are pinned when the model is opened, such as the feet
  std::vector<Note> notes = {};
};

/// Built-in models by name ("figure", "planar", robots), else a file by its extension.
/// Throws std::invalid_argument listing the names, or ParseError.
Model openModel(const std::string& nameOrFile);

/// Frames of the pose in which the skin is bound, worldFromJoint; without a skin the rest frames. The two
/// differ where a body was bound in a pose that the skeleton's dofs need not reach (a fitted body on an ASF
/// skeleton, some glTF files): what is built on the surface must begin here, not at restFrames.
Frames bindFrames(const Model& model);
/// Whether the skin is bound in the skeleton's rest pose, to 1e-6 m and rad.
bool restsAsBound(const Model& model);

/// The model with a rounded body around its bones (skinning/bodies/body_around.h) where it has none; for
/// everything that shows it. Taken from the cache when the same skeleton was shown before. A skeleton around
/// which no body can be made stays bare, and a note says why.
Model withBody(Model model);

/// Names of the built-in models.
std::vector<std::string> builtInModels();
/// Whether openModel reads no file for it: a built-in model or a description ("planar:...").
bool standsInNoFile(const std::string& nameOrFile);

}  // namespace gelenk
