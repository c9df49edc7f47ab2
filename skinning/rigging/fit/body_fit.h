#pragma once

#include <Eigen/Core>
#include <vector>

#include "skinning/rigging/fit/kd_tree.h"
#include "skinning/rigging/fit/surface_samples.h"
#include "skinning/rigging/fit/template_body.h"

namespace gelenk {

/// A surface to be fitted, ready for questions about its nearest point. Positions and normals are asked
/// together: |p - q|^2 + (reach |n - m|)^2, so that the palm is not taken for the back of the hand.
class FitTarget {
 public:
  FitTarget(SurfaceSamples samples, double normalReach);

  int nearest(const Eigen::Vector3d& point, const Eigen::Vector3d& normal) const;
  const SurfaceSamples& samples() const { return samples_; }
  double normalReach() const { return reach_; }

 private:
  SurfaceSamples samples_;
  double reach_;
  KdTree<6> tree_;
};

/// Vertices of the template under the maps, blended by its weights.
std::vector<Eigen::Vector3d> deformed(const TemplateBody& body, const PieceMaps& maps);
/// Where the joints come to lie.
std::vector<Eigen::Vector3d> deformedJoints(const TemplateBody& body, const PieceMaps& maps);

/// A place of the body that is known, for one vertex of the template. Distances across a surface leave it
/// free to slide along limbs; a saddle such as the crotch holds it.
struct Landmark {
  int vertex = 0;
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Matrix3d metric = Eigen::Matrix3d::Zero();  ///< all distances of the surface together weigh about 1
};

struct FitStage {
  int rounds = 10;
  double stiffness = 1.0;     ///< weight of the pieces' shape: a rotation times a length and a girth
  double robustWidth = 0.05;  ///< distances well beyond it count for little; in template heights
  double pull = 0.1;          ///< weight of the distance along the surface beside that across it
  bool symmetric = true;      ///< the solution is its own mirror image at x = 0
  int vertices = 1500;        ///< of the template that take part, about
  int samples = 1500;         ///< of the target that look for the template, about
  std::vector<Landmark> landmarks = {};
};

/// Rounds of an articulated closest-point fit (Besl and McKay 1992; one affine map a piece as in Sumner,
/// Schmid and Pauly 2007): nearest points in both directions with normals, then one linear least-squares
/// problem for all maps, point to plane, with joints that stay together and pieces near a rotation times
/// length and girth. Returns the root mean square distance of the last round (robust weights, both ways).
double fitPieces(const TemplateBody& body, const FitTarget& target, PieceMaps& maps, const FitStage& stage);

/// The same piece by piece: root mean square distance across the surface, both ways, of what the piece
/// carries.
std::vector<double> pieceMisfits(const TemplateBody& body, const FitTarget& target, const PieceMaps& maps);

/// Root mean square distance between the whole surfaces, both ways, up to 0.06: the part across the surface,
/// and along it only what is beyond the spacing of the samples, so that finer triangles change nothing.
double surfaceMisfit(const TemplateBody& body, const FitTarget& target, const PieceMaps& maps);

/// How much the pieces' lengths and girths differ from those of the template in one size: the root mean
/// square of the logarithms of their stretches about the mean. About 0.15 among people, infinite where a
/// piece lost all extent.
double shapeStrain(const TemplateBody& body, const PieceMaps& maps);

/// Turns pieces about their own length, in steps of 30 degrees, to where their surface lies nearest: a hand
/// with the palm forwards has the same outline as one with the palm inwards. The parent takes half of the
/// turn. symmetric: the right pieces follow the left ones.
void twistPieces(const TemplateBody& body, const FitTarget& target, PieceMaps& maps, bool symmetric);

struct SurfaceStage {
  int rounds = 4;
  double smoothness = 4.0;  ///< weight of the differences between neighbours beside that of the distances
  double robustWidth = 0.02;
  bool symmetric = true;
};

/// What the pieces' maps leave over: every vertex of the template moves towards the surface on its own, its
/// displacement smooth over the template. Each joint follows the displacements around it (a local affine fit,
/// weighted by exp(-(d / r)^2), r its depth under the skin). Returns the joints.
std::vector<Eigen::Vector3d> refineJoints(const TemplateBody& body, const FitTarget& target,
                                          const PieceMaps& maps, const SurfaceStage& stage,
                                          std::vector<Eigen::Vector3d>* surface = nullptr);

}  // namespace gelenk
