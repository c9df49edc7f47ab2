#include "skinning/skin.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gelenk {

std::vector<Influences> fourLargest(const SparseWeights& weights, int jointCount, WeightLoss* loss) {
  std::vector<Influences> result(weights.size());
  WeightLoss lost;
  std::vector<std::pair<int, double>> sorted;
  for (std::size_t v = 0; v < weights.size(); ++v) {
    const auto reject = [v](const std::string& why) {
      throw std::invalid_argument("weights of vertex " + std::to_string(v) + ": " + why);
    };
    sorted.clear();
    double total = 0.0;
    for (const auto& [joint, weight] : weights[v]) {
      if (joint < 0 || joint >= jointCount) reject("joint " + std::to_string(joint) + " does not exist");
      if (!std::isfinite(weight) || weight < 0.0) reject("a weight is negative or not finite");
      if (weight == 0.0) continue;
      total += weight;
      const auto same =
          std::find_if(sorted.begin(), sorted.end(), [&, j = joint](const auto& e) { return e.first == j; });
      if (same != sorted.end())
        same->second += weight;
      else
        sorted.emplace_back(joint, weight);
    }
    if (!(total > 0.0)) reject("all weights are zero");

    const std::size_t kept = std::min<std::size_t>(4, sorted.size());
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const auto& a, const auto& b) { return a.second > b.second; });
    double sum = 0.0;
    for (std::size_t k = 0; k < kept; ++k) sum += sorted[k].second;
    result[v].weights = {0.0, 0.0, 0.0, 0.0};
    for (std::size_t k = 0; k < kept; ++k) {
      result[v].joints[k] = sorted[k].first;
      result[v].weights[k] = sorted[k].second / sum;
    }
    if (sorted.size() > 4) {
      const double missing = std::max(0.0, 1.0 - sum / total);
      lost.mean += missing;
      lost.max = std::max(lost.max, missing);
      ++lost.verticesOverFour;
    }
  }
  if (!weights.empty()) lost.mean /= static_cast<double>(weights.size());
  if (loss) *loss = lost;
  return result;
}

Skin bindSkin(Mesh mesh, const Frames& restFrames, std::vector<Influences> influences) {
  validate(mesh);
  if (influences.size() != mesh.positions.size())
    throw std::invalid_argument("the mesh has " + std::to_string(mesh.positions.size()) +
                                " vertices, the weights have " + std::to_string(influences.size()) + " rows");
  if (mesh.normals.size() != mesh.positions.size()) computeNormals(mesh);
  Skin skin{.mesh = std::move(mesh), .influences = std::move(influences), .jointFromRestWorld = {}};
  for (const Eigen::Isometry3d& worldFromJoint : restFrames)
    skin.jointFromRestWorld.push_back(worldFromJoint.inverse(Eigen::Isometry));
  return skin;
}

std::vector<Eigen::Isometry3d> skinningMatrices(const Skin& skin, const Frames& worldFromJoint) {
  std::vector<Eigen::Isometry3d> matrices(worldFromJoint.size());
  for (std::size_t i = 0; i < worldFromJoint.size(); ++i)
    matrices[i] = worldFromJoint[i] * skin.jointFromRestWorld[i];
  return matrices;
}

}  // namespace gelenk
