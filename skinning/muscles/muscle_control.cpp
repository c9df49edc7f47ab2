#include "skinning/muscles/muscle_control.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace gelenk {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// Radius that stands for the limb's thickness: a quarter of the section's width plus height.
double limbRadius(const LimbShape& shape) { return 0.25 * (shape.sectionUpper - shape.sectionLower).sum(); }

double bendFraction(double theta, double rest, double full) {
  const double whole = 1.0 - std::cos(full - rest);
  return whole > 1e-9 ? std::clamp((1.0 - std::cos(theta - rest)) / whole, 0.0, 1.5) : 0.0;
}

MusclePlane bulge(double inner, double outer, double radius) {
  MusclePlane plane;
  plane.stretch.diagonal() << 1.0 + inner + outer, 1.0 + 0.25 * (inner + outer);
  plane.offset = Vector2d((inner - outer) * radius, 0.0);
  return plane;
}

}  // namespace

MuscleControl defaultMuscleControl(const Limb& limb) {
  MuscleControl control;
  for (std::size_t i = 0; i + 1 < limb.joints.size(); ++i)
    control.curves.push_back(i == 0 ? MuscleCurve{} : MuscleCurve{.flexor = 0.04, .extensor = 0.02});
  control.sculpted.resize(control.curves.size());
  return control;
}

MuscleControl noMuscleControl(const Limb& limb) {
  MuscleControl control = defaultMuscleControl(limb);
  for (MuscleCurve& curve : control.curves) curve = {.flexor = 0.0, .extensor = 0.0};
  control.keepVolume = false;
  return control;
}

std::vector<MuscleState> muscleStates(const Limb& limb, const LimbFrames& frames,
                                      const MuscleControl& control) {
  const int links = static_cast<int>(limb.shape.links.size());
  std::vector<MuscleState> states(links);
  const double radius = limbRadius(limb.shape);
  for (int i = 0; i < links; ++i) {
    const MuscleCurve curve = i < static_cast<int>(control.curves.size())
                                  ? control.curves[i]
                                  : MuscleCurve{.flexor = 0.0, .extensor = 0.0};
    // The muscles of a link drive the joint at its end; the last link's those that drive the joint at its
    // beginning.
    const int joint = std::min(i + 1, links - 1);
    double fraction = 0.0;
    if (joint >= 1)
      fraction = bendFraction(jointBend(frames, joint).bend, limb.bendAtRest[joint - 1], curve.fullBend);
    const double inner = curve.flexor * (fraction + control.activation);
    const double outer = curve.extensor * (control.activation - fraction);
    states[i].plane2 = states[i].plane4 = bulge(inner, outer, radius);
    MusclePlane& nextToJoint = joint == i + 1 ? states[i].plane4 : states[i].plane2;
    nextToJoint = bulge(curve.nearJoint * inner, curve.nearJoint * outer, radius);
    nextToJoint.stretch *= 1.0 - curve.tendon * std::min(fraction, 1.0);

    if (i >= static_cast<int>(control.sculpted.size())) continue;
    const auto add = [](MusclePlane& plane, const MusclePlane& edit) {
      plane.stretch = 0.5 * (plane.stretch * edit.stretch + edit.stretch * plane.stretch);
      plane.offset += edit.offset;
      plane.displacement = edit.displacement;
    };
    add(states[i].plane2, control.sculpted[i].plane2);
    add(states[i].plane4, control.sculpted[i].plane4);
  }
  return states;
}

LimbSurface limbSurface(const MuscleSkin& body, int limb) {
  LimbSurface surface;
  std::vector<int> local(body.vertices.size(), -1);
  const auto on = [&](int v) { return body.vertices[v].limb == limb && body.vertices[v].weight > 0.5; };
  std::map<std::pair<int, int>, int> open;  // directed edges without their opposite
  for (const auto& triangle : body.skin.mesh.triangles) {
    if (!on(triangle[0]) || !on(triangle[1]) || !on(triangle[2])) continue;
    std::array<int, 3> mapped;
    for (int k = 0; k < 3; ++k) {
      int& index = local[triangle[k]];
      if (index < 0) {
        index = static_cast<int>(surface.vertices.size());
        surface.vertices.push_back(triangle[k]);
      }
      mapped[k] = index;
    }
    surface.triangles.push_back(mapped);
    for (int k = 0; k < 3; ++k) {
      const std::pair<int, int> edge(mapped[k], mapped[(k + 1) % 3]), opposite(edge.second, edge.first);
      if (const auto found = open.find(opposite); found != open.end())
        open.erase(found);
      else
        open[edge] = 1;
    }
  }
  // Each remaining directed edge a -> b gets a triangle (b, a, apex), one apex a loop.
  if (!open.empty()) {
    std::map<int, int> next;
    for (const auto& [edge, one] : open) next[edge.first] = edge.second;
    while (!next.empty()) {
      const int apex = next.begin()->first;
      int a = apex;
      while (next.count(a)) {
        const int b = next[a];
        next.erase(a);
        if (a != apex && b != apex) surface.triangles.push_back({b, a, apex});
        a = b;
      }
    }
  }
  return surface;
}

namespace {

/// What the bones outside the limb contribute to the surface's vertices; the same for every muscle state.
std::vector<Vector3d> outsidePart(const MuscleSkin& body, const LimbSurface& surface,
                                  const Frames& worldFromJoint) {
  const auto matrices = skinningMatrices(body.skin, worldFromJoint);
  std::vector<Vector3d> part(surface.vertices.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < part.size(); ++i) {
    const Influences& in = body.outside[surface.vertices[i]];
    for (int k = 0; k < 4; ++k)
      if (in.weights[k] > 0.0)
        part[i] += in.weights[k] * (matrices[in.joints[k]] * body.skin.mesh.positions[surface.vertices[i]]);
  }
  return part;
}

double volumeOf(const MuscleSkin& body, const LimbSurface& surface, const std::vector<Vector3d>& outside,
                const LimbPose& pose) {
  std::vector<Vector3d> positions = outside;
  const Vector3d origin = pose.worldFromNearEnd.translation();  // near the surface: less cancellation
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const LimbVertex& vertex = body.vertices[surface.vertices[i]];
    positions[i] += vertex.weight * deformLimbPoint(pose, vertex) - origin;
  }
  double sixfold = 0.0;
  for (const auto& [a, b, c] : surface.triangles)
    sixfold += positions[a].dot(positions[b].cross(positions[c]));
  return sixfold / 6.0;
}

}  // namespace

double limbVolume(const MuscleSkin& body, const LimbSurface& surface, const Frames& worldFromJoint,
                  const LimbPose& pose) {
  return volumeOf(body, surface, outsidePart(body, surface, worldFromJoint), pose);
}

std::vector<MuscleState> scaled(std::vector<MuscleState> states, double s) {
  for (MuscleState& state : states) {
    state.swell *= s;
    for (MusclePlane* plane : {&state.plane2, &state.plane4}) {
      plane->stretch *= s;
      plane->offset *= s;
    }
  }
  return states;
}

VolumeScale volumeKeepingScale(const MuscleSkin& body, int limb, const LimbSurface& surface,
                               const Frames& worldFromJoint, const LimbFrames& frames,
                               const std::vector<MuscleState>& states, double restVolume) {
  if (surface.triangles.empty()) return {1.0, false};
  const LimbShape& shape = body.limbs[limb].shape;
  const std::vector<Vector3d> outside = outsidePart(body, surface, worldFromJoint);
  std::vector<MuscleState> complete = states;
  complete.resize(shape.links.size());
  const auto volume = [&](double s) {
    return volumeOf(body, surface, outside, poseLimb(shape, frames, scaled(complete, s)));
  };
  constexpr double h = 0.2;
  const double below = volume(1.0 - h), at = volume(1.0), above = volume(1.0 + h);
  // V(1 + x) = at + b x + a x^2
  const double a = (above + below - 2.0 * at) / (2.0 * h * h), b = (above - below) / (2.0 * h),
               c = at - restVolume;
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant < 0.0) return {std::clamp(1.0 - b / (2.0 * a), 0.3, 3.0), false};
  // The root nearest zero, without cancellation.
  const double x = -2.0 * c / (b + std::copysign(std::sqrt(discriminant), b));
  if (!std::isfinite(x) || std::abs(x) > 0.7) return {1.0, false};
  return {1.0 + x, true};
}

MuscleRig::MuscleRig(MuscleSkin body, const Frames& restFrames) : body_(std::move(body)) {
  for (int l = 0; l < static_cast<int>(body_.limbs.size()); ++l) {
    const Limb& limb = body_.limbs[l];
    controls_.push_back(defaultMuscleControl(limb));
    surfaces_.push_back(limbSurface(body_, l));
    restVolumes_.push_back(
        limbVolume(body_, surfaces_[l], restFrames, poseLimb(limb.shape, limbFrames(limb, restFrames))));
  }
}

std::vector<LimbPose> MuscleRig::pose(const Frames& worldFromJoint, const Eigen::VectorXd* q) const {
  std::vector<LimbPose> poses;
  for (int l = 0; l < static_cast<int>(body_.limbs.size()); ++l) {
    const Limb& limb = body_.limbs[l];
    const LimbFrames frames = limbFrames(limb, worldFromJoint, q);
    std::vector<MuscleState> states = muscleStates(limb, frames, controls_[l]);
    if (controls_[l].keepVolume) {
      const double s =
          volumeKeepingScale(body_, l, surfaces_[l], worldFromJoint, frames, states, restVolumes_[l]).scale;
      states = scaled(std::move(states), s);
    }
    poses.push_back(poseLimb(limb.shape, frames, states));
  }
  return poses;
}

}  // namespace gelenk
