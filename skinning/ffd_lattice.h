#pragma once

#include <Eigen/Core>
#include <array>

namespace gelenk {

/// A deformed point and the first derivatives of the deformation with respect to the lattice parameters.
struct FfdSample {
  Eigen::Vector3d position;
  Eigen::Matrix3d derivatives;  ///< columns d/du, d/dv, d/dw
};

/// One control plane whose 4 x 4 points are an affine image of the section rectangle, point(u, v) = origin + axes (u, v).
/// Metres; u, v in [0, 1] span the rectangle.
struct FfdPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();

  Eigen::Vector3d point(double u, double v) const { return origin + axes * Eigen::Vector2d(u, v); }
};

/// A tri-cubic Bezier volume, the free-form deformation of Sederberg and Parry 1986:
///     x(u, v, w) = sum_ijk B_i(u) B_j(v) B_k(w) P_ijk,   B_i the cubic Bernstein polynomials.
/// Plane k holds the 16 points with the same k, w runs along the bone. Parameters outside [0, 1] extrapolate the polynomial.
struct FfdLattice {
  std::array<Eigen::Vector3d, 64> points;  ///< index 16 k + 4 j + i

  FfdSample evaluate(const Eigen::Vector3d& uvw) const;
  Eigen::Vector3d position(const Eigen::Vector3d& uvw) const;
};

/// The lattice of four affine planes.
FfdLattice latticeOf(const std::array<FfdPlane, 4>& planes);

/// Cubic Bernstein polynomials at t, and their derivatives.
inline Eigen::Vector4d bernstein(double t) {
  const double s = 1.0 - t;
  return {s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t};
}
inline Eigen::Vector4d bernsteinDerivative(double t) {
  const double s = 1.0 - t;
  return {-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t};
}

/// The same volume evaluated without its 64 points: Bernstein polynomials reproduce affine functions, so the tri-cubic
/// collapses to x = sum_k B_k(w) plane_k(u, v). Several times cheaper, and an independent route for tests.
inline FfdSample evaluateAffine(const FfdPlane* plane, const Eigen::Vector3d& uvw) {
  const Eigen::Vector4d b = bernstein(uvw.z()), d = bernsteinDerivative(uvw.z());
  double blend[9] = {}, slope[9] = {};  // origin, axis u, axis v: plain loops, which vectorise
  for (int k = 0; k < 4; ++k) {
    const double *origin = plane[k].origin.data(), *axes = plane[k].axes.data();
    for (int i = 0; i < 3; ++i) {
      blend[i] += b[k] * origin[i];
      slope[i] += d[k] * origin[i];
    }
    for (int i = 0; i < 6; ++i) {
      blend[i + 3] += b[k] * axes[i];
      slope[i + 3] += d[k] * axes[i];
    }
  }
  FfdSample sample;
  for (int i = 0; i < 3; ++i) {
    sample.position[i] = blend[i] + blend[i + 3] * uvw.x() + blend[i + 6] * uvw.y();
    sample.derivatives(i, 0) = blend[i + 3];
    sample.derivatives(i, 1) = blend[i + 6];
    sample.derivatives(i, 2) = slope[i] + slope[i + 3] * uvw.x() + slope[i + 6] * uvw.y();
  }
  return sample;
}

}  // namespace gelenk
