#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinematics/io/note.h"
#include "kinematics/masses.h"

namespace gelenk {

/// What a URDF draws on a link.
struct UrdfVisual {
  enum class Shape { Mesh, Box, Cylinder, Sphere };
  int joint = 0;  ///< of the skeleton: the one that carries the link
  Eigen::Isometry3d jointFromVisual = Eigen::Isometry3d::Identity();
  Shape shape = Shape::Mesh;
  bool collision = false;                          ///< the simpler geometry for collisions, to fall back on
  std::string fileName = {};                       ///< Mesh: as written, perhaps package://...
  Eigen::Vector3d size = Eigen::Vector3d::Ones();  ///< Mesh: scale; Box: edges; Cylinder: (radius, radius,
                                                   ///< length along z); Sphere: radius thrice
  std::optional<Eigen::Vector4d> colour = {};      ///< red, green, blue, alpha, 0 to 1 as written (sRGB)
  std::string texture = {};                        ///< file of the picture that lies on it; empty: none
  int line = 0;
};

struct UrdfRobot {
  std::string name;
  Skeleton skeleton;  ///< with the mimics as couplings
  std::vector<UrdfVisual> visuals;
  std::optional<Masses> masses = {};  ///< of the links' <inertial>; none where no link has one above 0
  std::vector<Note> notes;
};

/// A robot description (ROS). Links are frames: the root link becomes the fixed root joint, named after the
/// link, every URDF joint one joint of its name whose frame is its child link's. revolute and continuous turn
/// about the axis, prismatic slides along it, planar slides along two axes and turns about its normal,
/// floating moves freely, fixed has no dof. rpy = (r, p, y): R = Rz(y) Ry(p) Rx(r). Metres and radians, z
/// mostly up. Zeros outside limits are allowed: the rest configuration is then the nearest end of the range.
/// What mimics a joint that mimics another one follows the last of them (Coupling); its limits hold for that
/// too.
///
/// Throws ParseError: XML that is not well formed or nests deeper than 200, a root element other than robot,
/// missing names, parents or children, unknown links or joint types, a link with two parents, no or two root
/// links, a cycle, numbers that are none, an axis of length zero, reversed limits, a name used twice, a mimic
/// of no joint, of itself, of a joint that mimics in a circle, or between joints of several dofs, an
/// <inertial> without a mass or with one below 0. Notes: a mimic on a fixed joint or towards one, which is
/// passed over; limits of a follower that leave its source no value, likewise; limits of 0 to 0; no <limit>.
UrdfRobot readUrdf(const std::string& path);
UrdfRobot parseUrdf(std::string_view text, const std::string& file);

}  // namespace gelenk
