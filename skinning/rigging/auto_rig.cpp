#include "skinning/rigging/auto_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>

#include "kinematics/motion/joint_matching.h"
#include "skinning/rigging/fit/placement.h"
#include "skinning/rigging/fit/rig_skeleton.h"
#include "skinning/rigging/fit/rig_transfer.h"
#include "skinning/rigging/fit/rig_weights.h"
#include "skinning/rigging/fit/voxel_body.h"

namespace gelenk {

using Eigen::Vector3d;

namespace {

/// Times the stages and asks whether to go on.
class Stages {
 public:
  Stages(const RigOptions& options, std::vector<RigStage>& out) : options_(options), out_(out) {}

  void begin(const std::string& name, double done) {
    end();
    if (options_.progress && !options_.progress(name, done)) throw RigStopped();
    out_.push_back({name});
    start_ = Clock::now();
  }
  void end() {
    if (!out_.empty()) out_.back().seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  const RigOptions& options_;
  std::vector<RigStage>& out_;
  Clock::time_point start_ = Clock::now();
};

const TemplateBody& templateOf(RigTemplate which) {
  return which == RigTemplate::Quadruped ? quadrupedTemplate() : humanTemplate();
}

/// The skeleton of the template as it stands by itself.
Skeleton restingSkeleton(RigTemplate which) {
  const TemplateBody& body = templateOf(which);
  std::vector<Vector3d> positions;
  for (const TemplateJoint& joint : body.joints) positions.push_back(joint.position);
  return rigSkeleton(rigJoints(body, which, {.maps = restMaps(body)}, positions));
}

/// Which template's joints have more of the meanings that the user's skeleton names.
RigTemplate kindOf(const Skeleton& own) {
  const auto shared = [&](RigTemplate which) {
    return matchJoints(restingSkeleton(which), own).matches.size();
  };
  return shared(RigTemplate::Quadruped) > shared(RigTemplate::Human) ? RigTemplate::Quadruped
                                                                     : RigTemplate::Human;
}

/// From rough to fine: the pieces may bend their shapes more and more, and far points count less and less.
constexpr FitStage schedule[] = {
    {.rounds = 8, .stiffness = 0.5, .robustWidth = 0.08},
    {.rounds = 10, .stiffness = 0.2, .robustWidth = 0.05},
    {.rounds = 12, .stiffness = 0.05, .robustWidth = 0.03, .pull = 0.03},
    {.rounds = 8, .stiffness = 0.02, .robustWidth = 0.03, .pull = 0.02},
};

/// Joints that came to lie outside the body go to the nearest place inside; on symmetric bodies the right
/// ones as the mirror images of the left.
void moveInside(std::vector<RigJoint>& joints, const VoxelBody& voxels, const Placement& placement) {
  if (!voxels.hasInside()) return;
  const auto mirrored = [&](const Vector3d& p) {
    const Vector3d q = placement.frame.toBody(p);
    return placement.frame.toWorld({-q.x(), q.y(), q.z()});
  };
  for (RigJoint& joint : joints) {
    if (voxels.isInside(joint.position)) continue;
    Vector3d inside = voxels.nearestInside(joint.position, 0.04 * placement.frame.scale);
    const bool middle = std::abs(placement.frame.toBody(joint.position).x()) < 1e-6;
    if (placement.symmetric && middle) inside = 0.5 * (inside + mirrored(inside));
    if (placement.symmetric && !middle)
      for (RigJoint& other : joints)
        if (&other != &joint &&
            (mirrored(joint.position) - other.position).norm() < 1e-6 * placement.frame.scale)
          other.position = mirrored(inside);
    joint.position = inside;
  }
}

}  // namespace

RiggedBody rigBody(const Mesh& mesh, const RigOptions& options) {
  validate(mesh);
  RiggedBody out;
  RigReport& report = out.report;
  Stages stages(options, report.stages);

  stages.begin("template", 0.0);
  const RigTemplate kind = options.own ? kindOf(*options.own) : options.skeleton;
  const TemplateBody& body = templateOf(kind);

  stages.begin("place", 0.1);
  SurfaceSamples samples = sampleSurface(mesh, 6000);
  if (samples.points.empty()) throw RigRefused("no triangle has an area");
  const VoxelBody voxels(mesh, 128);
  const SurfaceAir air = faceOutwards(samples, voxels);
  const auto percent = [](double share) { return std::to_string(std::lround(100.0 * share)) + " %"; };
  if (air.flipped > 0.005)
    report.repairs.push_back(percent(air.flipped) + " of the surface faces inwards: turned");
  if (air.hidden > 0.005)
    report.repairs.push_back(percent(air.hidden) + " of the surface lies inside the body: passed over");
  Placement placement = placeBody(body, samples, {options.up, options.front});
  if (placement.maps.empty()) throw RigRefused("the body stands in none of the ways that were asked for");

  stages.begin("fit", 0.3);
  const FitTarget target(inBodySpace(samples, placement.frame), 0.05);
  for (FitStage stage : schedule) {
    stage.symmetric = placement.symmetric;
    if (stage.rounds == 10) twistPieces(body, target, placement.maps, placement.symmetric);
    report.misfit = fitPieces(body, target, placement.maps, stage);
    if (options.progress && !options.progress("fit", 0.4)) throw RigStopped();
  }
  const std::vector<Vector3d> positions =
      refineJoints(body, target, placement.maps, {.symmetric = placement.symmetric});
  std::vector<RigJoint> joints = rigJoints(body, kind, placement, positions);
  moveInside(joints, voxels, placement);
  out.skeleton = rigSkeleton(joints);
  if (options.own) {
    LaidSkeleton laid = layOn(out.skeleton, *options.own);
    if (!laid.placed.empty()) {
      std::string names;
      for (const std::string& name : laid.placed) names += (names.empty() ? "" : ", ") + name;
      report.doubts.push_back("placed by proportion, not by the surface: " + names);
    }
    out.skeleton = std::move(laid.skeleton);
  }

  stages.begin("weights", 0.6);
  SparseWeights weights = rigWeights(mesh, out.skeleton);
  const std::vector<Influences> kept = fourLargest(weights, out.skeleton.jointCount(), &report.loss);
  for (std::size_t v = 0; v < weights.size(); ++v) {
    weights[v].clear();
    for (int k = 0; k < 4; ++k)
      if (kept[v].weights[k] > 0.0) weights[v].emplace_back(kept[v].joints[k], kept[v].weights[k]);
  }
  out.weights = std::move(weights);
  stages.end();

  report.up = placement.frame.axes.col(1);
  report.front = placement.frame.axes.col(2);
  report.pose = placement.pose;
  report.symmetric = placement.symmetric;
  double low = unlimited, high = -unlimited;
  for (const Vector3d& p : samples.points) {
    low = std::min(low, report.up.dot(p));
    high = std::max(high, report.up.dot(p));
  }
  report.height = high - low;
  const double margin = std::clamp((placement.runnerUp / placement.misfit - 1.0) / 0.1, 0.0, 1.0);
  const double likeness = std::clamp((0.035 - report.misfit) / 0.02, 0.0, 1.0);
  report.confidence = likeness * (0.3 + 0.7 * margin);
  if (report.misfit > 0.05)
    throw RigRefused("nothing like the template's body is in this mesh (it misses the surface by " +
                     std::to_string(std::lround(100.0 * report.misfit)) + " % of its height)");
  return out;
}

}  // namespace gelenk
