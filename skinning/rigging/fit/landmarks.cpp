#include "skinning/rigging/fit/landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "skinning/rigging/fit/girth_profile.h"

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

/// The end of a limb or tail along its last piece: the outermost sample of those whose nearest place of the
/// template is on that piece or the one before.
std::optional<Landmark> limbEnd(const TemplateBody& body, int piece, double farthest, double weight,
                                const std::vector<Vector3d>& now, const std::vector<int>& nearest,
                                const SurfaceSamples& samples, const PieceMaps& maps) {
  const BodyPiece& part = body.pieces[piece];
  const Vector3d along = (maps[piece].linear * (part.to - part.from)).normalized();
  Landmark end;
  double tip = -std::numeric_limits<double>::infinity(), reach = tip;
  for (int v = 0; v < static_cast<int>(now.size()); ++v)
    if (shareOf(body, v, piece) > 0.5 && along.dot(now[v]) > tip) tip = along.dot(now[v]), end.vertex = v;
  for (std::size_t s = 0; s < samples.points.size(); ++s)
    if (shareOf(body, nearest[s], piece) + shareOf(body, nearest[s], part.parent) > 0.5)
      reach = std::max(reach, along.dot(samples.points[s]));
  if (!(std::abs(reach - tip) < farthest)) return {};
  end.place = now[end.vertex] + (reach - tip) * along;
  end.metric = weight * along * along.transpose();
  return end;
}

/// The wrist by where arm and hand are narrowest. It holds the hand's length, which a sleeve leaves open: the
/// template's tapering arm would slide outwards until its thick end fills the cuff.
std::optional<Landmark> wrist(const TemplateBody& body, int piece, const std::vector<Vector3d>& now,
                              const KdTree<3>& tree, const Mesh& mesh, const BodyFrame& frame,
                              const PieceMaps& maps) {
  const BodyPiece &hand = body.pieces[piece], &arm = body.pieces[hand.parent];
  const auto along = [&](const BodyPiece& part, int k, double share) {
    return Vector3d(maps[k].origin + share * maps[k].linear * (part.to - part.from));
  };
  const auto isArm = [&](int v) { return shareOf(body, v, piece) + shareOf(body, v, hand.parent) > 0.5; };
  const Vector3d from = along(arm, hand.parent, 0.1), to = along(hand, piece, 1.0);
  constexpr int cuts = 60;
  GirthProfile own(from, to, cuts), wanted(from, to, cuts);
  for (const auto& t : body.surface.triangles)
    for (int k = 0; k < 3; ++k)
      if (isArm(t[k]) && isArm(t[(k + 1) % 3])) own.add(now[t[k]], now[t[(k + 1) % 3]]);
  std::vector<Vector3d> places;
  std::vector<char> near;
  for (const Vector3d& p : mesh.positions) {
    places.push_back(frame.toBody(p));
    near.push_back((places.back() - from).norm() < 1.5 * (to - from).norm() &&
                   isArm(tree.nearest(places.back())));
  }
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k)
      if (near[t[k]] && near[t[(k + 1) % 3]]) wanted.add(places[t[k]], places[t[(k + 1) % 3]]);
  const auto here = own.waist(), there = wanted.waist();
  if (!here || !there || std::abs(*there - *here) > 0.1) return {};
  const Vector3d axis = (to - from).normalized();
  Landmark out{.vertex = -1, .metric = 0.05 * axis * axis.transpose()};
  double nearest = std::numeric_limits<double>::infinity();
  for (int v = 0; v < static_cast<int>(now.size()); ++v)
    if (const double d = std::abs(axis.dot(now[v] - from) - *here); isArm(v) && d < nearest)
      nearest = d, out.vertex = v;
  if (out.vertex < 0) return {};
  out.place = now[out.vertex] + (*there - *here) * axis;
  return out;
}

/// Where a leg stands: the middle of its lowest samples, for the middle of the template's sole.
std::optional<Landmark> sole(const TemplateBody& body, int piece, const std::vector<Vector3d>& now,
                             const std::vector<int>& nearest, const SurfaceSamples& samples) {
  const BodyPiece& part = body.pieces[piece];
  Landmark out{.vertex = -1, .metric = 0.05 * Matrix3d::Identity()};
  const Vector3d middle(part.to.x(), 0.0, part.to.z());
  for (int v = 0; v < static_cast<int>(now.size()); ++v) {
    const auto& rest = body.surface.positions;
    if (shareOf(body, v, piece) > 0.5 &&
        (out.vertex < 0 || (rest[v] - middle).norm() < (rest[out.vertex] - middle).norm()))
      out.vertex = v;
  }
  std::vector<Vector3d> leg;
  for (std::size_t s = 0; s < samples.points.size(); ++s)
    if (shareOf(body, nearest[s], piece) + shareOf(body, nearest[s], part.parent) > 0.5)
      leg.push_back(samples.points[s]);
  if (out.vertex < 0 || leg.size() < 8) return {};
  const auto higher = [](const Vector3d& a, const Vector3d& b) { return a.y() < b.y(); };
  const double ground = std::min_element(leg.begin(), leg.end(), higher)->y();
  constexpr double thick = 0.04;
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  for (const Vector3d& p : leg)
    if (p.y() < ground + thick) low = low.cwiseMin(p), high = high.cwiseMax(p);
  out.place = 0.5 * (low + high);
  out.place.y() = ground;
  // A foot that lies flat slides along itself: only its height is known.
  if (std::abs((part.to - part.from).normalized().y()) < 0.7) {
    out.metric = 0.05 * Vector3d::UnitY() * Vector3d::UnitY().transpose();
    out.place = {now[out.vertex].x(), ground, now[out.vertex].z()};
  }
  if ((out.place - now[out.vertex]).norm() > 0.2) return {};
  return out;
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
  for (int k = 0; k < static_cast<int>(body.pieces.size()); ++k) {
    if (body.pieces[k].twists) {  // a hand
      if (const auto end = limbEnd(body, k, 0.15, 0.05, now, nearest, target.samples(), maps))
        out.push_back(*end);
      if (const auto place = wrist(body, k, now, tree, mesh, frame, maps)) out.push_back(*place);
    }
    if (body.pieces[k].trails)
      if (const auto end = limbEnd(body, k, 0.25, 0.015, now, nearest, target.samples(), maps))
        out.push_back(*end);
    if (body.pieces[k].stands)
      if (const auto end = sole(body, k, now, nearest, target.samples())) out.push_back(*end);
  }
  return out;
}

}  // namespace gelenk
