#pragma once

#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "skinning/skin.h"

namespace gelenk {

/// The skeletons that gelenk brings along.
enum class RigTemplate {
  Human,      ///< the built-in figure's joints
  Pinocchio,  ///< the 18 joints of Pinocchio's human
  Quadruped,
};

struct RigOptions {
  RigTemplate skeleton = RigTemplate::Human;
  /// A skeleton of the user's, which takes the place of `skeleton`: human or four-legged by its joints'
  /// names.
  std::optional<Skeleton> own = {};
  /// Unit vectors where the user knows how the body stands; else it is found out.
  std::optional<Eigen::Vector3d> up = {}, front = {};
  /// Called with the name of a stage and the share done, 0 to 1; false stops the work (RigStopped).
  std::function<bool(const std::string& stage, double done)> progress = {};
};

struct RigStage {
  std::string name;
  double seconds = 0.0;
};

/// What was found, and how sure that is.
struct RigReport {
  Eigen::Vector3d up = Eigen::Vector3d::UnitY(), front = Eigen::Vector3d::UnitZ();
  double height = 0.0;      ///< along `up`, in the mesh's unit
  double misfit = 0.0;      ///< root mean square distance between body and fitted template, in heights
  double strain = 0.0;      ///< how far the template's proportions had to change, as a logarithm
  double confidence = 0.0;  ///< 0 to 1; below 0.5 the result needs a look
  std::vector<double> jointConfidence;  ///< of each joint; lower where the surface around it is unlike
  int limbs = 0;                        ///< slender branches of the body (fit/limbs.h)
  std::string pose;                     ///< the template's pose that the body was nearest to
  /// Between left and right, facing left: the plane of symmetry where the body has one.
  Eigen::Hyperplane<double, 3> middle{Eigen::Vector3d::UnitX(), 0.0};
  bool symmetric = false;  ///< the body is its own mirror image, and so is the skeleton then
  WeightLoss loss;         ///< by keeping four influences
  std::vector<RigStage> stages;
  std::vector<std::string> repairs;  ///< what was mended for the fit; the mesh itself stays as it is
  std::vector<std::string> doubts;
};

struct RiggedBody {
  Skeleton skeleton;      ///< rests where the body stands
  SparseWeights weights;  ///< of the joints, up to four a vertex of the input mesh; each row sums to 1
  SparseWeights bones;    ///< the same by bone: j is the bone from joint j to its parent, which carries it
  RigReport report;
};

/// No body of the template's kind is in the mesh; the message says what was missed.
struct RigRefused : std::runtime_error {
  using std::runtime_error::runtime_error;
};
struct RigStopped : std::runtime_error {
  RigStopped() : std::runtime_error("rigging was stopped") {}
};

/// A skeleton and weights for a mesh that has neither: a template body with known joints is laid on the
/// surface (fit/placement.h, fit/body_fit.h), the joints follow, and heat gives the weights. Any mesh: holes,
/// pieces, flipped or repeated faces and loose vertices are ordinary input, and vertices keep their order.
/// The same input gives the same bits. Throws RigRefused, RigStopped, std::invalid_argument for an invalid
/// mesh.
RiggedBody rigBody(const Mesh& mesh, const RigOptions& options = {});

/// A fitted joint mended by hand: it rests at `place`, all others where they did. Motions, limits and rest
/// angles stay, offsets change.
Skeleton withJointAt(const Skeleton& skeleton, int joint, const Eigen::Vector3d& place);
/// The same with its partner at the mirrored place; a joint without partner stays in the plane. Throws
/// std::invalid_argument where the names tell no partners (symmetry.h).
Skeleton withJointAt(const Skeleton& skeleton, int joint, const Eigen::Vector3d& place,
                     const Eigen::Hyperplane<double, 3>& middle);

/// The weights anew for the skeleton as it is now.
void weigh(const Mesh& mesh, RiggedBody& body);

/// What of a rig is taken by hand, and what of that stands pinned: by the names of the joints here.
struct RigGrips {
  std::vector<std::string> handles, pins;
};
RigGrips rigGrips(const Skeleton& skeleton);

}  // namespace gelenk
