#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/motion/motion_clip.h"
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
  std::vector<GltfClip> clips = {};
  std::vector<Note> notes = {};
};

/// Animations are resampled at the rate of their keys where these are evenly spaced, else at 60 Hz; cubic
/// splines go through their keys linearly. Textures, cameras and morph targets are passed over. Throws
/// ParseError (line 0): what the library finds wrong, indices and sizes that do not fit, cycles of nodes,
/// unequal scales or shear, no node.
GltfModel readGltf(const std::string& path);
/// The same from the bytes of a .gltf or .glb; folder: where its external buffers lie.
GltfModel parseGltf(std::string_view bytes, const std::string& file, const std::string& folder = "");

/// A binary glTF (.glb): nodes in the rest pose, mesh with skin where there is one, one animation a clip
/// (linear, on quaternions). Numbers of mesh and animation are floats.
std::string formatGlb(const Skeleton& skeleton, const Skin* skin, const std::vector<GltfClip>& clips);
/// .glb is binary, .gltf text with the data inside.
void writeGltf(const std::string& path, const Skeleton& skeleton, const Skin* skin,
               const std::vector<GltfClip>& clips);

}  // namespace gelenk
