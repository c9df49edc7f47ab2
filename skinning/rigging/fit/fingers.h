#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

/// Where a hand is, roughly.
struct HandPlace {
  Eigen::Vector3d elbow, wrist, knuckles;
};

/// A finger's three joints from the palm outwards, and its tip.
using FingerJoints = std::array<Eigen::Vector3d, 4>;

/// The fingers that stand out of a hand: thumb, then from the index outwards. Four or five; none where fewer
/// are seen (a mitten) or more. They are the branches of the surface by its geodesic distance from the wrist;
/// the joints divide each branch's middle line as they do in people.
std::vector<FingerJoints> findFingers(const Mesh& mesh, const HandPlace& hand);

}  // namespace gelenk
