#include "solvers/ceres/quaternion_chain.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>
#include <stdexcept>

#include "solvers/ceres/ceres_options.h"

namespace gelenk {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// The unit-quaternion formula on any q, as it stands on paper: with ||q|| != 1 it is no rotation, and that
/// is the point.
struct EndError {
  std::array<double, 3> lengths;
  std::array<double, 3> target;

  template <typename T>
  bool operator()(const T* q1, const T* q2, const T* q3, T* residual) const {
    T point[3] = {T(lengths[2]), T(0.0), T(0.0)}, turned[3];
    ceres::UnitQuaternionRotatePoint(q3, point, turned);
    turned[0] += T(lengths[1]);
    ceres::UnitQuaternionRotatePoint(q2, turned, point);
    point[0] += T(lengths[0]);
    ceres::UnitQuaternionRotatePoint(q1, point, turned);
    for (int k = 0; k < 3; ++k) residual[k] = turned[k] - T(target[k]);
    return true;
  }
};

struct UnitLengthPenalty {
  double weight;
  template <typename T>
  bool operator()(const T* q, T* residual) const {
    residual[0] = T(weight) * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - T(1.0));
    return true;
  }
};

}  // namespace

const std::string_view quaternionChainMethod = "Ceres Levenberg-Marquardt";

Vector3d quaternionChainEnd(const std::vector<double>& lengths, const std::vector<Quaterniond>& q) {
  Vector3d end = Vector3d::Zero();
  Quaterniond rotation = Quaterniond::Identity();
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    rotation = rotation * q[i].normalized();
    end += rotation * Vector3d(lengths[i], 0.0, 0.0);
  }
  return end;
}

QuaternionChainFit fitQuaternionChain(const std::vector<double>& lengths,
                                      const std::vector<Quaterniond>& start, const Vector3d& target,
                                      UnitConstraint constraint, double penaltyWeight) {
  if (lengths.size() != 3 || start.size() != 3)
    throw std::invalid_argument("the quaternion chain has exactly three joints");
  std::array<std::array<double, 4>, 3> q;
  for (int i = 0; i < 3; ++i) q[i] = {start[i].w(), start[i].x(), start[i].y(), start[i].z()};
  const EndError error{{lengths[0], lengths[1], lengths[2]}, {target.x(), target.y(), target.z()}};

  ceres::Problem problem;
  problem.AddResidualBlock(new ceres::AutoDiffCostFunction<EndError, 3, 4, 4, 4>(new EndError(error)),
                           nullptr, q[0].data(), q[1].data(), q[2].data());
  for (auto& block : q) {
    if (constraint == UnitConstraint::Manifold)
      problem.SetManifold(block.data(), new ceres::QuaternionManifold);
    else
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<UnitLengthPenalty, 1, 4>(new UnitLengthPenalty{penaltyWeight}),
          nullptr, block.data());
  }
  ceres::Solver::Summary summary;
  ceres::Solve(smallDenseOptions(500), &problem, &summary);

  QuaternionChainFit fit;
  for (const auto& block : q) {
    fit.q.emplace_back(block[0], block[1], block[2], block[3]);
    fit.constraintError = std::max(fit.constraintError, std::abs(fit.q.back().norm() - 1.0));
  }
  double residual[3];
  error(q[0].data(), q[1].data(), q[2].data(), residual);
  fit.claimedError = Vector3d(residual[0], residual[1], residual[2]).norm();
  fit.trueError = (quaternionChainEnd(lengths, fit.q) - target).norm();
  fit.iterations = static_cast<int>(summary.iterations.size()) - 1;
  return fit;
}

}  // namespace gelenk
