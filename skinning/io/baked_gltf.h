#pragma once

#include <functional>
#include <string>

#include "skinning/blend/linear_blend.h"

namespace gelenk {

/// A motion of a surface whose vertices are written frame by frame, for viewers that know linear blending
/// only: a .glb (glTF 2.0, binary) of one mesh with a morph target a frame and an animation of their weights,
/// at each key one frame alone, linear between. surface(f): positions and normals of frame f, metres, as many
/// as the mesh has. Throws std::invalid_argument: no frame, a rate that is not positive, a surface of another
/// size; std::runtime_error where the file cannot be written or would be larger than glb's 4 GB.
void writeBakedGltf(const std::string& path, const Mesh& mesh, int frames, double framesPerSecond,
                    const std::function<SkinnedVertices(int)>& surface);

}  // namespace gelenk
