#include "skinning/cotangent.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace gelenk {

using Eigen::Vector3d;
using Eigen::VectorXd;
using SparseMatrix = Eigen::SparseMatrix<double>;

SparseMatrix cotangentMatrix(const Mesh& mesh, VectorXd& areas) {
  const int n = static_cast<int>(mesh.positions.size());
  areas = VectorXd::Zero(n);
  std::vector<Eigen::Triplet<double>> entries;
  entries.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    const double doubleArea = (mesh.positions[t[1]] - mesh.positions[t[0]])
                                  .cross(mesh.positions[t[2]] - mesh.positions[t[0]])
                                  .norm();
    for (int k = 0; k < 3; ++k) {
      const int apex = t[k], i = t[(k + 1) % 3], j = t[(k + 2) % 3];
      areas[apex] += doubleArea / 6.0;
      const Vector3d u = mesh.positions[i] - mesh.positions[apex],
                     v = mesh.positions[j] - mesh.positions[apex];
      const double cotangent = u.dot(v) / std::max(doubleArea, 1e-9 * (u.squaredNorm() + v.squaredNorm()));
      entries.emplace_back(std::max(i, j), std::min(i, j), 0.5 * cotangent);
    }
  }
  SparseMatrix weights(n, n);  // lower triangle
  weights.setFromTriplets(entries.begin(), entries.end());
  VectorXd diagonal = VectorXd::Zero(n);
  for (int column = 0; column < n; ++column)
    for (SparseMatrix::InnerIterator it(weights, column); it; ++it) {
      it.valueRef() = -std::max(it.value(), 0.0);
      diagonal[it.row()] -= it.value();
      diagonal[it.col()] -= it.value();
    }
  SparseMatrix onDiagonal(n, n);
  onDiagonal.reserve(Eigen::VectorXi::Ones(n));
  for (int i = 0; i < n; ++i) onDiagonal.insert(i, i) = diagonal[i];
  return weights + onDiagonal;
}

}  // namespace gelenk
