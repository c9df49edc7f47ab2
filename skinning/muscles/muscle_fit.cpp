#include "skinning/muscles/muscle_fit.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace gelenk {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

int parametersOfPlane(MuscleFreedom freedom) {
  return freedom == MuscleFreedom::Scale ? 3 : freedom == MuscleFreedom::ScaleAndOffset ? 5 : 48;
}

/// The state of one plane whose parameter p alone is 1 (and the stretch's identity taken away).
MusclePlane unitChange(int p, MuscleFreedom freedom) {
  MusclePlane plane;
  if (freedom == MuscleFreedom::FreePoints) {
    plane.displacement.assign(16, Vector3d::Zero());
    plane.displacement[p / 3][p % 3] = 1.0;
    return plane;
  }
  if (p == 0) plane.stretch(0, 0) += 1.0;
  if (p == 1) plane.stretch(1, 1) += 1.0;
  if (p == 2) plane.stretch(0, 1) = plane.stretch(1, 0) = 1.0;
  if (p >= 3) plane.offset[p - 3] = 1.0;
  return plane;
}

void add(MusclePlane& plane, const MusclePlane& unit, double amount) {
  plane.stretch += amount * (unit.stretch - Eigen::Matrix2d::Identity());
  plane.offset += amount * unit.offset;
  if (unit.displacement.empty()) return;
  if (plane.displacement.empty()) plane.displacement.assign(16, Vector3d::Zero());
  for (int c = 0; c < 16; ++c) plane.displacement[c] += amount * unit.displacement[c];
}

MusclePlane& planeOf(std::vector<MuscleState>& states, int index) {
  return index % 2 == 0 ? states[index / 2].plane2 : states[index / 2].plane4;
}

}  // namespace

MuscleFit fitMuscle(const MuscleSkin& body, int limb, const Frames& restFrames,
                    const std::vector<Vector3d>& displacement, MuscleFreedom freedom) {
  std::vector<int> sculpted;
  for (std::size_t v = 0; v < body.vertices.size(); ++v)
    if (body.vertices[v].limb == limb && body.vertices[v].volume >= 0 && displacement[v].norm() > 0.0)
      sculpted.push_back(static_cast<int>(v));
  MuscleFit fit;
  fit.vertices = static_cast<int>(sculpted.size());
  const LimbShape& shape = body.limbs[limb].shape;
  fit.states.resize(shape.links.size());
  if (sculpted.empty()) return fit;

  const LimbFrames frames = limbFrames(body.limbs[limb], restFrames);
  const auto positions = [&](const std::vector<MuscleState>& states) {
    const LimbPose pose = poseLimb(shape, frames, states);
    VectorXd x(3 * sculpted.size());
    for (std::size_t i = 0; i < sculpted.size(); ++i) {
      const LimbVertex& vertex = body.vertices[sculpted[i]];
      x.segment<3>(3 * i) = pose.position(vertex.volume, vertex.uvw);
    }
    return x;
  };

  const int planes = 2 * static_cast<int>(shape.links.size()), each = parametersOfPlane(freedom);
  const VectorXd rest = positions(fit.states);
  MatrixXd A(rest.size(), planes * each);  // one column a parameter: the deformation is linear in them
  for (int p = 0; p < planes; ++p)
    for (int k = 0; k < each; ++k) {
      std::vector<MuscleState> states(shape.links.size());
      planeOf(states, p) = unitChange(k, freedom);
      A.col(p * each + k) = positions(states) - rest;
    }
  VectorXd wanted(rest.size());
  for (std::size_t i = 0; i < sculpted.size(); ++i) wanted.segment<3>(3 * i) = displacement[sculpted[i]];

  MatrixXd normal = A.transpose() * A;
  const double ridge = (freedom == MuscleFreedom::FreePoints ? 1e-6 : 1e-12) * normal.diagonal().mean();
  normal.diagonal().array() += ridge;
  const VectorXd solution = normal.ldlt().solve(A.transpose() * wanted);
  for (int p = 0; p < planes; ++p)
    for (int k = 0; k < each; ++k)
      add(planeOf(fit.states, p), unitChange(k, freedom), solution[p * each + k]);
  fit.residual = (A * solution - wanted).norm() / wanted.norm();
  return fit;
}

}  // namespace gelenk
