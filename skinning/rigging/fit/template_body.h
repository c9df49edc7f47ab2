#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <string>
#include <vector>

#include "skinning/mesh.h"

namespace gelenk {

/// A part of a template body that deforms by one affine map when it is fitted, such as the left forearm.
struct BodyPiece {
  std::string name;
  int parent = -1;  ///< earlier; -1 for the first
  int partner = 0;  ///< the mirrored part; itself in the middle
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  int mate = -1;           ///< the other half of a limb, whose stretch should be like its own
  double stiffness = 1.0;  ///< how strictly the piece is a rotation times a stretch
  double bond = 0.0;       ///< how strictly it turns with its parent
  bool twists = false;     ///< its turn about its own length is not known from the pose
  bool stands = false;     ///< its end is a sole on the ground
  bool trails = false;     ///< its end is the tip of a tail, whose length is not known
  int lifter = -1;         ///< the piece that takes it along where it is raised above the horizontal

  double length() const { return (to - from).norm(); }
};

/// A joint inside the template. It moves with the affine map of its piece.
struct TemplateJoint {
  std::string name;
  int parent = -1;
  int partner = 0;
  int piece = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
};

/// One affine map a piece of the template: x -> linear (x - piece.from) + origin.
struct PieceMap {
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
};
using PieceMaps = std::vector<PieceMap>;

/// A pose that bodies are often made in.
struct TemplatePose {
  std::string name;
  PieceMaps maps;
  bool symmetric = true;
  double rarity =
      1.0;  ///< factor on its misfit among the others: unusual proportions must fit clearly better
};

/// A body whose inside is known: surface, the pieces that move it and the joints. Height 1 (four-legged:
/// length 1), y up, facing +z, left at +x, symmetric in x = 0.
struct TemplateBody {
  Mesh surface;  ///< with normals
  std::vector<BodyPiece> pieces;
  std::vector<std::array<std::pair<int, double>, 4>> weights;  ///< of the pieces, one row a vertex
  std::vector<double> importance;                              ///< of each vertex in a fit, about 1
  std::vector<TemplateJoint> joints;
  std::vector<TemplatePose> poses;
  bool fourLegged = false;
  int crotch =
      -1;  ///< the vertex between the legs, where the cut in the middle is lowest; -1: not looked for
  double variety = 0.04;    ///< strain (shapeStrain) that is ordinary among bodies of the kind
  double crotchDrop = 0.0;  ///< how much further it lies under the hips than in people: the grid fills it

  int piece(const std::string& name) const;
};

/// The maps that leave the template where it is.
PieceMaps restMaps(const TemplateBody& body);
/// Turns a piece so that it points along `direction`, with what hangs on it; `aim`: the right partner
/// likewise, mirrored.
void aimOne(const TemplateBody& body, PieceMaps& maps, const std::string& piece,
            const Eigen::Vector3d& direction);
void aim(const TemplateBody& body, PieceMaps& maps, const std::string& left,
         const Eigen::Vector3d& direction);

/// The built-in figure with its 53 joints and 12 end sites.
const TemplateBody& humanTemplate();
/// Four-legged animals with the same joints: horse and deer; heavy cattle on short legs; dog, wolf and fox.
const TemplateBody& hoofedTemplate();
const TemplateBody& cattleTemplate();
const TemplateBody& pawedTemplate();

}  // namespace gelenk
