#pragma once

#include <cstdint>

#include "skinning/bodies/body_shape.h"
#include "skinning/bodies/polygonise.h"
#include "skinning/skin.h"

namespace gelenk {

/// The body of the figure of kinematics/notation/mannequin.h in its rest pose: 54 generalised cylinders,
/// figures fitted to a CC0 body.
BodyShape mannequinShape();

/// The grid of the figure's mesh: 19 mm, drawn together at hands, head and feet.
PolygoniseOptions mannequinGrid();

/// The figure's mesh (closed, manifold, genus 0, exactly symmetric) bound to mannequin() with heat weights,
/// which are as symmetric as the mesh. Takes about a second; apps keep it in a cache
/// (skinning/io/skin_cache.h).
Skin makeMannequinSkin(const Skeleton& mannequin, WeightLoss* loss = nullptr);

/// A fingerprint of everything that the skin is made from: tables, grid, rest pose and the version of the
/// method.
std::uint64_t mannequinSkinKey(const Skeleton& mannequin);

}  // namespace gelenk
