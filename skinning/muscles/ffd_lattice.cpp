#include "skinning/muscles/ffd_lattice.h"

namespace gelenk {

using Eigen::Vector3d;
using Eigen::Vector4d;

namespace {

using PointColumns = Eigen::Matrix<double, 3, 64>;

Eigen::Map<const PointColumns> columns(const std::array<Vector3d, 64>& points) {
  return Eigen::Map<const PointColumns>(points[0].data());
}

}  // namespace

FfdSample FfdLattice::evaluate(const Vector3d& uvw) const {
  const Vector4d bu = bernstein(uvw.x()), bv = bernstein(uvw.y()), bw = bernstein(uvw.z());
  const Vector4d du = bernsteinDerivative(uvw.x()), dv = bernsteinDerivative(uvw.y()),
                 dw = bernsteinDerivative(uvw.z());
  const auto P = columns(points);
  FfdSample sample{Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  for (int k = 0; k < 4;
       ++k) {  // contract u, then v, then w: 16 + 4 + 1 short sums instead of 64 products of three
    Vector3d plane = Vector3d::Zero(), planeU = Vector3d::Zero(), planeV = Vector3d::Zero();
    for (int j = 0; j < 4; ++j) {
      const auto row = P.middleCols<4>(16 * k + 4 * j);
      const Vector3d along = row * bu;
      plane += bv[j] * along;
      planeV += dv[j] * along;
      planeU += bv[j] * (row * du);
    }
    sample.position += bw[k] * plane;
    sample.derivatives.col(0) += bw[k] * planeU;
    sample.derivatives.col(1) += bw[k] * planeV;
    sample.derivatives.col(2) += dw[k] * plane;
  }
  return sample;
}

Vector3d FfdLattice::position(const Vector3d& uvw) const {
  const Vector4d bu = bernstein(uvw.x()), bv = bernstein(uvw.y()), bw = bernstein(uvw.z());
  const auto P = columns(points);
  Vector3d position = Vector3d::Zero();
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j) position += bw[k] * bv[j] * (P.middleCols<4>(16 * k + 4 * j) * bu);
  return position;
}

FfdLattice latticeOf(const std::array<FfdPlane, 4>& planes) {
  FfdLattice lattice;
  for (int k = 0; k < 4; ++k)
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) lattice.points[16 * k + 4 * j + i] = planes[k].point(i / 3.0, j / 3.0);
  return lattice;
}

}  // namespace gelenk
