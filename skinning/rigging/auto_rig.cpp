#include "skinning/rigging/auto_rig.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "kinematics/motion/joint_matching.h"
#include "kinematics/symmetry.h"
#include "skinning/rigging/fit/landmarks.h"
#include "skinning/rigging/fit/limbs.h"
#include "skinning/rigging/fit/nearest_skin.h"
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
  /// Within a stage.
  void goOn(double done) {
    if (options_.progress && !options_.progress(out_.back().name, done)) throw RigStopped();
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

/// The bodies that may lie in the mesh; they have the same joints.
std::vector<const TemplateBody*> templatesOf(RigTemplate which) {
  if (which == RigTemplate::Quadruped) return {&hoofedTemplate(), &cattleTemplate(), &pawedTemplate()};
  return {&humanTemplate()};
}

/// The skeleton of the template as it stands by itself.
Skeleton restingSkeleton(RigTemplate which) {
  const TemplateBody& body = *templatesOf(which).front();
  std::vector<Vector3d> positions;
  for (const TemplateJoint& joint : body.joints) positions.push_back(joint.position);
  Placement atRest;
  atRest.maps = restMaps(body);
  return rigSkeleton(rigJoints(body, which, atRest, positions));
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
const FitStage schedule[] = {
    {.rounds = 8, .stiffness = 0.5, .robustWidth = 0.08},
    {.rounds = 10, .stiffness = 0.2, .robustWidth = 0.05},
    {.rounds = 12, .stiffness = 0.05, .robustWidth = 0.03, .pull = 0.03},
    {.rounds = 8, .stiffness = 0.02, .robustWidth = 0.03, .pull = 0.02},
};

/// How often the surface winds around a point: 1 inside a closed body that faces outwards, 0 outside (van
/// Oosterom and Strackee 1983).
double windingNumber(const Mesh& mesh, const Vector3d& p) {
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    const Vector3d a = mesh.positions[t[0]] - p, b = mesh.positions[t[1]] - p, c = mesh.positions[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2.0 * M_PI);
}

/// Joints that came to lie outside go towards the middle of their neighbours until they are inside, or, where
/// that is far, straight under the skin beside them; the end of a curled tail towards where its parent went.
/// Where faces disagree about what is inside the air decides (voxels).
void moveInside(std::vector<RigJoint>& joints, const Mesh& mesh, const VoxelBody* voxels) {
  const auto isInside = [&](const Vector3d& p) {
    return voxels ? !voxels->isOutside(p) : std::abs(windingNumber(mesh, p)) > 0.5;
  };
  const double near = 0.02 * bodySize(mesh);
  const std::vector<RigJoint> before = joints;
  for (std::size_t k = 0; k < joints.size(); ++k) {
    const Vector3d start = before[k].position;
    if (isInside(start)) continue;
    const auto moved = [&](const Vector3d& towards, double farthest) {
      const Vector3d way = towards - start;
      for (int step = 1; step <= 19 && 0.05 * step * way.norm() < farthest; ++step)
        if (isInside(start + 0.05 * step * way)) {
          joints[k].position = start + 0.05 * step * way;
          return true;
        }
      return false;
    };
    Vector3d home = Vector3d::Zero();
    int neighbours = 0;
    for (std::size_t i = 0; i < joints.size(); ++i)
      if (joints[k].parent == static_cast<int>(i) || before[i].parent == static_cast<int>(k))
        home += before[i].position, ++neighbours;
    if (neighbours == 0) continue;
    home /= neighbours;
    if (moved(home, near)) continue;
    const Vector3d skin = nearestSkin(mesh, start);
    if (const double gap = (skin - start).norm();
        gap < near && moved(skin + near / gap * (skin - start), 2.0 * near))
      continue;
    if (!moved(home, unlimited) && neighbours == 1 && joints[k].parent >= 0)
      moved(joints[joints[k].parent].position, unlimited);
  }
}

void tellRepairs(const SurfaceAir& air, const MeshTopology& shape, RigReport& report) {
  const auto percent = [](double share) { return std::to_string(std::lround(100.0 * share)) + " %"; };
  const auto tell = [&](int count, const std::string& what) {
    if (count > 0) report.repairs.push_back(std::to_string(count) + " " + what);
  };
  if (air.flipped > 0.005)
    report.repairs.push_back(percent(air.flipped) + " of the surface faces inwards: turned for the fit");
  if (air.hidden > 0.005)
    report.repairs.push_back(percent(air.hidden) + " of the surface lies inside the body: passed over");
  if (shape.components > 1) tell(shape.components, "pieces: taken as one body");
  tell(shape.boundaryEdges, "edges of one triangle only (holes, or corners that were not welded)");
  tell(shape.nonManifoldEdges, "edges of more than two triangles, or of two that disagree");
  tell(shape.unreferencedVertices, "vertices of no triangle: they follow their nearest bone");
  tell(shape.degenerateTriangles, "triangles without area: passed over");
}

struct Fit {
  const TemplateBody* body;
  Placement placement;
  std::shared_ptr<FitTarget> target;
  double misfit = 1.0;
  double rival = unlimited;  ///< misfit of the best other way to stand
};

/// Every way to stand that the rough fits could not tell apart gets the first half of the schedule; the best
/// of them the rest.
Fit fitBest(const TemplateBody& body, const Mesh& mesh, const SurfaceSamples& samples,
            const std::vector<Placement>& placements, Stages& stages) {
  std::vector<Fit> fits;
  for (const Placement& placement : placements) {
    Fit fit{&body, placement, std::make_shared<FitTarget>(inBodySpace(samples, placement.frame), 0.05)};
    for (int k = 0; k < 2; ++k) {
      FitStage stage = schedule[k];
      stage.symmetric = placement.symmetric;
      if (k == 1) twistPieces(body, *fit.target, fit.placement.maps, placement.symmetric);
      fit.misfit = fitPieces(body, *fit.target, fit.placement.maps, stage);
    }
    fits.push_back(std::move(fit));
    stages.goOn(0.4);
  }
  const auto rank = [](const Fit& fit) {
    return fit.misfit * (fit.placement.authored ? authoredBonus : 1.0);
  };
  std::stable_sort(fits.begin(), fits.end(), [&](const Fit& a, const Fit& b) { return rank(a) < rank(b); });
  Fit best = fits[0];
  if (fits.size() > 1) best.rival = fits[1].misfit / best.misfit;
  twistPieces(body, *best.target, best.placement.maps, best.placement.symmetric);
  for (int k = 2; k < static_cast<int>(std::size(schedule)); ++k) {
    FitStage stage = schedule[k];
    stage.landmarks = findLandmarks(body, mesh, best.placement.frame, *best.target, best.placement.maps);
    stage.symmetric = best.placement.symmetric;
    best.misfit = fitPieces(body, *best.target, best.placement.maps, stage);
    stages.goOn(0.5);
  }
  return best;
}

/// What tells which of several templates lies in the mesh: the misfit of the pieces, each counted alike. A
/// tail says nothing about it.
double kindMisfit(const Fit& fit) {
  const std::vector<double> misfits = pieceMisfits(*fit.body, *fit.target, fit.placement.maps);
  double sum = 0.0;
  int counted = 0;
  for (std::size_t k = 0; k < misfits.size(); ++k)
    if (fit.body->pieces[k].name != "tail_root") sum += misfits[k], ++counted;
  return sum / counted;
}

/// 1 for a surface as near as that of people, 0 for one that is not the template's.
double likenessOf(double misfit, double none) { return std::clamp((none - misfit) / 0.02, 0.0, 1.0); }

/// The confidence in each joint: the whole body's, and how near the surface lies around the joint.
std::vector<double> jointConfidences(const TemplateBody& body, const Fit& fit,
                                     const std::vector<RigJoint>& joints, double whole) {
  const std::vector<double> misfits = pieceMisfits(body, *fit.target, fit.placement.maps);
  std::vector<double> out;
  for (const RigJoint& joint : joints) {
    const int above = body.pieces[joint.piece].parent;
    const double near = std::max(misfits[joint.piece], above < 0 ? 0.0 : misfits[above]);
    out.push_back(whole * likenessOf(near, 0.03));
  }
  return out;
}

/// Files stand along an axis, the fit a degree or two beside it: enough for a seat to hide a stool's legs.
Vector3d alongAxis(const Vector3d& up) {
  int axis = 0;
  const double share = up.cwiseAbs().maxCoeff(&axis);
  return share < 0.99 ? up : Vector3d(std::copysign(1.0, up[axis]) * Vector3d::Unit(axis));
}

/// Fills the report and refuses what is no such body: the template misses the surface, or had to change its
/// proportions beyond any animal's.
void judge(const TemplateBody& body, const Fit& fit, const SurfaceSamples& samples, const VoxelBody& coarse,
           RigReport& report) {
  const Placement& placement = fit.placement;
  // The frame's axes are those of the surface; those of the body are its pelvis's.
  const Eigen::Matrix3d pelvis = placement.frame.axes * placement.maps[0].linear;
  report.up = pelvis.col(1).normalized();
  report.front = pelvis.col(0).cross(report.up).normalized();
  report.pose = placement.pose;
  report.symmetric = placement.symmetric;
  report.misfit = surfaceMisfit(body, *fit.target, placement.maps);
  report.strain = shapeStrain(body, placement.maps);
  double low = unlimited, high = -unlimited;
  for (const Vector3d& p : samples.points) {
    low = std::min(low, report.up.dot(p));
    high = std::max(high, report.up.dot(p));
  }
  report.height = high - low;
  report.limbs = countLimbs(coarse);
  const double likeness = likenessOf(report.misfit, 0.0255),
               proportion = std::clamp((3.0 * body.variety - report.strain) / (2.0 * body.variety), 0.0, 1.0),
               margin = std::clamp((fit.rival - 1.0) / 0.1, 0.0, 1.0);
  report.confidence = likeness * proportion * (0.3 + 0.7 * margin);
  report.middle = Eigen::Hyperplane<double, 3>(placement.frame.axes.col(0), placement.frame.origin);
  if (likeness < 0.5) report.doubts.push_back("the surface is unlike the template's");
  if (proportion < 0.5) report.doubts.push_back("the proportions are unlike the template's");
  if (margin < 0.5) report.doubts.push_back("the body could also stand or face another way (--up, --front)");
  if (report.limbs < 2 && likeness < 0.5)
    throw RigRefused(
        "no such body is in this mesh: no limbs stand out of it, and its surface is unlike the "
        "template's");
  if (report.misfit > 0.0455 || report.strain > 1.2)
    throw RigRefused("no such body is in this mesh: the template's surface stays " +
                     std::to_string(std::lround(100.0 * report.misfit)) +
                     " % of its height away, with its proportions changed by " +
                     std::to_string(std::lround(100.0 * std::expm1(report.strain))) + " % on average");
  // A robot may be as unlike as a chair, but it stands on two legs.
  if (const int legs = countLegs(coarse, alongAxis(report.up));
      !body.fourLegged && likeness == 0.0 && legs != 2)
    throw RigRefused("no such body is in this mesh: it stands on " +
                     (legs == 0 ? "no leg" : std::to_string(legs) + (legs == 1 ? " leg" : " legs")) +
                     ", not on two, and its surface is unlike the template's");
}

/// Each joint of the one skeleton takes the value of the nearest joint of the other.
std::vector<double> carriedOver(const std::vector<double>& values, const Skeleton& from, const Skeleton& to) {
  const Frames places = restFrames(from);
  std::vector<double> out;
  for (const Eigen::Isometry3d& frame : restFrames(to)) {
    const auto nearest = std::min_element(places.begin(), places.end(), [&](const auto& a, const auto& b) {
      return (a.translation() - frame.translation()).norm() < (b.translation() - frame.translation()).norm();
    });
    out.push_back(values[nearest - places.begin()]);
  }
  return out;
}

Skeleton layOwn(const Skeleton& fitted, const Skeleton& own, RigReport& report) {
  LaidSkeleton laid = layOn(fitted, own);
  std::string names;
  for (const std::string& name : laid.placed) names += (names.empty() ? "" : ", ") + name;
  if (!names.empty()) report.doubts.push_back("placed by proportion, not by the surface: " + names);
  return std::move(laid.skeleton);
}

}  // namespace

RiggedBody rigBody(const Mesh& mesh, const RigOptions& options) {
  validate(mesh);
  RiggedBody out;
  RigReport& report = out.report;
  Stages stages(options, report.stages);

  stages.begin("template", 0.0);
  const RigTemplate kind = options.own ? kindOf(*options.own) : options.skeleton;
  const std::vector<const TemplateBody*> bodies = templatesOf(kind);

  stages.begin("surface", 0.1);
  SurfaceSamples samples = sampleSurface(mesh, 6000);
  if (samples.points.empty()) throw RigRefused("no triangle has an area");
  const VoxelBody voxels(mesh, 128);
  const SurfaceAir air = faceOutwards(samples, voxels);
  const bool flipped = air.flipped > 0.0;
  tellRepairs(air, topology(mesh), report);

  stages.begin("placing", 0.15);
  std::vector<std::vector<Placement>> placements;
  for (const TemplateBody* body : bodies)
    placements.push_back(placeBody(*body, samples, {options.up, options.front}));

  stages.begin("fit", 0.35);
  std::optional<Fit> best;
  double least = 0.0;  // its misfit
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    if (placements[k].empty()) continue;
    Fit fit = fitBest(*bodies[k], mesh, samples, placements[k], stages);
    const double misfit = bodies.size() > 1 ? kindMisfit(fit) : 0.0;
    if (!best || misfit < least) best = std::move(fit), least = misfit;
  }
  if (!best) throw RigRefused("the body stands in none of the ways that were asked for");
  const Fit& fit = *best;
  const TemplateBody& body = *fit.body;
  judge(body, fit, samples, VoxelBody(mesh, 64), report);
  const Placement& placement = fit.placement;
  std::vector<RigJoint> joints =
      rigJoints(body, kind, placement,
                refineJoints(body, *fit.target, placement.maps, {.symmetric = placement.symmetric}));
  moveInside(joints, mesh, flipped ? &voxels : nullptr);
  addFingers(joints, mesh, placement);
  out.skeleton = rigSkeleton(joints);
  report.jointConfidence = jointConfidences(body, fit, joints, report.confidence);
  if (options.own) {
    const Skeleton fitted = std::move(out.skeleton);
    out.skeleton = layOwn(fitted, *options.own, report);
    report.jointConfidence = carriedOver(report.jointConfidence, fitted, out.skeleton);
  }

  stages.begin("weights", 0.6);
  weigh(mesh, out);
  stages.end();
  return out;
}

void weigh(const Mesh& mesh, RiggedBody& body) {
  RigWeights weights = rigWeights(mesh, body.skeleton, {}, &body.report.loss);
  body.weights = std::move(weights.joints);
  body.bones = std::move(weights.bones);
}

Skeleton withJointAt(const Skeleton& skeleton, int joint, const Vector3d& place) {
  Frames frames = restFrames(skeleton);
  std::vector<Joint> joints = skeleton.joints();
  const Frames before = frames;
  frames[joint].translation() = place;
  const auto parentFrom = [&](const Frames& all, int i) {
    return skeleton.parent(i) < 0
               ? all[i]
               : Eigen::Isometry3d(all[skeleton.parent(i)].inverse(Eigen::Isometry) * all[i]);
  };
  const auto settle = [&](int i) {  // rest frame = offset * motion at rest, and the motion stays
    joints[i].parentFromZero =
        parentFrom(frames, i) * parentFrom(before, i).inverse(Eigen::Isometry) * joints[i].parentFromZero;
  };
  settle(joint);
  for (const int child : skeleton.children(joint)) settle(child);
  return Skeleton(std::move(joints), skeleton.rest());
}

Skeleton withJointAt(const Skeleton& skeleton, int joint, const Vector3d& place,
                     const Eigen::Hyperplane<double, 3>& middle) {
  const int partner = mirrorPartners(skeleton)[joint];
  if (partner == joint) return withJointAt(skeleton, joint, middle.projection(place));
  const Vector3d image = place - 2.0 * middle.signedDistance(place) * middle.normal();
  return withJointAt(withJointAt(skeleton, joint, place), partner, image);
}

RigGrips rigGrips(const Skeleton& skeleton) {
  RigGrips grips;
  const auto add = [&](std::vector<std::string>& out, std::initializer_list<const char*> names) {
    for (const char* name : names)
      if (skeleton.findJoint(name)) out.emplace_back(name);
  };
  const bool fourLegged = skeleton.findJoint("ffoot_l").has_value(),
             full = skeleton.findJoint("wrist_l").has_value();
  if (fourLegged) {
    add(grips.pins, {"ffoot_l", "ffoot_r", "hfoot_l", "hfoot_r"});
    add(grips.handles, {"ffoot_l", "ffoot_r", "hfoot_l", "hfoot_r", "head", "tail", "pelvis"});
  } else if (full) {
    add(grips.pins, {"ankle_l", "ankle_r"});
    add(grips.handles, {"wrist_l", "wrist_r", "ankle_l", "ankle_r", "headbase", "pelvis"});
  } else {  // Pinocchio's human
    add(grips.pins, {"ankle_left", "ankle_right"});
    add(grips.handles, {"hand_left", "hand_right", "ankle_left", "ankle_right", "head", "pelvis"});
  }
  return grips;
}

}  // namespace gelenk
