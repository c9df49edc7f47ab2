#include "skinning/rigging/weight_transfer.h"

#include <algorithm>
#include <stdexcept>

namespace gelenk {

using Eigen::Vector3d;

namespace {

double smoothStep(double t) {
  t = std::clamp(t, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

}  // namespace

SparseWeights transferWeights(const BoneWeights& weights, const std::vector<Vector3d>& vertices,
                              const Skeleton& fitted, const TransferredSkeleton& transferred) {
  if (weights.rows() != static_cast<Eigen::Index>(vertices.size()) ||
      weights.cols() != fitted.jointCount() - 1)
    throw std::invalid_argument(
        "the weights need one row a vertex and one column a bone of the fitted skeleton");
  const Frames rest = restFrames(fitted);
  std::vector<std::vector<BonePiece>> piecesOf(fitted.jointCount());
  for (const BonePiece& piece : transferred.pieces) piecesOf[piece.child].push_back(piece);
  for (int c = 1; c < fitted.jointCount(); ++c) {
    auto& pieces = piecesOf[c];
    std::sort(pieces.begin(), pieces.end(),
              [](const BonePiece& a, const BonePiece& b) { return a.from < b.from; });
    if (!pieces.empty()) continue;
    const Vector3d start = rest[fitted.parent(c)].translation();
    int nearest = 0;
    for (int j = 0; j < transferred.skeleton.jointCount(); ++j)
      if ((transferred.bindFrames[j].translation() - start).norm() <
          (transferred.bindFrames[nearest].translation() - start).norm())
        nearest = j;
    pieces.push_back({c, 0.0, 1.0, nearest});
  }

  SparseWeights result(vertices.size());
  for (std::size_t v = 0; v < vertices.size(); ++v)
    for (int c = 1; c < fitted.jointCount(); ++c) {
      double left = weights(v, c - 1);
      if (left == 0.0) continue;
      const auto& pieces = piecesOf[c];
      const Vector3d start = rest[fitted.parent(c)].translation(), along = rest[c].translation() - start;
      const double t = (vertices[v] - start).dot(along) / along.squaredNorm();
      for (std::size_t k = 0; k + 1 < pieces.size(); ++k) {
        const double width =
            0.5 * std::min(pieces[k].to - pieces[k].from, pieces[k + 1].to - pieces[k + 1].from);
        const double beyond = smoothStep((t - pieces[k].to) / width + 0.5);
        if (beyond < 1.0) result[v].emplace_back(pieces[k].joint, left * (1.0 - beyond));
        left *= beyond;
      }
      if (left > 0.0) result[v].emplace_back(pieces.back().joint, left);
    }
  return result;
}

}  // namespace gelenk
