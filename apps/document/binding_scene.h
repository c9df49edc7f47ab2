#pragma once

#include <string>

#include "apps/document/model.h"
#include "apps/document/scene.h"
#include "kinematics/skeleton.h"
#include "skinning/rigging/weight_paint.h"

namespace gelenk {

/// The part of a scene that keeps weights edited by hand: the vertices that differ from the model's own
/// binding, joints by name. JSON text, every weight to the last bit. vertexCount: of the model's skin, so
/// that another body is not taken for this one.
std::string bindingText(const WeightChange& changed, int vertexCount, const Skeleton& skeleton);

/// Throws std::runtime_error naming the entry: no JSON, another number of vertices, a joint that the skeleton
/// has not, a vertex out of range or not in ascending order, weights that are not positive, more than four or
/// without sum 1.
WeightChange parseBinding(const std::string& text, int vertexCount, const Skeleton& skeleton);

/// Gives the model's skin the weights that the scene keeps, if any. Throws as parseBinding does.
void applyBinding(const Scene& scene, Model& model);

}  // namespace gelenk
