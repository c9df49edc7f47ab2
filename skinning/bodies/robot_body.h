#pragma once

#include "skinning/mesh_look.h"
#include "skinning/skin.h"

namespace gelenk {

/// Proportions and paint of an arm's body. Radii as shares of the chain's length, colours sRGB 0..1.
struct RobotFigures {
  double shoulder = 0.068, wrist = 0.040;           ///< radii of the links at base and tool
  Eigen::Vector3f shell = {0.86f, 0.87f, 0.88f};    ///< of the links
  Eigen::Vector3f housing = {0.36f, 0.38f, 0.41f};  ///< of joints, base and flange
  Eigen::Vector3f accent = {0.16f, 0.45f, 0.72f};   ///< rings and caps
};

/// Figures of a robot known by name (robots.h), else the default ones.
RobotFigures robotFigures(std::string_view name);

struct RobotBody {
  Skin skin;
  MeshLook look;
};

/// A body around a chain of joints, made from its frames alone: tapering shells between the places where
/// joints lie, a drum with two caps across each hinge, a ring around each link that turns about itself, a
/// column in its guide for each slide, a plinth and a flange. Every vertex is rigid on one joint. Parts
/// overlap where they meet; each is closed.
///
/// Throws std::invalid_argument where a joint has two children, or all joints lie in one place.
RobotBody robotBody(const Skeleton& skeleton, const RobotFigures& figures = {});

/// Of a link that a file describes: colour in sRGB and alpha; by default the grey of those without a
/// material.
Material linkMaterial(const Eigen::Vector4d& rgba = {0.78, 0.79, 0.80, 1.0});

}  // namespace gelenk
