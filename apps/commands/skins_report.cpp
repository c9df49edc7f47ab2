#include "apps/commands/skins_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include "apps/document/chosen_skin.h"
#include "kinematics/motion/joint_matching.h"
#include "kinematics/rotation.h"
#include "skinning/blend/limb_chains.h"
#include "skinning/blend/skin_measures.h"
#include "skinning/bodies/self_intersection.h"

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double degree = M_PI / 180.0;

/// The frames with a joint and all below it turned about a world axis through the joint.
Frames turned(const Skeleton& skeleton, Frames frames, int joint, const Vector3d& axis, double angle) {
  const Vector3d at = frames[joint].translation();
  const Eigen::Isometry3d turn =
      Eigen::Translation3d(at) * Eigen::AngleAxisd(angle, axis) * Eigen::Translation3d(-at);
  for (int i = 0; i < skeleton.jointCount(); ++i)
    if (i == joint || skeleton.isAncestor(joint, i)) frames[i] = turn * frames[i];
  return frames;
}

/// Sides of the body in the world of the bind pose.
struct BodyAxes {
  Vector3d up, left, forward;
};

/// Left from a pair of limbs.
BodyAxes bodyAxes(const Model& model, const Frames& rest, const std::vector<LimbChain>& limbs) {
  BodyAxes axes{.up = model.up, .left = Vector3d::UnitX(), .forward = Vector3d::UnitZ()};
  for (const LimbChain& a : limbs)
    for (const LimbChain& b : limbs) {
      if (a.arm != b.arm || !a.left || b.left) continue;
      axes.left = rest[a.joints[0]].translation() - rest[b.joints[0]].translation();
      axes.left = (axes.left - axes.up.dot(axes.left) * axes.up).normalized();
      axes.forward = axes.left.cross(axes.up);
      return axes;
    }
  return axes;
}

/// Turns `part` of the way from one direction to another.
struct Swing {
  Vector3d axis;
  double angle;
};
Swing swingTo(const Vector3d& from, const Vector3d& to, double part) {
  const Vector3d w = logRotation(rotationBetween(from, to));
  return {w.normalized(), part * w.norm()};
}

class TrialMaker {
 public:
  explicit TrialMaker(const Model& model)
      : model_(model),
        rest_(bindFrames(model)),
        limbs_(limbChains(model.skeleton)),
        axes_(bodyAxes(model, rest_, limbs_)) {}

  SkinTrials standard() {
    for (const LimbChain& limb : limbs_)
      if (limb.left) limb.arm ? arm(limb) : leg(limb);
    trunk("neck", {"neck"}, {{0, 40}, {1, 40}});
    trunk("spine", {"spine1", "spine", "chest"}, {{0, 40}, {1, 60}});
    rigidBones();
    return std::move(trials_);
  }

  SkinTrials motion(const MotionClip& clip, int count) {
    for (const LimbChain& limb : limbs_) bonesOf(limb);
    std::vector<int> all(trials_.bones.size());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<int>(i);
    const int frames = clip.frameCount(), shown = std::min(count, frames);
    for (int i = 0; i < shown; ++i) {
      const int frame = shown > 1 ? i * (frames - 1) / (shown - 1) : 0;
      const Eigen::VectorXd q = clip.q.col(frame);
      trials_.poses.push_back({.name = fmt::format("frame {}", frame + 1),
                               .frames = forwardKinematics(model_.skeleton, q),
                               .q = q,
                               .radius = 1e6,
                               .bones = all});
    }
    return std::move(trials_);
  }

 private:
  Vector3d at(int joint) const { return rest_[joint].translation(); }
  Vector3d along(const LimbChain& limb, int bone) const {
    return (at(limb.joints[bone + 1]) - at(limb.joints[bone])).normalized();
  }
  std::vector<int> bonesOf(const LimbChain& limb) {
    const int first = static_cast<int>(trials_.bones.size());
    const char* names[2][2] = {{"thigh", "shank"}, {"upper arm", "forearm"}};
    for (int k = 0; k < 2; ++k)
      trials_.bones.push_back({fmt::format("{} {}", limb.left ? "left" : "right", names[limb.arm][k]),
                               at(limb.joints[k]), at(limb.joints[k + 1])});
    return {first, first + 1};
  }
  void add(std::string name, int joint, const Vector3d& axis, double angle, const Vector3d& centre,
           double radius, std::vector<int> bones) {
    trials_.poses.push_back({.name = std::move(name),
                             .frames = turned(model_.skeleton, rest_, joint, axis, angle),
                             .turn = {joint, axis, angle},
                             .centre = centre,
                             .radius = radius,
                             .bones = std::move(bones)});
  }
  /// From joint to joint; where a joint has none after it, half of the bone before it further on.
  void rigidBones() {
    const Skeleton& skeleton = model_.skeleton;
    std::vector<char> carries(skeleton.jointCount(), 0);
    const auto bone = [&](int joint, const Vector3d& head, const Vector3d& end) {
      if ((end - head).norm() > 1e-6) trials_.rigid.push_back({joint, head, end});
    };
    for (int j = 0; j < skeleton.jointCount(); ++j)
      if (const int parent = skeleton.parent(j); parent >= 0) {
        carries[parent] = 1;
        bone(parent, at(parent), at(j));
      }
    for (int j = 0; j < skeleton.jointCount(); ++j)
      if (const int parent = skeleton.parent(j); parent >= 0 && !carries[j])
        bone(j, at(j), at(j) + 0.5 * (at(j) - at(parent)));
  }
  double length(const LimbChain& limb, int bone) const {
    return (at(limb.joints[bone + 1]) - at(limb.joints[bone])).norm();
  }
  /// Across the two bones as they rest; where they rest straight, across the body.
  Vector3d bendAxis(const LimbChain& limb) const {
    const Vector3d across = along(limb, 0).cross(along(limb, 1));
    if (across.norm() > 0.05) return across.normalized();
    return (limb.arm ? along(limb, 0).cross(axes_.forward) : along(limb, 0).cross(-axes_.forward))
        .normalized();
  }
  double bentAtRest(const LimbChain& limb) const {
    return std::acos(std::clamp(along(limb, 0).dot(along(limb, 1)), -1.0, 1.0));
  }

  void arm(const LimbChain& limb) {
    const std::vector<int> bones = bonesOf(limb);
    const int shoulder = limb.joints[0], elbow = limb.joints[1], hand = limb.joints[2];
    for (const double bend : {30.0, 60.0, 90.0, 120.0, 150.0})
      add(fmt::format("elbow {:.0f}", bend), elbow, bendAxis(limb), bend * degree - bentAtRest(limb),
          at(elbow), 0.5 * length(limb, 0), bones);
    for (const double twist : {80.0, 170.0})
      add(fmt::format("forearm twist {:.0f}", twist), elbow, along(limb, 1), twist * degree,
          0.5 * (at(elbow) + at(hand)), 0.6 * length(limb, 1), bones);
    for (const double twist : {80.0, 170.0})
      add(fmt::format("hand twist {:.0f}", twist), hand, along(limb, 1), twist * degree,
          0.5 * (at(elbow) + at(hand)), 0.6 * length(limb, 1), {bones[1]});
    for (SkinPoseCase& pose : trials_.poses)
      if (pose.name.find(" twist ") != std::string::npos) pose.freeBone = elbow;
    for (const double twist : {45.0, 90.0})
      add(fmt::format("upper arm twist {:.0f}", twist), shoulder, along(limb, 0), twist * degree,
          0.5 * (at(shoulder) + at(elbow)), 0.6 * length(limb, 0), {bones[0]});
    for (const auto& [name, to] : {std::pair<const char*, Vector3d>{"up", axes_.up + 0.1 * axes_.left},
                                   {"forward", axes_.forward},
                                   {"cross", axes_.forward - axes_.left}})
      for (const double part : {0.5, 1.0}) {
        const Swing swing = swingTo(along(limb, 0), to, part);
        add(fmt::format("shoulder {}{}", name, part < 1.0 ? " halfway" : ""), shoulder, swing.axis,
            swing.angle, at(shoulder), 0.5 * length(limb, 0), {bones[0]});
      }
    for (const double bend : {35.0, 70.0})
      add(fmt::format("wrist {:.0f}", bend), hand, bendAxis(limb), bend * degree, at(hand),
          0.4 * length(limb, 1), {bones[1]});
  }

  void leg(const LimbChain& limb) {
    const std::vector<int> bones = bonesOf(limb);
    const int hip = limb.joints[0], knee = limb.joints[1];
    Vector3d axis = along(limb, 0).cross(-axes_.forward);  // the shank goes back
    axis.normalize();
    for (const double bend : {30.0, 60.0, 90.0, 120.0, 140.0})
      add(fmt::format("knee {:.0f}", bend), knee, axis, bend * degree, at(knee), 0.4 * length(limb, 0),
          bones);
    for (const double bend : {60.0, 90.0, 120.0})
      add(fmt::format("hip {:.0f}", bend), hip, -axis, bend * degree, at(hip), 0.4 * length(limb, 0),
          {bones[0]});
  }

  /// Bend forwards (axis 0, left) and turn about up (axis 1), degrees.
  void trunk(const char* name, const std::vector<std::string>& parts,
             const std::vector<std::pair<int, double>>& turns) {
    const auto names = plainNames(model_.skeleton);
    for (const std::string& part : parts)
      for (std::size_t i = 0; i < names.size(); ++i) {
        if (names[i].part != part || names[i].side != Side::Middle) continue;
        for (const auto& [axis, degrees] : turns)
          add(fmt::format("{} {} {:.0f}", name, axis == 0 ? "bend" : "twist", degrees), static_cast<int>(i),
              axis == 0 ? axes_.left : axes_.up, degrees * degree, at(static_cast<int>(i)),
              0.1 * bodySize(model_.skin->mesh), {});
        return;
      }
  }

  const Model& model_;
  Frames rest_;
  std::vector<LimbChain> limbs_;
  BodyAxes axes_;
  SkinTrials trials_;
};

double seconds(const std::function<void()>& action) {
  const auto start = std::chrono::steady_clock::now();
  action();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

/// The forearm turned about its bone by a coordinate that is known.
double largestStep(const Model& model, const ChosenSkin& skin) {
  const Frames rest = bindFrames(model);
  const std::vector<LimbChain> limbs = limbChains(model.skeleton);
  const auto arm =
      std::find_if(limbs.begin(), limbs.end(), [](const LimbChain& l) { return l.arm && l.left; });
  if (arm == limbs.end()) return -1.0;
  const int elbow = arm->joints[1];
  const Vector3d axis = (rest[arm->joints[2]].translation() - rest[elbow].translation()).normalized();
  TwistCoordinate twist = coordinateAbout(model.skeleton, rest, elbow, axis);
  if (twist.index < 0 && skin.layered()) return -1.0;
  Eigen::VectorXd q = model.skeleton.rest();
  if (twist.index < 0) twist = {.index = 0, .rest = q[0]};  // as if the joint had one
  PreparedSkin known = skin.prepared();
  for (TwistBone& bone : known.spread.bones)
    bone.own = bone.joint == elbow ? twist : TwistCoordinate{}, bone.ofChild = {};
  SkinnedVertices before, now;
  double largest = 0.0;
  const double step = known.method->kind == SkinMethodKind::DeltaMush ? 1.0 : 0.1;
  for (int i = 0; i <= static_cast<int>(400.0 / step); ++i) {
    const double angle = (-200.0 + step * i) * degree;
    q[twist.index] = twist.rest + twist.sign * angle;
    const Frames frames = turned(model.skeleton, rest, elbow, axis, angle);
    if (skin.layered())
      skin.pose(frames, &q, now, SkinNormals::Cheap);
    else
      blendSkin(known, poseBones(known, frames, &q), now, SkinNormals::Cheap);
    for (std::size_t v = 0; v < before.positions.size(); ++v)
      largest = std::max(largest, (now.positions[v] - before.positions[v]).norm());
    std::swap(before, now);
  }
  return 1e3 * largest * 0.1 / step;
}

/// What every pose is measured against, made once for a body.
struct Ruler {
  const Mesh& mesh;
  MeshEdges edges = innerEdges(mesh);
  std::vector<double> restAngles = edgeAngles(edges, mesh.positions);
  std::vector<std::vector<SkinSection>> sections = {};  ///< of each bone
  SurfaceDistance distance{mesh};

  std::vector<std::array<int, 3>> trianglesOf(const SkinPoseCase& pose) const {
    std::vector<std::array<int, 3>> part;
    for (const auto& t : mesh.triangles)
      if (std::ranges::all_of(t, [&](int v) { return isInPart(pose, v); })) part.push_back(t);
    return part;
  }
  bool isInPart(const SkinPoseCase& pose, int v) const {
    return (mesh.positions[v] - pose.centre).norm() < pose.radius;
  }
};

/// The elastic flesh in a pose.
struct Reference {
  SkinCell cell;
  std::vector<Vector3d> positions;  ///< of the part; elsewhere the bind pose's
  bool valid = false;               ///< the part does not run through itself
};

SkinCell measure(const SkinPoseCase& pose, const Ruler& ruler, const std::vector<Vector3d>& positions,
                 const std::vector<std::array<int, 3>>& triangles, int restPairs) {
  SkinCell cell{.pose = pose.name};
  cell.pairs = static_cast<int>(selfIntersections(positions, triangles).size()) - restPairs;
  cell.crease = crease(ruler.restAngles, edgeAngles(ruler.edges, positions)) / degree;
  for (const int b : pose.bones)
    cell.section = std::min(cell.section, smallestSection(ruler.sections[b], positions));
  const PartVolume part(ruler.mesh, pose.centre, pose.radius);
  if (!part.empty()) cell.volume = part.volume(positions) / part.volume(ruler.mesh.positions) - 1.0;
  return cell;
}

void measureNormals(const PreparedSkin& prepared, const SkinPoseCase& pose, const SkinnedVertices& at,
                    SkinCell& cell) {
  const std::vector<double> errors = normalErrors(prepared.skin.mesh, at.positions, at.normals);
  std::vector<double> blended;
  for (std::size_t v = 0; v < errors.size(); ++v)
    if (prepared.skin.influences[v].weights[1] > 0.0 &&
        (prepared.skin.mesh.positions[v] - pose.centre).norm() < pose.radius)
      blended.push_back(errors[v] / degree);
  if (blended.empty()) return;
  double sum = 0.0;
  for (const double e : blended) sum += e;
  cell.normalMean = sum / static_cast<double>(blended.size());
  const auto most =
      blended.begin() + static_cast<std::ptrdiff_t>(0.95 * static_cast<double>(blended.size() - 1));
  std::nth_element(blended.begin(), most, blended.end());
  cell.normalMost = *most;
}

/// The flesh of every pose that turns a limb, in steps of at most six degrees; poses of one joint share it.
std::vector<std::optional<Reference>> elasticReferences(
    const Model& model, const SkinTrials& trials, const Ruler& ruler,
    const std::function<void(double, const std::string&)>& progress) {
  const Frames rest = bindFrames(model);
  std::vector<std::optional<Reference>> all(trials.poses.size());
  std::map<std::tuple<int, int, double>, std::unique_ptr<ElasticFlesh>> fleshes;
  for (std::size_t p = 0; p < all.size(); ++p) {
    const SkinPoseCase& pose = trials.poses[p];
    if (pose.turn.joint < 0 || pose.bones.empty()) continue;
    progress(static_cast<double>(p) / static_cast<double>(all.size()), "elastic reference, " + pose.name);
    std::vector<FleshBone> bones = trials.rigid;
    std::erase_if(bones, [&](const FleshBone& bone) { return bone.joint == pose.freeBone; });
    auto& flesh = fleshes[{pose.turn.joint, pose.freeBone, pose.radius}];
    if (!flesh)
      flesh = std::make_unique<ElasticFlesh>(ruler.mesh, bones, pose.centre, 1.5 * pose.radius + 0.03);
    flesh->reset();
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(pose.turn.angle) / (6.0 * degree))));
    std::vector<Eigen::Isometry3d> motions(rest.size());
    for (int i = 1; i <= steps; ++i) {
      const Frames now =
          turned(model.skeleton, rest, pose.turn.joint, pose.turn.axis, pose.turn.angle * i / steps);
      for (std::size_t j = 0; j < rest.size(); ++j) motions[j] = now[j] * rest[j].inverse(Eigen::Isometry);
      flesh->follow(motions, i < steps ? 8 : 80);
    }
    Reference& reference = all[p].emplace();
    reference.positions = ruler.mesh.positions;
    flesh->carry(reference.positions);
    const auto triangles = ruler.trianglesOf(pose);
    reference.cell = measure(pose, ruler, reference.positions, triangles,
                             static_cast<int>(selfIntersections(ruler.mesh.positions, triangles).size()));
    reference.cell.method = "elastic reference";
    reference.valid = reference.cell.pairs <= 0;
  }
  return all;
}

}  // namespace

SkinTrials standardTrials(const Model& model) { return TrialMaker(model).standard(); }
SkinTrials motionTrials(const Model& model, const MotionClip& clip, int count) {
  return TrialMaker(model).motion(clip, count);
}

SkinComparison compareSkins(const Model& model, const std::vector<SkinChoice>& methods,
                            const SkinTrials& trials, bool timing, bool reference,
                            const std::function<void(double, const std::string&)>& progress,
                            const std::function<void(const SkinChoice&, const SkinPoseCase&, const Mesh&,
                                                     const SkinnedVertices&)>& picture) {
  const Mesh& mesh = model.skin->mesh;
  Ruler ruler{.mesh = mesh};
  const int restPairs = static_cast<int>(selfIntersections(mesh.positions, mesh.triangles).size());
  for (const SkinBone& bone : trials.bones)
    ruler.sections.push_back(sectionsAlong(mesh, bone.head, bone.end, 19));
  SkinComparison out{.methods = methods, .cells = {}, .costs = {}, .reference = {}};
  std::vector<std::optional<Reference>> references(trials.poses.size());
  if (reference) references = elasticReferences(model, trials, ruler, progress);
  for (const auto& r : references)
    if (r) out.reference.push_back(r->cell);
  std::vector<ChosenSkin> skins;
  for (const SkinChoice& choice : methods) {
    SkinCost cost{.method = toString(choice), .bytes = skinMethod(choice.method).bytesAVertex};
    progress(0.0, "preparing " + cost.method);
    cost.prepareSeconds = seconds([&] { skins.emplace_back(model, *model.skin, choice); });
    if (skins.back().layered()) cost.bytes += 36;  // u, v, w, W, the rest normal, rows
    out.costs.push_back(cost);
  }
  const double all = static_cast<double>(methods.size() * trials.poses.size());
  SkinnedVertices at;
  for (std::size_t m = 0; m < methods.size(); ++m)
    for (std::size_t p = 0; p < trials.poses.size(); ++p) {
      const SkinPoseCase& pose = trials.poses[p];
      progress(static_cast<double>(m * trials.poses.size() + p) / all,
               out.costs[m].method + ", " + pose.name);
      skins[m].pose(pose.frames, pose.q.size() ? &pose.q : nullptr, at);
      SkinCell cell = measure(pose, ruler, at.positions, mesh.triangles, restPairs);
      measureNormals(skins[m].prepared(), pose, at, cell);
      cell.method = out.costs[m].method;
      if (const auto& r = references[p]; r && r->valid) {
        cell.volumeOff = std::abs(cell.volume - r->cell.volume);
        double sum = 0.0;
        int count = 0;
        for (int v = 0; v < static_cast<int>(at.positions.size()); ++v)
          if (ruler.isInPart(pose, v))
            sum += std::pow(ruler.distance.of(at.positions[v], v, r->positions), 2), ++count;
        if (count > 0) cell.distance = std::sqrt(sum / count);
      }
      out.cells.push_back(std::move(cell));
      if (picture) picture(methods[m], pose, mesh, at);
    }
  if (!timing || trials.poses.empty()) return out;

  const SkinPoseCase& pose = trials.poses[trials.poses.size() / 2];
  const auto run = [&](const ChosenSkin& skin, SkinNormals normals) {
    return seconds([&] { skin.pose(pose.frames, nullptr, at, normals); });
  };
  constexpr int rounds = 25;
  std::vector<std::vector<double>> exact(methods.size()), cheap(methods.size());
  std::vector<double> plain;
  for (int round = 0; round < rounds; ++round) {
    progress(static_cast<double>(round) / rounds, "timing");
    // The plain linear blend of this program, positions and normals, is what others are compared with.
    plain.push_back(seconds([&] { linearBlendSkin(*model.skin, pose.frames, at); }));
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const bool slow = methods[m].method == SkinMethodKind::DeltaMush && round > 2;  // a twentyfold solve
      if (slow) continue;
      exact[m].push_back(run(skins[m], SkinNormals::Gradients));
      cheap[m].push_back(run(skins[m], SkinNormals::Cheap));
    }
  }
  const double unit = median(plain);
  for (std::size_t m = 0; m < methods.size(); ++m) {
    progress(static_cast<double>(m) / static_cast<double>(methods.size()), "steps of " + out.costs[m].method);
    out.costs[m].timesLbs = median(exact[m]) / unit;
    out.costs[m].timesLbsCheap = median(cheap[m]) / unit;
    out.costs[m].nanoseconds = 1e9 * median(cheap[m]) / static_cast<double>(mesh.positions.size());
    out.costs[m].largestStep = largestStep(model, skins[m]);
  }
  return out;
}

std::string toCsv(const std::vector<SkinCell>& cells) {
  std::string csv =
      "method,pose,pairs,crease_deg,smallest_section,volume_change,normal_mean_deg,normal_95_deg,"
      "volume_off_reference,distance_to_reference_mm\n";
  for (const SkinCell& c : cells)
    csv += fmt::format("{},{},{},{:.3f},{:.4f},{:.5f},{:.3f},{:.3f},{},{}\n", c.method, c.pose, c.pairs,
                       c.crease, c.section, c.volume, c.normalMean, c.normalMost,
                       c.volumeOff ? fmt::format("{:.5f}", *c.volumeOff) : "",
                       c.distance ? fmt::format("{:.3f}", 1e3 * *c.distance) : "");
  return csv;
}

std::string toCsv(const std::vector<SkinCost>& costs) {
  std::string csv =
      "method,prepare_s,times_lbs_gradient_normals,times_lbs_cheap_normals,ns_a_vertex,bytes_a_vertex,"
      "largest_step_mm_per_0.1_deg\n";
  for (const SkinCost& c : costs) {
    const auto timed = [&](double value) { return c.timesLbs > 0.0 ? fmt::format("{:.2f}", value) : ""; };
    csv += fmt::format("{},{:.3f},{},{},{},{},{}\n", c.method, c.prepareSeconds, timed(c.timesLbs),
                       timed(c.timesLbsCheap), timed(c.nanoseconds), c.bytes,
                       c.largestStep < 0.0 ? "" : fmt::format("{:.3f}", c.largestStep));
  }
  return csv;
}

}  // namespace gelenk
