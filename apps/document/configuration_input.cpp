#include "apps/document/configuration_input.h"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

#include "kinematics/configuration.h"

namespace gelenk {

Eigen::VectorXd checkedConfiguration(const Skeleton& skeleton, Eigen::VectorXd q, const std::string& what) {
  if (q.size() != skeleton.nq())
    throw std::invalid_argument(
        fmt::format("{} needs {} values for this model, {} given", what, skeleton.nq(), q.size()));
  if (!q.allFinite()) throw std::invalid_argument(what + " must be finite numbers");
  for (int i = 0; i < skeleton.jointCount(); ++i) {
    if (!skeleton.joint(i).ball) continue;
    const Eigen::Quaterniond rotation = ballRotation(skeleton, q, i);
    const double length = rotation.norm();
    if (!(std::abs(length - 1.0) < 1e-3))
      throw std::invalid_argument(fmt::format("{}: the quaternion of '{}' must have length 1, not {:.6g}",
                                              what, skeleton.joint(i).name, length));
    if (std::abs(length - 1.0) > 1e-12) setBallRotation(skeleton, q, i, rotation.normalized());
  }
  skeleton.couple(q);
  return q;
}

}  // namespace gelenk
