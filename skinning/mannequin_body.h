#pragma once

#include "skinning/body_shape.h"
#include "skinning/polygonise.h"

namespace gelenk {

/// The body of the figure of kinematics/mannequin.h in its rest pose: 54 generalised cylinders, figures fitted to a CC0 body.
BodyShape mannequinShape();

/// The grid of the figure's mesh: 16 mm, drawn together at hands, head and feet.
PolygoniseOptions mannequinGrid();

}  // namespace gelenk
