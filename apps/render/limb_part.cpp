#include "apps/render/limb_part.h"

#include <algorithm>

namespace gelenk {

std::vector<int> descendants(const Skeleton& skeleton, int joint) {
  std::vector<int> joints{joint};
  for (int j = joint + 1; j < skeleton.jointCount(); ++j)
    if (std::ranges::binary_search(joints, skeleton.parent(j))) joints.push_back(j);
  return joints;
}

bool belongsTo(const Influences& vertex, const std::vector<int>& joints) {
  double weight = 0.0;
  for (int k = 0; k < 4; ++k)
    if (std::ranges::binary_search(joints, static_cast<int>(vertex.joints[k]))) weight += vertex.weights[k];
  return weight >= 0.5;
}

}  // namespace gelenk
