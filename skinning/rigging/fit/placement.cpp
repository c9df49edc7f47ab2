#include "skinning/rigging/fit/placement.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>

namespace gelenk {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double normalReach = 0.05;

SurfaceSamples thinned(const SurfaceSamples& samples, std::size_t count) {
  const std::size_t stride = std::max<std::size_t>(1, samples.points.size() / count);
  SurfaceSamples out;
  for (std::size_t i = 0; i < samples.points.size(); i += stride) {
    out.points.push_back(samples.points[i]);
    out.normals.push_back(samples.normals[i]);
  }
  return out;
}

struct Range {
  double low, high;
};
/// Extent along a direction without the outermost half per cent at either end.
Range extent(const std::vector<Vector3d>& points, const Vector3d& direction) {
  std::vector<double> x;
  for (const Vector3d& p : points) x.push_back(direction.dot(p));
  std::sort(x.begin(), x.end());
  const std::size_t cut = x.size() / 200;
  return {x[cut], x[x.size() - 1 - cut]};
}

/// One way to stand.
struct Stance {
  Matrix3d axes;
  const MirrorPlane* plane;
};

/// The directions in which most of a flat body's points lie spread, both ways round.
std::vector<Vector2d> principalAxes(const std::vector<Vector2d>& points) {
  Vector2d mean = Vector2d::Zero();
  for (const Vector2d& p : points) mean += p / static_cast<double>(points.size());
  Matrix2d spread = Matrix2d::Zero();
  for (const Vector2d& p : points) spread += (p - mean) * (p - mean).transpose();
  const Matrix2d axes = Eigen::SelfAdjointEigenSolver<Matrix2d>(spread).eigenvectors();
  return {axes.col(0), -axes.col(0), axes.col(1), -axes.col(1)};
}

/// The corners of the convex hull, anticlockwise (Andrew 1979).
std::vector<Vector2d> convexHull(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t first = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= first + 2) {
        const Vector2d u = hull.back() - hull[hull.size() - 2], v = p - hull.back();
        if (u.x() * v.y() - u.y() * v.x() > 0.0) break;
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// What lies flat on its four feet lies on one of the long sides of its hull: the directions away from the
/// three longest, edges within five degrees taken together.
std::vector<Vector2d> awayFromLongSides(const std::vector<Vector2d>& points) {
  const std::vector<Vector2d> hull = convexHull(points);
  const double together = std::cos(5.0 * M_PI / 180.0), apart = std::cos(12.0 * M_PI / 180.0);
  std::vector<std::pair<double, Vector2d>> sides;
  const auto edge = [&](std::size_t i) { return Vector2d(hull[(i + 1) % hull.size()] - hull[i]); };
  for (std::size_t i = 0; i < hull.size(); ++i) {
    Vector2d sum = Vector2d::Zero();
    for (std::size_t j = 0; j < hull.size(); ++j)
      if (edge(j).normalized().dot(edge(i).normalized()) > together) sum += edge(j);
    sides.emplace_back(sum.norm(), Vector2d(-sum.y(), sum.x()).normalized());
  }
  std::stable_sort(sides.begin(), sides.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<Vector2d> out;
  for (const auto& [length, inwards] : sides)
    if (out.size() < 3 &&
        std::none_of(out.begin(), out.end(), [&, d = inwards](const auto& o) { return o.dot(d) > apart; }))
      out.push_back(inwards);
  return out;
}

std::vector<Stance> stancesOf(const TemplateBody& body, const SurfaceSamples& samples,
                              const std::vector<MirrorPlane>& planes, const PlacementWishes& wishes) {
  std::vector<Stance> out;
  for (const MirrorPlane& plane : planes) {
    const Vector3d n = plane.normal, u = n.unitOrthogonal(), v = n.cross(u);
    std::vector<Vector2d> flat;
    for (const Vector3d& p : samples.points) flat.emplace_back(u.dot(p), v.dot(p));
    std::vector<Vector2d> uprights = principalAxes(flat);
    if (body.fourLegged)
      for (const Vector2d& up : awayFromLongSides(flat)) uprights.push_back(up);
    if (wishes.up)
      if (const Vector2d up(u.dot(*wishes.up), v.dot(*wishes.up)); up.norm() > 0.8)
        uprights = {up.normalized()};
    for (const Vector2d& upright : uprights)
      for (const double side : {1.0, -1.0}) {
        const Vector3d up = upright.x() * u + upright.y() * v, left = side * n;
        Matrix3d axes;
        axes << left, up, left.cross(up);
        if (wishes.up && up.dot(*wishes.up) < 0.8) continue;
        if (wishes.front && axes.col(2).dot(*wishes.front) < 0.8) continue;
        out.push_back({axes, &plane});
      }
  }
  return out;
}

bool standsAsAuthored(const Stance& stance) {
  return stance.axes.col(1).y() > 0.9 && stance.axes.col(2).z() > 0.9;
}

struct Trial {
  Stance stance;
  const TemplatePose* pose;
  BodyFrame frame;
  std::shared_ptr<FitTarget> target;
  PieceMaps maps;
  double misfit = 1.0;
};

/// The posed template has the body's extent along the upright axis, stands where it stands and is centred.
BodyFrame frameFor(const Stance& stance, const SurfaceSamples& samples, const std::vector<Vector3d>& posed) {
  BodyFrame frame{.axes = stance.axes};
  const Range tall = extent(samples.points, stance.axes.col(1)),
              deep = extent(samples.points, stance.axes.col(2));
  const Range tallPosed = extent(posed, Vector3d::UnitY()), deepPosed = extent(posed, Vector3d::UnitZ());
  frame.scale = (tall.high - tall.low) / (tallPosed.high - tallPosed.low);
  const double side = stance.axes.col(0).dot(stance.plane->normal) * stance.plane->offset;
  const Vector3d origin(side, tall.low - frame.scale * tallPosed.low,
                        0.5 * (deep.low + deep.high - frame.scale * (deepPosed.low + deepPosed.high)));
  frame.origin = stance.axes * origin;
  return frame;
}

}  // namespace

SurfaceSamples inBodySpace(const SurfaceSamples& samples, const BodyFrame& frame) {
  SurfaceSamples out;
  for (const Vector3d& p : samples.points) out.points.push_back(frame.toBody(p));
  for (const Vector3d& n : samples.normals) out.normals.push_back(frame.axes.transpose() * n);
  return out;
}

std::vector<Placement> placeBody(const TemplateBody& body, const SurfaceSamples& samples,
                                 const PlacementWishes& wishes) {
  Eigen::AlignedBox3d box;
  for (const Vector3d& p : samples.points) box.extend(p);
  const std::vector<MirrorPlane> planes = mirrorPlanes(samples, box.diagonal().norm());
  constexpr double symmetricMisfit = 0.004;
  const bool symmetric = planes[0].misfit < symmetricMisfit;

  const SurfaceSamples few = thinned(samples, 700);
  std::vector<Trial> trials;
  std::vector<std::vector<Vector3d>> posed;
  for (const TemplatePose& pose : body.poses) posed.push_back(deformed(body, pose.maps));
  for (const Stance& stance : stancesOf(body, samples, planes, wishes)) {
    if (symmetric && stance.plane->misfit > std::max(symmetricMisfit, 3.0 * planes[0].misfit)) continue;
    for (std::size_t k = 0; k < body.poses.size(); ++k) {
      if (symmetric && !body.poses[k].symmetric) continue;
      Trial trial{stance, &body.poses[k], frameFor(stance, few, posed[k]), nullptr, body.poses[k].maps};
      if (!(trial.frame.scale > 0.0)) continue;
      trial.target = std::make_shared<FitTarget>(inBodySpace(few, trial.frame), normalReach);
      trials.push_back(std::move(trial));
    }
  }
  const auto run = [&](std::size_t keep, FitStage stage) {
    for (Trial& trial : trials) {
      stage.symmetric = symmetric && trial.stance.plane->misfit < symmetricMisfit;
      trial.misfit = trial.pose->rarity * fitPieces(body, *trial.target, trial.maps, stage);
      if (standsAsAuthored(trial.stance)) trial.misfit *= authoredBonus;
    }
    std::stable_sort(trials.begin(), trials.end(),
                     [](const Trial& a, const Trial& b) { return a.misfit < b.misfit; });
    if (trials.size() > keep) trials.resize(keep);
  };
  run(16, {.rounds = 1, .stiffness = 3.0, .robustWidth = 0.2, .vertices = 250, .samples = 250});
  run(8, {.rounds = 4, .stiffness = 2.0, .robustWidth = 0.2, .vertices = 300, .samples = 300});
  run(8, {.rounds = 8, .stiffness = 1.0, .robustWidth = 0.1, .vertices = 400, .samples = 400});

  std::vector<Placement> out;
  for (const Trial& trial : trials) {
    if (trial.misfit > 1.25 * trials[0].misfit) break;
    const bool known = std::any_of(out.begin(), out.end(), [&](const Placement& p) {
      return p.frame.axes.cwiseProduct(trial.stance.axes).colwise().sum().minCoeff() > 0.8;
    });
    if (known) continue;
    out.push_back({.frame = trial.frame,
                   .maps = trial.maps,
                   .pose = trial.pose->name,
                   .symmetric = symmetric && trial.stance.plane->misfit < symmetricMisfit,
                   .misfit = trial.misfit,
                   .authored = standsAsAuthored(trial.stance)});
  }
  return out;
}

}  // namespace gelenk
