#pragma once

#include "kinematics/masses.h"

namespace gelenk {

/// The built-in figure's masses: an adult man of 73 kg. Shares of the body's mass and places of the centres
/// along the segments: de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of
/// Biomechanics 29 (1996), table 4, males. The trunk's three parts move with pelvis, spine_02 and spine_03.
/// skeleton: mannequin().
Masses mannequinMasses(const Skeleton& skeleton);

/// A point of a foot that stands on the ground at rest.
struct FootPoint {
  int joint;
  Eigen::Vector3d inJoint;  ///< metres
};
/// Heel, ball (inner and outer edge) and toe of both feet, fixed to the feet's joints: the soles' outline at
/// rest, y = 0.
std::vector<FootPoint> mannequinSoles(const Skeleton& skeleton);

}  // namespace gelenk
