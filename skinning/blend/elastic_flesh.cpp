#include "skinning/blend/elastic_flesh.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace gelenk {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Cell = std::array<int, 3>;

constexpr double volumeStiffness = 3.0;  // against 1 of shape
constexpr double grip = 1e-10;           // metres: crumbs without a bone stay where they are

/// Where lines along z cross the surface, by column of cubes: (z, +1 entering the body from below or -1).
class Columns {
 public:
  Columns(const Mesh& mesh, double cell) : cell_(cell) {
    for (const auto& t : mesh.triangles) {
      const Vector3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      const double twice = (b.x() - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (b.y() - a.y());
      if (twice == 0.0) continue;
      const auto first = [&](double x) { return static_cast<int>(std::floor(x / cell - 0.5)); };
      const Vector3d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
      for (int i = first(low.x()); i <= first(high.x()) + 1; ++i)
        for (int j = first(low.y()); j <= first(high.y()) + 1; ++j) {
          const double x = middle(i), y = middle(j);
          const double v = ((x - a.x()) * (c.y() - a.y()) - (c.x() - a.x()) * (y - a.y())) / twice,
                       w = ((b.x() - a.x()) * (y - a.y()) - (x - a.x()) * (b.y() - a.y())) / twice;
          if (v < 0.0 || w < 0.0 || v + w > 1.0) continue;
          of_[{i, j}].emplace_back(a.z() + v * (b.z() - a.z()) + w * (c.z() - a.z()), twice > 0.0 ? -1 : 1);
        }
    }
  }
  bool inside(const Cell& cell) const {
    const auto found = of_.find({cell[0], cell[1]});
    int winding = 0;
    if (found != of_.end())
      for (const auto& [z, sign] : found->second)
        if (z < middle(cell[2])) winding += sign;
    return winding > 0;
  }

 private:
  /// Of a cube, off its centre by a little: no line then meets an edge of a regular mesh.
  double middle(int i) const { return (i + 0.5 + 1.7e-5) * cell_; }
  double cell_;
  std::map<std::pair<int, int>, std::vector<std::pair<double, int>>> of_;
};

double distanceToSegment(const Vector3d& p, const FleshBone& bone) {
  const Vector3d along = bone.end - bone.head;
  const double square = along.squaredNorm();
  const double s = square > 0.0 ? std::clamp((p - bone.head).dot(along) / square, 0.0, 1.0) : 0.0;
  return (p - bone.head - s * along).norm();
}

/// R + 3 P: the nearest rotation and the nearest matrix of determinant 1.
Matrix3d wanted(const Matrix3d& F) {
  Eigen::SelfAdjointEigenSolver<Matrix3d> eigen;
  eigen.computeDirect(F.transpose() * F);  // squares of the stretches, ascending
  const Matrix3d V = eigen.eigenvectors();
  Matrix3d U;
  for (const int k : {2, 1}) U.col(k) = (F * V.col(k)).normalized();
  U.col(1) = (U.col(1) - U.col(2).dot(U.col(1)) * U.col(2)).normalized();
  U.col(0) = U.col(1).cross(U.col(2)) * (V.determinant() > 0.0 ? 1.0 : -1.0);
  const Vector3d stretch = (U.transpose() * F * V).diagonal();  // the smallest is negative where turned over
  Vector3d s = stretch;
  for (int k = 0; k < 8; ++k) {  // Newton on the product, along its gradient
    const Vector3d slope(s.y() * s.z(), s.x() * s.z(), s.x() * s.y());
    s = stretch + (slope.dot(s - stretch) - (s.prod() - 1.0)) / std::max(slope.squaredNorm(), 1e-6) * slope;
  }
  return U * (Vector3d::Ones() + volumeStiffness * s).asDiagonal() * V.transpose();
}

/// Five tetrahedra of a cube; its neighbours have the mirrored ones.
constexpr int fiveOfCube[5][4] = {{0, 3, 5, 6}, {1, 0, 3, 5}, {2, 0, 3, 6}, {4, 0, 5, 6}, {7, 3, 5, 6}};

}  // namespace

ElasticFlesh::ElasticFlesh(const Mesh& rest, const std::vector<FleshBone>& bones, const Vector3d& centre,
                           double radius, double cell, double rigid) {
  const auto cellAt = [&](const Vector3d& p) {
    return Cell{static_cast<int>(std::floor(p.x() / cell)), static_cast<int>(std::floor(p.y() / cell)),
                static_cast<int>(std::floor(p.z() / cell))};
  };
  std::map<Cell, int> cells, nodes;
  const auto node = [&](const Cell& at) {
    return nodes.try_emplace(at, static_cast<int>(nodes.size())).first->second;
  };
  const auto addCell = [&](const Cell& at) {
    const auto [found, fresh] = cells.try_emplace(at, static_cast<int>(cells.size()));
    if (!fresh) return found->second;
    std::array<int, 8> corners;
    for (int c = 0; c < 8; ++c) corners[c] = node({at[0] + (c & 1), at[1] + (c >> 1 & 1), at[2] + (c >> 2)});
    cells_.push_back(corners);
    return found->second;
  };
  const Columns columns(rest, cell);
  const Cell low = cellAt(centre - Vector3d::Constant(radius)),
             high = cellAt(centre + Vector3d::Constant(radius));
  for (int i = low[0]; i <= high[0]; ++i)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int k = low[2]; k <= high[2]; ++k)
        if ((cell * (Vector3d(i, j, k) + Vector3d::Constant(0.5)) - centre).norm() < radius &&
            columns.inside({i, j, k}))
          addCell({i, j, k});
  for (std::size_t v = 0; v < rest.positions.size(); ++v) {
    const Vector3d& p = rest.positions[v];
    if ((p - centre).norm() >= radius) continue;
    const Cell at = cellAt(p);
    anchors_.push_back({static_cast<int>(v), addCell(at), p / cell - Vector3d(at[0], at[1], at[2])});
  }

  const int count = static_cast<int>(nodes.size());
  rest_.resize(count, 3);
  joint_.assign(count, -1);
  for (const auto& [at, n] : nodes) {
    const Vector3d p = cell * Vector3d(at[0], at[1], at[2]);
    rest_.row(n) = p;
    double nearest = rigid;
    for (const FleshBone& bone : bones)
      if (const double d = distanceToSegment(p, bone); d < nearest) nearest = d, joint_[n] = bone.joint;
  }
  now_ = rest_;
  int unknowns = 0, fixed = 0;
  for (const int joint : joint_) unknown_.push_back(joint < 0 ? unknowns++ : -1 - fixed++);
  if (fixed == 0) throw std::invalid_argument("no bone lies in this part of the body");

  std::vector<Eigen::Triplet<double>> freeFree, freeFixed;
  for (const auto& [at, c] : cells)
    for (const auto& corners : fiveOfCube) {
      Tetrahedron t;
      Matrix3d edges;
      const int mirror = (at[0] + at[1] + at[2]) & 1;
      for (int k = 0; k < 4; ++k) t.nodes[k] = cells_[c][corners[k] ^ mirror];
      for (int k = 0; k < 3; ++k)
        edges.col(k) = (rest_.row(t.nodes[k + 1]) - rest_.row(t.nodes[0])).transpose();
      t.volume = std::abs(edges.determinant()) / 6.0;
      t.gradients.bottomRows<3>() = edges.inverse();
      t.gradients.row(0) = -t.gradients.bottomRows<3>().colwise().sum();
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) {
          const int row = unknown_[t.nodes[a]], column = unknown_[t.nodes[b]];
          const double value =
              (1.0 + volumeStiffness) * t.volume * t.gradients.row(a).dot(t.gradients.row(b));
          if (row < 0) continue;
          if (column >= 0)
            freeFree.emplace_back(row, column, value);
          else
            freeFixed.emplace_back(row, -1 - column, value);
        }
      tetrahedra_.push_back(t);
    }
  for (int n = 0; n < unknowns; ++n) freeFree.emplace_back(n, n, grip);
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(freeFree.begin(), freeFree.end());
  freeFromFixed_.resize(unknowns, fixed);
  freeFromFixed_.setFromTriplets(freeFixed.begin(), freeFixed.end());
  solver_.compute(matrix);
  if (solver_.info() != Eigen::Success) throw std::runtime_error("the flesh could not be factorised");
}

void ElasticFlesh::follow(const std::vector<Eigen::Isometry3d>& worldFromRest, int iterations) {
  const int unknowns = static_cast<int>(solver_.rows());
  Places fixed(static_cast<int>(joint_.size()) - unknowns, 3);
  for (std::size_t n = 0; n < joint_.size(); ++n)
    if (joint_[n] >= 0) {
      now_.row(n) = worldFromRest[joint_[n]] * Vector3d(rest_.row(n).transpose());
      fixed.row(-1 - unknown_[n]) = now_.row(n);
    }
  const Places pulled = freeFromFixed_ * fixed;
  for (int k = 0; k < iterations; ++k) {
    Places right = -pulled;
    for (std::size_t n = 0; n < joint_.size(); ++n)
      if (joint_[n] < 0) right.row(unknown_[n]) += grip * rest_.row(n);
    for (const Tetrahedron& t : tetrahedra_) {
      Matrix3d F = Matrix3d::Zero();
      for (int a = 0; a < 4; ++a) F += now_.row(t.nodes[a]).transpose() * t.gradients.row(a);
      const Matrix3d push = t.volume * wanted(F);
      for (int a = 0; a < 4; ++a)
        if (const int row = unknown_[t.nodes[a]]; row >= 0)
          right.row(row) += (push * t.gradients.row(a).transpose()).transpose();
    }
    const Places solved = solver_.solve(right);
    for (std::size_t n = 0; n < joint_.size(); ++n)
      if (joint_[n] < 0) now_.row(n) = solved.row(unknown_[n]);
  }
}

void ElasticFlesh::carry(std::vector<Vector3d>& positions) const {
  for (const Anchor& anchor : anchors_) {
    Vector3d sum = Vector3d::Zero();
    for (int c = 0; c < 8; ++c) {
      double share = 1.0;
      for (int k = 0; k < 3; ++k) share *= c >> k & 1 ? anchor.share[k] : 1.0 - anchor.share[k];
      sum += share * now_.row(cells_[anchor.cell][c]).transpose();
    }
    positions[anchor.vertex] = sum;
  }
}

}  // namespace gelenk
