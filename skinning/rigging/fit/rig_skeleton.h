#pragma once

#include <string>
#include <vector>

#include "kinematics/skeleton.h"
#include "skinning/rigging/auto_rig.h"
#include "skinning/rigging/fit/placement.h"

namespace gelenk {

/// A fitted joint in the mesh's space.
struct RigJoint {
  std::string name;
  int parent = -1;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< from the template at rest
  int piece = 0;                                       ///< of the template
  int figureJoint = -1;  ///< of mannequin(), whose limits it takes; -1: an unlimited ball
};

/// The template's joints at their fitted positions (in the template's space), as the skeleton wants them.
std::vector<RigJoint> rigJoints(const TemplateBody& body, RigTemplate skeleton, const Placement& placement,
                                const std::vector<Eigen::Vector3d>& positions);

/// Adds the fingers that are seen in the mesh to both hands of the figure's joints: as many left as right, in
/// a symmetric body mirrored from the left. Nothing where a hand is a mitten.
void addFingers(std::vector<RigJoint>& joints, const Mesh& mesh, const Placement& placement);

/// Joints that rest where the body stands. Those of the figure keep its axes, zeros and limits: the rest
/// angles say how the body is posed; what a hinge cannot turn goes into its offset.
Skeleton rigSkeleton(const std::vector<RigJoint>& joints);

}  // namespace gelenk
