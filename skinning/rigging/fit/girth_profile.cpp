#include "skinning/rigging/fit/girth_profile.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace gelenk {

using Eigen::Vector3d;

GirthProfile::GirthProfile(const Vector3d& from, const Vector3d& to, int cuts)
    : from_(from), along_((to - from).normalized()), step_((to - from).norm() / (cuts - 1)), widths_(cuts) {
  const Vector3d u = along_.unitOrthogonal(), v = along_.cross(u);
  for (int d = 0; d < directions; ++d)
    across_[d] = std::cos(M_PI * d / directions) * u + std::sin(M_PI * d / directions) * v;
}

void GirthProfile::add(const Vector3d& a, const Vector3d& b) {
  const double ta = along_.dot(a - from_) / step_, tb = along_.dot(b - from_) / step_;
  const double first = std::max(0.0, std::ceil(std::min(ta, tb))),
               last = std::min(static_cast<double>(widths_.size() - 1), std::max(ta, tb));
  for (double cut = first; cut <= last; ++cut) {
    const Vector3d p = ta == tb ? a : Vector3d(a + (cut - ta) / (tb - ta) * (b - a));
    for (int d = 0; d < directions; ++d) {
      auto& [least, most] = widths_[static_cast<std::size_t>(cut)][d];
      const double x = across_[d].dot(p - from_);
      least = std::min(least, x);
      most = std::max(most, x);
    }
  }
}

double GirthProfile::girth(int cut) const {
  double sum = 0.0;
  for (const auto& [least, most] : widths_[cut]) sum += std::max(0.0, most - least);
  return M_PI * sum / directions;
}

std::optional<double> GirthProfile::waist() const {
  std::vector<double> g;
  for (int cut = 0; cut < static_cast<int>(widths_.size()); ++cut) g.push_back(girth(cut));
  const int n = static_cast<int>(g.size());
  int narrowest = -1;
  double depth = 1.15;
  for (int k = 1; k + 1 < n; ++k) {
    if (!(g[k] > 0.0)) continue;
    const double before = *std::max_element(g.begin(), g.begin() + k),
                 after = *std::max_element(g.begin() + k + 1, g.end());
    if (const double thicker = std::min(before, after); thicker > depth * g[k])
      narrowest = k, depth = thicker / g[k];
  }
  if (narrowest < 0) return {};
  const double about = 1.04 * g[narrowest];
  int low = narrowest, high = narrowest;
  while (low > 0 && g[low - 1] < about) --low;
  while (high + 1 < n && g[high + 1] < about) ++high;
  return 0.5 * (low + high) * step_;
}

}  // namespace gelenk
