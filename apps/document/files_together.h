#pragma once

#include <string>
#include <vector>

#include "apps/document/model_reference.h"

namespace gelenk {

/// What files that came at once are together: a scene; a URDF or glTF with what it names; a surface with its
/// skeleton, weights and motion; an AMC with its ASF; else the one file that opens. Files that those read by
/// themselves (meshes, buffers, pictures) and hidden files may lie among them. Throws std::invalid_argument
/// with a sentence for none that opens and for several.
ModelReference filesTogether(const std::vector<std::string>& paths);

}  // namespace gelenk
