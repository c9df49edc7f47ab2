#include "skinning/blend/weight_smoothing.h"

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
  A *= 0.25 * length * length;
  for (int v = 0; v < n; ++v) A.coeffRef(v, v) += areas[v];
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
