#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>

namespace gelenk {

/// A deformed point and the first derivatives of the deformation with respect to the lattice parameters.
struct FfdSample {
  Eigen::Vector3d position;
  Eigen::Matrix3d derivatives;  ///< columns d/du, d/dv, d/dw
};

/// One control plane whose 4 x 4 points are an affine image of the section rectangle, point(u, v) = origin +
/// axes (u, v). Metres; u, v in [0, 1] span the rectangle.
struct FfdPlane {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();

  Eigen::Vector3d point(double u, double v) const { return origin + axes * Eigen::Vector2d(u, v); }
};

/// A tri-cubic Bezier volume, the free-form deformation of Sederberg and Parry 1986:
///     x(u, v, w) = sum_ijk B_i(u) B_j(v) B_k(w) P_ijk,   B_i the cubic Bernstein polynomials.
/// Plane k holds the 16 points with the same k, w runs along the bone. Parameters outside [0, 1] extrapolate
/// the polynomial.
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

/// The same volume evaluated without its 64 points: Bernstein polynomials reproduce affine functions, so the
/// tri-cubic collapses to x = sum_k B_k(w) plane_k(u, v). Several times cheaper, and an independent route for
/// tests.
inline FfdSample evaluateAffine(const FfdPlane* plane, const Eigen::Vector3d& uvw) {
  const Eigen::Vector4d b = bernstein(uvw.z()), d = bernsteinDerivative(uvw.z());
  Eigen::Matrix<double, 3, 2> axes = Eigen::Matrix<double, 3, 2>::Zero();  // d/du, d/dv
  double x[3] = {}, xw[3] = {};
  for (int k = 0; k < 4; ++k) {
    axes += b[k] * plane[k].axes;
    const double *origin = plane[k].origin.data(), *u = plane[k].axes.data(), *v = u + 3;
    for (int i = 0; i < 3; ++i) {  // the plane's point at u, v
      const double point = origin[i] + uvw.x() * u[i] + uvw.y() * v[i];
      x[i] += b[k] * point;
      xw[i] += d[k] * point;
    }
  }
  FfdSample sample;  // filled once: sums kept in it would go through memory for every plane
  sample.position << x[0], x[1], x[2];
  sample.derivatives << axes(0, 0), axes(0, 1), xw[0], axes(1, 0), axes(1, 1), xw[1], axes(2, 0), axes(2, 1),
      xw[2];
  return sample;
}

/// Normal of a surface embedded in the volume, J^-T m made unit, with m = J_rest^T n_rest. By cofactors, in
/// two cross products: m_u v x w + m_v w x u + m_w u x v = v x (m_u w - m_w u) + m_v w x u.
inline Eigen::Vector3d deformedNormal(const FfdSample& at, const Eigen::Vector3d& m) {
  const Eigen::Vector3d u = at.derivatives.col(0), v = at.derivatives.col(1), w = at.derivatives.col(2);
  const Eigen::Vector3d normal = v.cross(m.x() * w - m.z() * u) + m.y() * w.cross(u);
  return normal.normalized();
}

}  // namespace gelenk
