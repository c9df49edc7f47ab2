#pragma once

#include <array>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

// What is measured of a skinned body against its rest pose: facts of surfaces, which know no method.

/// A closed curve in which a plane across a bone cuts the body at rest: points on edges of the mesh.
struct SkinSection {
  struct Point {
    int a = 0, b = 0;    ///< the edge
    double share = 0.0;  ///< from a to b
  };
  std::vector<Point> points;
  double restArea = 0.0;  ///< m^2
};

/// Sections across the segment from head to end at `count` places between them, both ends left out. Of each
/// plane the curve round the bone; none where there is no closed curve whose points all stay within half the
/// bone's length of it (the plane runs into the trunk).
std::vector<SkinSection> sectionsAlong(const Mesh& mesh, const Eigen::Vector3d& head,
                                       const Eigen::Vector3d& end, int count);

/// Area of the sections' images (length of the vector area) against rest, the smallest; 1 without sections.
double smallestSection(const std::vector<SkinSection>& sections,
                       const std::vector<Eigen::Vector3d>& positions);

/// A part of a body as a closed surface: its triangles and fans over the openings, whose hubs are means of
/// the openings' vertices.
class PartVolume {
 public:
  /// Triangles without an inside, such as three times the same vertex, are passed over.
  explicit PartVolume(const std::vector<std::array<int, 3>>& triangles);
  /// What lies within a radius of a point at rest, whole triangles.
  PartVolume(const Mesh& mesh, const Eigen::Vector3d& centre, double radius);
  /// m^3.
  double volume(const std::vector<Eigen::Vector3d>& positions) const;
  bool empty() const { return triangles_.empty(); }

 private:
  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::vector<int>> openings_;  ///< vertices in order, against the triangles' sense
};

/// Edges of two triangles each, for creases.
struct MeshEdges {
  std::vector<std::array<int, 4>>
      corners;  ///< edge a, b and the two triangles' other corners: (a, b, c), (b, a, d)
};
MeshEdges innerEdges(const Mesh& mesh);
/// Angles between the normals of an edge's two triangles, radians, signed: convex positive.
std::vector<double> edgeAngles(const MeshEdges& edges, const std::vector<Eigen::Vector3d>& positions);
/// Mean of the 50 largest growths of an edge's angle in either sense, radians.
double crease(const std::vector<double>& rest, const std::vector<double>& now);

/// Distance of points to a surface that lies nearly where they do, metres: from a vertex of the same number
/// downhill along edges to the nearest one, then to its triangles.
class SurfaceDistance {
 public:
  explicit SurfaceDistance(const Mesh& mesh);
  double of(const Eigen::Vector3d& point, int vertex, const std::vector<Eigen::Vector3d>& positions) const;

 private:
  std::vector<std::vector<std::array<int, 3>>> round_;  ///< triangles of each vertex
};

/// Angle between each vertex's normal and the one of its triangles' corners (weighted by area), radians.
std::vector<double> normalErrors(const Mesh& mesh, const std::vector<Eigen::Vector3d>& positions,
                                 const std::vector<Eigen::Vector3d>& normals);

}  // namespace gelenk
