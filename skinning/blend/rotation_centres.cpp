#include "skinning/blend/rotation_centres.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace gelenk {
namespace {

using Eigen::Vector3d;

/// Triangles of like weights on two bones.
struct Bin {
  double mass = 0.0;                  ///< sum of a w_j w_l
  Vector3d place = Vector3d::Zero();  ///< sum of a w_j w_l v
  double first = 0.0, second = 0.0;   ///< sums of a w_j w_l w_j and a w_j w_l w_l; divided by mass at last
};
using Pair = std::pair<int, int>;

struct Weighted {
  int joint;
  double weight;
};

std::vector<Weighted> meanWeights(const Skin& skin, const std::array<int, 3>& triangle) {
  std::vector<Weighted> sum;
  for (const int v : triangle)
    for (int k = 0; k < 4 && skin.influences[v].weights[k] > 0.0; ++k) {
      const int joint = skin.influences[v].joints[k];
      const auto same =
          std::find_if(sum.begin(), sum.end(), [&](const Weighted& w) { return w.joint == joint; });
      if (same != sum.end())
        same->weight += skin.influences[v].weights[k] / 3.0;
      else
        sum.push_back({joint, skin.influences[v].weights[k] / 3.0});
    }
  std::sort(sum.begin(), sum.end(), [](const Weighted& a, const Weighted& b) { return a.joint < b.joint; });
  return sum;
}

std::map<Pair, std::vector<Bin>> binnedTriangles(const Skin& skin, int bins) {
  std::map<Pair, std::vector<Bin>> of;
  const Mesh& mesh = skin.mesh;
  for (const auto& t : mesh.triangles) {
    const Vector3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const double area = 0.5 * (b - a).cross(c - a).norm();
    const Vector3d centroid = (a + b + c) / 3.0;
    const std::vector<Weighted> weights = meanWeights(skin, t);
    for (std::size_t i = 0; i < weights.size(); ++i)
      for (std::size_t k = i + 1; k < weights.size(); ++k) {
        const double wi = weights[i].weight, wk = weights[k].weight, mass = area * wi * wk;
        std::vector<Bin>& list = of[{weights[i].joint, weights[k].joint}];
        if (bins > 0 && list.empty()) list.resize(static_cast<std::size_t>(bins) * bins);
        if (bins == 0) list.emplace_back();
        const auto cell = [&](double w) { return std::min(static_cast<int>(w * bins), bins - 1); };
        Bin& bin = bins == 0 ? list.back() : list[static_cast<std::size_t>(cell(wi)) * bins + cell(wk)];
        bin.mass += mass;
        bin.place += mass * centroid;
        bin.first += mass * wi;
        bin.second += mass * wk;
      }
  }
  for (auto& [pair, list] : of) {
    std::erase_if(list, [](const Bin& bin) { return !(bin.mass > 0.0); });
    for (Bin& bin : list) bin.first /= bin.mass, bin.second /= bin.mass;
  }
  return of;
}

}  // namespace

std::vector<Vector3d> rotationCentres(const Skin& skin, std::vector<bool>* blended, int bins) {
  const auto triangles = binnedTriangles(skin, bins);
  std::vector<Vector3d> centres = skin.mesh.positions;
  if (blended) blended->assign(centres.size(), false);
  constexpr double bySquare = 1.0 / (centreSigma * centreSigma);
  for (std::size_t v = 0; v < centres.size(); ++v) {
    const Influences& in = skin.influences[v];
    double mass = 0.0;
    Vector3d place = Vector3d::Zero();
    for (int i = 0; i < 4 && in.weights[i] > 0.0; ++i)
      for (int k = i + 1; k < 4 && in.weights[k] > 0.0; ++k) {
        const bool ordered = in.joints[i] < in.joints[k];
        const auto found =
            triangles.find(ordered ? Pair{in.joints[i], in.joints[k]} : Pair{in.joints[k], in.joints[i]});
        if (found == triangles.end()) continue;
        const double first = ordered ? in.weights[i] : in.weights[k],
                     second = ordered ? in.weights[k] : in.weights[i];
        for (const Bin& bin : found->second) {
          const double unlike = first * bin.second - second * bin.first;
          const double distance = unlike * unlike * bySquare;
          if (distance > 40.0) continue;  // e^-40 of what the vertex's own triangles count
          const double share = first * second * std::exp(-distance);
          mass += share * bin.mass;
          place += share * bin.place;
        }
      }
    if (!(mass > 1e-300)) continue;
    centres[v] = place / mass;
    if (blended) (*blended)[v] = true;
  }
  return centres;
}

}  // namespace gelenk
