#pragma once

#include <string>

#include "apps/document/model.h"

namespace gelenk {

struct MuscleSettings;

/// Writes the vertices of every frame of the model's motion (of its rest pose where it has none), posed by
/// its skinning, to a .glb for viewers that only know linear blending, and says so. muscles: of its layers;
/// null: the defaults. Throws std::invalid_argument for a model without a body and a path that is no .glb.
void writeBakedSkin(const std::string& path, const Model& model, const MuscleSettings* muscles = nullptr);

}  // namespace gelenk
