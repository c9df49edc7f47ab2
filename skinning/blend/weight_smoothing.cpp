#include "skinning/blend/weight_smoothing.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <stdexcept>

#include "skinning/cotangent.h"
#include "skinning/rigging/weight_paint.h"

namespace gelenk {
namespace {

/// Vertices in exactly one place become one: seams of texture coordinates are no borders.
Mesh welded(const Mesh& mesh, std::vector<int>& of) {
  Mesh out;
  std::map<std::array<double, 3>, int> at;
  for (const Eigen::Vector3d& p : mesh.positions) {
    const auto [found, fresh] = at.try_emplace({p.x(), p.y(), p.z()}, static_cast<int>(out.positions.size()));
    if (fresh) out.positions.push_back(p);
    of.push_back(found->second);
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<int, 3> t{of[a], of[b], of[c]};
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) out.triangles.push_back(t);
  }
  return out;
}

/// Four weights that are continuous along the surface: where a fifth bone becomes the fourth, both have lost
/// all that they had, because the fifth largest weight is taken off the others. Dropping it as it is would
/// make a crease there.
void keepFour(std::vector<std::pair<int, double>>& row) {
  if (row.size() <= 4) return;
  std::stable_sort(row.begin(), row.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  const double fifth = row[4].second < row[0].second ? row[4].second : 0.0;  // five alike: no telling
  row.resize(4);
  for (auto& [joint, weight] : row) weight -= fifth;
  std::erase_if(row, [](const auto& entry) { return !(entry.second > 0.0); });
}

/// How far a joint's part of the surface lies from the axis along which it is longest, root mean square.
class PartRadius {
 public:
  void add(const Eigen::Vector3d& p, double area) {
    area_ += area, first_ += area * p, second_ += area * p * p.transpose();
  }
  double value() const {
    if (!(area_ > 0.0)) return 0.0;
    const Eigen::Vector3d mean = first_ / area_;
    const Eigen::Matrix3d spread = second_ / area_ - mean * mean.transpose();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread, Eigen::EigenvaluesOnly);
    return std::sqrt(std::max(spread.trace() - axes.eigenvalues()[2], 0.0));
  }

 private:
  double area_ = 0.0;
  Eigen::Vector3d first_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second_ = Eigen::Matrix3d::Zero();
};

/// Of each vertex the length, or the radius of its joints' parts where that is less.
Eigen::VectorXd lengths(const Mesh& mesh, const std::vector<Influences>& influences,
                        const Eigen::VectorXd& areas, int jointCount, double length) {
  std::vector<PartRadius> parts(jointCount);
  const auto forEach = [&](std::size_t v, auto&& each) {
    for (int k = 0; k < 4; ++k) each(influences[v].joints[k], influences[v].weights[k]);
  };
  for (std::size_t v = 0; v < influences.size(); ++v)
    forEach(v, [&](int joint, double weight) {
      parts[joint].add(mesh.positions[v] - mesh.positions[0], weight * areas[static_cast<Eigen::Index>(v)]);
    });
  std::vector<double> radius;
  for (const PartRadius& part : parts) radius.push_back(part.value());
  Eigen::VectorXd result = Eigen::VectorXd::Zero(areas.size());
  for (std::size_t v = 0; v < influences.size(); ++v) {
    double& own = result[static_cast<Eigen::Index>(v)];
    forEach(v, [&](int joint, double weight) { own += weight * radius[joint]; });
    own = std::min(own, length);
  }
  return result;
}

}  // namespace

Skin smoothWeights(Skin skin, double length) {
  if (!(length >= 0.0) || !std::isfinite(length))
    throw std::invalid_argument("weights are smoothed over a length of 0 or more, not " +
                                std::to_string(length));
  if (length == 0.0) return skin;
  std::vector<int> of;
  const Mesh mesh = welded(skin.mesh, of);
  const int n = static_cast<int>(mesh.positions.size());
  Eigen::VectorXd areas;
  Eigen::SparseMatrix<double> A = cotangentMatrix(mesh, areas);
  const double least = std::max(1e-12 * areas.sum() / n, 1e-300);
  areas = areas.cwiseMax(least);
  std::vector<Influences> influences(n);
  for (std::size_t v = 0; v < of.size(); ++v) influences[of[v]] = skin.influences[v];
  const Eigen::VectorXd over = lengths(mesh, influences, areas, skin.jointCount(), length);
  Eigen::VectorXd diagonal = areas;
  for (int column = 0; column < n; ++column)
    for (Eigen::SparseMatrix<double>::InnerIterator it(A, column); it; ++it) {
      if (it.row() == it.col()) continue;
      it.valueRef() *= 0.25 * over[it.row()] * over[it.col()];
      diagonal[it.row()] -= it.value(), diagonal[it.col()] -= it.value();
    }
  for (int v = 0; v < n; ++v) A.coeffRef(v, v) = diagonal[v];
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(A);
  if (factor.info() != Eigen::Success) throw std::runtime_error("the heat equation could not be factorised");

  std::vector<std::vector<std::pair<int, double>>> rows(n);
  for (int joint = 0; joint < skin.jointCount(); ++joint) {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(n);
    for (std::size_t v = 0; v < of.size(); ++v)
      for (int k = 0; k < 4; ++k)
        if (skin.influences[v].joints[k] == joint && skin.influences[v].weights[k] > 0.0)
          w[of[v]] = skin.influences[v].weights[k];
    if (w.isZero(0.0)) continue;
    for (int step = 0; step < 2; ++step) {
      const Eigen::VectorXd heat = areas.cwiseProduct(w);  // not an expression of w, into which is solved
      w = factor.solve(heat);
    }
    for (int v = 0; v < n; ++v)
      if (w[v] > 1e-5) rows[v].emplace_back(joint, w[v]);
  }
  for (auto& row : rows) keepFour(row);
  for (std::size_t v = 0; v < of.size(); ++v)
    if (!rows[of[v]].empty()) skin.influences[v] = exactInfluences(rows[of[v]]);
  return skin;
}

}  // namespace gelenk
