#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/motion/motion_clip.h"
#include "skinning/mesh_look.h"
#include "skinning/skin.h"

namespace gelenk {

struct GltfClip {
  std::string name;
  MotionClip clip;
};

/// A glTF 2.0 file as one articulated model: every node becomes a joint (an unlimited ball where a skin or an
/// animation turns it, with three translations where an animation moves it or where it is the root; else
/// fixed), all meshes one skin. Metres, y up, as the format prescribes.
struct GltfModel {
  Skeleton skeleton;  ///< the zero configuration is the file's own pose
  std::optional<Skin> skin = {};
  std::shared_ptr<const MeshLook> look = {};  ///< of the skin: a part a mesh and material
  std::vector<GltfClip> clips = {};
  std::vector<Note> notes = {};
};

struct GltfOptions {
  /// Rate at which animations that frames cannot hold are sampled, exactly at every frame: steps, splines,
  /// keys at uneven times. Default: a multiple of the keys' rate, 60 Hz or more; 60 Hz for uneven keys.
  std::optional<double> framesPerSecond = {};
};

/// Animations whose keys are evenly spaced and linear keep the rate of their keys; all others are sampled
/// (LINEAR, STEP and CUBICSPLINE as in appendix C) at the rate of the options, which a note tells. Triangles,
/// strips and fans are read, with base colour (factor, texture, vertex colours), alpha cut-out and sides of
/// their materials; points, lines, cameras and morph targets are passed over. A body whose bind pose is the
/// file's own pose moved as a whole stands as in the scene; other bind poses are kept. Unequal scales,
/// mirrors and shear are kept in rigid parts and in bones that nothing turns below. Vertices without weights
/// are held by the skin's first joint.
///
/// Throws ParseError (line 0): what the library finds wrong, a required extension that is not read, indices
/// and sizes that do not fit, cycles of nodes, unequal scales above nodes that turn, no node.
GltfModel readGltf(const std::string& path, const GltfOptions& options = {});
/// The same from the bytes of a .gltf or .glb; folder: where its external buffers lie.
GltfModel parseGltf(std::string_view bytes, const std::string& file, const std::string& folder = "",
                    const GltfOptions& options = {});

/// A binary glTF (.glb): nodes in the rest pose, mesh with skin where there is one, one animation a clip
/// (linear, on quaternions). Numbers of mesh and animation are floats.
std::string formatGlb(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips);
/// What is written of a joint: where it rests, or its axes, limits and rest angles, too, as extras that
/// readGltf takes up in a file without animations (gltf_joints.h).
enum class GltfJoints { Frames, AsTheyMove };

/// .glb is binary, .gltf text with the data inside.
void writeGltf(const std::string& path, const Skeleton& skeleton, const Skin* skin,
               const std::vector<GltfClip>& clips, GltfJoints joints = GltfJoints::Frames);

}  // namespace gelenk
