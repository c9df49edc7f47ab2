#include "skinning/rigging/fit/landmarks.h"

#include <cmath>
#include <limits>

namespace gelenk {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

double shareOf(const TemplateBody& body, int vertex, int piece) {
  double share = 0.0;
  for (const auto& [k, w] : body.weights[vertex])
    if (k == piece) share += w;
  return share;
}

/// The end of a limb along its last piece: the outermost sample of those whose nearest place of the template
/// is on that piece or the one before.
std::optional<Landmark> limbEnd(const TemplateBody& body, int piece, const std::vector<Vector3d>& now,
                                const std::vector<int>& nearest, const SurfaceSamples& samples,
                                const PieceMaps& maps) {
  const BodyPiece& part = body.pieces[piece];
  const Vector3d along = (maps[piece].linear * (part.to - part.from)).normalized();
  Landmark end;
  double tip = -std::numeric_limits<double>::infinity(), reach = tip;
  for (int v = 0; v < static_cast<int>(now.size()); ++v)
    if (shareOf(body, v, piece) > 0.5 && along.dot(now[v]) > tip) tip = along.dot(now[v]), end.vertex = v;
  for (std::size_t s = 0; s < samples.points.size(); ++s)
    if (shareOf(body, nearest[s], piece) + shareOf(body, nearest[s], part.parent) > 0.5)
      reach = std::max(reach, along.dot(samples.points[s]));
  if (!(std::abs(reach - tip) < 0.15)) return {};
  end.place = now[end.vertex] + (reach - tip) * along;
  end.metric = 0.05 * along * along.transpose();
  return end;
}

}  // namespace

std::optional<Vector3d> findCrotch(const Mesh& mesh, const BodyFrame& frame, const Vector3d& about,
                                   double reach) {
  // Beside the middle, where many meshes have a row of edges.
  constexpr double cut = 0.001;
  std::optional<Vector3d> lowest;
  for (const auto& t : mesh.triangles) {
    const Vector3d corner[3] = {frame.toBody(mesh.positions[t[0]]), frame.toBody(mesh.positions[t[1]]),
                                frame.toBody(mesh.positions[t[2]])};
    for (int k = 0; k < 3; ++k) {
      const Vector3d &a = corner[k], &b = corner[(k + 1) % 3];
      if ((a.x() < cut) == (b.x() < cut)) continue;
      const Vector3d p = a + (cut - a.x()) / (b.x() - a.x()) * (b - a);
      if (!lowest || p.y() < lowest->y()) lowest = p;
    }
  }
  if (!lowest || std::abs(lowest->y() - about.y()) > reach) return {};
  return Vector3d(0.0, lowest->y(), lowest->z());
}

std::vector<Landmark> findLandmarks(const TemplateBody& body, const Mesh& mesh, const BodyFrame& frame,
                                    const FitTarget& target, const PieceMaps& maps) {
  std::vector<Landmark> out;
  const std::vector<Vector3d> now = deformed(body, maps);
  if (body.crotch >= 0) {
    const Vector3d drop = body.crotchDrop * Vector3d::UnitY();
    if (const auto crotch = findCrotch(mesh, frame, now[body.crotch] + drop, 0.06))
      out.push_back({body.crotch, *crotch - drop, 0.1 * Matrix3d::Identity()});
  }
  std::vector<KdTree<3>::Point> points(now.begin(), now.end());
  const KdTree<3> tree(std::move(points));
  std::vector<int> nearest;
  for (const Vector3d& p : target.samples().points) nearest.push_back(tree.nearest(p));
  for (int k = 0; k < static_cast<int>(body.pieces.size()); ++k)
    if (body.pieces[k].twists)  // a hand
      if (const auto end = limbEnd(body, k, now, nearest, target.samples(), maps)) out.push_back(*end);
  return out;
}

}  // namespace gelenk
