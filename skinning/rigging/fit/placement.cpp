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

std::vector<Stance> stancesOf(const SurfaceSamples& samples, const std::vector<MirrorPlane>& planes,
                              const PlacementWishes& wishes) {
  std::vector<Stance> out;
  for (const MirrorPlane& plane : planes) {
    const Vector3d n = plane.normal, u = n.unitOrthogonal(), v = n.cross(u);
    Vector2d mean = Vector2d::Zero();
    for (const Vector3d& p : samples.points) mean += Vector2d(u.dot(p), v.dot(p));
    mean /= static_cast<double>(samples.points.size());
    Matrix2d spread = Matrix2d::Zero();
    for (const Vector3d& p : samples.points) {
      const Vector2d d = Vector2d(u.dot(p), v.dot(p)) - mean;
      spread += d * d.transpose();
    }
    const Matrix2d principal = Eigen::SelfAdjointEigenSolver<Matrix2d>(spread).eigenvectors();
    for (int k = 0; k < 2; ++k)
      for (const double sign : {1.0, -1.0})
        for (const double side : {1.0, -1.0}) {
          const Vector3d up = sign * (principal(0, k) * u + principal(1, k) * v), left = side * n;
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
  for (const Stance& stance : stancesOf(samples, planes, wishes)) {
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
